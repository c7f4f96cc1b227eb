"""Schedules of planned lines: read from timings, aligned with recordings, or spoken."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

from lipsync_lang.production.builds.planned_line import PlannedLine
from lipsync_lang.production.builds.timing_cache import TimingCache
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.sound.speech.speaking.speaker import Speaker

CallResult = TypeVar("CallResult")

ScheduleOrError = Schedule | Exception
"""Schedule of a line, or the error in its place."""


def schedules(
    folder: Path,
    lines: Sequence[PlannedLine],
    speaker: Speaker,
    engine: str | None = None,
    cache: TimingCache | None = None,
) -> list[ScheduleOrError]:
    """Time the phonemes of lines by their timings, their recordings, or only their text.

    `engine` is another speech engine than the language's; `none` estimates times. Lines whose
    timings are in the cache are not timed again.
    """
    from lipsync_lang.sound.speech.hearing.alignment import align_many
    from lipsync_lang.sound.speech.hearing.recognition import recognise_many

    out: dict[int, ScheduleOrError] = {}
    told: dict[int, tuple[Path, str]] = {}
    heard: dict[int, Path] = {}
    silent: dict[int, str] = {}
    for at, line in enumerate(lines):
        if line.timings is not None:
            out[at] = attempt(partial(_from_timings, speaker, folder, line, cache))
        elif cache is not None and (known := cache.load(line)):
            out[at] = known
        elif line.audio is None:
            silent[at] = line.text
        elif line.text:
            told[at] = folder / line.audio, line.text
        else:
            heard[at] = folder / line.audio
    out |= zip(told, align_many(speaker, told.values()), strict=True)
    out |= zip(heard, recognise_many(speaker, heard.values()), strict=True)
    out |= zip(silent, speaker.speak_many(silent.values(), engine=engine), strict=True)
    if cache is not None:
        for at in (*told, *heard, *silent):
            cache.save(lines[at], out[at])
    return [out[at] for at in range(len(lines))]


def attempt(call: Callable[[], CallResult]) -> CallResult | Exception:
    """Return the result of a call, or its error, which concerns only one line."""
    try:
        return call()
    except Exception as error:  # noqa: BLE001 the other lines are still made
        return error


def _from_timings(
    speaker: Speaker, folder: Path, line: PlannedLine, cache: TimingCache | None
) -> Schedule:
    from lipsync_lang.schedules.timed_words import TimedWords
    from lipsync_lang.schedules.timing_readers import read_timings
    from lipsync_lang.sound.speech.filling import filled
    from lipsync_lang.sound.speech.sound import with_sound

    assert line.timings is not None  # noqa: S101 the caller asked for lines with timings
    found = read_timings(folder / line.timings)
    audio = None if line.audio is None else folder / line.audio
    if isinstance(found, TimedWords):
        made = cache.load(line) if cache is not None else None
        if made is None:
            made = filled(speaker, found, audio=audio)
            if cache is not None:
                cache.save(line, made)
        return made
    return found if audio is None else with_sound(found, audio)
