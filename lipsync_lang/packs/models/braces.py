"""Expand braces in names: `mouthSmile{Left,Right}` stands for two names, two braces for four.

Malformed braces are ordinary characters: no name is ever refused here.
"""

import re
from itertools import product
from math import prod

MAX_EXPANDED_NAMES = 256
"""Most names one pattern may expand to; beyond, its braces are ordinary characters."""

_BRACE = re.compile(r"\{([^{},]+(?:,[^{},]+)+)\}")


def expanded(name: str) -> tuple[str, ...]:
    """Return the names that a pattern expands to; a name without braces gives itself.

    The last brace varies fastest: `a{1,2}{x,y}` gives a1x, a1y, a2x, a2y.
    """
    parts = _BRACE.split(name)
    fixed, choices = parts[::2], [inner.split(",") for inner in parts[1::2]]
    stray = any(mark in part for part in fixed for mark in "{}")
    if not choices or stray or prod(map(len, choices)) > MAX_EXPANDED_NAMES:
        return (name,)
    return tuple(
        fixed[0] + "".join(a + b for a, b in zip(chosen, fixed[1:], strict=True))
        for chosen in product(*choices)
    )


def paired(name: str, count: int) -> tuple[tuple[str, ...], ...] | None:
    """Distribute the names of a pattern over `count` others; None if the numbers do not fit.

    Equal numbers pair one to one. A single name goes to each of the others. If `count` is 1, all
    names go to the one.

    Returns
    -------
    `count` tuples of names
    """
    names = expanded(name)
    if len(names) == count:
        return tuple((one,) for one in names)
    return (names,) * count if 1 in {len(names), count} else None
