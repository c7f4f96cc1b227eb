"""Delivery of a line: levels over time, and edits of its phonemes, times and curves by hand.

Settings of a call override those of the line, which override those of the character. Packs measure
time in words, so that their settings apply to any recording; calls measure time in seconds.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError, did_you_mean, spelled
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.pipeline.bend import Bend
from lipsync_lang.pipeline.curve import bspline
from lipsync_lang.pipeline.levels import Blend, Dial, Level
from lipsync_lang.pipeline.overlay import Overlay
from lipsync_lang.pipeline.prepare import GIVEN
from lipsync_lang.pipeline.tables import RESOLUTION, Tables
from lipsync_lang.resolver.compiled import CompiledPair
from lipsync_lang.schedules.phoneme_changes import misfit, with_changes
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.text.phonology.emphasis import as_marked

Points = Sequence[Sequence[float]]
"""Pairs of time and level, with non-decreasing times."""

DialLevels = Mapping[str, "float | Points"]
"""A constant level, or points of time in seconds and level, by name."""

LAST_SHARE = 0.9999
"""Share of a word at its end: a position of 1 more is the start of the next word."""

MOST = {"style": 1.0, "dial": 2.0, "expression": 1.0}
"""Maximum share of a style, level of a dial, and weight of a shape of an expression."""

SAME_SECONDS = 1e-3
"""Maximum difference between two times of one boundary."""

EditedCurves = Mapping[str, Sequence[Sequence[float]]]
"""Control points of a curve, by pose."""


def delivery(
    compiled: "CompiledPair",
    schedule: "Schedule",
    line: str | None,
    styles: DialLevels | None,
    dials: DialLevels | None,
) -> tuple[tuple[Blend, ...], tuple[Dial, ...]]:
    """Return the style blends and region dials of a line.

    Raises LipsyncError if a style or region is unknown, a level is out of range, or the line has
    fewer words.

    Parameters
    ----------
    line : name of a line of the character, which may have its own settings
    styles, dials : settings of the call; they override those of the character and the line
    """
    usual, special = compiled.delivery, compiled.line_deliveries.get(line or "", {})
    # most lines have neither, and need no arrays
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
                at = [0.0] if single else [in_seconds(name, at, schedule) for at, _ in points]
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

    Raises LipsyncError if a pose is unknown, an amount is out of range, or the line has fewer
    words.
    """
    stated = compiled.line_deliveries.get(line or "", {}).get("bends", {})
    found = {
        pose: [(in_seconds(f"the bend of {pose}", at, schedule), amount) for at, amount in points]
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
    """Convert seconds to a position in words, with a fraction; the reverse of `in_seconds`.

    A time in a pause becomes the end of the word before. A line without words counts as one.
    """
    words = schedule.words
    spans = [(word.start, word.end) for word in words] or [(schedule.start, schedule.end)]
    number = max(0, sum(start <= seconds for start, _ in spans) - 1)
    start, end = spans[number]
    share = min(max((seconds - start) / (end - start), 0.0), 1.0)
    if number + 1 < len(spans):
        # a share of 1 would be the start of the next word, which may follow a pause
        share = min(share, LAST_SHARE)
    return round(number + share, 4)


def in_seconds(name: str, at: float, schedule: "Schedule") -> float:
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


def with_expression(animation: Animation, tables: Tables, expression: DialLevels) -> Animation:
    """Return an animation with an expression added; see `Performer.with_expression`.

    Weights add up, and speech takes precedence: an expression fills the remaining room.

    - While lips or teeth touch, an expression adds nothing to a pose that the contact keeps low;
      before and after, it fades with the weights that make the contact.
    - An expression adds no more to a pose than its constraints allow.
    - A shape that speech does not move has the weight of the expression, and of a gesture.

    Weights of speech are never lowered, so its contacts and constraints still hold. While an
    expression fades, speed and acceleration may exceed the limits of the motion.

    The tables have the contacts and constraints that the animation keeps. Columns after their poses
    are those of gestures, and of other expressions.
    """
    wanted = {
        spelled(name, animation.poses): timed("expression", name, level).at(animation.times)
        for name, level in expression.items()
    }
    weights = np.ascontiguousarray(animation.weights.T)
    spoken = weights[: len(tables.priority)]
    # (T,) degree of each contact, 1 if it raises no pose. It may lose GIVEN to the softening,
    # and is closed all the same
    closed = [
        (spoken[one.raised].T / (one.floor[one.raised] - GIVEN)).clip(0, 1).min(1, initial=1.0)
        for one in tables.contacts
    ]
    # a list, since the loop takes names out of `wanted`
    for name in [name for name in wanted if name in animation.poses]:
        pose = animation.poses.index(name)
        if pose < len(spoken):
            spoken[pose] += _added(wanted.pop(name), pose, spoken, tables, closed)
        else:
            most = 1.0 if animation.columns[pose].node is None else np.inf  # degrees of a bone
            weights[pose] = np.minimum(weights[pose] + wanted.pop(name), most)
    rows = np.vstack([weights, *wanted.values()])
    channels = (*animation.columns, *map(Channel, wanted))
    return replace(
        animation, poses=(*animation.poses, *wanted), weights=np.ascontiguousarray(rows.T),
        channels=channels,
    )  # fmt: skip


def _added(
    wanted: Floats, pose: int, weights: Floats, tables: Tables, closed: Sequence[Floats]
) -> Floats:
    """Return the share of an expression for a pose within contacts and constraints: (T,)."""
    added = np.minimum(wanted, 1 - weights[pose])
    for contact, made in zip(tables.contacts, closed, strict=True):
        if contact.ceiling[pose] < 1:
            added = added * (1 - made)
    for low, high, threshold in tables.caps:
        if pose in (low, high):
            added = np.minimum(added, threshold - weights[low] - weights[high])
    for low, other in tables.at_most:
        if pose == low:
            added = np.minimum(added, weights[other] - weights[pose])
    return np.maximum(added, 0.0)


def marked_text(compiled: CompiledPair, text: str, line: str | None) -> str:
    """Return the text of a line with the marks of emphasis that the character states for it."""
    return as_marked(text, compiled.line_deliveries.get(line or "", {}).get("text"))


def corrected(
    stated: Mapping[str, Any], compiled: CompiledPair, schedule: Schedule, line: str | None
) -> Schedule:
    """Return a schedule with the phonemes, times and emphasis that the character states for a line.

    If the text, the voice or the recording has changed since, phonemes or times are not used, and
    a remark says so.
    """
    # the same line in another language has other phonemes
    if not stated or stated.get("language", compiled.language) != compiled.language:
        return schedule
    levels = dict(stated.get("emphasis", ()))
    if levels:
        words = tuple(
            replace(word, emphasis=levels.get(number, word.emphasis))
            for number, word in enumerate(schedule.words)
        )
        schedule = replace(schedule, words=words)
    changes = stated.get("phonemes", ())
    other = misfit(schedule, changes)
    if other:
        remark = (
            f"the phonemes of line '{line}' in {compiled.character} were changed in another text "
            f"or voice ({other}), and are not used; change them again, or delete its `phonemes`"
        )
        return replace(schedule, remarks=(*schedule.remarks, remark))
    if changes:
        schedule = with_changes(schedule, changes)
    if not stated.get("times"):
        return schedule
    times = schedule.times.copy()
    # a shorter line lacks some of the boundaries; then none of them is moved
    known = [row for row in stated["times"] if row[0] < len(times)]
    for boundary, _, now in known:
        times[boundary] = now
    same = all(abs(schedule.times[boundary] - was) < SAME_SECONDS for boundary, was, _ in known)
    if same and len(known) == len(stated["times"]) and (np.diff(times) > 0).all():
        return replace(schedule, times=times)
    remark = (
        f"the boundaries of line '{line}' in {compiled.character} were moved in another recording "
        "or voice, and are not used; move them again, or delete its `times`"
    )
    return replace(schedule, remarks=(*schedule.remarks, remark))


def overlays(
    compiled: CompiledPair, schedule: Schedule, silent: Sequence[bool], line: str | None
) -> tuple[Overlay, ...]:
    """Find the edits of a character that apply to a schedule.

    Their addresses do not depend on time, so edits apply to any recording: word 2 is the third
    word, and its phoneme 0 is its first sound. Pauses are not counted. Raises LipsyncError if the
    character has no edits for the line, or an edit names a missing word or phoneme.

    Parameters
    ----------
    silent : True for each scheduled phoneme that is silence
    line : name of the line; its edits override the word edits of the character
    """
    if line is not None and line not in compiled.line_edits:
        raise LipsyncError(
            f"{compiled.character} has no edits for line '{line}'; "
            f"{did_you_mean(line, compiled.line_edits)}"
        )
    found: list[Overlay] = []
    for word in schedule.words if compiled.word_edits else ():
        # spellings differ in case at the start of a sentence
        curves = compiled.word_edits.get(word.text.casefold())
        if curves:
            found += _laid(compiled, curves, schedule, word.first, word.stop)
    for number, edit in enumerate(compiled.line_edits[line] if line is not None else ()):
        here = f"edit {number} of line '{line}'"
        first, stop = _span(here, schedule, silent, edit)
        found += _laid(compiled, edit["curves"], schedule, first, stop)
    return tuple(found)


def _laid(
    compiled: CompiledPair, curves: EditedCurves, schedule: Schedule, first: int, stop: int
) -> Iterator[Overlay]:
    start, end = float(schedule.times[first]), float(schedule.times[stop])
    at = np.linspace(0, 1, RESOLUTION + 1)
    for pose, points in curves.items():
        # the points of an edit are drawn as those of a bigram are
        values = bspline(np.array([points], np.float64), at)[0].clip(0, 1)
        yield Overlay(start, end, compiled.poses.index(pose), values)


def _span(
    here: str, schedule: Schedule, silent: Sequence[bool], edit: Mapping[str, Any]
) -> tuple[int, int]:
    """Return the scheduled phonemes of an edit: a phoneme, a word, or the whole line."""
    first, stop = 0, len(schedule)
    if edit.get("word") is not None:
        if edit["word"] >= len(schedule.words):
            count = len(schedule.words)
            raise LipsyncError(
                f"{here} is for word {edit['word']}, counted from 0, but the line has {count} words"
            )
        word = schedule.words[edit["word"]]
        first, stop = word.first, word.stop
    if edit.get("phoneme") is None:
        return first, stop
    spoken = [index for index in range(first, stop) if not silent[index]]
    if edit["phoneme"] >= len(spoken):
        raise LipsyncError(
            f"{here} is for phoneme {edit['phoneme']}, counted from 0, but there are "
            f"{len(spoken)} phonemes without the pauses"
        )
    index = spoken[edit["phoneme"]]
    return index, index + 1
