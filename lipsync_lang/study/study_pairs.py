"""Pairs of a study: balanced, with random order and sides, repeatable by a seed."""

import random
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

from lipsync_lang.errors import LipsyncError
from lipsync_lang.study.study_file import MAX_PAIRS, ClipSide, StudyPair

PAIRS_PER_CHECK = 10
"""Number of pairs per attention check, unless the number of checks is given."""


class ClipPair(NamedTuple):
    """Two methods on one line of one character."""

    line: str
    character: str
    methods: tuple[str, str]


def possible_pairs(
    lines: Sequence[str],
    characters: Sequence[str],
    methods: Sequence[str],
    lacks: Callable[[str, str], bool],
) -> Iterator[ClipPair]:
    """Yield every unordered pair of methods on each line and character.

    Parameters
    ----------
    lacks : True if a method (first) has no curves for a line (second); its pairs are left out
    """
    for character in characters:
        for line in lines:
            there = [method for method in methods if not lacks(method, line)]
            for pair in combinations(there, 2):
                yield ClipPair(line, character, pair)


def in_balanced_order(pairs: Iterable[ClipPair], seed: int) -> Iterator[ClipPair]:
    """Yield the pairs in an order whose first N are balanced, for every N.

    Each next pair has the methods, then the character, then the line with the fewest pairs so far;
    chance decides between equals.
    """
    chance = random.Random(seed)  # noqa: S311 a repeatable order is wanted
    groups: dict[tuple[tuple[str, str], str], list[ClipPair]] = {}
    for pair in pairs:
        groups.setdefault((pair.methods, pair.character), []).append(pair)
    for group in groups.values():
        chance.shuffle(group)
    ties = {key: chance.random() for key in groups}
    methods: Counter[tuple[str, str]] = Counter()
    characters: Counter[str] = Counter()
    lines: Counter[str] = Counter()
    cells: Counter[tuple[tuple[str, str], str]] = Counter()
    while groups:
        key = min(groups, key=lambda k: (methods[k[0]], characters[k[1]], cells[k], ties[k]))
        group = groups[key]
        at = min(range(len(group)), key=lambda n: lines[group[n].line])
        pair = group.pop(at)
        if not group:
            del groups[key]
        methods[pair.methods] += 1
        characters[pair.character] += 1
        cells[key] += 1
        lines[pair.line] += 1
        yield pair


def checks_for(count: int, stated: int | None) -> int:
    """Return the number of attention checks for a number of pairs.

    >>> checks_for(40, None), checks_for(3, None), checks_for(40, 0)
    (4, 1, 0)
    """
    return max(1, round(count / PAIRS_PER_CHECK)) if stated is None else stated


def laid_out(pairs: Sequence[ClipPair], checks: int, seed: int) -> tuple[StudyPair, ...]:
    """Return the pairs with sides, and attention checks among them, in random order.

    Each method of a pair is on the left as often as on the right, give or take one. Both clips
    of a check are by the same method.

    Raises
    ------
    LipsyncError
        There are too many pairs.
    """
    if len(pairs) + checks > MAX_PAIRS:
        raise LipsyncError(
            f"there are {len(pairs) + checks} pairs with the checks; "
            f"a study has at most {MAX_PAIRS} (`pairs`)"
        )
    chance = random.Random(f"{seed} sides")  # noqa: S311 a repeatable choice is wanted
    turned: dict[tuple[str, str], bool] = {}
    rows: list[tuple[str, str, str, str, ClipSide | None]] = []
    for pair in pairs:
        turn = turned.setdefault(pair.methods, chance.random() < 0.5)  # noqa: PLR2004 a coin
        turned[pair.methods] = not turn
        left, right = reversed(pair.methods) if turn else pair.methods
        rows.append((pair.line, pair.character, left, right, None))
    sides: tuple[ClipSide, ClipSide] = ("left", "right")
    first = chance.randrange(2)
    for number in range(checks):
        pair = pairs[number * len(pairs) // checks]
        method, side = pair.methods[0], sides[(first + number // 2) % 2]
        rows.append((pair.line, pair.character, method, method, side))
    chance.shuffle(rows)
    width = max(3, len(str(len(rows))))
    return tuple(
        StudyPair(
            pair=f"p{number:0{width}}", line=line, character=character, left=left, right=right,
            check=check,
        )
        for number, (line, character, left, right, check) in enumerate(rows, 1)
    )  # fmt: skip
