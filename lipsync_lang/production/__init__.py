"""Production: whole games, and characters that speak live."""
