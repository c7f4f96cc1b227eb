"""Banks: curves for phone bigrams, drafted and written."""
