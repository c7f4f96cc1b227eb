"""Gestures: blinks, brows and nods, placed by the facts of a line and laid over its frames."""
