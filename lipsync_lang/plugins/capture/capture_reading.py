"""Readers of captures: lines of signals with their phonemes, from files.

A read-out converts a table of sensors, which are positions, to measures of a pose set. An
unreadable file is set aside with the reason, and the other files are still read.

Conventions: T samples, M measures; times are in seconds.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple, cast

import numpy as np

from lipsync_lang import (
    AnimationError,
    LipsyncError,
    Performer,
    Schedule,
    ScheduleError,
    TimedWords,
)
from lipsync_lang.animations.animation_readers import (
    ANIMATION_READERS,
    MAX_ANIMATION_BYTES,
    Recording,
    read_animation,
)
from lipsync_lang.animations.readers.csv import table_of
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import did_you_mean, shortlist
from lipsync_lang.base.files import read_input
from lipsync_lang.base.files.reading import input_text
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import ReadOut
from lipsync_lang.plugins.capture.capture_files import HEAD_OF_CAPTURE, CaptureFiles, find_captures
from lipsync_lang.plugins.capture.fit_file import SetAside
from lipsync_lang.plugins.capture.fit_lines import CapturedLine, resampled
from lipsync_lang.reports.quality.fitting import even_times, placed_columns
from lipsync_lang.schedules.schedule import SILENCE
from lipsync_lang.schedules.timing_file import TimingFile, unnamed_encoding
from lipsync_lang.schedules.timing_readers import timings_of

MIN_SAMPLES = 2

MAX_SENSED = 1e9
"""Maximum size of a value; larger ones are damage, and their squares overflow."""

MAX_SAMPLE_SECONDS = 86_400.0
"""Maximum time of a sample; larger ones are in another unit."""

FPS_TOLERANCE = 0.01
"""Maximum relative difference of the stated frame rate from that of the times."""

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


class SensorSignals(NamedTuple):
    """Measures from a table of sensors."""

    times: Floats
    """(T,) seconds."""
    measures: tuple[str, ...]
    values: Floats
    """(T, M) values; NaN for a lost sensor."""
    remarks: tuple[str, ...]


def load_readout(path: Path) -> ReadOut:
    """Read a read-out; PackFaults has all its faults if it is unsound."""
    return cast("ReadOut", Library(project=None).load(path, "readout").model)


def read_sensors(path: Path, readout: ReadOut) -> SensorSignals | None:
    """Read a table of sensors; return None without any column of the read-out."""
    mend = "check that it is a table of sensors"
    content = read_input(path, MAX_ANIMATION_BYTES, error=AnimationError, mend=mend)
    times, names, table = table_of(path, content, gaps=True)
    wanted = {column for sums in readout.measures.values() for column in sums}
    if wanted.isdisjoint(names):
        return None
    _check_times(path, times)
    lacking = {
        measure: column
        for measure, sums in readout.measures.items()
        for column in sums
        if column not in names
    }
    known = [measure for measure in readout.measures if measure not in lacking]
    if not known:
        column = min(wanted - set(names))
        raise AnimationError(f"{path}: has no column '{column}'; {did_you_mean(column, names)}")
    remarks = [
        f"{path}: has no column '{column}', so measure '{measure}' is left out"
        for measure, column in lacking.items()
    ]
    sensed = np.where(np.isfinite(table), table, np.nan)
    if readout.lost is not None:
        sensed[sensed == readout.lost] = np.nan
    # NaN, a lost sensor, is beyond nothing.
    beyond = (np.abs(sensed) > MAX_SENSED).any(axis=1)
    if beyond.any():
        raise AnimationError(
            f"{path}: sample {int(beyond.argmax())}: a value is beyond {MAX_SENSED:g}; state such "
            "values as `lost` in the read-out, or export the table again"
        )
    places = {name: at for at, name in enumerate(names)}
    values = np.column_stack(
        [
            sum(
                weight * sensed[:, places[column]]
                for column, weight in readout.measures[one].items()
            )
            for one in known
        ]
    )
    return SensorSignals(times, tuple(known), values, tuple(remarks))


def _check_times(path: Path, times: Floats) -> None:
    falls = np.diff(times) <= 0
    if len(times) < MIN_SAMPLES:
        what = f"has only {len(times)} samples; export the whole recording"
    elif not (np.isfinite(times) & (np.abs(times) <= MAX_SAMPLE_SECONDS)).all():
        what = "a time is not a number of seconds; name the column time_ms if it has milliseconds"
    elif falls.any():
        what = f"sample {int(falls.argmax()) + 1}: its time does not rise; sort the table"
    else:
        return
    raise AnimationError(f"{path}: {what}")


class Captures(NamedTuple):
    """Captured lines, and the captures that are not used."""

    lines: tuple[CapturedLine, ...]
    set_aside: tuple[SetAside, ...]


def read_captures(  # noqa: PLR0913 facts that files may lack
    performer: Performer,
    paths: str | Path | Iterable[str | Path],
    *,
    readout: str | Path | None = None,
    speaker: str | None = None,
    aligner: str | None = None,
    notation: str | None = None,
    progress: Callable[[int, int], None] = lambda _done, _all: None,
) -> Captures:
    """Read captures (`find_captures`) with their phonemes, as signals of a performer's face.

    By default, the read-out is `readout.yaml` in the folder of the captures or above, the aligner
    the language's, and the notation that of the read-out or the language. `progress` is called with
    the numbers of captures read and of all. A fault of one capture sets that one aside.
    """
    found, aside = find_captures(paths, speaker=speaker)
    stated = None if readout is None else load_readout(Path(readout))
    load = cache(load_readout)
    lines = []
    spoken = aligned_captures(performer, found, aligner)
    for number, files in enumerate(found, 1):
        try:
            own = load(files.readout) if stated is None and files.readout else stated
            lines.append(_line(performer, files, own, notation, spoken.get(files.name)))
        except (LipsyncError, OSError) as error:
            aside.append(SetAside(line=files.name, why=str(error)))
        progress(number, len(found))
    return Captures(tuple(lines), tuple(aside))


def _line(
    performer: Performer,
    files: CaptureFiles,
    readout: ReadOut | None,
    notation: str | None,
    spoken: Schedule | LipsyncError | None,
) -> CapturedLine:
    """Read one capture: of sensors if the read-out has the columns, or else poses or channels."""
    line: CapturedLine | None = None
    # Both kinds are CSV, and only the columns tell sensors from poses.
    may_be_sensors = files.capture.suffix.lower() == ".csv"
    if may_be_sensors:  # unless it is a table of another kind, such as a take of Live Link Face
        with files.capture.open("rb") as stream:
            head = stream.read(HEAD_OF_CAPTURE)
        kinds = ANIMATION_READERS.ending(files.capture)
        may_be_sensors = not any(one.fits and one.fits(head) for one in kinds)
    if readout is not None and may_be_sensors:
        sensed = read_sensors(files.capture, readout)
        if sensed is not None:
            line = _measured(performer, files.capture, sensed)
    try:
        line = line or _weighted(performer, read_animation(files.capture))
    except AnimationError as error:
        if readout is not None or not may_be_sensors:
            raise
        raise AnimationError(f"{error} (for a table of sensors, give a read-out)") from None
    fps = (len(line.times) - 1) / float(line.times[-1] - line.times[0])
    if files.fps is not None and abs(fps / files.fps - 1) > FPS_TOLERANCE:
        raise AnimationError(
            f"{files.capture}: its times have {fps:.4g} frames per second, but the list states "
            f"{files.fps:g}; correct the wrong one"
        )
    # By identity: a recording may truly hold a line of one silence.
    own = None if line.schedule is SILENT_SCHEDULE else line.schedule
    found = timed_capture(performer, files, readout, notation, spoken or own)
    schedule, more = readable(performer, found)
    remarks = (*line.remarks, *schedule.remarks, *more)
    times, name, who = line.times + files.start, files.name, files.speaker
    return replace(line, name=name, schedule=schedule, times=times, speaker=who, remarks=remarks)


def _measured(performer: Performer, path: Path, sensed: SensorSignals) -> CapturedLine:
    """Return the measures of sensors that the pose set has."""
    known = performer.compiled.measures
    used = [at for at, name in enumerate(sensed.measures) if name in known]
    if not used:
        raise AnimationError(
            f"{path}: its read-out has {few_names(sensed.measures)}, but the measures of "
            f"{performer.character} are {few_names(known) or 'none'}; use these in the read-out"
        )
    signals = tuple(sensed.measures[at] for at in used)
    gains = np.array([[known[s].get(pose, 0.0) for pose in performer.poses] for s in signals])
    times, _ = even_times(str(path), sensed.times)
    values = sensed.values[:, used]
    # Times that are even already come back as they are.
    if times is not sensed.times:
        values = resampled(times, sensed.times, values)
    other = [name for name in sensed.measures if name not in known]
    remarks = sensed.remarks
    if other:
        # without the path, so that it is told once for all captures
        told = f"{performer.character} has no measure {few_names(other)}; these are left out"
        remarks += (told,)
    return CapturedLine(
        str(path), SILENT_SCHEDULE, times, signals, values, gains, free=True, remarks=remarks
    )


def _weighted(performer: Performer, recording: Recording) -> CapturedLine:
    """Return the recorded poses or rig channels of an animation."""
    found = placed_columns(recording, performer)
    names = [found.face[number].name for number in found.numbers.tolist()]
    gains = found.gains[found.numbers]
    remarks = found.remarks
    if found.missing:
        told = f"has no column for {few_names(found.missing)}; these are not fitted"
        remarks += (f"{recording.source}: {told}",)
    deaf = ~gains.any(axis=1)
    if deaf.all():
        raise AnimationError(f"{recording.source}: no pose moves any of {few_names(names)}")
    kept = np.flatnonzero(~deaf)
    signals = tuple(names[at] for at in kept)
    schedule, rigged = recording.schedule or SILENT_SCHEDULE, found.face != performer.channels
    values = found.values[:, kept]
    line = CapturedLine(recording.source, schedule, found.times, signals, values, gains[kept])
    return replace(line, rigged=rigged, remarks=remarks)


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
        with unnamed_encoding():
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
