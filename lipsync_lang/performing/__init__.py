"""Performing: the performer, the label reader, streams and explanations of frames."""
