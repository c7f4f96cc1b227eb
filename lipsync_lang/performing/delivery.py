"""Delivery of a line: style shares and region levels over time.

Settings of a call override those of the line, which override those of the character. Packs measure
time in words, so that their settings apply to any recording; calls measure time in seconds.
"""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.base.errors import LipsyncError, did_you_mean, spelled
from lipsync_lang.pipeline.bend import Bend
from lipsync_lang.pipeline.levels import Blend, Dial, Level

if TYPE_CHECKING:
    from lipsync_lang.resolver.compiled import CompiledPair
    from lipsync_lang.schedules.schedule import Schedule

Points = Sequence[Sequence[float]]
"""Pairs of time and level, with non-decreasing times."""

DialLevels = Mapping[str, "float | Points"]
"""A constant level, or points of time in seconds and level, by name."""

LAST_SHARE = 0.9999
"""Share of a word at its end: a position of 1 more is the start of the next word."""

MOST = {"style": 1.0, "dial": 2.0, "expression": 1.0}
"""Maximum share of a style, level of a dial, and weight of a shape of an expression."""


def delivery(
    compiled: "CompiledPair",
    schedule: "Schedule",
    line: str | None,
    styles: DialLevels | None,
    dials: DialLevels | None,
) -> tuple[tuple[Blend, ...], tuple[Dial, ...]]:
    """Return the style blends and region dials of a line.

    Parameters
    ----------
    line : name of a line of the character, which may have its own settings
    styles, dials : settings of the call; they override those of the character and the line

    Raises
    ------
    LipsyncError
        A style or region is unknown, a level is out of range, or the line has fewer words.
    """
    usual, special = compiled.delivery, compiled.line_deliveries.get(line or "", {})
    if not (styles or dials or any(usual.values()) or any(special.values())):
        return (), ()
    own = [usual, special]
    known_styles, poses = compiled.style_names, len(compiled.poses)
    blends = [
        Blend(known_styles.index(name), level)
        for name, level in _levels("style", own, schedule, styles or {}, known_styles).items()
        if level.values.max() > 0
    ]
    scaled = [
        Dial(np.isin(np.arange(poses), compiled.regions[name]), level, f"dial {name}")
        for name, level in _levels("dial", own, schedule, dials or {}, compiled.regions).items()
        # a dial at 1 throughout would only cost time in each frame
        if np.any(level.values != 1)
    ]
    return tuple(blends), tuple(scaled)


def _levels(
    what: str,
    own: Sequence[Mapping[str, Mapping[str, Points]]],
    schedule: "Schedule",
    asked: DialLevels,
    known: "Sequence[str] | Mapping[str, object]",
) -> dict[str, Level]:
    """Merge the levels by name; later settings override earlier ones."""
    found = {}
    for stated in own:
        for name, points in stated.get(f"{what}s", {}).items():
            if name in known:  # unknown names already caused a warning while reading the packs
                # a single point is a constant, at whatever word of whatever line
                single = len(points) == 1
                at = [0.0] if single else [second(name, at, schedule) for at, _ in points]
                values = np.array([value for _, value in points], np.float64)
                found[name] = Level(np.array(at), values)
    for stated_name, level in asked.items():
        name = spelled(stated_name, known)
        if name not in known:
            kind = "style" if what == "style" else "region"
            raise LipsyncError(f"unknown {kind} '{name}'; {did_you_mean(name, known)}")
        found[name] = timed(what, name, level)
    return found


def timed(what: str, name: str, level: "float | Points") -> Level:
    """Return the level for a setting of a call, in seconds."""
    points = [(0.0, level)] if isinstance(level, (int, float)) else [tuple(p) for p in level]
    most = MOST[what]
    for point in points:
        at, value = point if len(point) == len(("seconds", "level")) else (0.0, float("nan"))
        if not (isfinite(at) and 0 <= value <= most):
            raise LipsyncError(
                f"{what} {name}: {level!r} is not a level; give a number from 0 to {most:g}, "
                "or pairs of a time in seconds and such a number"
            )
    times = [at for at, _ in points]
    if times != sorted(times) or not times:
        raise LipsyncError(
            f"{what} {name}: its points are not in order of time; sort them by their seconds"
        )
    return Level(np.array(times), np.array([value for _, value in points], np.float64))


def bends_of(
    compiled: "CompiledPair",
    schedule: "Schedule",
    line: str | None,
    asked: Mapping[str, Points] | None,
) -> tuple[Bend, ...]:
    """Return the bends of a line: its own keys by pose, overridden by those of the call.

    Raises
    ------
    LipsyncError
        A pose is unknown, an amount is out of range, or the line has fewer words.
    """
    stated = compiled.line_deliveries.get(line or "", {}).get("bends", {})
    found = {
        pose: [(second(f"the bend of {pose}", at, schedule), amount) for at, amount in points]
        for pose, points in stated.items()
    }
    bends = []
    for pose, keys in {**found, **(asked or {})}.items():
        if pose not in compiled.poses:
            raise LipsyncError(f"unknown pose '{pose}'; {did_you_mean(pose, compiled.poses)}")
        points = np.array(keys, np.float64)
        sound = points.ndim == 2 and points.shape[1] == 2 and np.isfinite(points).all()  # noqa: PLR2004 rows of two
        if not sound or np.abs(points[:, 1]).max() > 1 or (np.diff(points[:, 0]) < 0).any():
            raise LipsyncError(
                f"the bend of {pose} must be pairs of a time in seconds and an amount from -1 to "
                "1, in order of time"
            )
        bends.append(Bend(compiled.poses.index(pose), points[:, 0], points[:, 1]))
    return tuple(bends)


def in_words(seconds: float, schedule: "Schedule") -> float:
    """Convert seconds to a position in words, with a fraction; the reverse of `second`.

    A time in a pause becomes the end of the word before. A line without words counts as one.
    """
    words = schedule.words
    spans = [(word.start, word.end) for word in words] or [(schedule.start, schedule.end)]
    number = max(0, sum(start <= seconds for start, _ in spans) - 1)
    start, end = spans[number]
    share = min(max((seconds - start) / (end - start), 0.0), 1.0)
    if number + 1 < len(spans):
        share = min(share, LAST_SHARE)
    return round(number + share, 4)


def second(name: str, at: float, schedule: "Schedule") -> float:
    """Convert a position in words, with a fraction, to seconds."""
    words, times = schedule.words, schedule.times
    if not words:
        return float(times[0] + min(at, 1.0) * (times[-1] - times[0]))
    if at > len(words):
        raise LipsyncError(
            f"{name} has a point at word {at:g}, but {schedule.source} has {len(words)} words; "
            "correct the points in the character"
        )
    # the position after the last word is the end of that word
    whole = min(int(at), len(words) - 1)
    start, end = float(times[words[whole].first]), float(times[words[whole].stop])
    return start + (at - whole) * (end - start)
