"""Pictures of one report: how bigrams are distributed, what the first of them add up to, the map.

Shapes are SVG stretched to the width at hand, x in ranks and y in thousandths from the top; text
stands beside them as HTML, so that it keeps its size on a telephone.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from math import ceil, floor, log10

from lipsync_lang.coverage.page.markup import Markup, join, tags
from lipsync_lang.coverage.page.states import Row, States
from lipsync_lang.coverage.page.wording import NBSP, percent

HEIGHT = 1000
STEPS, GAMMA = 9, 0.4
"""Shades of the map, and the power that keeps what is rare from being all alike."""

TICKS = 5  # numbers along an axis, at most
LATE = 0.78  # of the width: labels of marks beyond it stand to their left
ALL = "100"
HANGING, STANDING = (0.7, 0.5, 0.3), (0.08, 0.26, 0.44)
"""Heights at which the labels of marks end, from the first mark on; 0 is the top."""


def distribution(rows: Sequence[Row], codes: str, needed: Mapping[str, int]) -> Markup:
    """Draw how often each bigram is heard, by rank, in the colour of its status (figure 2)."""
    most = max((row["percent"] for row in rows), default=0) or 1
    step = _step(most)
    top = ceil(round(most / step, 6)) * step
    bars = [
        tags.path(class_=f"s{code}", d=_bars(rows, codes, code, top)) for code in sorted(set(codes))
    ]
    ticks = {f"{n * step:g}{NBSP}%": n * step / top for n in range(round(top / step) + 1)}
    return _figure(
        "Distribution",
        "How often each bigram is heard, the most heard first; coloured by status.",
        join(bars),
        ticks,
        _marks(needed, len(rows), STANDING, standing=True),
        len(rows),
    )


def running(rows: Sequence[Row], needed: Mapping[str, int]) -> Markup:
    """Draw what share of all that is heard the first bigrams add up to."""
    line = "".join(f"V{HEIGHT - round(row['running'] * HEIGHT / 100)}h1" for row in rows)
    shapes = (
        tags.path(class_="under", d=f"M0 {HEIGHT}{line}V{HEIGHT}z"),
        tags.path(class_="line", d=f"M0 {HEIGHT}{line}"),
    )
    return _figure(
        "Running total",
        "What share of all that is heard the most heard bigrams make up together.",
        join(*shapes),
        {f"{share}{NBSP}%": share / 100 for share in (0, 25, 50, 75, 100)},
        _marks(needed, len(rows), HANGING, standing=False),
        len(rows),
    )


def heat_map(rows: Sequence[Row], phonemes: Sequence[str], states: States | None) -> Markup:
    """Draw first by second phoneme, the stronger the more heard, coloured by state."""
    places = {row["bigram"]: number for number, row in enumerate(rows)}
    halves = [row["bigram"].partition("-") for row in rows]
    named = {half for first, _, second in halves for half in (first, second)}
    axis = [phoneme for phoneme in phonemes if phoneme in named]
    axis += sorted(named - set(axis))
    most = max((row["count"] for row in rows), default=0) or 1

    def cell(first: str, second: str) -> Markup:
        place = places.get(f"{first}-{second}")
        if place is None:
            return tags.td()
        row = rows[place]
        looks = f"n{ceil(STEPS * (row['count'] / most) ** GAMMA)}"
        if states:
            looks += f" s{states.status_code(row)} l{states.layer_code(row)}"
        return tags.td(class_=looks, data_i=place, title=f"{row['bigram']}: {row['count']:,}")

    head = tags.tr(tags.td(), (tags.th(second) for second in axis))
    lines = (tags.tr(tags.th(first), (cell(first, second) for second in axis)) for first in axis)
    return tags.table(
        tags.thead(head), tags.tbody(lines), class_="map", style=f"--size:{len(axis) + 1}"
    )


def bars(counts: Mapping[str, int]) -> Markup:
    """Draw how often each of some names is heard, the most heard first."""
    most = max(counts.values(), default=0) or 1
    ranked = sorted(counts.items(), key=lambda item: -item[1])
    return tags.ol(
        (
            tags.li(
                tags.b(name), tags.i(style=f"--part:{100 * heard / most:.1f}%"),
                tags.span(f"{heard:,}"),
            )
            for name, heard in ranked
        ),
        class_="bars",
    )  # fmt: skip


def stack(parts: Sequence[tuple[int, str]], label: str) -> Markup:
    """Draw shares of a whole beside each other, each in the colour of its status' code."""
    whole = sum(part for part, _ in parts) or 1
    pieces = (
        tags.i(class_=f"s{code}", style=f"width:{100 * part / whole:.2f}%")
        for part, code in parts
        if part
    )
    return tags.span(pieces, class_="stack", role="img", aria_label=label)


