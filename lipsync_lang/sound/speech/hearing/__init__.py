"""Recordings to timed phonemes: alignment with a text, and recognition without one."""
