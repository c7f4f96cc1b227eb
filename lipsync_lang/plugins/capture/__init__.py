"""Capture: recorded motion of faces, and the targets, motion and bigrams that reproduce it."""
