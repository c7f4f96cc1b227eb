"""Schedules of planned lines: read from timings, aligned with recordings, or spoken.

Aligners, recognisers and voices take most of a build, so their schedules are kept on disk. One is
found by the digest of all that it depends on: text, sound, language, engines and the program's own
code. So another character, frame rate or project reads it in a millisecond. A file is trusted as a
compiled pair is: it must be whole, and it holds data alone (decision 0002).
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from lipsync_lang.production.builds.digests import digest, file_digest
from lipsync_lang.production.builds.planned_line import PlannedLine
from lipsync_lang.resolver.cache import delete_oldest, folder, keep, unsealed
from lipsync_lang.schedules.schedule import Audio, Schedule, Word
from lipsync_lang.sound.speech.sound import read_audio

if TYPE_CHECKING:
    from lipsync_lang.performing.performer import Performer

MARK = b"lipsync-lang timings, version 2\n"

TIMERS = ("plugins/mfa", "schedules", "sound", "text")
"""Folders of the code that times lines. A change below them invalidates every file."""

MAX_KEPT_TIMINGS_BYTES = 2**30
"""Maximum bytes of all timings; the oldest are deleted first. A spoken second has 44 kB."""

TIMINGS_SUFFIX = ".timings"

CallResult = TypeVar("CallResult")

ScheduleOrError = Schedule | Exception
"""Schedule of a line, or the error in its place."""


@dataclass(frozen=True)
class TimingCache:
    """Cache of the timings of lines in one language.

    Parameters
    ----------
    folder : of the project
    reading : digest of all settings of the language and its engines
    reuse : False to write only
    """

    folder: Path
    reading: str
    reuse: bool = True

    def has(self, line: PlannedLine) -> bool:
        """Return True if the timings of a line are in the cache, to be checked when loaded."""
        try:
            path = self._path(line) if self.reuse else None
        except OSError:  # of the recording
            return False
        # Without a look inside, since this only decides how many processes pay.
        return path is not None and path.is_file()

    def load(self, line: PlannedLine) -> Schedule | None:
        """Return the schedule of a line, with its sound; None if there is none to trust."""
        with suppress(Exception):  # a forged file can fail anywhere, and the line is timed again
            content = unsealed(MARK, self._path(line) if self.reuse else None)
            recording = None if line.audio is None else read_audio(self.folder / line.audio)
            return _decoded(content, recording)
        return None

    def save(self, line: PlannedLine, timed: object) -> None:
        """Keep the schedule of a line; an error, or a cache that cannot be written, is skipped."""
        if not isinstance(timed, Schedule):
            return
        with suppress(OSError):  # of the recording
            keep(self._path(line), MARK, _encoded(timed, own=line.audio is None))

    def _path(self, line: PlannedLine) -> Path | None:
        where = folder()
        if where is None:
            return None
        files = [path and file_digest(self.folder / path) for path in (line.audio, line.timings)]
        name = digest(self.reading, line.text, files, str(line.timings)).hex()
        return where / "timings" / f"{name}{TIMINGS_SUFFIX}"


def prune_timings() -> None:
    """Delete the oldest timings beyond the size limit of the cache."""
    where = folder()
    if where is not None:
        delete_oldest(where / "timings", f"*{TIMINGS_SUFFIX}", MAX_KEPT_TIMINGS_BYTES)


def _encoded(schedule: Schedule, *, own: bool) -> Iterator[bytes]:
    """Yield the parts of a file; sound is kept if it is the schedule's own, not a recording."""
    head: dict[str, Any] = {f.name: getattr(schedule, f.name) for f in fields(schedule)}
    audio = head.pop("audio") if own else head.update(audio=None)
    head["times"] = schedule.times.tolist()
    head["words"] = [[*vars(word).values()] for word in schedule.words]
    head["audio"] = [audio.rate, audio.usual_level] if audio else None
    text = json.dumps(head).encode()
    yield len(text).to_bytes(8, "little") + text
    if audio is not None:
        yield audio.samples.astype("<i2", copy=False).tobytes()


