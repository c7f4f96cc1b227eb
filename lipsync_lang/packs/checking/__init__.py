"""Checks of packs beyond their models: within a file, and between files."""
