"""Hold contacts: lips that must meet do meet, however short the sound.

Conventions: times are seconds; (n,) is phonemes and (P, T) poses by frames.

The paper has no such stage: its fast "p" is as weak as its curve. Here every phoneme that demands
a contact holds it for as long as a viewer needs to see it.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from lipsync_lang.pipeline.arrays import Bools, Floats
from lipsync_lang.pipeline.tables import Contact
from lipsync_lang.pipeline.track import Track

MARGIN = 0.030
"""Seconds of a phoneme, at each side, in which the contact may still be closing or opening."""

SHORTEST = 0.042
"""Seconds for which a contact is held at least: one frame of film."""


class Plateau(NamedTuple):
    """Weight at which a contact holds a pose, before later stages take their part of it."""

    pose: int
    weight: float
    """0 to 1, or beyond where that makes the plateau long enough."""


def demands(contact: Contact, track: Track) -> Bools:
    """Return True for the phonemes of a track that demand a contact: (n,)."""
    return contact.phonemes[track.ids] & ~track.waived


def held_frames(wanted: Bools, track: Track, first: float, fps: float, count: int) -> Bools:
    """Return True for the frames over which a contact is held.

    A phoneme holds over its span less `MARGIN` on each side, widened about its middle to
    `SHORTEST` and to one frame. Neighbours that demand the same hold on through their boundary.

    Parameters
    ----------
    wanted : (n,) as from `demands`
    first : seconds of frame 0

    Returns
    -------
    (count,)
    """
    at = np.flatnonzero(wanted)
    start, end = track.bounds[at], track.bounds[at + 1]
    reach = max(SHORTEST, 1 / fps) / 2
    middle = (start + end) / 2
    low = np.minimum(start + MARGIN * ~wanted[at - 1], middle - reach)
    high = np.maximum(end - MARGIN * ~wanted[at + 1], middle + reach)
    begin = np.ceil((low - first) * fps - 1e-6).tolist()
    stop = np.floor((high - first) * fps + 1e-6).tolist()
    held = np.zeros(count, bool)
    for a, b in zip(begin, stop, strict=True):
        held[max(0, int(a)) : max(0, int(b) + 1)] = True
    return held


def hold(
    curves: Floats, raised: Iterable[Plateau], lowered: Iterable[Plateau], held: Bools
) -> Floats:
    """Raise (P, T) curves to a contact's floors and lower them to its ceilings where held.

    Levels may lie beyond 0 and 1. The speed limit then needs more frames to reach them, which
    lengthens the plateau. Clip the curves after the speed limit.
    """
    out = curves.copy()
    for pose, weight in raised:
        np.maximum(out[pose], weight, out=out[pose], where=held)
    for pose, weight in lowered:
        np.minimum(out[pose], weight, out=out[pose], where=held)
    return out
