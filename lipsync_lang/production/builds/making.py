"""Production of lines: time their phonemes, perform them, judge them and write their outputs.

Outputs are written under temporary names beside their targets. The build renames them once it has
recorded them. A line that fails does not disturb the others.
"""

import errno
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from io import BytesIO
from pathlib import Path
from stat import S_ISDIR
from typing import Any, BinaryIO, NamedTuple, Self
from zlib import crc32

from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.base.errors import LipsyncError, shortlist
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.base.files.targets import read_only, refuse_locked
from lipsync_lang.base.files.temporary import temporary_name, this_process
from lipsync_lang.performing.delivery import marked_text
from lipsync_lang.performing.label_reader import label_remarks
from lipsync_lang.performing.performer import Performer
from lipsync_lang.production.builds.archives import split_archive
from lipsync_lang.production.builds.digests import digest, file_digest, output_digest
from lipsync_lang.production.builds.faces import face_file
from lipsync_lang.production.builds.needs import BuildSettings, PairNeeds
from lipsync_lang.production.builds.planned_line import (
    CONFIDENCE,
    BuiltLine,
    JudgedFigure,
    PlannedLine,
    recorded_path,
)
from lipsync_lang.production.builds.records import Key, LineRecord, as_json, packed_figures
from lipsync_lang.production.builds.timing import (
    TIMERS,
    ScheduleOrError,
    TimingCache,
    attempt,
    schedules,
)
from lipsync_lang.production.builds.timing_formats import use_timing_formats
from lipsync_lang.reports.quality.figures import Quality
from lipsync_lang.resolver.cache import compiler
from lipsync_lang.schedules.schedule import DOUBTFUL, Schedule

MAX_FINDINGS = 3
"""Maximum number of findings of a figure in a report."""

FULL = frozenset((errno.ENOSPC, errno.EDQUOT))
"""Errors of a full disk."""

NO_FILES: Mapping[str, str] = {}

TIMING_DOUBT = "doubt of timings"
"""Figure of an aligned line: 1 minus its confidence."""


class LineBatch(NamedTuple):
    """Lines of one language that are made together, so that each is timed once."""

    language: str
    characters: tuple[str, ...]
    lines: tuple[PlannedLine, ...]


LineJudgement = tuple[Mapping[str, bytes], tuple[JudgedFigure, ...]]
"""Needs of a performed line, and its figures of quality."""


class MadeFile(NamedTuple):
    """An output under its temporary name."""

    path: str
    """Its target, from the project's folder."""
    temporary: str
    size: int
    changed: int
    """Time of its last change in nanoseconds; the CRC of a member of an archive."""
    digest: str


@dataclass(frozen=True)
class MadeLine:
    """A line from a worker, packed there: its figures would take long to travel as objects."""

    key: Key
    record: LineRecord
    """Its record, without the inputs, needs and outputs that the build adds."""
    message: str
    failed: tuple[str, ...]
    """Names of the figures that exceed limits of the project."""
    left_out: tuple[str, ...]
    files: tuple[MadeFile, ...] = ()
    needs: Mapping[str, bytes] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    """Remarks of the writers on the character's model and channels, and on words left out."""
    fatal: bool = False
    """True if the disk or the folder refuses every other line, too."""

    @classmethod
    def of(cls, built: BuiltLine, contents: Mapping[str, str] = NO_FILES, **rest: Any) -> Self:
        """Pack a line; `contents` has the digest of each source file, by path."""
        failed = tuple(one.name for one in built.failed)
        notes = [(figure.at, figure.words) for figure in built.figures]
        result = as_json((built.outcome, built.message, built.seconds, notes, built.left_out))
        judged = built.verdict, built.confidence, *packed_figures(built.figures)
        record = LineRecord("", as_json(contents), b"", {}, *judged, result)
        return cls(built.line.key, record, built.message, failed, built.left_out, **rest)


