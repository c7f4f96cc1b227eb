"""Transfer of phone bigrams from one face to another, by the mouth that a viewer sees."""
