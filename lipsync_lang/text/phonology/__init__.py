"""Phonology: text to labels, and labels of any notation to common phonemes."""