@dataclass(frozen=True)
class LineMaker:
    """Maker of the lines of a project, which each worker receives once."""

    folder: Path
    settings: BuildSettings
    owner: str = field(default_factory=this_process)
    """The process that puts outputs in place, or deletes them if it is interrupted."""
    reuse: bool = True
    """False to time lines again whose timings are in the cache."""
    _folders: dict[str, str] = field(default_factory=dict, init=False, repr=False, compare=False)
    """Folders for waiting outputs that this batch has checked, by path."""

    def __call__(self, batch: LineBatch, pairs: Mapping[str, PairNeeds]) -> list[MadeLine]:
        """Make the lines of a batch, in order; `pairs` has the needs of each character."""
        # A worker has opened no project.
        use_timing_formats(self.settings.timing_formats or {})
        self._folders.clear()  # a worker outlives a build, and folders may go or become links
        first = {line.name: line for line in reversed(batch.lines)}
        contents: dict[str, dict[str, str]] = {name: {} for name in first}
        for name, line in first.items():  # before the files are read
            for path in filter(None, (line.timings, line.audio)):
                with suppress(OSError):  # the reader of the file says why
                    known = recorded_path(self.folder, path)
                    contents[name][known] = file_digest(self.folder / path)
        timed = list(zip(batch.lines, self._timed(batch.lines, pairs), strict=True))
        made: dict[tuple[str, str, str], MadeLine] = {}
        for character, pair in pairs.items():
            own = [(line, said) for line, said in timed if line.character == character]
            performed = [*self._performed(pair.performer, own)]
            # Megabytes of outputs drive small arrays out of the processor's cache: judge all first.
            judged = self._judged(pair, performed)
            for (line, animation), found in zip(performed, judged, strict=True):
                made[line.key] = self._made(pair, line, animation, found, contents[line.name])
        return [made[line.key] for line in batch.lines]

    def animation(self, line: PlannedLine, pair: PairNeeds) -> Animation:
        """Perform one line, or raise its error."""
        (said,) = self._timed((line,), {line.character: pair})
        ((_, animation),) = self._performed(pair.performer, [(line, said)])
        if isinstance(animation, Exception):
            raise animation
        return animation

    def cache(self, pair: PairNeeds) -> TimingCache:
        """Return the cache for the timings of a pair's lines."""
        cleaning, engine = pair.performer.speaker.cleaning, self.settings.tts
        reading = digest(pair.speech.hex(), cleaning, engine, compiler(TIMERS))
        return TimingCache(self.folder, reading.hex(), self.reuse)

    def _timed(
        self, lines: Sequence[PlannedLine], pairs: Mapping[str, PairNeeds]
    ) -> Iterator[ScheduleOrError]:
        """Yield the schedule of each line; characters with the same speech share it."""
        compiled = [pairs[line.character].performer.compiled for line in lines]
        marked = [
            line if text == line.text else replace(line, text=text)
            for line, who in zip(lines, compiled, strict=True)
            for text in [marked_text(who, line.text, line.name)]
        ]
        keys = [(pairs[line.character].speech, line.name, line.text) for line in marked]
        # Reversed, so that the first of the lines with equal keys stays.
        asked = dict(zip(reversed(keys), reversed(marked), strict=True))
        known: dict[tuple[bytes, str, str], ScheduleOrError] = {}
        for speech in dict.fromkeys(speech for speech, *_ in asked):
            own = [line for (one, *_), line in asked.items() if one == speech]
            pair = pairs[own[0].character]
            asked_of = pair.performer, self.settings.tts, partial(self.cache, pair)
            timed = schedules(self.folder, own, *asked_of)
            known |= {
                (speech, line.name, line.text): one for line, one in zip(own, timed, strict=True)
            }
        return (known[key] for key in keys)

    def _performed(
        self, performer: Performer, timed: Sequence[tuple[PlannedLine, ScheduleOrError]]
    ) -> Iterator[tuple[PlannedLine, Animation | Exception]]:
        """Yield the animation of each line, or its error; all at once if no line fails."""
        rest = self.settings.idle
        sound = [(line, s.resting(rest)) for line, s in timed if isinstance(s, Schedule)]
        edited = performer.compiled.line_edits
        asked: dict[str, Any] = {"fps": self.settings.fps, "gestures": self.settings.gestures}
        names = [line.name if line.name in edited else None for line, _ in sound]
        found: list[Animation | Exception]
        try:
            found = [*performer.perform_many([said for _, said in sound], lines=names, **asked)]
        except Exception:  # noqa: BLE001 each line reports its own error
            found = [
                attempt(partial(performer.perform, said, line=name, **asked))
                for (_, said), name in zip(sound, names, strict=True)
            ]
        animations = iter(found)
        for line, said in timed:
            yield line, said if isinstance(said, Exception) else next(animations)

    def _judged(
        self, pair: PairNeeds, performed: Sequence[tuple[PlannedLine, Animation | Exception]]
    ) -> list[LineJudgement | Exception]:
        """Judge lines, or return the error of each; all at once if no line fails."""
        from lipsync_lang.reports.quality.check_animation import check, check_all

        limits = {name: most for name, most in self.settings.limits.items() if name != CONFIDENCE}
        sound = [one for _, one in performed if isinstance(one, Animation)]
        found: list[Quality | Exception]
        try:
            found = [*check_all(sound, pair.performer, limits)]
        except Exception:  # noqa: BLE001 each line reports its own error
            found = [attempt(partial(check, one, limits=limits)) for one in sound]
        qualities = iter(found)
        out: list[LineJudgement | Exception] = []
        for line, animation in performed:
            quality = animation if isinstance(animation, Exception) else next(qualities)
            if isinstance(quality, Exception):
                out.append(quality)
            elif isinstance(animation, Animation):
                out.append(attempt(partial(self._judgement, pair, line, animation, quality)))
        return out

    def _judgement(
        self, pair: PairNeeds, line: PlannedLine, animation: Animation, quality: Quality
    ) -> LineJudgement:
        reasons = any(WRITERS[name].reasons for name, _ in line.outputs)
        needs = pair.of(animation.schedule, spoken=line.timings is None, reasons=reasons)
        figures = [
            JudgedFigure(
                name,
                value,
                unit,
                limit,
                tuple([at for at, _ in findings[:MAX_FINDINGS]]),
                findings[0].what if findings else why,
                name.partition(" ")[0] in self.settings.limits,
            )
            for name, value, unit, limit, _, findings, why in quality.figures
        ]
        confidence = animation.schedule.confidence
        if confidence is not None:
            stated = CONFIDENCE in self.settings.limits
            most = 1 - self.settings.limits.get(CONFIDENCE, DOUBTFUL)
            figures.append(JudgedFigure(TIMING_DOUBT, 1 - confidence, "", most, binding=stated))
        return needs, tuple(figures)

    def _made(
        self,
        pair: PairNeeds,
        line: PlannedLine,
        animation: Animation | Exception,
        judged: LineJudgement | Exception,
        contents: Mapping[str, str],
    ) -> MadeLine:
        """Write a line; an error is reported for this line only."""
        if isinstance(animation, Exception):
            return self._failed(line, animation)
        if isinstance(judged, Exception):
            return self._failed(line, judged)
        needs, figures = judged
        schedule = animation.schedule
        files: list[MadeFile] = []
        try:
            face = face_file(line.character, pair) if self.settings.face_once else ""
            export = ExportSettings(
                self.settings.offset, face=face, frame_rate=self.settings.frame_rate
            )
            shown = replace(pair.performer.rigged(animation), export=export)
            self._write(line, shown, files)
            remarks = [*pair.performer.compiled.report.idle]
            remarks += [one for name, _ in line.outputs for one in WRITERS[name].remarks(shown)]
            if schedule.left_out:
                words = shortlist([f"'{word}'" for word in schedule.left_out], MAX_FINDINGS)
                lacking = f"{line.place}: the recording lacks words of the text: {words}"
                remarks.insert(0, lacking)
        except Exception as error:  # noqa: BLE001 the other lines of the batch are made
            for file in files:
                Path(file.temporary).unlink(missing_ok=True)
            return self._failed(line, error)
        built = BuiltLine(
            line,
            "built",
            "; ".join((*schedule.remarks, *label_remarks(pair.performer.labels, schedule))),
            float(animation.times[-1] - animation.times[0]),
            schedule.confidence,
            figures,
            schedule.left_out,
        )
        more = {"files": tuple(files), "needs": needs, "remarks": tuple(remarks)}
        return MadeLine.of(built, contents, **more)

    def _failed(self, line: PlannedLine, error: Exception) -> MadeLine:
        """Return a line with the reason why it failed, and its place."""
        home, locked = f"{self.folder}{os.sep}", ""
        if isinstance(error, OSError) and error.filename:
            locked = read_only(Path(error.filename), error)
        if isinstance(error, LipsyncError):
            message = f"{line.place}: {error}".replace(home, "")
        elif isinstance(error, OSError):
            where = f"{error.filename}: " if error.filename and not locked else ""
            free = "; free some space" if error.errno in FULL else ""
            why = locked or f"{error.strerror or error}{free}"
            message = f"{line.place}: {where}{why}".replace(home, "")
        elif isinstance(error, MemoryError):
            message = f"{line.place}: out of memory; give fewer --workers, or split the line"
        else:
            why = f"an internal error stopped it ({type(error).__name__}: {error})"
            message = f"{line.place}: {why}; report the line"
        fatal = bool(locked) or (isinstance(error, OSError) and error.errno in FULL)
        return MadeLine.of(BuiltLine(line, "failed", message), fatal=fatal)

    def _write(self, line: PlannedLine, animation: Animation, files: list[MadeFile]) -> None:
        for name, path in line.outputs:
            stream = BytesIO()
            WRITERS[name].write(animation, stream)
            content = stream.getbuffer()
            within, _, last = path.rpartition("/")
            if within not in self._folders:
                waiting = parent_of(self.folder, path)
                refuse_outside(waiting, self.folder)
                waiting.mkdir(parents=True, exist_ok=True)
                self._folders[within] = str(waiting)
            parent = self._folders[within]
            temporary = os.path.join(parent, temporary_name(last, self.owner))  # noqa: PTH118 once a file
            with created(temporary, os.path.join(parent, last)) as out:  # noqa: PTH118
                files.append(MadeFile(path, temporary, 0, 0, ""))
                out.write(content)
            crc, size = crc32(content), len(content)
            archived = split_archive(path) is not None
            changed = crc if archived else os.stat(temporary).st_mtime_ns  # noqa: PTH116 once a file
            files[-1] = MadeFile(path, temporary, size, changed, output_digest(crc, size))


def parent_of(folder: Path, path: str) -> Path:
    """Return the folder in which an output waits: its own, or that of its archive."""
    split = split_archive(path)
    return (folder / (path if split is None else split[0])).parent


def created(temporary: str, target: str) -> BinaryIO:
    """Open a new file with the permissions of the file that it will replace."""
    try:
        found = os.stat(target).st_mode  # noqa: PTH116 once a file
        # A rename onto a folder would fail late, and on Windows without a clear reason.
        if S_ISDIR(found):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), target)
        refuse_locked(Path(target), found)
        mode = found & 0o666
    except FileNotFoundError:
        mode = 0o666
    # `O_EXCL`, so that a link of that name in a foreign project is not followed.
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    return os.fdopen(os.open(temporary, flags, mode), "wb")
