"""Script of a project: its bigrams, counted in a thread and cached until it changes.

A count depends on the script and on its reading by the language. The bigrams of the character are
looked up each time, so that an edit of a bank needs no new count.
"""

import logging
import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from hashlib import file_digest
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from threading import Thread
from typing import Any
from weakref import WeakKeyDictionary, finalize

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.reach import is_reached
from lipsync_lang.packs.finding import FOLDERS
from lipsync_lang.packs.project import find_project, load_project
from lipsync_lang.packs.speaker_faces import SpeakerFaces, stated_faces
from lipsync_lang.performing.performer import Performer
from lipsync_lang.production.builds.script_faults import in_words_of_project
from lipsync_lang.reports.coverage.corpus import Pages, Reading, Takes, count, units
from lipsync_lang.reports.coverage.report import CoverageReport
from lipsync_lang.reports.coverage.report_figures import CountFigures, report_of
from lipsync_lang.reports.coverage.scripts import scripts_of
from lipsync_lang.studio.workshop import Workshop
from lipsync_lang.text.lines import Line, read_lines
from lipsync_lang.text.lines.line_readers import AS_FOUND, TableLayout, by_suffix

_log = logging.getLogger(__name__)

MAX_SCRIPTS = 200
"""Maximum number of files of a project to offer as scripts."""

MAX_FOLDERS = 2000
"""Maximum number of folders of a project to search for scripts."""

# A workshop that ends takes its script along.
_scripts: "WeakKeyDictionary[Workshop, ScriptCount]" = WeakKeyDictionary()


@dataclass(frozen=True)
class ScriptReading:
    """The reading of a script for the open pair; two equal readings count the same lines."""

    column: str | None
    """Column of a table, by name or number; None for the one that is named after the language."""
    names: tuple[str, ...] = ()
    """Names of the language, which a column may have."""
    speaker: str | None = None
    """Column of the speakers; None for the likeliest."""
    encoding: str | None = None
    """Encoding of the file; None for UTF-8, or what the file's mark says."""
    cast: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """Speakers with their characters; empty if the open character speaks every line."""
    character: str = ""
    layout: TableLayout = AS_FOUND
    """The sheet of the project, and the row that names the columns."""

    @property
    def faces(self) -> SpeakerFaces | None:
        """The characters of the speakers; None if the open character speaks every line."""
        return SpeakerFaces(dict(self.cast)) if self.cast else None

    @property
    def takes(self) -> Takes | None:
        """The choice of the open character's lines; None for every line."""
        faces = self.faces
        return None if faces is None else lambda line: self.character in faces.of(line.speaker)


def reading_of(workshop: Workshop, column: str | None, *, sent: bool) -> ScriptReading:
    """Return the reading of a script for the open pair.

    A character that the project's `cast` does not name speaks every line: somebody chose it. The
    user states `column`; None is the project's, or the language's own. A script that was `sent`
    has no columns of the project. Raises LipsyncError if the project file is unsound.
    """
    file = find_project(workshop.project)
    project = None if file is None else load_project(file).model
    given, finder = workshop.language, workshop.library()
    paths = () if ":" in given else finder.lookup("language", given)
    own = [
        name
        for name in ({} if project is None else project.languages)
        if name == given or (paths and ":" not in name and finder.lookup("language", name) == paths)
    ]
    word = given if project is None or not own else project.languages[own[0]] or own[0]
    names = finder.column_names(given, word)
    if project is None:
        return ScriptReading(column, names)
    character = workshop.character
    faces = SpeakerFaces(stated_faces(project) if project.cast else {})
    cast = tuple(faces.stated.items()) if character in faces.characters else ()
    if sent:
        return ScriptReading(column, names, cast=cast, character=character)
    stated = project.columns.text and project.columns.text.replace("{language}", word)
    layout = TableLayout(project.columns.sheet, project.columns.header_row)
    return ScriptReading(
        column or stated, names, project.columns.speaker, project.encoding, cast, character, layout
    )


@dataclass(eq=False)
class _CountRun:
    """A running count, or its result."""

    key: object
    performer: Performer
    lines: int = 0
    figures: CountFigures | None = None
    fault: str = ""
    remarks: list[str] = field(default_factory=list)
    dropped: bool = False

    def work(self, path: Path, reading: ScriptReading, scripts: Iterable[str]) -> None:
        """Count a script; an error becomes `fault`."""
        if reading.cast:
            self.remarks.append(f"counts the lines that `cast` gives to {reading.character}")
        pages = Pages()
        # A run that is dropped is closed by nobody else.
        finalize(self, pages.close)
        folder = f"{path.parent}{os.sep}"
        try:
            lines = read_lines(
                path, column=reading.column, encoding=reading.encoding,
                remark=lambda told: self.remarks.append(told.replace(folder, "")),
                cleaning=self.performer.cleaning, names=reading.names, speaker=reading.speaker,
                layout=reading.layout,
            )  # fmt: skip
            own = Reading(self.performer, scripts, reading.takes)
            corpus, counts = count(self._seen(lines), [own], pages, reading.faces)
            if corpus.lines:
                self.figures = CountFigures(counts[0], pages)
            else:
                self.fault = f"{path.name} has no lines to count"
        except LipsyncError as error:
            self.fault = in_words_of_project(error).replace(folder, "")
        except Exception:  # noqa: BLE001 a thread has nobody else to tell
            _log.exception("counting %s failed", path)
            self.fault = (
                f"{path.name} could not be counted; see the terminal of the studio for details"
            )

    def _seen(self, lines: Iterable[Line]) -> Iterator[Line]:
        for line in lines:
            if self.dropped:
                return  # another script took its place
            self.lines += 1
            yield line


