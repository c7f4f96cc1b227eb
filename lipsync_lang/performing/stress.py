"""Dials from stress and emphasis.

Stressed vowels open the mouth a little wider, unstressed ones a little less, emphasised words a
good deal wider.

Speakers lower the jaw further for stressed vowels (Summers 1987, "Effects of stress and final
consonant voicing on vowel production"; Erickson 2002, "Articulation of extreme formant patterns for
emphasized vowels"). The pose set states by how much; its amounts are far below those of emphasis.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.pipeline.arrays import Bools
from lipsync_lang.pipeline.levels import Dial, Level

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Schedule

UNSTRESSED, PRIMARY, SECONDARY = 0, 1, 2

RAMP_SECONDS = 0.08
"""Time over which an emphasised word begins, and ends, to open the mouth wider."""


def stress_dial(
    stated: Mapping[str, Any] | None,
    schedule: "Schedule",
    stresses: Sequence[int | None],
    factor: float,
    poses: Bools,
) -> Dial | None:
    """Return the dial for stress; None if nothing is marked or the pose set states no amounts.

    Parameters
    ----------
    stated : the pose set's `intensity`
    stresses : stress of each vowel, None for other sounds; empty if nothing marks any
    factor : 0 for no effect, 1 for the setting of the pose set
    poses : (P,) True for the poses that effort moves
    """
    if stated is None or not factor or not stresses:
        return None
    levels = {
        PRIMARY: max(1 + factor * (stated["stressed"] - 1), 0.0),
        SECONDARY: 1.0,
        UNSTRESSED: max(1 + factor * (stated["unstressed"] - 1), 0.0),
    }
    vowels = [number for number, stress in enumerate(stresses) if stress is not None]
    if not vowels:
        return None
    middles = (schedule.times[:-1] + schedule.times[1:]) / 2
    values = [levels[stress] for stress in stresses if stress is not None]
    level = Level(middles[vowels], np.array(values))
    return Dial(poses, level, "stress")


def emphasis_dial(
    stated: Mapping[str, Any] | None, schedule: "Schedule", poses: Bools
) -> Dial | None:
    """Return the dial for emphasised words; None if there are none, or nothing for them to move.

    The parameters are those of `stress_dial`.
    """
    words = [word for word in schedule.words if word.emphasis]
    if stated is None or not words:
        return None
    ramps = [
        (schedule.times[word.first] - RAMP_SECONDS, schedule.times[word.first],
         schedule.times[word.stop], schedule.times[word.stop] + RAMP_SECONDS)
        for word in words
    ]  # fmt: skip
    times = np.unique(np.array(ramps))
    highs = [word.emphasis * (stated["emphasised"] - 1) for word in words]
    rises = [
        np.interp(times, ramp, (0, high, high, 0)) for ramp, high in zip(ramps, highs, strict=True)
    ]
    return Dial(poses, Level(times, 1 + np.max(rises, axis=0)), "emphasis")
