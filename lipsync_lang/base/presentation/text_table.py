"""Align columns of text by the width that a terminal gives each character."""

from collections.abc import Iterable, Iterator, Sequence
from unicodedata import combining, east_asian_width


def columns(rows: Iterable[Sequence[str]], gap: int = 2, widest: int = 48) -> Iterator[str]:
    """Yield a line per row, its cells padded to common widths of at most `widest` columns."""
    kept = [list(row) for row in rows]
    count = max(map(len, kept), default=0)
    widths = [
        min(max((width(row[i]) for row in kept if i < len(row)), default=0), widest)
        for i in range(count)
    ]
    for row in kept:
        cells = [cell + " " * (max(widths[i] - width(cell), 0) + gap) for i, cell in enumerate(row)]
        yield "".join(cells).rstrip()


def width(text: str) -> int:
    """Return the width of a text in terminal columns."""
    return sum(
        # Accents and joiners take no column; wide characters of East Asia take two.
        0 if combining(c) or c in "\u200b\u200c\u200d" else 2 if east_asian_width(c) in "WF" else 1
        for c in text
    )
