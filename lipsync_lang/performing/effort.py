"""Dials from effort: loud sounds, stressed vowels and emphasised words move the mouth further.

Speech is compared with a reference: its active level, the mean power of the sounds of about two
seconds without the pauses (as ITU-T P.56 measures it), against that of ordinary speech. Microphones
and mixes differ, so the first `TOLERANCE` decibels of that do not count. The level of a single
sound tells little of its mouth: on filmed lips and on articulographs, r falls if it counts.

Within a line the jaw also follows the energy of each frame, against the median of all: the mouth is
widest where the voice is loudest, which is not always the middle of a vowel.

Speakers lower the jaw further for stressed vowels (Summers 1987, "Effects of stress and final
consonant voicing on vowel production"; Erickson 2002, "Articulation of extreme formant patterns for
emphasized vowels"). The pose set states the amounts, which are far below those of emphasis.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.sound_memory import kept_with
from lipsync_lang.pipeline import kernel
from lipsync_lang.pipeline.levels import Dial, Level
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.resolver.compiled import CompiledPair
from lipsync_lang.schedules.schedule import Schedule

UNSTRESSED, PRIMARY, SECONDARY = 0, 1, 2

VOWEL = "vowel"
"""Sound class of the sounds that carry stress."""

SILENT_MANNER, CONSONANT_MANNER, VOWEL_MANNER = 0, 1, 2
MANNERS = {"": SILENT_MANNER, VOWEL: VOWEL_MANNER}
"""Sound classes as numbers: silence, sounds without stress, and sounds that carry it."""

RAMP_SECONDS = 0.08
"""Duration of the rise before an emphasised word, and of the fall after it."""

STRESS_REACH_SECONDS = 0.15
"""Time from the middle of a vowel in which its stress has an effect, if no other is nearer."""

MOST = 2.0
"""Maximum intensity; 1 is the setting of the pose set."""

AROUND_SECONDS = 1.0
"""Time on each side of a sound over which the level of the speech is measured."""

SPAN = 4.5
"""Difference from the reference, beyond the tolerance, in decibels at the least and most level."""

BLOCK_SAMPLES = 1 << 20
"""Samples that are squared at once."""

ENERGY_STEP_SECONDS = 0.01
"""Distance of the frames whose energy is measured."""

ENERGY_REACH_SECONDS = 0.03
"""Time on each side of a frame over which its energy is measured: a jaw follows no faster."""

ENERGY_SHARE = 0.1
"""Largest share by which the energy of a frame raises or lowers the level."""

ENERGY_SPAN = 12.0
"""Difference of a frame from the line's median in decibels at which that share is reached."""

TOLERANCE = 6.0
"""Difference of the speech from the reference level in decibels that has no effect."""

FULL_SCALE = 32768.0
"""Amplitude of int16 samples at 0 dBFS."""

FLOOR = 1.0
"""Amplitude of int16 samples that counts as silence; avoids the logarithm of 0."""


def stress_levels(stated: Mapping[str, Any], factor: float) -> dict[int, float]:
    """Return the level of a vowel for each stress; see `stress_dial`."""
    return {
        PRIMARY: max(1 + factor * (stated["stressed"] - 1), 0.0),
        SECONDARY: 1.0,
        UNSTRESSED: max(1 + factor * (stated["unstressed"] - 1), 0.0),
    }


def vowel_level(middles: Floats, values: Floats) -> Level:
    """Return the level of vowels over time: straight lines that return to 1 far from vowels.

    A level depends only on vowels within twice `STRESS_REACH_SECONDS`, so a stream need not wait
    for the vowel after a pause.

    Parameters
    ----------
    middles, values : (V,) seconds and level of each vowel
    """
    # between vowels that lie closer, the lines back to 1 would cross
    apart = np.flatnonzero(np.diff(middles) > 2 * STRESS_REACH_SECONDS)
    after = np.concatenate((middles[apart], middles[-1:])) + STRESS_REACH_SECONDS
    before = np.concatenate((middles[:1], middles[apart + 1])) - STRESS_REACH_SECONDS
    times = np.concatenate((middles, after, before))
    # stable, so that of two points at one time the vowel comes first
    order = np.argsort(times, kind="stable")
    ones = np.ones(len(after) + len(before))
    return Level(times[order], np.concatenate((values, ones))[order])


class StressMarks:
    """Reads marks of stress label by label.

    A mark before a consonant belongs to the vowel after it, as the IPA writes stress. The mark ends
    at a silence.
    """

    def __init__(self, before: int | None = None) -> None:
        self.before = before

    def of(self, mark: int | None, kind: str) -> int | None:
        """Return the stress of the next label; None if it is not a vowel.

        Parameters
        ----------
        mark : mark of the label, if any
        kind : sound class of the label; empty for silence
        """
        if kind == VOWEL:
            stress = mark if mark is not None else self.before or UNSTRESSED
            self.before = None
            return stress
        self.before = (mark or self.before) if kind else None
        return None


