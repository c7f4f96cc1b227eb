"""The data and marks of a YAML file, built from the parser's events.

Building is iterative and bounded: no file, however made, takes the program down.
"""

import gc
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

from lipsync_lang.packs.yaml.events import Event, Parser, YamlError, parsers
from lipsync_lang.packs.yaml.faults import Fault, shown
from lipsync_lang.packs.yaml.source import LARGEST, TOP, Data, Position, SourceMark, YamlSource

DEEPEST = 40
"""Levels of nesting; packs use about eight."""

LONGEST_NUMBER = 64
"""Digits; a longer integer is read as a float, which is all a pack could mean by it."""

TAG = "P014"
"""The code of a tag."""

_INT = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_BASED = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
_SPECIAL: Final = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **{
        f"{sign}.{s}": float(f"{sign}inf") for sign in ("", "+", "-") for s in ("inf", "Inf", "INF")
    },
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
_NOT_TEXT = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\ud800-\udfff\ufffe\uffff]")


def build(path: Path, content: bytes) -> YamlSource:
    """Read YAML as far as it goes; see `source.scan`."""
    try:
        return _built(path, _text(path, content))
    except _StopError as stop:
        return YamlSource(path, None, faults=tuple(sorted(stop.faults)))


def _built(path: Path, text: str) -> YamlSource:
    """Build from the events of the first parser that can read the text."""
    try:
        asked = parsers(text)
    except YamlError as error:
        raise _StopError(_syntax(path, text, error)) from None
    stop = _StopError()
    for parse in asked:
        builder = _Builder(path)
        try:
            source = builder.build(text, parse)
            if parse is asked[-1] or all(fault.code != TAG for fault in source.faults):
                return source  # else the parsers may differ on the tag: one faulty, one unknown
        except YamlError as error:
            stop = _StopError(*builder.faults, _syntax(path, text, error))
    raise stop


class _StopError(Exception):
    """Reading cannot go on."""

    def __init__(self, *faults: Fault) -> None:
        self.faults = faults


def _text(path: Path, content: bytes) -> str:
    """Decode a file, or say what and where is not text."""

    def stop(at: int, code: str, what: str, hint: str) -> _StopError:
        before = content[:at].decode("utf-8", "replace")
        line = before.count("\n") + 1
        column = len(before) - (before.rfind("\n") + 1) + 1
        return _StopError(Fault(shown(path), line, column, code, what, hint))

    if len(content) > LARGEST:
        hint = "split it into several packs"
        raise stop(0, "P002", f"the file is larger than {LARGEST >> 20} MB", hint)
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise stop(0, "P003", "the file is UTF-16", "save it as UTF-8")
    if content.startswith(b"\xef\xbb\xbf"):
        what = "the file starts with a byte order mark"
        raise stop(0, "P004", what, "save it as UTF-8 without BOM")
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        what = f"byte 0x{content[error.start]:02x} is not UTF-8"
        raise stop(error.start, "P003", what, "save the file as UTF-8") from None
    bad = _NOT_TEXT.search(text)
    if bad:
        what = f"control character U+{ord(bad.group()):04X}"
        raise stop(len(text[: bad.start()].encode()), "P005", what, "delete it")
    if not text.strip():
        raise stop(
            0, "P006", "the file is empty", "start it with `kind: ...`, `format: 1`, `name: ...`"
        )
    return text


