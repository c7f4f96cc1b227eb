"""Takes for the players of games: each pose that moves, within 1/512 of its range."""

import struct

import numpy as np

from lipsync_lang.animations.writers.take import (
    TAKE_ERROR,
    TAKE_HEAD,
    TAKE_MAGIC,
    TAKE_STEPS,
    TAKE_TRACK,
)


def take_names(content):
    """Return the names of the poses of a take, and the position of what follows."""
    assert content.startswith(TAKE_MAGIC)
    at = len(TAKE_MAGIC)
    (count,) = struct.unpack_from("<H", content, at)
    names, at = [], at + 2
    for _ in range(count):
        (length,) = struct.unpack_from("<H", content, at)
        names.append(content[at + 2 : at + 2 + length].decode())
        at += 2 + length
    return names, at


def as_take(content, animation):
    names, base = take_names(content)
    rate, start, delay, frames, tracks, _ = TAKE_HEAD.unpack_from(content, base)
    assert (frames, tracks) == (len(animation.times), len(names))
    assert [rate, start, delay] == np.float32(
        [animation.fps, animation.times[0] + animation.offset, animation.offset]
    ).tolist()
    assert set(names) == {
        pose
        for pose, column in zip(animation.poses, animation.weights.T, strict=True)
        if any(column)
    }
    for number in range(tracks):
        pose, count, place, low, span = TAKE_TRACK.unpack_from(
            content, base + TAKE_HEAD.size + number * TAKE_TRACK.size
        )
        at, frame, keys = base + place, 0, []
        for key in range(count):
            (word,) = struct.unpack_from("<H", content, at)
            step, at = word >> 10, at + 2
            if key and not step:
                (step,) = struct.unpack_from("<H", content, at)
                at += 2
            frame += step if key else 0
            keys.append((frame, low + span * (word & 1023) / TAKE_STEPS))
        shown = np.interp(np.arange(frames), *zip(*keys, strict=True))
        assert np.abs(shown - animation[names[pose]]).max() <= TAKE_ERROR * span + 1e-5


READ_BACK = {"player": as_take}