def stresses_of(marks: Ints, manners: Ints) -> Ints:
    """Return the stress of each label, as `StressMarks` reads them; -1 if it is not a vowel: (n,).

    Parameters
    ----------
    marks : (n,) mark of each label; -1 for none
    manners : (n,) 0 for silence, 2 for a vowel, 1 for other sounds
    """
    at = np.arange(len(marks))
    vowel, clears = manners == VOWEL_MANNER, manners != CONSONANT_MANNER
    # index of the latest mark, and of the latest label that ends one: a running maximum
    # of indices replaces the loop of `StressMarks`
    carried = np.maximum.accumulate(np.where(~clears & (marks > 0), at, -1))
    cleared = np.maximum.accumulate(np.where(clears, at, -1))
    # one step later: a vowel takes the mark before it, and ends it for the labels after
    cleared[1:] = cleared[:-1]
    cleared[0] = -1
    passed = np.where(carried > cleared, marks[carried], UNSTRESSED)
    return np.where(vowel, np.where(marks >= 0, marks, passed), -1)


def stress_dial(
    stated: Mapping[str, Any] | None,
    schedule: "Schedule",
    stresses: Ints,
    factor: float,
    poses: Bools,
) -> Dial | None:
    """Return the dial for stress; None without marks, or without amounts in the pose set.

    Parameters
    ----------
    stated : the pose set's `intensity`
    stresses : (n,) stress of each vowel, -1 for other sounds; empty without marks
    factor : 0 for no effect, 1 for the setting of the pose set
    poses : (P,) True for the poses that effort moves
    """
    if stated is None or not factor or not stresses.size:
        return None
    vowels = np.flatnonzero(stresses >= 0)
    if not vowels.size:
        return None
    middles = (schedule.times[:-1] + schedule.times[1:]) / 2
    known = stress_levels(stated, factor)
    # a table by stress, so that one index turns all vowels into levels
    levels = np.array([known[stress] for stress in sorted(known)])
    return Dial(poses, vowel_level(middles[vowels], levels[stresses[vowels]]), "stress")


def emphasis_dial(
    stated: Mapping[str, Any] | None, schedule: "Schedule", poses: Bools
) -> Dial | None:
    """Return the dial for emphasised words; None without such words or without amounts.

    The parameters are those of `stress_dial`.
    """
    words = [word for word in schedule.words if word.emphasis]
    if stated is None or not words:
        return None
    spans = [schedule.times[[word.first, word.stop]] for word in words]
    ramps = [(start - RAMP_SECONDS, start, end, end + RAMP_SECONDS) for start, end in spans]
    highs = [word.emphasis * (stated["emphasised"] - 1) for word in words]
    return Dial(poses, ramped_level(ramps, highs), "emphasis")


def ramped_level(ramps: Sequence[Sequence[float]], highs: Sequence[float]) -> Level:
    """Return the level of emphasised words.

    Parameters
    ----------
    ramps : four times of each word: begin of the rise, start, end, and end of the fall
    highs : increase of the level by each word
    """
    times = np.unique(np.array(ramps))
    # words may follow so closely that their ramps overlap: the higher one counts
    rises = [
        np.interp(times, ramp, (0, high, high, 0)) for ramp, high in zip(ramps, highs, strict=True)
    ]
    return Level(times, 1 + np.max(rises, axis=0))


def loudness_dial(  # noqa: PLR0913, PLR0917 the loudness, and settings for it
    compiled: CompiledPair,
    schedule: Schedule,
    spoken: Bools,
    intensity: float | None,
    motion: Motion,
    poses: Bools,
) -> Dial | None:
    """Return the dial for loudness; None if the intensity is 0.

    Raises LipsyncError if the intensity is out of range, the pose set names no region, or the
    schedule has no audio.

    Parameters
    ----------
    spoken : (n,) False for silence
    intensity : 0 for no effect, 1 for the setting of the pose set, 2 for twice that; None for the
        motion's `loudness`, without an error if there is no sound or no region
    motion : its `loudness` and `reference_level`
    poses : (P,) True for the poses that effort moves
    """
    stated = compiled.intensity
    if intensity is None:
        missing = stated is None or schedule.audio is None
        intensity = 0.0 if missing else motion.loudness
    if not 0 <= intensity <= MOST:
        raise LipsyncError(f"intensity {intensity:g}: give a number from 0 to {MOST:g}")
    if intensity == 0:
        return None
    if stated is None:
        region = next(iter(compiled.regions), "REGION")
        raise LipsyncError(
            f"{compiled.poseset} has no regions for loudness; "
            f"add `intensity: {{regions: [{region}]}}` to the pose set"
        )
    if schedule.audio is None:
        raise LipsyncError(
            f"{schedule.source} has no recording, whose loudness this effect needs; "
            "speak a text, or give the recording with the timed phonemes"
        )
    limits = (stated["least"], stated["most"])
    usual = schedule.audio.usual_level
    reference = motion.reference_level if usual is None else usual

    def level() -> Level:
        slow = levels(schedule, spoken, intensity, limits, reference)
        return frame_levels(slow, schedule, intensity, limits)

    # another take of the line may have the same sound at other times
    given = (schedule.times.tobytes(), spoken.tobytes(), intensity, limits, reference)
    return Dial(poses, kept_with(schedule.audio, "loudness", given, level), "loudness")


