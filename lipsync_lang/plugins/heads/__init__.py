"""Heads: talking heads made from face models that are free to use, on the user's machine."""
