"""Names that stand for several: `mouthSmile{Left,Right}` is two names, two braces multiply.

Braces that are not well formed are letters like any others: no name is ever refused here.
"""

import re
from itertools import product
from math import prod

MOST = 256
"""Names that one may stand for; of more, the braces are taken as letters."""

_BRACE = re.compile(r"\{([^{},]+(?:,[^{},]+)+)\}")


def expanded(name: str) -> tuple[str, ...]:
    """Return the names that a name stands for: itself where it has no braces.

    The last brace turns fastest: `a{1,2}{x,y}` is a1x, a1y, a2x, a2y.
    """
    parts = _BRACE.split(name)
    fixed, choices = parts[::2], [inner.split(",") for inner in parts[1::2]]
    stray = any(mark in part for part in fixed for mark in "{}")
    if not choices or stray or prod(map(len, choices)) > MOST:
        return (name,)
    return tuple(
        fixed[0] + "".join(a + b for a, b in zip(chosen, fixed[1:], strict=True))
        for chosen in product(*choices)
    )


def paired(name: str, count: int) -> tuple[tuple[str, ...], ...] | None:
    """Pair the names that a name stands for off with `count` others; None where they do not fit.

    As many go one to one; a single one goes with each; several go together with a single other.
    """
    names = expanded(name)
    if len(names) == count:
        return tuple((one,) for one in names)
    return (names,) * count if 1 in {len(names), count} else None
