"""Wording of numbers and lists in reports and pages.

A percentage has one decimal, and a row of a ranking has two. `100 %` means all, and `0 %` means
nothing: nearly all is `99.9 %`, and nearly nothing is `under 0.1 %`. JSON and CSV hold four
decimals by the same rule.
"""

from collections.abc import Iterable, Sequence
from functools import cache
from os.path import commonprefix
from pathlib import PurePath

from lipsync_lang.base.grouping import grouped

NBSP = "\N{NO-BREAK SPACE}"
"""A no-break space; in pages it separates number and unit."""

SHOWN_PLACE_PARTS = 2
"""Number of parts of a path that pages show, which leaves out home folders."""

MAX_LISTED_NAMES = 3
"""Maximum number of names in a list."""

TENTHS = 10

WHOLE_PERCENT = 100.0

DOCUMENT_DECIMALS = 4
LEAST_STEP = 1e-4
LEAST, MOST = 0.05, 99.95
"""Bounds beyond which one decimal would show nothing, or all."""


def percent(part: float, whole: float) -> float:
    """Return part of whole in percent, as documents hold it; 0 if the whole is 0.

    >>> percent(2, 3), percent(999_999_999, 1_000_000_000), percent(1, 1_000_000_000)
    (66.6667, 99.9999, 0.0001)
    """
    return rounded(WHOLE_PERCENT * part / whole, is_all=part >= whole) if whole else 0.0


def rounded(percentage: float, *, is_all: bool) -> float:
    """Round a percentage as documents hold it: 100 if it is all, and 0 if it is nothing."""
    whole = round(percentage, DOCUMENT_DECIMALS)
    if is_all or percentage <= 0:
        return whole
    return min(max(whole, LEAST_STEP), WHOLE_PERCENT - LEAST_STEP)


def percentage_text(percentage: float, space: str = " ") -> str:
    """Write a percentage, with a `space` between number and unit.

    >>> [percentage_text(one) for one in (0, 0.01, 27.94, 38, 99.99, 100)]
    ['0 %', 'under 0.1 %', '27.9 %', '38.0 %', '99.9 %', '100 %']
    """
    if percentage in (0, WHOLE_PERCENT):
        number = f"{percentage:.0f}"
    elif percentage < LEAST:
        number = "under 0.1"
    else:
        number = "99.9" if MOST <= percentage < WHOLE_PERCENT else f"{percentage:.1f}"
    return f"{number}{space}%"


def ranked_text(percentage: float) -> str:
    """Write the percentage of a row of a ranking, without its unit."""
    return f"{percentage:.2f}"


def hours(time: float) -> str:
    """Format a time: `25 min`, `3.5 h`, `34 h`."""
    minutes = round(time * 60)
    if minutes < 60:  # noqa: PLR2004 of an hour
        return f"{minutes}{NBSP}min"
    shown = f"{time:,.0f}" if time >= TENTHS else f"{time:.1f}".removesuffix(".0")
    return f"{shown}{NBSP}h"


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
    parts = (place.rpartition(":") for place in places)
    lines = grouped((file + colon, line) for file, colon, line in parts)
    return "; ".join(f"{file}{', '.join(found)}" for file, found in lines.items())


@cache
def short_place(place: str) -> str:
    """Shorten ``home/folder/file.yaml:3:1`` to its last parts."""
    return "/".join(PurePath(place.replace("\\", "/")).parts[-SHOWN_PLACE_PARTS:])