def _bars(rows: Sequence[Row], codes: str, code: str, top: float) -> str:
    """Return the outline of the bars of one status, those side by side in one piece."""
    path, place = [], 0
    for one, group in groupby(zip(rows, codes, strict=True), key=lambda pair: pair[1]):
        heights = [HEIGHT - round(row["percent"] * HEIGHT / top) for row, _ in group]
        if one == code:
            steps = "".join(f"V{height}h1" for height in heights)
            path.append(f"M{place} {HEIGHT}{steps}V{HEIGHT}z")
        place += len(heights)
    return "".join(path)


def _step(most: float) -> float:
    """Return a round step that some ticks reach the highest bar with."""
    rough = most / TICKS
    size: float = 10.0 ** floor(log10(rough))
    return next(size * times for times in (1, 2, 5, 10) if size * times >= rough)


def _figure(  # noqa: PLR0913, PLR0917 the parts of a figure
    title: str, words: str, shapes: Markup, ticks: Mapping[str, float], marks: Markup, width: int
) -> Markup:
    grid = (tags.span(text, class_="tick", style=_at(bottom=at)) for text, at in ticks.items())
    ranks = (
        tags.span(f"{rank:,}", class_="rank", style=_at(left=(rank - 0.5) / width))
        for rank in _ranks(width)
    )
    picture = tags.svg(
        shapes, viewBox=f"0 0 {max(1, width)} {HEIGHT}", preserveAspectRatio="none", role="img",
        aria_label=f"{title}. {words}",
    )  # fmt: skip
    return tags.figure(
        tags.figcaption(tags.h3(title), tags.p(words)),
        tags.div(grid, picture, marks, ranks, class_="plot"),
        tags.p("bigrams by rank", class_="axis"),
    )


def _marks(
    needed: Mapping[str, int], width: int, heights: Sequence[float], *, standing: bool
) -> Markup:
    """Draw where shares of all that is heard are reached; the labels avoid each other's lines."""
    shares = sorted((share for share in needed if share != ALL), key=float)
    marks = []
    for share, height in zip(shares, heights, strict=False) if width else ():
        at = needed[share] / width
        end = {"top": height} if standing else {"bottom": 1 - height}
        looks = f"mark{' stands' if standing else ''}{' late' if at > LATE else ''}"
        text = (tags.b(f"{share}{NBSP}%"), f" {needed[share]:,}")
        marks.append(tags.span(tags.span(text), class_=looks, style=_at(left=at, **end)))
    return join(marks)


def _ranks(width: int) -> Iterator[int]:
    if width:
        step = max(1, round(_step(width)))
        yield 1
        yield from (rank for rank in range(step, width, step) if 1 < rank < width - step / 2)
    if width > 1:
        yield width


def _at(**places: float) -> str:
    return ";".join(f"{side}:{100 * place:.2f}%" for side, place in places.items())


def described(parts: Mapping[str, tuple[int, int]]) -> str:
    """Say what a stack of shares shows."""
    whole = sum(heard for _, heard in parts.values())
    said = (f"{percent(100 * heard / whole)} {name}" for name, (_, heard) in parts.items() if heard)
    return ", ".join(said) or "nothing is heard"
