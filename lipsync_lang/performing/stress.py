"""Dials from stress and emphasis.

Stressed vowels open the mouth a little wider, unstressed ones a little less, emphasised words a
good deal wider.

Speakers lower the jaw further for stressed vowels (Summers 1987, "Effects of stress and final
consonant voicing on vowel production"; Erickson 2002, "Articulation of extreme formant patterns for
emphasized vowels"). The pose set states the amounts, which are far below those of emphasis.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.pipeline.levels import Dial, Level

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Schedule

UNSTRESSED, PRIMARY, SECONDARY = 0, 1, 2

VOWEL = "vowel"
"""Sound class of the sounds that carry stress."""

SILENT_MANNER, CONSONANT_MANNER, VOWEL_MANNER = 0, 1, 2
"""Sound classes as numbers: silence, sounds without stress, and sounds that carry it."""

RAMP_SECONDS = 0.08
"""Duration of the rise before an emphasised word, and of the fall after it."""

STRESS_REACH_SECONDS = 0.15
"""Time from the middle of a vowel in which its stress has an effect, if no other is nearer."""


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
    ramps = [
        (schedule.times[word.first] - RAMP_SECONDS, schedule.times[word.first],
         schedule.times[word.stop], schedule.times[word.stop] + RAMP_SECONDS)
        for word in words
    ]  # fmt: skip
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
