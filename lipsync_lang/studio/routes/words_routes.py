"""Routes of the words and lines of a character: curve edits, pronunciations and deliveries.

A curve edit starts with the control points of the performed curves.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.json_object import Json
from lipsync_lang.performing.performer import Performer
from lipsync_lang.pipeline.curve import bspline
from lipsync_lang.schedules.phoneme_changes import excerpt
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.studio.routes.requests import StudioRequest, whole_number
from lipsync_lang.studio.workshop import Workshop

POINTS_A_SOUND = 3
"""Number of control points for each sound of a span."""

MOST_POINTS, LEAST_POINTS = 32, 5
"""Bounds on the control points of a curve."""

LEAST_WEIGHT = 0.02
"""Minimum weight of a pose; a pose that stays below is left out."""

CORRECTIONS = 6
"""Number of corrections of the control points, since a curve stays below its polygon."""


def performed_curves(
    performer: Performer, schedule: Schedule, first: int, stop: int, fps: float
) -> dict[str, list[list[float]]]:
    """Return the curves of a character over sounds `first` to `stop`, without its curve edits.

    They are control points (time, weight) by pose, in the normalised time of the span.

    Examples
    --------
    >>> performer = ll.resolve("english", "facefx")
    >>> schedule = ll.Schedule(("M", "AA"), [0, 0.1, 0.3])
    >>> curves = performed_curves(performer, schedule, 0, 2, 60)
    >>> curves["open"][0][0], curves["open"][-1][0]
    (0.0, 1.0)
    """
    compiled = replace(performer.compiled, word_edits={}, line_edits={})
    animation = replace(performer, compiled=compiled).perform(schedule, fps)
    start, end = float(schedule.times[first]), float(schedule.times[stop])
    count = min(MOST_POINTS, max(LEAST_POINTS, POINTS_A_SOUND * (stop - first)))
    at = np.linspace(0, 1, count)
    # bigrams, words and sounds are drawn in a time of their own, from 0 to 1
    seconds = start + at * (end - start)
    weights = animation.weights
    moving = {
        pose: np.interp(seconds, animation.times, weights[:, number])
        for number, pose in enumerate(animation.poses)
        if weights[(animation.times >= start) & (animation.times <= end), number].max(initial=0)
        > LEAST_WEIGHT
    }
    found = {}
    for pose, values in moving.items():
        points = np.column_stack((at, values))
        # A fixed number instead of a linear system: the clipped points have no exact solution.
        for _ in range(CORRECTIONS):
            missing = values - bspline(points[None], at)[0]
            points[:, 1] = np.clip(points[:, 1] + missing, 0, 1)
        found[pose] = [[round(float(t), 3), round(float(v), 3)] for t, v in points]
    return found


def words(workshop: Workshop, _: StudioRequest) -> Json:
    """Return the words, pronunciations and lines of the character, and the spoken line's sounds."""
    library, compiled = workshop.library(), workshop.performer.compiled
    model = library.character(compiled.character).model
    language = library.language(compiled.language)
    path = workshop.files().get("character")
    return {
        "character": compiled.character,
        "file": workshop.shown(path) if path is not None else "",
        "words": [
            {"word": word, "curves": _points(one.curves)} for word, one in model.words.items()
        ],
        "pronunciations": [
            {"language": name, "word": word, "phonemes": list(sounds)}
            for name, said in model.pronunciations.items()
            for word, sounds in said.items()
        ],
        "lineage": list(language.lineage),
        "lines": [
            {
                "name": name,
                "edits": [
                    {"word": edit.word, "phoneme": edit.phoneme, "curves": _points(edit.curves)}
                    for edit in line.edits
                ],
                "styles": _points(line.styles),
                "dials": _points(line.dials),
            }
            for name, line in model.lines.items()
        ],
        "phonemes": [*dict.fromkeys((*compiled.phonemes, *compiled.shades))],
        "sounds": _sounds(workshop),
    }


def _points(curves: Any) -> dict[str, list[list[float]]]:
    """Return the points of curves or levels by pose, style or region."""
    return {name: [list(point) for point in points] for name, points in curves.items()}


def _sounds(workshop: Workshop) -> list[list[str]]:
    """Return the common phonemes of each label of the line; silence is empty."""
    schedule = workshop.schedule
    if schedule is None:
        return []
    performer = workshop.performer
    ids, _, source = performer.common_phonemes(schedule)
    sounds: list[list[str]] = [[] for _ in schedule.labels]
    for number, label in zip(ids.tolist(), source.tolist(), strict=True):
        if number != performer.compiled.tables.silence:
            sounds[label].append(performer.compiled.phonemes[number])
    return sounds


def start(workshop: Workshop, request: StudioRequest) -> Json:
    """Return curves as a start for edits: those of the character without its curve edits.

    The query names a word of the line, a phoneme of that word or of the line, or neither for all.
    `alone` performs the span without its neighbours: a word's curves serve all lines.
    """
    schedule = workshop.schedule
    if schedule is None:
        raise LipsyncError("there is no line; type a line that contains the word")
    for name in ("word", "phoneme"):
        if request.query.get(name) and whole_number(request.query[name]) is None:
            raise LipsyncError(f"`{name}` must be a whole number from 0 on")
    word, phoneme = (whole_number(request.query.get(name, "")) for name in ("word", "phoneme"))
    first, stop, count = 0, len(schedule), len(schedule.words)
    if word is not None:
        if word >= count:
            raise LipsyncError(
                f"the line has {count} words, counted from 0; there is no word {word}"
            )
        first, stop = schedule.words[word].first, schedule.words[word].stop
    if phoneme is not None:
        spoken = [n for n, said in enumerate(_sounds(workshop)) if said and first <= n < stop]
        if phoneme >= len(spoken):
            known = f"there are {len(spoken)} phonemes, counted from 0"
            raise LipsyncError(f"{known}; there is no phoneme {phoneme}")
        first, stop = spoken[phoneme], spoken[phoneme] + 1
    if request.query.get("alone"):
        schedule = excerpt(schedule, first, stop)
        first, stop = 0, len(schedule)
    fps = workshop.settings.fps
    return {"curves": performed_curves(workshop.performer, schedule, first, stop, fps)}
