"""Edits of words and lines: phonemes, times, emphasis, and curves, by word and phoneme.

The addresses of curves do not depend on time, so edits apply to any recording: word 2 is the third
word, and its phoneme 0 is its first sound. Pauses are not counted.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.pipeline.curve import bspline
from lipsync_lang.pipeline.overlay import Overlay
from lipsync_lang.pipeline.tables import RESOLUTION
from lipsync_lang.resolver.compiled import CompiledPair
from lipsync_lang.schedules.phoneme_changes import misfit, with_changes
from lipsync_lang.schedules.schedule import Schedule

SAME_SECONDS = 1e-3
"""Maximum difference between two times of one boundary."""

EditedCurves = Mapping[str, Sequence[Sequence[float]]]
"""Control points of a curve, by pose."""


def corrected(
    stated: Mapping[str, Any], compiled: CompiledPair, schedule: Schedule, line: str | None
) -> Schedule:
    """Return a schedule with the phonemes, times and emphasis that the character states for a line.

    If the text, the voice or the recording has changed since, phonemes or times are not used, and
    a remark says so.
    """
    if stated.get("language", compiled.language) != compiled.language:
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

    Parameters
    ----------
    silent : True for each scheduled phoneme that is silence
    line : name of the line; its edits override the word edits of the character

    Raises
    ------
    LipsyncError
        The character has no edits for the line, or an edit names a missing word or phoneme.
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
