"""Performing: the performer, its label reader, and explanations of frames."""
