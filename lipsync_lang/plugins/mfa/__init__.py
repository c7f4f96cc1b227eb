"""Forced alignment by the Montreal Forced Aligner, a program of its own."""
