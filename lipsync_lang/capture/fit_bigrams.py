"""Fits of bigrams: individual curves for pairs with enough occurrences.

Conventions: R drafted rows, P poses, n control values; the first and the last are always at rest.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from lipsync_lang.banks.draft import TIMES
from lipsync_lang.capture.fit_lines import FitLine, occurrences
from lipsync_lang.capture.fit_slopes import control_slopes
from lipsync_lang.capture.fit_solver import solve
from lipsync_lang.capture.fit_targets import OCCURRENCE_SECONDS, seen_poses, seen_rows
from lipsync_lang.capture.fit_values import FitFace, FitValues
from lipsync_lang.pipeline.arrays import Bools, Floats

ENOUGH_OCCURRENCES = 10
"""Minimum number of occurrences of a bigram with fitted curves."""

BIGRAM_PRIOR_OCCURRENCES = 10.0
"""Number of occurrences with the same weight as the draft."""


def fit_bigrams(
    face: FitFace,
    base: FitValues,
    lines: Sequence[FitLine],
    enough: int = ENOUGH_OCCURRENCES,
) -> FitValues:
    """Return values with fitted curves for bigrams with enough occurrences."""
    often = occurrences(lines, len(face.tables.curves))[face.rows] >= enough
    rows = np.flatnonzero(often)
    if not rows.size:
        return base
    free = _free(len(rows), seen_poses(lines))
    drafts = face.controls(replace(base, bigrams={}))[rows]
    strength = BIGRAM_PRIOR_OCCURRENCES * OCCURRENCE_SECONDS * lines[0].frames.fps / len(TIMES)
    start = np.zeros(int(free.sum()))

    def values(vector: Floats) -> FitValues:
        changes = np.zeros(drafts.shape)
        changes[free] = vector
        return replace(base, bigrams=dict(zip(face.rows[rows].tolist(), changes, strict=True)))

    def errors(vector: Floats) -> Floats:
        return face.errors(values(vector), lines)

    def slopes(vector: Floats) -> Any:
        columns = control_slopes(face, values(vector), lines).columns(rows)
        return seen_rows(lines, columns[:, np.flatnonzero(free.ravel())])

    bounds = -drafts[free], 1 - drafts[free]
    return values(solve(start, _prior(len(start), strength), bounds, errors, slopes))


def _free(rows: int, seen: Bools) -> Bools:
    """Return True for the control values that a fit may change: (rows, P, n)."""
    out = np.zeros((rows, len(seen), len(TIMES)), bool)
    out[:, seen, 1:-1] = True
    return out


def _prior(count: int, strength: float) -> Any:
    from scipy import sparse

    return sparse.identity(count, format="csr") * np.sqrt(strength)
