"""Readers of animation files from any program, for evaluation: one module per format."""

from lipsync_lang.animations.animation_readers import Recording as Recording
from lipsync_lang.animations.animation_readers import read_animation as read_animation
