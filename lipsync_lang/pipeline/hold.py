"""Hold contacts: closures are complete, even in short sounds.

Conventions: times are seconds; (n,) is phonemes and (P, T) poses by frames.

The paper has no such stage: its fast "p" is as weak as its curve. Here every phoneme that demands
a contact holds it for as long as a viewer needs to see it.
"""

from collections.abc import Iterable
from math import ceil, floor
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.pipeline.tables import Contact
from lipsync_lang.pipeline.track import Track

MARGIN = 0.030
"""Seconds of a phoneme, at each side, in which the contact may still be closing or opening."""

SHORTEST = 0.042
"""Minimum seconds of a held contact: one frame of film."""


class Plateau(NamedTuple):
    """Weight at which a contact holds a pose, before later stages take their part of it."""

    pose: int
    weight: float
    """0 to 1, or beyond where that makes the plateau long enough."""


def bounds(raised: Iterable[Plateau], lowered: Iterable[Plateau], poses: int) -> Floats:
    """Return the minimum and maximum weight of each pose, infinite if free: (2, P, 1)."""
    out = np.full((2, poses, 1), np.inf)
    out[0] = -np.inf
    for pose, weight in raised:
        out[0, pose] = weight
    for pose, weight in lowered:
        out[1, pose] = min(weight, out[1, pose, 0])
    return out


def demands(contact: Contact, track: Track) -> Bools:
    """Return True for the phonemes of a track that demand a contact: (n,)."""
    return contact.phonemes[track.ids] & ~track.waived


def held_frames(wanted: Bools, track: Track, first: float, fps: float, count: int) -> Bools:
    """Return True for the frames over which a contact is held: (count,).

    A phoneme holds over its span less `MARGIN` on each side, widened about its middle to
    `SHORTEST` and to one frame. Neighbours that demand the same hold on through their boundary.

    Parameters
    ----------
    wanted : (n,) as from `demands`
    first : seconds of frame 0
    """
    held = np.zeros(count, bool)
    reach = max(SHORTEST, 1 / fps) / 2
    bounds, alike = track.bounds.tolist(), wanted.tolist()
    for at in wanted.nonzero()[0].tolist():  # few: arrays of them would take longer
        start, end = bounds[at], bounds[at + 1]
        middle = (start + end) / 2
        low = min(start if alike[at - 1] else start + MARGIN, middle - reach)
        high = max(end if alike[at + 1] else end - MARGIN, middle + reach)
        # 1e-6 of a frame: a frame on the very boundary belongs to the contact
        begin, last = ceil((low - first) * fps - 1e-6), floor((high - first) * fps + 1e-6)
        held[max(0, begin) : max(0, last + 1)] = True
    return held


def hold(curves: Floats, least: Floats, most: Floats, held: Bools) -> Floats:
    """Raise (P, T) curves to a contact's floors and lower them to its ceilings while it is held.

    Levels may lie beyond 0 and 1. The speed limit then needs more frames to reach them, which
    lengthens the plateau. Clip the curves after the speed limit.

    Parameters
    ----------
    least, most : (P, 1) levels as from `bounds`
    held : (T,)
    """
    out = curves.copy()
    at = held.nonzero()[0]
    out[:, at] = np.minimum(np.maximum(curves[:, at], least), most)
    return out
