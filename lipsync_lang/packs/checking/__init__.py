"""Checks of packs: within one file, between files, and all of them at once."""
