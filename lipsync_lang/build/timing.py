"""Schedules of planned lines: read from timings, laid on recordings, or spoken."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

from lipsync_lang.build.planned_line import PlannedLine
from lipsync_lang.errors import LipsyncError
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.speech.speaking import Speaker

Made = TypeVar("Made")

Timed = Schedule | Exception
"""The schedule of a line, or the reason why it has none."""


def schedules(
    folder: Path, lines: Sequence[PlannedLine], speaker: Speaker, engine: str | None = None
) -> list[Timed]:
    """Time the phonemes of lines, each by what it has: timings, a recording, or its text alone.

    Parameters
    ----------
    folder : of the project
    lines : of the speaker's language
    engine : another speech engine than the language's; `none` for estimated times

    Returns
    -------
    For each line its schedule, or the error that this line met
    """
    out: list[Timed] = [
        attempt(partial(_from_files, folder, line, speaker))
        if line.timings is not None or line.audio is not None
        else LipsyncError("it was not spoken")
        for line in lines
    ]
    spoken = [at for at, one in enumerate(lines) if one.timings is None and one.audio is None]
    texts = [lines[at].text for at in spoken]
    for at, schedule in zip(spoken, speaker.speak_many(texts, engine=engine), strict=True):
        out[at] = schedule
    return out


def attempt(call: Callable[[], Made]) -> Made | Exception:
    """Return what a call makes, or its error, which is told of one line alone."""
    try:
        return call()
    except Exception as error:  # noqa: BLE001 whatever it is, the other lines are made
        return error


def _from_files(folder: Path, line: PlannedLine, speaker: Speaker) -> Schedule:
    from lipsync_lang.schedules.timing_readers import read_schedule
    from lipsync_lang.speech.hearing import aligned, recognised
    from lipsync_lang.speech.sound import with_sound

    audio = None if line.audio is None else folder / line.audio
    if line.timings is not None:
        schedule = read_schedule(folder / line.timings)
        return schedule if audio is None else with_sound(schedule, audio)
    assert audio is not None  # noqa: S101 the caller asked for lines with files
    if line.text:
        return aligned(speaker, audio, line.text)
    return recognised(speaker, audio)