def _scalar(text: str) -> Data:
    """Resolve a plain scalar by the YAML 1.2 core schema."""
    if text in _SPECIAL:
        return _SPECIAL[text]
    if text[0] not in "+-.0123456789":
        return text
    if _INT.fullmatch(text):
        return int(text) if len(text) <= LONGEST_NUMBER else float(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    if _BASED.fullmatch(text):
        number = int(text[2:], 8 if text[1] == "o" else 16)
        return number if len(text) <= LONGEST_NUMBER else float("inf")
    return text


def _syntax(path: Path, text: str, error: YamlError) -> Fault:
    """Put the parser's complaint into a fault."""
    line, column = error.place or TOP
    lines = text.splitlines()
    rest = lines[line - 1][: column + 1] if line <= len(lines) else ""
    if "'\\t'" in error.problem or "\t" in rest[: len(rest) - len(rest.lstrip())]:
        what, hint = "a tab stands where YAML wants spaces", "indent with spaces"
        return Fault(shown(path), line, column, "P007", what, hint)
    problem = error.problem or "not sound YAML"
    if "undefined alias" in problem:
        return Fault(shown(path), line, column, "P012", problem)
    hint = error.context or "check quotes, brackets and indentation here and in the line above"
    if error.context and error.started is not None:
        hint = f"{error.context} that starts in line {error.started}"
    return Fault(shown(path), line, column, "P008", problem, hint)


@dataclass(slots=True)
class _Frame:
    """A mapping or sequence that is being read."""

    data: Data
    inner: Data
    start: Event
    """The parser's mark, as all marks of events."""
    anchor: str | None
    key: str | None = None
    """The key whose value comes next; None while a key is due."""
    key_at: Position = TOP
    dropped: bool = False
    """The value that comes next belongs to a faulty key."""


class _Anchored(NamedTuple):
    """A value that aliases may repeat, and how many characters state it."""

    data: Data
    mark: SourceMark
    chars: int


class _Builder:
    """Builds data and marks from the event stream of one file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.faults: list[Fault] = []
        self.frames: list[_Frame] = []
        self.anchors: dict[str, _Anchored] = {}
        self.chars = 0
        """Characters of the text, and of what its aliases stand for so far."""
        self.last: Event = None
        self.root: tuple[Any, SourceMark] | None = None

    def build(self, text: str, parse: Parser) -> YamlSource:
        """Read the whole text."""
        self.chars = len(text)
        with _no_collection():
            self._read(text, parse)
        if self.root is None:
            raise self._stop(1, 1, "P006", "the file holds nothing but comments", "state the pack")
        data, mark = self.root
        return YamlSource(self.path, data, mark, tuple(sorted(self.faults)))

    def _read(self, text: str, parse: Parser) -> None:
        """Take every event; what the parser cannot read is raised with its place."""
        act = {
            "ScalarEvent": self._on_scalar,
            "SequenceStartEvent": lambda event: self._on_start(event, [], []),
            "MappingStartEvent": lambda event: self._on_start(event, {}, {}),
            "SequenceEndEvent": self._on_end,
            "MappingEndEvent": self._on_end,
            "AliasEvent": self._on_alias,
            "DocumentStartEvent": self._on_document,
        }
        try:
            for event in parse(text):
                self.last = event.start_mark
                handler = act.get(event.__class__.__name__)
                if handler is not None:
                    handler(event)
        except YamlError as error:
            error.place = error.place or (self.last.line + 1, self.last.column + 1)
            raise

    def _stop(self, line: int, column: int, code: str, what: str, hint: str = "") -> _StopError:
        return _StopError(*self.faults, Fault(shown(self.path), line, column, code, what, hint))

    def _note(self, line: int, column: int, code: str, what: str, hint: str = "") -> None:
        self.faults.append(Fault(shown(self.path), line, column, code, what, hint))

    def _on_document(self, event: Event) -> None:
        line, column = event.start_mark.line + 1, event.start_mark.column + 1
        if self.root is not None:
            hint = "delete the line `---`, or move what follows to a file of its own"
            raise self._stop(line, column, "P009", "a second document starts here", hint)
        if event.version is not None and tuple(event.version) != (1, 2):
            version = ".".join(map(str, event.version))
            hint = "delete the line `%YAML`"
            self._note(line, column, "P017", f"YAML {version} is asked for; packs are 1.2", hint)

    def _on_scalar(self, event: Event) -> None:
        mark = event.start_mark
        line, column = mark.line + 1, mark.column + 1
        text: str = event.value
        plain = not event.style
        if event.tag is not None:
            self._tagged(line, column, event.tag)
        if event.style == '"' and _NOT_TEXT.search(text):
            bad = f"U+{ord(_NOT_TEXT.search(text).group()):04X}"  # type: ignore[union-attr]
            self._note(line, column, "P005", f"control character {bad} in quotes", "delete it")
            text = _NOT_TEXT.sub("?", text)
        frame = self.frames[-1] if self.frames else None
        if frame is not None and frame.key is None and frame.data.__class__ is dict:
            self._key(frame, text, line, column, plain=plain)
            value: Data = text
        else:
            value = _scalar(text) if plain else text
            self._add(value, SourceMark(line, column))
        if event.anchor:
            chars = event.end_mark.index - mark.index
            self.anchors[event.anchor] = _Anchored(value, SourceMark(line, column), chars)

    def _key(self, frame: _Frame, text: str, line: int, column: int, *, plain: bool) -> None:
        """Take the text as the key of the value that comes next."""
        frame.key, frame.key_at = text, Position(line, column)
        if text == "<<" and plain:
            frame.dropped = True
            hint = "write the fields out; an alias (`*name`) may stand for a whole value"
            self._note(line, column, "P013", "merge keys (`<<`) are not supported", hint)
        elif text in frame.inner:
            frame.dropped = True
            first = frame.inner[text][0].line
            hint = f"it stands first in line {first}; keep one of the two"
            self._note(line, column, "P015", f"'{text}' is stated twice", hint)

    def _on_start(self, event: Event, data: Data, inner: Data) -> None:
        mark = event.start_mark
        line, column = mark.line + 1, mark.column + 1
        if event.tag is not None:
            self._tagged(line, column, event.tag)
        self._not_a_key(line, column)
        if len(self.frames) >= DEEPEST:
            hint = "packs nest about eight levels deep; is a bracket left open?"
            raise self._stop(line, column, "P010", f"nests deeper than {DEEPEST} levels", hint)
        self.frames.append(_Frame(data, inner, mark, event.anchor))

    def _on_end(self, event: Event) -> None:
        frame = self.frames.pop()
        data = tuple(frame.data) if frame.data.__class__ is list else frame.data
        mark = SourceMark(frame.start.line + 1, frame.start.column + 1, frame.inner)
        if frame.anchor:
            chars = event.end_mark.index - frame.start.index
            self.anchors[frame.anchor] = _Anchored(data, mark, chars)
        self._add(data, mark)

    def _on_alias(self, event: Event) -> None:
        """Repeat an anchored value.

        Anchored values hold no aliases, so that text which aliases stand for is as long as it
        looks; all of it together may not be longer than a file. So an alias cannot multiply.
        """
        mark = event.start_mark
        line, column = mark.line + 1, mark.column + 1
        around = next((frame.anchor for frame in self.frames if frame.anchor), None)
        if around is not None:
            what = f"alias '*{event.anchor}' lies within the value anchored by '&{around}'"
            raise self._stop(line, column, "P012", what, "write the value out")
        found = self.anchors.get(event.anchor)
        if found is None:
            what, hint = f"alias '*{event.anchor}' has no anchor", f"write '&{event.anchor}' before"
            raise self._stop(line, column, "P012", what, f"{hint} it")
        if not self._not_a_key(line, column):
            frame = self.frames[-1]
            frame.key, frame.dropped = "", True
            return
        self.chars += found.chars
        if self.chars > LARGEST:
            what = f"the file is larger than {LARGEST >> 20} MB once its aliases are written out"
            raise self._stop(line, column, "P011", what, "split it into several packs")
        self._add(found.data, found.mark)

    def _tagged(self, line: int, column: int, tag: str) -> None:
        what = f"tags such as '{tag}' are not supported"
        self._note(line, column, TAG, what, "delete it; quotes make text of anything")

    def _not_a_key(self, line: int, column: int) -> bool:
        """Say whether a value is due; a list, mapping or alias in a key's place is a fault."""
        frame = self.frames[-1] if self.frames else None
        if frame is None or frame.data.__class__ is list or frame.key is not None:
            return True
        what, hint = "a key must be plain text", "is a colon missing, or one too many?"
        self._note(line, column, "P016", what, hint)
        return False

    def _add(self, data: Data, mark: SourceMark) -> None:
        """Put a finished value where it belongs."""
        if not self.frames:
            self.root = data, mark
            return
        frame = self.frames[-1]
        if frame.data.__class__ is list:
            frame.data.append(data)
            frame.inner.append(mark)
        elif frame.key is None:  # a collection in a key's place: its value is dropped too
            frame.key, frame.dropped = "", True
        else:
            if not frame.dropped:
                frame.data[frame.key] = data
                frame.inner[frame.key] = (frame.key_at, mark)
            frame.key, frame.dropped = None, False


@contextmanager
def _no_collection() -> Iterator[None]:
    """Keep the collector from walking the growing data again and again."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()
