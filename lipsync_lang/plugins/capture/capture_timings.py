"""Timings of captures, from files beside them or by alignment with their sound."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from lipsync_lang.base.errors import LipsyncError, ScheduleError, shortlist
from lipsync_lang.base.files.reading import input_text
from lipsync_lang.packs.models import ReadOut
from lipsync_lang.performing.performer import Performer
from lipsync_lang.plugins.capture.capture_files import CaptureFiles
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.schedules.timed_words import TimedWords
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import timings_of

SILENT_SCHEDULE = Schedule((SILENCE,), np.array([0.0, 1.0]))

LONG_LAST_SECONDS = 0.5
"""Maximum length of a last sound; a longer one includes silence."""

LAST_SECONDS = 0.1
"""Length to which such a sound is shortened."""

MAX_UNKNOWN_SHARE = 0.1
"""Maximum share of labels unknown to the language, which are read as silence."""

MAX_TEXT_BYTES = 2**20

FEW_NAMES = 8
"""Maximum number of names in a message."""


def few_names(names: Iterable[str]) -> str:
    """Format the first few names as a list."""
    return shortlist(names, FEW_NAMES)


def timed_capture(
    performer: Performer,
    files: CaptureFiles,
    readout: ReadOut | None,
    notation: str | None,
    spoken: Schedule | LipsyncError | None,
) -> Schedule:
    """Return the phonemes of a capture: from its timings, alignment or own file."""
    if files.timings is not None:
        from lipsync_lang.sound.speech.filling import filled

        quiet = {*performer.compiled.silences, *(readout.silences if readout else ())}
        silences = frozenset(one.casefold() for one in quiet)
        found = timings_of(TimingFile.of(files.timings, silences=silences))
        if isinstance(found, TimedWords):
            return filled(performer.speaker, found, audio=files.audio)
        notation = notation or (readout.notation if readout else None) or found.notation
        return replace(found, notation=notation)
    if isinstance(spoken, LipsyncError):
        raise spoken
    if spoken is not None:
        return spoken
    near = files.capture.with_name(files.name.rpartition("/")[2])
    has = "a text, but no sound" if files.text is not None else "no timings"
    raise ScheduleError(
        f"{files.capture}: has {has}; put {near.name}.TextGrid beside it, or "
        f"{near.name}.txt and {near.name}.wav"
    )


def aligned_captures(
    performer: Performer, captures: Sequence[CaptureFiles], aligner: str | None
) -> dict[str, Schedule | LipsyncError]:
    """Align captures that have a text and a sound, but no timings; return results by name."""
    from lipsync_lang.sound.speech.hearing.alignment import align_many

    pairs: dict[str, tuple[Path, str]] = {}
    out: dict[str, Schedule | LipsyncError] = {}
    for one in captures:
        text = one.text
        if text is None or one.audio is None or one.timings is not None:
            continue
        try:
            if isinstance(text, Path):
                text = input_text(text, MAX_TEXT_BYTES, mend="give the text of one line").strip()
            pairs[one.name] = one.audio, text
        except LipsyncError as error:
            out[one.name] = error
    if pairs:
        found = align_many(performer.speaker, pairs.values(), aligner=aligner)
        out |= zip(pairs, found, strict=True)
    return out


def readable(performer: Performer, schedule: Schedule) -> tuple[Schedule, tuple[str, ...]]:
    """Return a schedule with silence for unknown labels; raise an error if there are many.

    The audio is dropped, because a performance would follow its loudness. A last sound that
    includes silence is shortened.
    """
    reader = performer.labels
    known = reader.notation(schedule)
    labels = dict.fromkeys(schedule.labels)
    unknown = {
        one for one in labels if known.find(one) is None and reader.unlisted(known, one) is None
    }
    lost = [at for at, label in enumerate(schedule.labels) if label in unknown]
    told: tuple[str, ...] = ()
    if len(lost) > MAX_UNKNOWN_SHARE * len(schedule):
        raise ScheduleError(
            f"{schedule.source}: {len(lost)} of {len(schedule)} labels are unknown to "
            f"{performer.language}: {few_names(sorted(unknown))}; name their notation, or list "
            "the silent ones in a read-out"
        )
    if lost:
        what = f"labels unknown to {performer.language}, read as silence"
        told = (f"{schedule.source}: {what}: {few_names(sorted(unknown))}",)
    made = replace(
        schedule,
        labels=tuple(SILENCE if label in unknown else label for label in schedule.labels),
        audio=None,
    )
    values = reader.values(made)
    silent = [value == reader.values(SILENT_SCHEDULE)[0] for value in values]
    if all(silent):
        raise ScheduleError(f"{schedule.source}: has only silence; check that it is the right file")
    return _cut_last(made, max(at for at, mute in enumerate(silent) if not mute)), told


def _cut_last(schedule: Schedule, last: int) -> Schedule:
    """Shorten a last sound that includes silence."""
    start, end = schedule.times[last : last + 2].tolist()
    if end - start <= LONG_LAST_SECONDS:
        return schedule
    labels = (*schedule.labels[: last + 1], SILENCE)
    times = np.array([*schedule.times[: last + 1], start + LAST_SECONDS, schedule.end])
    stress = (*schedule.stress[: last + 1], None) if schedule.stress else ()
    words = tuple(word for word in schedule.words if word.stop <= last + 1)
    told = (
        f"{schedule.source}: its last sound, {schedule.labels[last]!r}, lasts {end - start:.2f} s "
        f"and is shortened to {LAST_SECONDS:g} s"
    )
    return replace(
        schedule, labels=labels, times=times, stress=stress, words=words, lines=(),
        remarks=(*schedule.remarks, told),
    )  # fmt: skip
