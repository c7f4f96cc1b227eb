"""Banks: drafts, conversion and files of phone bigrams."""
