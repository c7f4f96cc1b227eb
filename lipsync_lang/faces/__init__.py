"""Faces: the shapes and bones of models, heads, and players in engines."""
