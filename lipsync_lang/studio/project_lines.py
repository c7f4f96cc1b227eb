"""Lines of the project's script, for the list and the open line of the studio.

A list holds the lines of the open language. A line opens on the open character if the script gives
the line to it, and otherwise on the first character of the line. A character that the script gives
no line to stays open: somebody chose it.
"""

from collections.abc import Iterable
from pathlib import Path

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.base.json_object import Json
from lipsync_lang.performing.performer import Performer
from lipsync_lang.production.builds.planned_line import PlannedLine
from lipsync_lang.production.builds.script import read_script
from lipsync_lang.production.builds.timing import schedules
from lipsync_lang.production.builds.timing_formats import open_project
from lipsync_lang.schedules.schedule import Schedule

MAX_LISTED = 100
"""Maximum number of lines in a response."""

MAX_READ_AGAIN = 10_000
"""Maximum number of lines of a script that is read again when a line is opened."""

ByCharacter = dict[str, PlannedLine]
"""A line in one language, on each of its characters."""


class ProjectLines:
    """Lines of the script of a project, read on the first request; None is for no project file.

    `paths` are folders of packs to search first.
    """

    def __init__(self, file: Path | None = None, paths: Iterable[Path] = ()) -> None:
        self._file, self._paths = file, tuple(paths)
        self._lines: dict[str, dict[str, ByCharacter]] = {}
        """Lines by language and name, in the order of the script."""
        self._characters: set[str] = set()

    def read(self) -> None:
        """Read the script again; raise LipsyncError if the project or its script is faulty."""
        self._lines, self._characters = {}, set()
        if self._file is None:
            return
        project = open_project(self._file)
        if not project.model.lines:
            return
        for line in read_script(project, paths=self._paths):
            own = self._lines.setdefault(line.language, {}).setdefault(line.name, {})
            own[line.character] = line
            self._characters.add(line.character)

    def listed(self, language: str, character: str, sought: str = "", first: int = 0) -> Json:
        """Return some lines of a language as JSON data; an empty one is the first language.

        The name, the speaker or the text of a line has the `sought` words; `first` is the number of
        the first line to return, among those found. `character` is the open one.
        """
        language = language or next(iter(self._lines), "")
        words = sought.casefold().split()
        own = self._lines.get(language, {})
        found = []
        for number, by in enumerate(own.values(), 1):
            line = next(iter(by.values()))
            text = f"{line.name} {line.speaker} {line.text}".casefold()
            if all(word in text for word in words):
                found.append((number, by))
        return {
            "language": language,
            "count": len(own),
            "found": len(found),
            "several": len(self._characters) > 1,
            "lines": [self._row(*one, character) for one in found[first : first + MAX_LISTED]],
        }

    def place(self, line: PlannedLine | None, character: str) -> Json | None:
        """Return a line's place in the script, and its neighbours; None for an unknown line."""
        own = {} if line is None else self._lines.get(line.language, {})
        if line is None or line.name not in own:
            return None
        names = list(own)
        number = names.index(line.name) + 1
        beside = [
            self._row(n, own[names[n - 1]], character) if 0 < n <= len(names) else None
            for n in (number - 1, number + 1)
        ]
        return {"name": line.name, "number": number, "count": len(own), "beside": beside}

    def named(self, language: str, character: str) -> list[tuple[str, str]]:
        """Return each line of a language with each of its characters.

        If the script gives no line to the open `character`, it has all lines.
        """
        unused = character not in self._characters
        return [
            (name, one)
            for name, by in self._lines.get(language, {}).items()
            for one in ([character] if unused else by)
        ]

    def has(self, name: str) -> bool:
        """Return True if the script has a line of this name."""
        return any(name in own for own in self._lines.values())

    def line(self, language: str, name: str, character: str) -> PlannedLine:
        """Return a line with its current recording and timings.

        Raises LipsyncError if there is no such line, or the script is faulty.
        """
        # The script may have been saved meanwhile; a large one takes seconds to read.
        if sum(map(len, self._lines.values())) <= MAX_READ_AGAIN:
            self.read()
        own = self._lines.get(language, {})
        if name not in own:
            raise LipsyncError(
                f"the script has no line '{name}' in {language}; {did_you_mean(name, own)}"
            )
        return self._on(own[name], character)

    def schedule(
        self, line: PlannedLine, performer: Performer, engine: str | None = None
    ) -> Schedule:
        """Time the phonemes of a line as in a build; raise LipsyncError if that fails."""
        assert self._file is not None  # noqa: S101 a line is of a project
        (timed,) = schedules(self._file.parent, [line], performer, engine)
        if isinstance(timed, LipsyncError):
            raise LipsyncError(f"{line.place}: {timed}") from None
        if isinstance(timed, Exception):
            raise timed
        return timed

    def _on(self, by: ByCharacter, character: str) -> PlannedLine:
        return by.get(character) or next(iter(by.values()))

    def _row(self, number: int, by: ByCharacter, character: str) -> Json:
        line = self._on(by, character)
        unused = character not in {"", *self._characters}
        return {
            "number": number,
            "name": line.name,
            "language": line.language,
            "character": character if unused else line.character,
            "speaker": line.speaker,
            "text": line.text,
            "recording": line.audio is not None,
            "timings": line.timings is not None,
        }
