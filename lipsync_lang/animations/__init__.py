"""Animations: pose weights over time, and the files they are written to.

One file per output format; `writer` is all that makes a format known.
"""

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.registry import WRITERS, save, writer

__all__ = ["WRITERS", "Animation", "save", "writer"]
