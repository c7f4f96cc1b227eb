"""Faces: the shapes and bones of models, and players in engines."""
