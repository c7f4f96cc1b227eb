"""Dials from loudness: louder sounds move the mouth further.

Vowels are always louder than stops, so each sound is compared with the median of its sound class in
the same line, in decibels. The overall volume has no effect, because it depends on the microphone.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.errors import LipsyncError
from lipsync_lang.performing.stress import opening
from lipsync_lang.pipeline.arrays import Bools, Floats
from lipsync_lang.pipeline.levels import Dial, Level

if TYPE_CHECKING:
    import numpy.typing as npt

    from lipsync_lang.resolver.compiled import Compiled
    from lipsync_lang.schedules.schedule import Audio, Schedule

MOST = 2.0
"""Maximum intensity; 1 is the setting of the pose set."""

SPAN = 9.0
"""Difference from the median in decibels at the minimum and maximum level."""

FLOOR = 1.0
"""Amplitude of int16 samples that counts as silence; avoids the logarithm of 0."""

_NEAR = (0.25, 0.5, 0.25)
"""Smoothing weights of the previous, current and next sound."""


def loudness_dial(
    compiled: "Compiled",
    schedule: "Schedule",
    classes: Sequence[str],
    intensity: float,
) -> Dial | None:
    """Return the dial for loudness; None if the intensity is 0.

    Parameters
    ----------
    classes : (n,) sound class of each phoneme; empty for silence
    intensity : 0 for no effect, 1 for the setting of the pose set, 2 for twice that

    Raises
    ------
    LipsyncError
        The intensity is out of range, the pose set names no region, or the schedule has no audio.
    """
    if not 0 <= intensity <= MOST:
        raise LipsyncError(f"intensity {intensity:g}: give a number from 0 to {MOST:g}")
    if intensity == 0:
        return None
    stated = compiled.intensity
    if stated is None:
        region = next(iter(compiled.regions), "REGION")
        raise LipsyncError(
            f"{compiled.poseset} does not say what loudness moves; "
            f"add `intensity: {{regions: [{region}]}}` to the pose set"
        )
    if schedule.audio is None:
        raise LipsyncError(
            f"{schedule.source} has no sound to take the loudness from; "
            "speak a text, or give the recording with the timed phonemes"
        )
    limits = (stated["least"], stated["most"])
    level = levels(schedule, schedule.audio, classes, intensity, limits)
    return Dial(opening(compiled), level, "loudness")


def levels(
    schedule: "Schedule",
    audio: "Audio",
    classes: Sequence[str],
    intensity: float,
    limits: tuple[float, float],
) -> Level:
    """Return the level over time: 1 at the median loudness of the sound class, within limits.

    The points are at the middle of each sound, with linear interpolation between them.
    """
    sounding = np.array([bool(one) for one in classes])
    if not sounding.any():
        return Level(np.zeros(1), np.ones(1))
    above = _above(_decibels(audio, schedule.times), np.array(classes), sounding)
    share = np.clip(_smooth(above, sounding) / SPAN, -1, 1)
    least, most = limits
    values = 1 + intensity * share * np.where(share > 0, most - 1, 1 - least)
    middles = (schedule.times[:-1] + schedule.times[1:]) / 2
    return Level(middles[sounding], np.maximum(values[sounding], 0.0))


def _decibels(audio: "Audio", times: Floats) -> Floats:
    """Return the loudness of each scheduled span in decibels: (n,); 0 for silence."""
    # A cumulative sum gives the power of every span without a loop over spans.
    power = np.concatenate([[0.0], np.cumsum(audio.samples.astype(np.float64) ** 2)])
    at = np.clip(np.rint(times * audio.rate), 0, len(audio.samples)).astype(np.intp)
    counts = np.maximum(np.diff(at), 1)
    return 10 * np.log10(np.maximum(np.diff(power[at]) / counts, FLOOR**2))


def _above(decibels: Floats, classes: "npt.NDArray[np.str_]", sounding: Bools) -> Floats:
    """Return each loudness relative to the median of its class: (n,) decibels; 0 in silence."""
    out = np.zeros(len(decibels))
    for one in set(classes[sounding]):
        here = classes == one
        # The median is robust against a few stressed sounds.
        out[here] = decibels[here] - np.median(decibels[here])
    return out


def _smooth(values: Floats, sounding: Bools) -> Floats:
    """Smooth neighbouring values within each run of sounds."""
    out = values.copy()
    cuts = np.flatnonzero(np.diff(sounding)) + 1
    for low, high in pairwise([0, *cuts, len(values)]):
        out[low:high] = np.convolve(np.pad(values[low:high], 1, mode="edge"), _NEAR, "valid")
    return out
