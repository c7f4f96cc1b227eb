"""Text: what is said, and how it sounds in a language."""
