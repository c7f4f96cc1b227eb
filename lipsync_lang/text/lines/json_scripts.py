"""Scripts in JSON: trees of texts, and files for translation that differ in names of fields alone.

A `JsonScript` states as data where entries are and what their fields are called, in
`script_formats.json` or in a project. An entry is an object that has a text, wherever it stands; in
a tree, each text is one. The keys on the way to it name it, with dots between them, unless a field
does. Objects whose keys are languages lead to the language that is read.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules.records import field_at
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.text.lines.columns import language_column
from lipsync_lang.text.lines.entries import MAX_ENTRY_DEPTH, ScriptEntry, entry_lines, whole_file
from lipsync_lang.text.lines.line_readers import (
    JSON_SUFFIX,
    LINE_READERS,
    SCHEDULE_FORMAT,
    Line,
    LineFile,
    StatedScript,
)

MAX_LOST_KEYS = 8
"""Number of keys that are not found in the text, after which places are no longer looked for."""


@dataclass(frozen=True)
class JsonScript(StatedScript):
    """A format of scripts in JSON."""

    suffixes: Sequence[str] = (JSON_SUFFIX,)
    within: str = ""
    """Field of the objects around an entry that comes before its identifier."""
    languages: str | None = None
    """Name of the objects whose keys are languages; empty for the outermost, None without."""
    native: str = ""
    """Field of the file with the language whose texts are the keys themselves."""
    unnamed: Sequence[str] = ()
    """Keys that are no part of an identifier."""
    skipped: str = ""
    """First character of keys that are no texts."""
    anywhere: bool = False
    """True if a plain `.json` with one entry anywhere is of this format."""

    def fits(self, document: object) -> bool:
        """Return True if all outermost objects are entries, or all values of a tree are texts."""
        if self.anywhere:
            return _holds(document, self.text)
        if not self.text:
            return isinstance(document, dict) and document != {} and _is_tree(document)
        values = _inside(document)
        entries = (isinstance(one, dict) and _text(one, self.text) is not None for one in values)
        return values != [] and all(entries)

    def entries(self, source: LineFile, file: TimingFile) -> Iterator[ScriptEntry]:
        """Yield the entries of a file."""
        document = file.json
        native = document.get(self.native) if self.native and isinstance(document, dict) else None
        reading = _Search(self, source, file, str(native or ""))
        yield from reading.found(document, (), "")

    def read(self, source: LineFile) -> Iterator[Line]:
        """Yield the lines of a file, in the format that its content tells for plain `.json`."""
        file = whole_file(source)
        if source.path.suffix.lower() != JSON_SUFFIX:
            if self.anywhere and not self.fits(file.json):
                raise self.misfit(file)
            return entry_lines(source, self.entries(source, file))
        document = file.document
        fitting = (one for one in JSON_SCRIPTS.values() if JSON_SUFFIX in one.suffixes)
        # Those of a project come first, and trees last, because they fit more than others.
        for one in sorted(fitting, key=lambda one: (not one.anywhere, not one.text)):
            if document is not None and one.fits(document):
                return entry_lines(source, one.entries(source, file))
        own = next((one for one in JSON_SCRIPTS.values() if one.anywhere), None)
        if own is not None and document is not None and JSON_SUFFIX in own.suffixes:
            raise own.misfit(file)
        # Timings are JSON, too; their reader names the fault of any other.
        return iter(LINE_READERS[SCHEDULE_FORMAT].read(source))

    def misfit(self, file: TimingFile) -> ScheduleError:
        """Return an error that a file has no entry."""
        what = f"has no object with a text at `{self.text}`, so it is not {self.name}"
        return file.fault(f"{what}; check the file, and the paths of its format")


JSON_SCRIPTS: dict[str, JsonScript] = {}
"""Formats by name, those of a project included."""


def add_json_script(one: JsonScript, module: str) -> None:
    """Register a format of scripts in JSON."""
    JSON_SCRIPTS[one.name] = one
    LINE_READERS.add(one.name, one.reader(), module)


@dataclass
class _Search:
    """The walk through a file, with the place that it has reached in the text."""

    script: JsonScript
    source: LineFile
    file: TimingFile
    native: str
    at: int = 0
    line: int = 1
    lost: int = 0

    def found(self, value: object, keys: tuple[str, ...], within: str) -> Iterator[ScriptEntry]:
        """Yield the entries at and below a value."""
        if len(keys) > MAX_ENTRY_DEPTH:
            self.number(keys)
            what = f"is nested deeper than {MAX_ENTRY_DEPTH} levels; check what wrote it"
            raise self.source.fault(self.line, what)
        if isinstance(value, dict):
            yield from self.of_object(value, keys, within)
        elif isinstance(value, list):
            for at, inner in enumerate(value):
                yield from self.found(inner, (*keys, str(at)), within)
        elif isinstance(value, str) and not self.script.text:
            yield ScriptEntry(self.number(keys), self.name(keys), value)

    def of_object(self, value: Json, keys: tuple[str, ...], within: str) -> Iterator[ScriptEntry]:
        """Yield the entries at and below an object."""
        script = self.script
        if script.text and _text(value, f"{script.text}|{script.original}") is not None:
            yield self.entry(value, keys, within)
            return
        own = value.get(script.within) if script.within else None
        within = ".".join(filter(None, (within, own if isinstance(own, str) else "")))
        named = script.languages
        if named is not None and (keys[-1:] == (named,) if named else not keys):
            yield from self.of_language(value, keys, within)
            return
        for key, inner in value.items():
            if not script.skipped or not key.startswith(script.skipped):
                yield from self.found(inner, (*keys, key), within)
        if script.native and keys[:-1] == (*script.unnamed[:1],):
            yield from self.of_key(value, keys)

    def of_language(self, value: Json, keys: tuple[str, ...], within: str) -> Iterator[ScriptEntry]:
        """Yield the entries of the language that is read."""
        names = list(value)
        at = language_column(names, self.source.names or [self.native])
        if at >= 0 and isinstance(value[names[at]], dict):
            # The empty key is no part of a name, and yet a level of depth.
            yield from self.found(value[names[at]], (*keys, ""), within)
        elif not keys:  # a tree without languages
            for key, inner in value.items():
                yield from self.found(inner, (key,), within)

    def of_key(self, value: Json, keys: tuple[str, ...]) -> Iterator[ScriptEntry]:
        """Yield the key itself if it is the text in the language that is read."""
        spoken = value.get(self.script.languages or "")
        names = list(spoken) if isinstance(spoken, dict) else []
        asked = self.source.names or [self.native]
        if language_column(names, asked) < 0 and language_column(["", self.native], asked) > 0:
            yield ScriptEntry(self.number(keys), self.name(keys), keys[-1])

    def entry(self, value: Json, keys: tuple[str, ...], within: str) -> ScriptEntry:
        """Return the entry that an object is."""
        script = self.script
        name = _text(value, script.id) or self.name(keys)
        return ScriptEntry(
            self.number((name,) if script.id else keys),
            ",".join(filter(None, (within, name))) if script.within else name,
            _text(value, script.text) or "",
            _text(value, script.original) or "",
            _text(value, script.speaker) or "",
            tuple(filter(None, (_text(value, script.note),))),
            ready=_text(value, script.state) not in script.unready,
        )

    def name(self, keys: tuple[str, ...]) -> str:
        """Return the name of an entry from the keys on its way."""
        return ".".join(key for key in keys if key and key not in self.script.unnamed)

    def number(self, keys: tuple[str, ...]) -> int:
        """Return the line of the last key, which stands behind the entry before."""
        named = (key for key in reversed(keys) if key and not key.isdecimal())
        if self.lost < MAX_LOST_KEYS and (key := next(named, "")):
            # Parsed JSON has no lines. Its keys come in the order of the file.
            found = self.file.text.find(f'"{key}"', self.at)
            self.lost = self.lost + 1 if found < 0 else 0
            if found >= 0:
                self.line += self.file.text.count("\n", self.at, found)
                self.at = found
        return self.line


def _text(value: Json, paths: str) -> str | None:
    """Return the first text at one of the paths."""
    found = (field_at(value, path.strip()) for path in paths.split("|") if path.strip())
    return next((one for one in found if isinstance(one, str)), None)


def _inside(value: object) -> list[object]:
    """Return the values in an object or a list; none in other values."""
    if isinstance(value, dict):
        return [*value.values()]
    return value if isinstance(value, list) else []


def _is_tree(value: object, depth: int = 0) -> bool:
    """Return True if a value holds texts alone."""
    # The walk through the file refuses what is deeper, with its line.
    if depth > MAX_ENTRY_DEPTH or isinstance(value, str) or value is None:
        return True
    holds = isinstance(value, (dict, list))
    return holds and all(_is_tree(one, depth + 1) for one in _inside(value))


def _holds(value: object, paths: str, depth: int = 0) -> bool:
    """Return True if an entry is at or below a value."""
    if isinstance(value, dict) and _text(value, paths) is not None:
        return True
    inner = _inside(value) if depth <= MAX_ENTRY_DEPTH else []
    return any(_holds(one, paths, depth + 1) for one in inner)