class ScriptCount:
    """Script of a workshop."""

    def __init__(self) -> None:
        self.name, self.sent = "", False
        """Name of the script for the user, empty without one; True if the browser sent it."""
        self.column: str | None = None
        """Column of a table; None for the most likely one."""
        self._path: Path | None = None
        self._discard: finalize[..., ScriptCount] | None = None
        self._run: _CountRun | None = None

    def choose(self, workshop: Workshop, name: str, column: str | None) -> None:
        """Use a file of the project as the script.

        Raises LipsyncError if the file is outside the project, missing, or of an unknown format.
        """
        if not is_reached(workshop.project / name, workshop.project):
            raise LipsyncError(
                f"'{name}' is outside the project's folder; drop the file onto this page"
            )
        self._take(workshop.project / name, name, column)

    def receive(self, put: Callable[[Path], Path], column: str | None) -> None:
        """Use a sent file as the script; `put` puts it into a folder, and returns its path."""
        folder = Path(mkdtemp())
        discard = finalize(self, rmtree, folder, ignore_errors=True)
        try:
            path = put(folder)
            self._take(path, path.name, column)
        except LipsyncError:
            discard()
            raise
        self._discard, self.sent = discard, True

    def _take(self, path: Path, name: str, column: str | None) -> None:
        if not os.path.isfile(path):  # noqa: PTH113 names of any length
            raise LipsyncError(f"there is no file '{name}' in the project")
        if path.suffix.lower() not in by_suffix():
            known = ", ".join(sorted(by_suffix()))
            raise LipsyncError(f"'{name}' has no known format of lines; known: {known}")
        self.clear()
        self._path, self.name, self.column = path, name, column

    def clear(self) -> None:
        """Remove the script."""
        if self._run is not None:
            self._run.dropped = True
        if self._discard is not None:
            self._discard()
        self.name, self.sent, self.column = "", False, None
        self._path = self._discard = self._run = None

    def update(self, workshop: Workshop) -> None:
        """Start a count unless there is one with the current settings of the language."""
        if self._path is None:
            return
        performer = workshop.performer
        reading = reading_of(workshop, self.column, sent=self.sent)
        try:
            with self._path.open("rb") as stream:
                digest = file_digest(stream, "sha256").hexdigest()
        except OSError as error:
            raise LipsyncError(f"{self.name} cannot be read: {error.strerror}") from None
        compiled = performer.compiled
        sounds = (compiled.manner, compiled.words, compiled.notations, compiled.counted)
        key = digest, reading, sounds, tuple(compiled.report.trigrams), units(performer).tobytes()
        if self._run is not None and self._run.key == key:
            return
        if self._run is not None:
            self._run.dropped = True
        run = self._run = _CountRun(key, replace(performer))
        pack = workshop.library().language(compiled.language)
        own = self._path, reading, scripts_of(pack.model)
        Thread(target=run.work, args=own, daemon=True).start()

    @property
    def progress(self) -> dict[str, Any]:
        """State of the count as JSON data: none, counting, ready or failed."""
        run = self._run
        if run is None:
            return {"state": "none", "lines": 0, "fault": "", "remarks": []}
        state = "failed" if run.fault else "ready" if run.figures is not None else "counting"
        return {"state": state, "lines": run.lines, "fault": run.fault, "remarks": run.remarks[:3]}

    def report(
        self, workshop: Workshop, minutes: float, *, sentences: bool = False
    ) -> CoverageReport | None:
        """Return the needs of the script from the open character; None without a count."""
        figures = None if self._run is None else self._run.figures
        # After a change of language, the old count has other bigrams until `update` starts anew.
        if figures is None or figures.count.size != len(workshop.performer.compiled.phonemes):
            return None
        return report_of(workshop.performer, figures, minutes, "", sentences=sentences)


def script_of(workshop: Workshop) -> ScriptCount:
    """Return the script of a workshop."""
    return _scripts.setdefault(workshop, ScriptCount())


def script_needs(workshop: Workshop) -> dict[str, tuple[int, str]]:
    """Count each bigram in the script, with an example word.

    Empty without a script, and until it is counted.
    """
    report = script_of(workshop).report(workshop, 1.0)
    if report is None:
        return {}
    return {row.bigram: (row.count, row.example) for row in (*report.bigrams, *report.silence)}


def scripts_in(project: Path) -> list[str]:
    """List possible scripts among the files of a project, without its packs."""
    found: list[str] = []
    for number, (here, folders, files) in enumerate(os.walk(project)):
        packs = FOLDERS.values() if Path(here) == project else ()
        folders[:] = sorted(f for f in folders if f[:1] != "." and f not in packs)
        names = (name for name in sorted(files) if name[:1] != ".")
        known = (name for name in names if Path(name).suffix.lower() in by_suffix())
        found += [(Path(here) / name).relative_to(project).as_posix() for name in known]
        if len(found) >= MAX_SCRIPTS or number >= MAX_FOLDERS:
            break
    return found[:MAX_SCRIPTS]