def levels(
    schedule: Schedule,
    spoken: Bools,
    intensity: float,
    limits: tuple[float, float],
    reference: float,
) -> Level:
    """Return the level over time, within limits; 1 without sound, or near the `reference` in dBFS.

    The points are at the middle of each sound, with linear interpolation between them.

    Parameters
    ----------
    spoken : (n,) False for silence
    """
    if schedule.audio is None or not spoken.any():
        return Level(np.zeros(1), np.ones(1))
    audio, times = schedule.audio, schedule.times
    cuts = np.clip(np.rint(times * audio.rate), 0, len(audio.samples)).astype(np.intp)
    powers = np.diff(energies(audio.samples, cuts))[spoken]
    counts = np.diff(cuts)[spoken]
    middles = ((times[:-1] + times[1:]) / 2)[spoken]
    # sounds around count by their samples, so that long ones count for more
    first = np.searchsorted(middles, middles - AROUND_SECONDS)
    stop = np.searchsorted(middles, middles + AROUND_SECONDS, side="right")
    # differences of running sums: a window costs the same however wide it is
    sums = (np.append(0, one.cumsum()) for one in (powers, counts))
    power, count = (one[stop] - one[first] for one in sums)
    far = 10 * np.log10((power / count.clip(1)).clip(FLOOR**2) / FULL_SCALE**2) - reference
    beyond = np.sign(far) * (np.abs(far) - TOLERANCE).clip(0)
    share = (beyond / SPAN).clip(-1, 1)
    least, most = limits
    # a louder voice moves towards the upper limit, a softer one towards the lower, so the
    # two limits need not lie equally far from 1
    values = 1 + intensity * share * np.where(share > 0, most - 1, 1 - least)
    return Level(middles, values.clip(0))


def energies(samples: npt.NDArray[np.int16], cuts: Ints) -> Ints:
    """Return the exact sum of squares before each cut; cuts are in order, and 0 to the length."""
    sums = np.zeros(len(cuts), np.int64)
    if kernel.compiled is not None:
        kernel.compiled.energies(np.require(samples, np.int16, ["C", "A"]), cuts, sums)
        return sums
    before = 0
    for start in range(0, len(samples), BLOCK_SAMPLES):  # sound may last an hour
        squares = np.square(samples[start : start + BLOCK_SAMPLES], dtype=np.int64)
        running = np.append(before, squares).cumsum()
        first, stop = cuts.searchsorted((start, start + len(running)))
        sums[first:stop] = running[cuts[first:stop] - start]
        before = running[-1]
    return sums


def frame_levels(
    slow: Level, schedule: Schedule, intensity: float, limits: tuple[float, float]
) -> Level:
    """Raise a level where a frame is louder than the median of the line, and lower it elsewhere.

    Parameters
    ----------
    slow : level of the speech, at the middle of each sound
    intensity : 0 for no effect of a frame, 1 for the full share
    """
    audio = schedule.audio
    if audio is None or len(slow.times) < 2:  # noqa: PLR2004 one sound has nothing to compare
        return slow
    first, last = slow.times[0], slow.times[-1]
    # the last sound seldom ends on a step
    middles = np.append(np.arange(first, last, ENERGY_STEP_SECONDS), last)
    ends = (middles + np.array([[-1], [1]]) * ENERGY_REACH_SECONDS).clip(first, last)
    start, stop = np.rint(ends * audio.rate).clip(0, len(audio.samples)).astype(np.intp)
    # at the ends of a line a frame may hold no sample
    count = (stop - start).clip(1)
    power = (energies(audio.samples, stop) - energies(audio.samples, start)) / count
    decibels = 10 * np.log10(power.clip(FLOOR**2))
    share = ((decibels - np.median(decibels)) / ENERGY_SPAN).clip(-1, 1)
    least, most = limits
    values = slow.at(middles) + intensity * ENERGY_SHARE * share
    lowest, highest = 1 - intensity * (1 - least), 1 + intensity * (most - 1)
    return Level(middles, values.clip(max(lowest, 0.0), highest))
