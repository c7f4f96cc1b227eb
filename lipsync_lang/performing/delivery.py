"""How a line is delivered: which styles are heard and how far each region moves, over time.

A character has a manner of its own, a line of it may differ, and a call has the last word. Packs
count time in words, so that a new recording changes nothing; a call counts it in seconds.
"""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.errors import LipsyncError, did_you_mean, spelled
from lipsync_lang.pipeline.levels import Blend, Dial, Level

if TYPE_CHECKING:
    from lipsync_lang.resolver.compiled import Compiled
    from lipsync_lang.schedules.schedule import Schedule

Points = Sequence[Sequence[float]]
"""Pairs of time and level, times never falling."""

Levels = Mapping[str, "float | Points"]
"""By name, a level that stays, or points of seconds and level."""

MOST = {"style": 1.0, "dial": 2.0}
"""The highest share of a style, and the highest level of a dial."""


def delivery(
    compiled: "Compiled",
    schedule: "Schedule",
    line: str | None,
    styles: Levels | None,
    dials: Levels | None,
) -> tuple[tuple[Blend, ...], tuple[Dial, ...]]:
    """Say which styles are blended in and which regions are scaled.

    Parameters
    ----------
    line : the name of a line that may have a manner of its own
    styles, dials : what the call asks for, over what the character and the line do

    Raises
    ------
    LipsyncError
        A style or a region is unknown, a level out of range, or a word beyond the line.
    """
    own = [compiled.delivery, compiled.line_deliveries.get(line or "", {})]
    known_styles, poses = tuple(compiled.style_origins), len(compiled.poses)
    blends = [
        Blend(known_styles.index(name), level)
        for name, level in _levels("style", own, schedule, styles or {}, known_styles).items()
        if level.values.max() > 0
    ]
    scaled = [
        Dial(np.isin(np.arange(poses), compiled.regions[name]), level)
        for name, level in _levels("dial", own, schedule, dials or {}, compiled.regions).items()
        if np.any(level.values != 1)
    ]
    return tuple(blends), tuple(scaled)


def _levels(
    what: str,
    own: Sequence[Mapping[str, Mapping[str, Points]]],
    schedule: "Schedule",
    asked: Levels,
    known: "Sequence[str] | Mapping[str, object]",
) -> dict[str, Level]:
    """Return every level by name, the later statement over the earlier."""
    found = {}
    for stated in own:
        for name, points in stated.get(f"{what}s", {}).items():
            if name in known:  # what is not was warned of when the packs were read
                found[name] = _spoken(name, points, schedule)
    for stated_name, level in asked.items():
        name = spelled(stated_name, known)
        if name not in known:
            raise LipsyncError(f"no {_called(what)} '{name}' here; {did_you_mean(name, known)}")
        found[name] = _timed(what, name, level)
    return found


def _called(what: str) -> str:
    return "style" if what == "style" else "region for a dial"


def _timed(what: str, name: str, level: "float | Points") -> Level:
    """Return the level that a call asks for."""
    points = [(0.0, level)] if isinstance(level, (int, float)) else [tuple(p) for p in level]
    most = MOST[what]
    for point in points:
        at, value = point if len(point) == len(("seconds", "level")) else (0.0, float("nan"))
        if not (isfinite(at) and 0 <= value <= most):
            raise LipsyncError(
                f"{what} {name}: {level!r} is no level; give a number from 0 to {most:g}, "
                "or pairs of seconds and such numbers"
            )
    times = [at for at, _ in points]
    if times != sorted(times) or not times:
        raise LipsyncError(f"{what} {name}: its seconds run back; put the points in order")
    return Level(np.array(times), np.array([value for _, value in points], np.float64))


def _spoken(name: str, points: Points, schedule: "Schedule") -> Level:
    """Return a level that a pack states over the words of a line."""
    values = np.array([value for _, value in points], np.float64)
    if len(points) == 1:
        return Level(np.zeros(1), values)
    return Level(np.array([_second(name, at, schedule) for at, _ in points]), values)


def _second(name: str, at: float, schedule: "Schedule") -> float:
    """Return when so many words are spoken, and a part of the next."""
    words, times = schedule.words, schedule.times
    if at > len(words):
        raise LipsyncError(
            f"{name} has a point at word {at:g}, but {schedule.source} has {len(words)} words; "
            "mend the character's line"
        )
    whole = min(int(at), len(words) - 1)
    start, end = float(times[words[whole].first]), float(times[words[whole].stop])
    return start + (at - whole) * (end - start)
