"""Faces: the shapes and bones of models."""
