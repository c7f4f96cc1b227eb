"""Takes: one line as sparse, quantised keys, which archives (`.takes`) hold for players.

A take has keys of straight lines for each moving pose: 16 bits with the frames since the last key
and the value in 1,024 steps. `docs/reference/takes.md` has the layout.
"""

import struct
from collections.abc import Sequence
from typing import BinaryIO

import numpy as np

from lipsync_lang.animations.keys import keyframes
from lipsync_lang.animations.writers import Animation, binary_writer
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import OutputError

TAKE_MAGIC = b"TAKE\1\0"
"""Start of a file of one take, with its version."""

TAKE_HEAD = struct.Struct("<fffIHH")
"""Rate, seconds of the first frame and of the sound on the timeline, frames, tracks, 0."""

TAKE_TRACK = struct.Struct("<HHIff")
"""Pose, keys, position of the keys in the take, least value, range of values."""

TEXT_LENGTH = struct.Struct("<H")

TAKE_STEPS = 1023
"""Steps of a value: 10 bits."""

SHORT_STEP = 63
"""Maximum number of frames between keys in 6 bits; a longer pause has a number of its own."""

TAKE_ERROR = 1 / 512
"""Largest error of a weight, as a share of the pose's range."""

SINGLE_MARGIN = 1e-5
"""Margin of the error for single precision."""

MOST_IN_16_BITS = 2**16 - 1


@binary_writer("player", suffix=".keys")
def write_take(animation: Animation, out: BinaryIO) -> None:
    """Quantised keys of one line, which archives (`.takes`) hold for the players of games."""
    moving = [n for n in range(len(animation.poses)) if animation.weights[:, n].any()]
    names = [animation.poses[n] for n in moving]
    out.write(TAKE_MAGIC + TEXT_LENGTH.pack(len(names)))
    for name in names:
        text = name.encode()
        out.write(TEXT_LENGTH.pack(len(text)) + text)
    start = float(animation.times[0]) + animation.offset
    place = TAKE_HEAD.size + TAKE_TRACK.size * len(moving)
    counts = len(animation.times), len(moving), 0
    out.write(TAKE_HEAD.pack(animation.fps, start, animation.offset, *counts))
    tracks, data = [], []
    for number, column in enumerate(moving):
        low, span, count, keys = _track(animation.poses[column], animation.weights[:, column])
        tracks.append(TAKE_TRACK.pack(number, count, place, low, span))
        data.append(keys)
        place += len(keys)
    out.write(b"".join([*tracks, *data]))


def _track(name: str, values: Floats) -> tuple[float, float, int, bytes]:
    """Return the least value, the range, the number of keys and the keys of a curve."""
    low, high = float(values.min()), float(values.max())
    if low >= 0 and high <= 1:
        low, high = 0.0, 1.0
    span = (high - low) or 1.0
    shares = (values - low) / span
    # Rounding to steps and to single precision takes a part of the error each.
    error = TAKE_ERROR - 0.5 / TAKE_STEPS - SINGLE_MARGIN
    keys = keyframes(np.arange(len(values)) / 1.0, shares, error)
    steps = np.diff(keys, prepend=0)
    if len(keys) > MOST_IN_16_BITS or steps.max() > MOST_IN_16_BITS:
        raise OutputError(f"the pose '{name}' has too many keys for a take; split the line")
    levels = np.rint(shares[keys] * TAKE_STEPS)
    return low, span, len(keys), _packed(steps.tolist(), levels.tolist())


def _packed(steps: Sequence[int], levels: Sequence[float]) -> bytes:
    words: list[int] = []
    for step, level in zip(steps, levels, strict=True):
        short = step if step <= SHORT_STEP else 0
        words.append(short << 10 | int(level))
        if words[1:] and not short:
            words.append(step)
    return np.array(words, "<u2").tobytes()
