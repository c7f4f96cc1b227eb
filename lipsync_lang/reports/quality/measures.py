"""Measures of a finished animation: their registry and common tools.

Conventions: smaller values are better, so that one number limits each. Shares are from 0 to 1.
Movement is in shares of a column's range, which is 1 for a pose. Figures in seconds are valid at
any frame rate, to within a frame.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, wraps
from importlib import import_module
from typing import TypeVar

import numpy as np

from lipsync_lang.base.arrays import Bools, Ints
from lipsync_lang.reports.quality.figures import Figure, Finding
from lipsync_lang.reports.quality.measured_scene import MeasuredScene

VISIBLE_SHARE = 0.05
"""Smallest visible change of a pose."""

Find = Callable[[MeasuredScene], Iterable[list[Figure]]]
"""A measure's function, which yields the figures of each line. The name of a figure is its contact
or rule, or empty if it is alone."""


@dataclass(frozen=True)
class Measure:
    """A measure: its name, unit, usual limit and function."""

    name: str
    unit: str
    limit: float | None
    find: Find
    told: str
    """The docstring: meaning and formula."""


MEASURES: dict[str, Measure] = {}


def measure(name: str, unit: str, limit: float | None = None) -> Callable[[Find], Find]:
    """Register a function ``scene -> figures of each line``; its docstring describes it."""

    def register(find: Find) -> Find:
        MEASURES[name] = Measure(name, unit, limit, find, find.__doc__ or "")
        return find

    return register


Found = TypeVar("Found")


def once(find: Callable[[MeasuredScene], Found]) -> Callable[[MeasuredScene], Found]:
    """Cache the result of a function of a scene, which several measures need."""

    @wraps(find)
    def remembered(scene: MeasuredScene) -> Found:
        known = scene.remembered
        if find not in known:
            known[find] = find(scene)
        return known[find]

    return remembered


@cache
def load_measures() -> dict[str, Measure]:
    """Return every measure by name, in the order of reports."""
    modules = [f"{__package__}.{name}" for name in ("closures", "seen", "movement", "likeness")]
    for module in modules:
        import_module(module)
    # another module may have imported one of them before
    ordered = sorted(MEASURES.values(), key=lambda known: modules.index(known.find.__module__))
    return {known.name: known for known in ordered}


def sentence(figure: Figure) -> str:
    """Return a figure in a sentence: its meaning, value and limit."""
    name, _, of = figure.name.partition(" ")
    # the first sentence alone: the rest tells how it is measured
    meaning = load_measures()[name].told.split("\n")[0].split(". ")[0].rstrip(".")
    subject = f"{meaning} ({of})" if of else meaning
    if figure.value is None:
        return f"{subject}: not judged, because {figure.why}."
    told = f"{subject}: {_amount(figure.value, figure.unit)}"
    if figure.limit is None:
        return f"{told}."
    return f"{told}; the limit is {_amount(figure.limit, figure.unit)}."


def _amount(value: float, unit: str) -> str:
    """Return a value with its unit; a share is in percent."""
    if unit.startswith("of "):
        return f"{100 * value:.3g} % {unit}"
    return f"{value:.3g} {unit}"


def one(
    value: float, parts: Mapping[str, float] | None = None, findings: Iterable[Finding] = ()
) -> list[Figure]:
    """Return a list with the single figure of a measure."""
    return [Figure("", float(value), parts=parts or {}, findings=tuple(sorted(findings)))]


def unjudged(why: str, of: str = "") -> list[Figure]:
    """Return a list with a figure without a value, and the reason."""
    return [Figure(of, None, why=why)]


def runs(mask: Bools, cuts: Ints) -> tuple[Ints, Ints]:
    """Return the first index of each run of True, and the index past its last.

    A run ends at each of `cuts`, where another line begins; the last cut may be the end.
    """
    before, after = np.zeros((2, len(mask)), bool)
    before[1:], after[:-1] = mask[:-1], mask[1:]
    before[cuts[:-1]] = after[cuts[1:] - 1] = False
    return (mask & ~before).nonzero()[0], (mask & ~after).nonzero()[0] + 1


def places(scene: MeasuredScene, told: Mapping[int, str]) -> Iterator[Finding]:
    """Yield a finding for each description, by the phoneme's index."""
    for number, what in told.items():
        at = round(float(scene.begin[number]), 4)
        yield Finding(at, f"{scene.labels[number]} {what}")
