"""Fuzz tests: every reader on damaged files, with a seed."""
