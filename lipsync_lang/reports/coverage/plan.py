"""The order of authoring, from counts: rankings, shares, and short lists of lines.

Bigrams are codes, that is, indices of counts. The most frequent comes first; of equally frequent
ones, the smaller code.
"""

from collections import Counter
from collections.abc import Sequence
from itertools import accumulate

import numpy as np

from lipsync_lang.base.arrays import Ints

PERCENTS = (90, 95, 99, 100)
"""Shares of all occurrences that `needed` reports."""


def ranked(counts: Ints) -> list[int]:
    """Return the indices of counts above 0, most frequent first."""
    # Stable, and signed before the negation: unsigned counts would wrap around.
    order = np.argsort(-counts.astype(np.int64), kind="stable")
    return [int(n) for n in order if counts[n] > 0]


def needed(counts: Sequence[int]) -> dict[str, int]:
    """Return the number of ranked counts that cover each of the `PERCENTS`.

    The most frequent bigrams are the smallest set that covers a share of the occurrences.
    """
    running = list(accumulate(counts))
    total = running[-1] if running else 0
    starts = (0, *running[:-1]) if total else ()
    return {str(share): sum(100 * at < share * total for at in starts) for share in PERCENTS}


def affordable(minutes: float) -> int:
    """Return the number of bigrams that can be authored in an hour, at some minutes each."""
    # 60 / 0.1 is a little below 600 in floats.
    return int(60 / minutes + 1e-9)


def cover(sets: Ints, starts: Ints, wanted: Ints) -> list[tuple[int, list[int]]]:
    """Choose few sets that together have every wanted member, each with those that it adds.

    The greedy choice takes the set with most missing members, then the smallest, then the first.
    At the end, redundant sets are dropped. Gains are updated as members are covered, so that each
    member is searched for once.

    Parameters
    ----------
    sets : members of all sets in sequence; a set has a member once
    starts : (n + 1,) index of each set's first member, and the length of `sets`
    wanted : members to cover; members of no set are ignored
    """
    inside = np.isin(sets, wanted)
    starts = np.asarray(starts, np.int64)
    sizes = np.diff(starts)
    gains = np.zeros(len(sizes), np.int64)
    gains[sizes > 0] = np.add.reduceat(inside, starts[:-1][sizes > 0], dtype=np.int64)
    # One product compares both: more missing members first, and then the smaller set.
    bonus = int(sizes.max(initial=0)) + 1
    chosen: list[int] = []
    missing = set(np.unique(sets[inside]).tolist())
    while missing:
        best = int(np.argmax(gains * bonus - sizes))
        chosen.append(best)
        for member in missing.intersection(_members(sets, starts, best)):
            missing.discard(member)
            at = np.flatnonzero(sets == member)
            gains[np.searchsorted(starts, at, "right") - 1] -= 1
    missing = set(wanted.tolist())
    found: list[tuple[int, list[int]]] = []
    # The greedy choice takes sets that later ones make needless.
    for number in _spared(chosen, sets, starts, wanted):
        new = [member for member in _members(sets, starts, number) if member in missing]
        missing.difference_update(new)
        found.append((number, new))
    return found


def _members(sets: Ints, starts: Ints, number: int) -> list[int]:
    return sets[starts[number] : starts[number + 1]].tolist()


def _spared(chosen: Sequence[int], sets: Ints, starts: Ints, wanted: Ints) -> list[int]:
    """Drop sets whose wanted members are all in other sets, beginning with the last choice."""
    asked = set(wanted.tolist())
    held = {n: asked.intersection(_members(sets, starts, n)) for n in chosen}
    times = Counter(member for members in held.values() for member in members)
    kept: list[int] = []
    for number in reversed(chosen):
        if all(times[member] > 1 for member in held[number]):
            for member in held[number]:
                times[member] -= 1
        else:
            kept.append(number)
    return kept[::-1]
