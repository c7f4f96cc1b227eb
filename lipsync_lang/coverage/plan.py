"""What to author, and in which order: counts in, plans out.

Bigrams are numbers here. What occurs most often comes first; of equals, the smaller number.
"""

from collections.abc import Sequence
from itertools import accumulate

import numpy as np
import numpy.typing as npt

Ints = npt.NDArray[np.integer]

SHARES = (90, 95, 99, 100)
"""Percent of all occurrences that are asked for."""


def ranked(counts: Ints) -> list[int]:
    """Return the numbers of what occurs, most frequent first."""
    order = np.argsort(-counts.astype(np.int64), kind="stable")
    return [int(n) for n in order if counts[n] > 0]


def percent(part: float, whole: float) -> float:
    """Return a share of 100, to four digits; of nothing, none."""
    return round(100 * part / whole, 4) if whole else 0.0


def needed(counts: Sequence[int]) -> dict[str, int]:
    """Return how many of ranked counts cover each of the `SHARES`.

    The most frequent ones are the smallest set that covers a share of the occurrences.
    """
    running = list(accumulate(counts))
    total = running[-1] if running else 0
    return {
        str(share): sum(100 * before < share * total for before in (0, *running[:-1]))
        if total
        else 0
        for share in SHARES
    }


def affordable(minutes: float, hours: float = 1.0) -> int:
    """Return how many bigrams can be authored in some hours."""
    return int(60 * hours / minutes + 1e-9)


def cover(sets: Ints, starts: Ints, wanted: Ints) -> list[tuple[int, list[int]]]:
    """Choose few sets that hold, together, everything wanted that any of them holds.

    Greedy: each time the set with most that is still missing, of equals the smallest, then the
    first. Afterwards those are left out whose members all are in others. The gain of every set is
    kept up to date, so that each member is looked at once, when it is covered.

    Parameters
    ----------
    sets : all members of all sets, one set after the other; a set holds a member once
    starts : (n + 1,) where each set starts, and where the last ends
    wanted : members to cover

    Returns
    -------
    The numbers of the sets in the order of choosing, with what each is the first to hold.
    """
    inside = np.isin(sets, wanted)
    starts = np.asarray(starts, np.int64)
    sizes = np.diff(starts)
    gains = np.zeros(len(sizes), np.int64)
    gains[sizes > 0] = np.add.reduceat(inside, starts[:-1][sizes > 0], dtype=np.int64)
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
    return _in_order(_spared(chosen, sets, starts, wanted), sets, starts, wanted)


def _members(sets: Ints, starts: Ints, number: int) -> list[int]:
    members: list[int] = sets[starts[number] : starts[number + 1]].tolist()
    return members


def _spared(chosen: Sequence[int], sets: Ints, starts: Ints, wanted: Ints) -> list[int]:
    """Leave out sets whose wanted members are all in others, the last chosen first."""
    asked = set(wanted.tolist())
    held = {n: asked.intersection(_members(sets, starts, n)) for n in chosen}
    times: dict[int, int] = {}
    for members in held.values():
        for member in members:
            times[member] = times.get(member, 0) + 1
    kept: list[int] = []
    for number in reversed(chosen):
        if all(times[member] > 1 for member in held[number]):
            for member in held[number]:
                times[member] -= 1
        else:
            kept.append(number)
    return kept[::-1]


def _in_order(
    chosen: Sequence[int], sets: Ints, starts: Ints, wanted: Ints
) -> list[tuple[int, list[int]]]:
    missing = set(wanted.tolist())
    found: list[tuple[int, list[int]]] = []
    for number in chosen:
        new = [m for m in _members(sets, starts, number) if m in missing]
        missing.difference_update(new)
        found.append((number, new))
    return found
