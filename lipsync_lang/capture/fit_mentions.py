"""Poses added to targets, because captures show them at phonemes without them.

Conventions: N targets, M steps, P poses, O occurrences.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from lipsync_lang.capture.fit_lines import FitLine
from lipsync_lang.capture.fit_values import FitFace, FitValues
from lipsync_lang.pipeline.arrays import Bools, Floats, Ints

ENOUGH_SHOWN = 8
"""Minimum number of occurrences for an added pose."""

LEAST_SHOWN = 0.06
"""Minimum mean weight above the curves for an added pose."""

SURE_SPREADS = 5.0
"""Minimum ratio of the mean weight and its standard error."""


def with_mentions(face: FitFace, values: FitValues, lines: Sequence[FitLine]) -> FitValues:
    """Return values with the poses added that the lines show beyond the curves.

    Only signals of a single pose count, because a sum of poses does not identify one.
    """
    sums = np.zeros((3, len(face.names), values.weights.shape[2]))
    for numbers, poses, means in _occurrences(face, values, lines):
        known, filled = np.isfinite(means), np.nan_to_num(means)
        for kind, added in enumerate((known, filled, filled**2)):
            np.add.at(sums[kind], (numbers[:, None], poses), added)
    count, total, squares = sums
    mean = total / np.maximum(count, 1)
    error = np.sqrt(np.maximum(squares / np.maximum(count, 1) - mean**2, 0) / np.maximum(count, 1))
    new: Bools = (
        (count >= ENOUGH_SHOWN)
        & (mean >= LEAST_SHOWN)
        & (mean >= SURE_SPREADS * error)
        & ~values.mentioned
        & (face.steps > 0)[:, None]
    )
    if not new.any():
        return values
    there = np.arange(values.weights.shape[1])[None, :, None] < face.steps[:, None, None]
    shown = (mean[:, None, :] * there).clip(0, 1)
    return replace(
        values,
        weights=np.where(new[:, None, :], shown, values.weights),
        dominance=np.where(new, 0.0, values.dominance),
        mentioned=values.mentioned | new,
    )


def _occurrences(
    face: FitFace, values: FitValues, lines: Sequence[FitLine]
) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Yield targets (O,), poses (S,), and mean weights above the curves (O, S) of each line."""
    target = face.targeted
    for line, shown in zip(lines, face.shown(values, lines), strict=True):
        alone = np.flatnonzero((line.gains != 0).sum(axis=1) == 1)
        poses = (line.gains[alone] != 0).argmax(axis=1)
        gains = line.gains[alone, poses]
        beyond = (line.wanted[:, alone] - shown[:, alone]) / gains
        sounds = np.flatnonzero(target[line.track.ids] >= 0)
        middles = line.track.bounds[sounds] + np.diff(line.track.bounds)[sounds] / 2
        at = np.rint((middles - line.frames.times()[0]) * line.frames.fps).astype(int)
        kept = (at >= 0) & (at < len(beyond))
        yield target[line.track.ids[sounds[kept]]], poses, beyond[at[kept]]