def _decoded(content: memoryview, recording: Audio | None) -> Schedule:
    size = 8 + int.from_bytes(content[:8], "little")
    head = json.loads(bytes(content[8:size]))
    sound = head.pop("audio")
    head |= {name: tuple(value) for name, value in head.items() if isinstance(value, list)}
    head["words"] = tuple(Word(*word) for word in head["words"])
    head["likely"] = tuple(tuple(map(tuple, one)) for one in head["likely"])
    made = Schedule(**head)
    if sound is None:
        return replace(made, audio=recording)
    samples = np.frombuffer(content[size:], "<i2").astype(np.int16, copy=False)
    return replace(made, audio=Audio(samples, *sound))


def schedules(
    folder: Path,
    lines: Sequence[PlannedLine],
    performer: "Performer",
    engine: str | None = None,
    opened: Callable[[], TimingCache | None] = lambda: None,
) -> list[ScheduleOrError]:
    """Time the phonemes of lines by their timings, their recordings, or only their text.

    `engine` is another speech engine than the language's; `none` estimates times. Lines whose
    timings are in the cache are not timed again. Timings with phonemes need neither the cache,
    which is opened for other lines, nor the performer's language.
    """
    cache = opened() if any(line.timings is None for line in lines) else None
    out: dict[int, ScheduleOrError] = {}
    told: dict[int, tuple[Path, str]] = {}
    heard: dict[int, Path] = {}
    silent: dict[int, str] = {}
    for at, line in enumerate(lines):
        if line.timings is not None:
            out[at] = attempt(partial(_from_timings, performer, folder, line, opened))
        elif cache is not None and (known := cache.load(line)):
            out[at] = known
        elif line.audio is None:
            silent[at] = line.text
        elif line.text:
            told[at] = folder / line.audio, line.text
        else:
            heard[at] = folder / line.audio
    out |= _without_timings(performer, told, heard, silent, engine)
    if cache is not None:
        for at in (*told, *heard, *silent):
            cache.save(lines[at], out[at])
    return [out[at] for at in range(len(lines))]


def _without_timings(
    performer: "Performer",
    told: Mapping[int, tuple[Path, str]],
    heard: Mapping[int, Path],
    silent: Mapping[int, str],
    engine: str | None,
) -> dict[int, ScheduleOrError]:
    """Time recordings with a text and without one, and texts without a recording."""
    out: dict[int, ScheduleOrError] = {}
    # without a recording, the models of hearing would be loaded for nothing
    if told:
        from lipsync_lang.sound.speech.hearing.alignment import align_many

        out |= zip(told, align_many(performer.speaker, told.values()), strict=True)
    if heard:
        from lipsync_lang.sound.speech.hearing.recognition import recognise_many

        out |= zip(heard, recognise_many(performer.speaker, heard.values()), strict=True)
    if silent:
        spoken = performer.speaker.speak_many(silent.values(), engine=engine)
        out |= zip(silent, spoken, strict=True)
    return out


def attempt(call: Callable[[], CallResult]) -> CallResult | Exception:
    """Return the result of a call, or its error, which concerns only one line."""
    try:
        return call()
    except Exception as error:  # noqa: BLE001 the other lines are still made
        return error


def _from_timings(
    performer: "Performer",
    folder: Path,
    line: PlannedLine,
    opened: Callable[[], TimingCache | None],
) -> Schedule:
    from lipsync_lang.schedules.timed_words import TimedWords, words_without_phonemes
    from lipsync_lang.schedules.timing_file import unnamed_encoding
    from lipsync_lang.schedules.timing_readers import read_timings

    assert line.timings is not None  # noqa: S101 the caller asked for lines with timings
    with unnamed_encoding():
        found = read_timings(folder / line.timings)
    audio = None if line.audio is None else folder / line.audio
    if audio is None and isinstance(found, Schedule) and not words_without_phonemes(found):
        return found
    from lipsync_lang.sound.speech.filling import with_phonemes

    cache = opened() if isinstance(found, TimedWords) else None
    made = None if cache is None else cache.load(line)
    if made is None:
        made = with_phonemes(performer.speaker, found, audio=audio)
        if cache is not None:
            cache.save(line, made)
    return made
