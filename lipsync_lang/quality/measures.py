"""What is measured of a finished animation, one function each.

Conventions: every value is the smaller the better, so that one number limits it. Shares are of 1.
What is visible is told in shares of a column's range: a pose's is 1. Frame rates may be any; what
is counted in seconds does not change with them, but by the length of a frame.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module

import numpy as np

from lipsync_lang.pipeline.arrays import Bools, Ints
from lipsync_lang.quality.figures import Finding
from lipsync_lang.quality.take import Take

VISIBLE = 0.05
"""The least change of a pose that a viewer sees."""

QUICK = 0.07
"""Seconds; a pose that is there and back within them flickers: one frame of 30 a second."""

SHORT = 0.1
"""Seconds; a shape that stays less is hardly seen."""

STIRRING = 0.1
"""Shares per second; slower than this, a pose stands still."""

BROKEN = 0.01
"""How far a pose may stand above a constraint unseen."""

FULL = 1e-3
"""How near to its most a pose is at its most."""


@dataclass(frozen=True)
class Measured:
    """What a measure found.

    Parameters
    ----------
    value : None where it cannot be judged, and `why`
    of : which of several, where a measure gives more than one figure
    limit : one of its own, over that of the measure
    """

    value: float | None
    parts: Mapping[str, float] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()
    of: str = ""
    why: str = ""
    limit: float | None = None


Find = Callable[[Take], Iterable[Measured]]


@dataclass(frozen=True)
class Measure:
    """One measure: its name, unit, usual limit, and what finds it."""

    name: str
    unit: str
    limit: float | None
    find: Find
    told: str
    """What it is and its formula, for people."""


MEASURES: dict[str, Measure] = {}


def measure(name: str, unit: str, limit: float | None = None) -> Callable[[Find], Find]:
    """Register a function ``scene -> figures`` as a measure; its docstring tells what it is."""

    def register(find: Find) -> Find:
        MEASURES[name] = Measure(name, unit, limit, find, find.__doc__ or "")
        return find

    return register


def load_measures() -> dict[str, Measure]:
    """Return every measure, in the order in which they are told."""
    import_module("lipsync_lang.quality.closures")
    import_module("lipsync_lang.quality.movement")
    return MEASURES


def one(
    value: float, parts: Mapping[str, float] | None = None, findings: Iterable[Finding] = ()
) -> list[Measured]:
    """Return the only figure of a measure."""
    ordered = tuple(sorted(findings))
    return [Measured(float(value), parts or {}, ordered)]


def unjudged(why: str, of: str = "") -> list[Measured]:
    """Return a figure that could not be judged."""
    return [Measured(None, of=of, why=why)]


def share(part: Bools) -> float:
    """Return the share of True."""
    return float(part.mean()) if part.size else 0.0


def runs(mask: Bools) -> tuple[Ints, Ints]:
    """Return the first frame of each run of True, and the one past its last."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(np.int8)))
    return edges[::2], edges[1::2]


def places(scene: Take, told: Mapping[int, str]) -> Iterator[Finding]:
    """Yield a finding for each phoneme of the track, by its number."""
    for number, what in told.items():
        at = round(float(scene.track.bounds[number]), 4)
        yield Finding(at, f"{scene.labels[number]} {what}")


def named(names: Iterable[str], values: Iterable[float], least: float = 0.0) -> dict[str, float]:
    """Return the values above a least by name, the greatest first."""
    pairs = [(n, round(float(v), 6)) for n, v in zip(names, values, strict=True) if v > least]
    return dict(sorted(pairs, key=lambda pair: -pair[1]))
