"""Studies: paired clips that people choose between, and statistics of their choices."""
