"""Planned lines of the rows of a script, with checks of ids, files, and counts of gaps."""

import os
import posixpath
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from lipsync_lang.base.errors import shortlist
from lipsync_lang.base.files.names import fault_of_name, folded_name
from lipsync_lang.packs.models import Project
from lipsync_lang.packs.project import FILE
from lipsync_lang.production.builds.casting import Cast
from lipsync_lang.production.builds.output_paths import OutputPattern, filled, for_line
from lipsync_lang.production.builds.planned_line import PlannedLine
from lipsync_lang.production.builds.recordings import Recordings
from lipsync_lang.production.builds.script_files import (
    PlanRemark,
    ScriptFile,
    ScriptLanguage,
    ScriptRow,
)

SHOWN_EXAMPLES = 3
"""Maximum number of examples in a remark."""

ALL = -1
"""Index that stands for all languages."""

LACKING = {
    "text": "without text, left out",
    "recording": "without a recording, so a voice speaks",
    "timings": "without the stated timings",
}
"""Kinds of gaps, and their words after the number of lines."""


class Examples:
    """Count of a thing, with the first few of it."""

    def __init__(self) -> None:
        self.count = 0
        self.first: list[str] = []

    def add(self, one: str) -> None:
        """Count one more."""
        self.count += 1
        if len(self.first) < SHOWN_EXAMPLES:
            self.first.append(one)

    def __str__(self) -> str:
        """List the first few."""
        return ", ".join(self.first) + (", ..." if self.count > len(self.first) else "")


