"""Recognition: a recording in, the words and sounds heard in it out."""
