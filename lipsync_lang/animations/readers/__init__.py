"""Readers of animation files from any program, for evaluation: one module per format."""

from lipsync_lang.animations.animation_readers import Recording, read_animation

__all__ = ["Recording", "read_animation"]
