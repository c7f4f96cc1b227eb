"""Phonology: labels and the notations they are written in."""