class ScriptPlanner:
    """Makes planned lines of rows; the faults of the cast are those of the rows too."""

    def __init__(
        self,
        project: Project,
        folder: Path,
        *,
        languages: dict[int, ScriptLanguage],
        cast: Cast,
        outputs: Sequence[OutputPattern],
    ) -> None:
        self._languages, self._cast, self._faults = languages, cast, cast.faults
        self._folder, self._recordings = folder, Recordings(folder)
        words = {index: language.word for index, language in languages.items()}
        self._outputs = {
            (index, character): [(o.writer, filled(o.path, word, character)) for o in outputs]
            for index, word in words.items()
            for character in cast.characters
        }
        self._project, self._heard = project, 0
        stated = project.audio, project.timings
        self._audio, self._timings = (
            {index: posixpath.normpath(filled(pattern, word)) for index, word in words.items()}
            if pattern
            else {}
            for pattern in stated
        )
        self._speakers_name_files = any(
            "{speaker}" in path for path in (*stated, *(o.path for o in outputs)) if path
        )
        self._met: dict[int, dict[str, str]] = defaultdict(dict)
        """Places of folded ids by language, or for all languages by `ALL`."""
        self._spelled: dict[str, str] = {}
        """Ids that differ from their folded form."""
        self._speakers: dict[str, str] = {}
        """Faults of speakers as names of files; empty for sound ones."""
        self._lacking: dict[str, dict[int, Examples]] = defaultdict(lambda: defaultdict(Examples))

    def lines(self, file: ScriptFile, row: ScriptRow) -> Iterator[PlannedLine]:
        """Yield the lines of a row; none for one with a fault."""
        place = f"{file.shown}:{row.number}"
        if not self._sound_names(file, row, place):
            return
        characters = self._cast.of(row.speaker, place)
        for index, text in row.texts:
            audio, timings = self._files(index, row, text)
            if not (text or audio or timings):
                self._lacking["text"][index].add(place)
                continue
            for character in characters:
                outputs = tuple(
                    [
                        (writer, for_line(pattern, row.name, row.speaker))
                        for writer, pattern in self._outputs[index, character]
                    ]
                )
                yield PlannedLine(
                    name=row.name,
                    language=self._languages[index].name,
                    character=character,
                    text=text,
                    speaker=row.speaker,
                    place=place,
                    timings=timings,
                    audio=audio,
                    outputs=outputs,
                )

    def _sound_names(self, file: ScriptFile, row: ScriptRow, place: str) -> bool:
        """Check that the id is sound and new, and the speaker if it names files."""
        if wrong := fault_of_name(row.name):
            self._faults.add(place, f"the id '{row.name}' {wrong}")
            return False
        if self._speakers_name_files and row.speaker:
            if row.speaker not in self._speakers:
                self._speakers[row.speaker] = wrong = fault_of_name(row.speaker)
                if wrong:
                    what = f"the speaker '{row.speaker}' {wrong}, or leave out {{speaker}}"
                    self._faults.add(place, what)
            if self._speakers[row.speaker]:
                return False
        name, key = row.name, folded_name(row.name)
        whole = len(file.languages) == len(self._languages)
        group = ALL if whole else next(iter(file.languages))
        for other, met in self._met.items():
            if key in met and (whole or other in (ALL, group)):
                spelled = self._spelled.get(key, key)
                if spelled == name:
                    what = f"the id '{name}' is used at {met[key]} already; each line needs its own"
                else:
                    what = (
                        f"the id '{name}' differs from '{spelled}' of {met[key]} only in the form "
                        "of its letters, so macOS and Windows use one file for both; rename one"
                    )
                self._faults.add(place, what)
                return False
        self._met[group][key] = place
        if key != name:
            self._spelled[key] = name
        return True

    def _files(self, index: int, row: ScriptRow, text: str) -> tuple[Path | None, Path | None]:
        """Return the recording and the timings of a line, if they exist."""
        audio, timings = None, row.timings
        if index in self._timings:
            path = for_line(self._timings[index], row.name, row.speaker)
            timings = timings or self._recordings.find(path)
            if timings is None and text:
                self._lacking["timings"][index].add(path)
        if index in self._audio:
            path = for_line(self._audio[index], row.name, row.speaker)
            audio = self._recordings.find(path)
            self._heard += audio is not None
            if timings is None and index not in self._timings:
                timings = self._recordings.timings_beside(
                    path, lambda: self._own_outputs(index, row)
                )
            if audio is None and timings is None and text:
                self._lacking["recording"][index].add(path)
        elif self._project.recordings == "required" and timings is None:
            self._lacking["recording"][index].add(row.name)
        return audio, timings

    def _own_outputs(self, index: int, row: ScriptRow) -> tuple[str, ...]:
        """Return the paths of a line's outputs, which are not timings of it."""
        return tuple(
            for_line(pattern, row.name, row.speaker)
            for character in self._cast.characters
            for _, pattern in self._outputs[index, character]
        )

    # After all rows

    def check_recordings(self) -> None:
        """Refuse lines without a recording if the project requires them; warn if none has one."""
        lacking = self._lacking["recording"]
        if self._project.recordings == "required":
            for index in lacking:
                what = self._told("recording", index, "without a recording or timings")
                self._faults.state(
                    ("recordings",), "P407", what, "record them, or correct the path"
                )
        elif self._audio and lacking and not self._heard and self._has_recordings():
            lines = sum(found.count for found in lacking.values())
            what = f"no file matches '{self._project.audio}', so voices speak {lines:,} lines"
            hint = "correct the path, or remove it; `recordings: required` makes this a fault"
            self._faults.state(("audio",), "W315", what, hint)
            lacking.clear()

    def _has_recordings(self) -> bool:
        """Return True if the project has files like its recordings, apart from its outputs."""
        suffix = os.path.splitext(self._project.audio or "")[1].lower()  # noqa: PTH122 text
        made = {path.partition("/")[0] for own in self._outputs.values() for _, path in own}
        for _, below, names in os.walk(self._folder):
            below[:] = [name for name in below if not name.startswith(".") and name not in made]
            if any(name.lower().endswith(suffix) for name in names):
                return True
        return False

    def _told(self, what: str, index: int, told: str) -> str:
        """Return the number of a language's lines that lack something, with examples."""
        found = self._lacking[what][index]
        lines = f"{found.count:,} line{'s' * (found.count > 1)}"
        return f"{self._languages[index].word}: {lines} {told}: {found}"

    def check_clashes(self, planned: Sequence[PlannedLine], scripts: Iterable[Path]) -> None:
        """Refuse lines that write to one file, or to a file that is read.

        Only digests are kept of all paths: a million lines have a million of them.
        """
        met: set[int] = set()
        again: set[int] = set()
        for line in planned:
            for _, path in line.outputs:
                digest = hash(folded_name(path))
                (again if digest in met else met).add(digest)
        read = {folded_name(path) for path in self._recordings.used()}
        read |= {folded_name(os.path.relpath(path, self._folder)) for path in scripts}
        again |= met & {hash(path) for path in read}
        first: dict[str, str] = {}
        for line in planned if again else ():
            for _, path in line.outputs:
                key = folded_name(path)
                if key in read:
                    self._faults.add(line.place, f"the output {path} is an input file")
                elif hash(key) in again and key in first:
                    what = f"the output {path} is also one of {first[key]}"
                    self._faults.add(line.place, f"{what}; put a '/' between its placeholders")
                first.setdefault(key, line.place)

    def tell(self, remark: PlanRemark) -> None:
        """Remark on the number of lines that are left out or lack a recording."""
        for what, told in LACKING.items():
            for index in self._lacking[what]:
                remark(self._told(what, index, told))
        unmet = self._cast.unmet()
        if unmet:
            remark(f"{FILE}: cast: no line is spoken by {shortlist(unmet, SHOWN_EXAMPLES)}")
        unused = Examples()
        for suffix in {os.path.splitext(pattern)[1] for pattern in self._audio.values()}:  # noqa: PTH122
            for path in self._recordings.unused(suffix):
                unused.add(path)
        if unused.count:
            files = f"{unused.count:,} recording{'s' * (unused.count > 1)}"
            remark(f"{files} without a line: {unused}")
