"""Animations of any program, read so that they can be judged: one module for each format."""

from lipsync_lang.animations.readers.animation_readers import Recording, read_animation

__all__ = ["Recording", "read_animation"]
