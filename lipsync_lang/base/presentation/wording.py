"""Format of numbers and lists in the page; a no-break space separates number and unit."""

from collections.abc import Iterable, Sequence
from os.path import commonprefix

from lipsync_lang.base.presentation.percentages import percentage_text

NBSP = "\N{NO-BREAK SPACE}"
MAX_LISTED_NAMES = 3
"""Maximum number of names in a list."""

TENTHS = 10


def percent(share: float) -> str:
    """Write a percentage."""
    return percentage_text(share, NBSP)


def hours(time: float) -> str:
    """Format a time: `25 min`, `3.5 h`, `34 h`."""
    minutes = round(time * 60)
    if minutes < 60:  # noqa: PLR2004 of an hour
        return f"{minutes}{NBSP}min"
    shown = f"{time:,.0f}" if time >= TENTHS else f"{time:.1f}".removesuffix(".0")
    return f"{shown}{NBSP}h"


def count(number: int, noun: str, nouns: str = "") -> str:
    """Format a number with its noun: `1 bigram`, `1,240 bigrams`."""
    return f"{number:,}{NBSP}{noun if number == 1 else nouns or noun + 's'}"


def listed(names: Sequence[str], shown: int = MAX_LISTED_NAMES) -> str:
    """Format names as a list in a sentence: `a`, `a and b`, `a, b and 3 more`."""
    most = list(names[:shown])
    if len(names) > shown:
        most.append(f"{len(names) - shown} more")
    *rest, last = most or ["none"]
    return f"{', '.join(rest)} and {last}" if rest else last


def folder(paths: Sequence[str]) -> str:
    """Return the common folder of all paths, with its separator; empty without one."""
    # The longest common text may end within the name of a folder.
    start = commonprefix(list(paths))  # noqa: RUF071 it is cut at a separator
    return start[: max(start.rfind("/"), start.rfind("\\")) + 1]


def gathered(places: Iterable[str]) -> str:
    """Format places, grouped by file: `act1.csv:3, 17; act2.csv:5`."""
    lines: dict[str, list[str]] = {}
    for place in places:
        file, colon, line = place.rpartition(":")
        lines.setdefault(file + colon, []).append(line)
    return "; ".join(f"{file}{', '.join(found)}" for file, found in lines.items())
