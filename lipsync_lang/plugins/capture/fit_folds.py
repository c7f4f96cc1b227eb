"""Cross-validation: fits without some lines or speakers, tested on these.

Conventions: an error is a root mean square over all recorded values, in weights of a pose; signals
without a scale are in units of the curves before the fit.
"""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from lipsync_lang import LipsyncError
from lipsync_lang.base.arrays import Ints
from lipsync_lang.base.errors import shortlist
from lipsync_lang.base.files.child_processes import child_pool
from lipsync_lang.plugins.capture.fit_lines import FitLine
from lipsync_lang.plugins.capture.fit_steps import fit_bigrams, fit_motion, fit_targets
from lipsync_lang.plugins.capture.fit_values import FitFace, FitValues, with_mentions

MOST_FOLDS = 5
"""Maximum number of parts of the lines or speakers."""

TRIED_SHARES = (0.25, 0.5, 0.75, 1.0)
"""Shares of the change from the values before the fit to the fitted values, to be compared."""

BIGRAM_SHARES = (0.5, 1.0)
"""The same for the curves of bigrams."""

MAX_FOLD_NAMES = 4
"""Maximum number of lines or speakers in the name of a part."""

BIGRAM_WORTH = 0.99
"""Maximum ratio of the held-out error with and without fitted bigrams. A small gain is ignored,
because the average of timing errors causes one too."""

By = Literal["line", "speaker"]


@dataclass(frozen=True, eq=False)
class FitTask:
    """Input of a fit, which is sent to worker processes."""

    face: FitFace
    lines: tuple[FitLine, ...]
    softness: Mapping[str, Ints]
    """Poses that take the softness of their region, by region."""
    anticipate: Mapping[str, Ints]
    """Poses with anticipation, by region."""

    def fit(self, kept: Sequence[int]) -> FitValues:
        """Fit targets, then motion, then bigrams to some of the lines."""
        lines = [self.lines[number] for number in kept]
        found = fit_targets(self.face, self.face.start, lines)
        named = with_mentions(self.face, found, lines)
        if named is not found:
            found = fit_targets(self.face, named, lines)
        groups = self.softness.values(), self.anticipate.values()
        found = fit_motion(self.face, found, lines, *groups)
        return fit_bigrams(self.face, found, lines)

    def error(self, values: FitValues, tested: Sequence[int]) -> float:
        """Return the error of some values on some lines."""
        lines = [self.lines[number] for number in tested]
        errors = self.face.errors(values, lines)
        count = sum(int(line.seen.sum()) for line in lines)
        return float(np.sqrt((errors**2).sum() / max(count, 1)))


class Fold(NamedTuple):
    """A part of the lines that a fit leaves out."""

    by: By
    name: str
    kept: tuple[int, ...]
    tested: tuple[int, ...]


class FitShares(NamedTuple):
    """Accepted shares of the change by a fit; 0 refuses it."""

    values: float
    bigrams: float


def folds(lines: Sequence[FitLine]) -> list[Fold]:
    """Divide lines into parts, and also speakers if there are several; one line has no parts."""
    found = list(_parts("line", [line.captured.name for line in lines]))
    speakers = [line.captured.speaker for line in lines]
    if len(set(speakers)) > 1:
        found += _parts("speaker", speakers)
    return found


def _parts(by: By, names: Sequence[str]) -> Iterator[Fold]:
    """Yield folds that keep lines of the same name together."""
    known = list(dict.fromkeys(names))
    count = min(MOST_FOLDS, len(known))
    for part in range(count if count > 1 else 0):
        # In turn instead of in blocks, since lines of one scene lie side by side.
        left = known[part::count]
        tested = tuple(n for n, name in enumerate(names) if name in left)
        kept = tuple(n for n, name in enumerate(names) if name not in left)
        yield Fold(by, shortlist(left, MAX_FOLD_NAMES), kept, tested)


def run_fits(task: FitTask, kept: Sequence[Sequence[int]], workers: int) -> Iterator[FitValues]:
    """Yield the fit to each selection of lines, in order; several workers run as processes."""
    if workers <= 1 or len(kept) <= 1:
        yield from map(task.fit, kept)
        return
    try:
        with child_pool(min(workers, len(kept))) as pool:
            yield from pool.map(task.fit, kept)
    except BrokenProcessPool:
        raise LipsyncError(
            "a process of the fit ended early, perhaps for lack of memory; fit in one process "
            '(workers=1). In a script, put the call under `if __name__ == "__main__":`'
        ) from None


def choose(task: FitTask, parts: Sequence[Fold], fits: Sequence[FitValues]) -> FitShares:
    """Return the shares with the lowest error on held-out lines; 0 if no share lowers it.

    Held-out speakers count as much as held-out lines: the larger error decides.
    """
    start = task.face.start
    before = [task.error(start, part.tested) for part in parts]

    def score(shares: FitShares) -> float:
        return worst(parts, before, errors(task, parts, fits, shares))

    # A ratio of 1 is the error before the fit: a share must lower it to be chosen.
    best, lowest = FitShares(0.0, 0.0), 1.0
    tried = [FitShares(share, 0.0) for share in TRIED_SHARES]
    for shares in tried:
        found = score(shares)
        if found < lowest:
            best, lowest = shares, found
    limit = BIGRAM_WORTH * lowest
    for share in BIGRAM_SHARES if best.values else ():
        shares = FitShares(best.values, share)
        found = score(shares)
        if found < limit:
            best, limit = shares, found
    return best


def errors(
    task: FitTask, parts: Sequence[Fold], fits: Sequence[FitValues], shares: FitShares
) -> list[float]:
    """Return the error of each fold's fit on its held-out lines."""
    start = task.face.start
    return [
        task.error(start.towards(fit, *shares), part.tested)
        for part, fit in zip(parts, fits, strict=True)
    ]


def worst(parts: Sequence[Fold], before: Sequence[float], after: Sequence[float]) -> float:
    """Return the ratio of the mean errors after and before the fit, by lines or by speakers."""
    found = []
    for by in dict.fromkeys(part.by for part in parts):
        own = [number for number, part in enumerate(parts) if part.by == by]
        found.append(sum(after[n] for n in own) / max(sum(before[n] for n in own), 1e-12))
    return max(found)
