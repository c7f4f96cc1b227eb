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

from lipsync_lang.packs.faults import Fault, shown
from lipsync_lang.packs.source import LARGEST, TOP, Data, Mark, Position, Source

DEEPEST = 40
"""Levels of nesting; packs use about eight."""

MOST_NODES = 2_000_000
"""Values of a file, each alias counted as if it were written out."""

LONGEST_NUMBER = 64
"""Digits; a longer integer is read as a float, which is all a pack could mean by it."""

Event = Any
"""An event of the YAML parser, which is untyped."""

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


def build(path: Path, content: bytes) -> Source:
    """Read YAML as far as it goes; see `source.scan`."""
    try:
        return _Builder(path).build(_text(path, content))
    except _StopError as stop:
        return Source(path, None, faults=tuple(sorted(stop.faults)))


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


@dataclass(slots=True)
class _Frame:
    """A mapping or sequence that is being read."""

    data: Data
    inner: Data
    line: int
    column: int
    anchor: str | None
    before: int
    """Values counted when it began."""
    height: int = 1
    key: str | None = None
    """The key whose value comes next; None while a key is due."""
    key_at: Position = TOP
    dropped: bool = False
    """The value that comes next belongs to a faulty key."""


class _Anchored(NamedTuple):
    """A value that aliases may repeat."""

    data: Data
    mark: Mark
    size: int
    height: int


class _Builder:
    """Builds data and marks from the event stream of one file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.faults: list[Fault] = []
        self.frames: list[_Frame] = []
        self.anchors: dict[str, _Anchored | None] = {}
        self.count = 0
        self.root: tuple[Any, Mark] | None = None

    def build(self, text: str) -> Source:
        """Read the whole text."""
        with _no_collection():
            self._read(text)
        if self.root is None:
            raise self._stop(1, 1, "P006", "the file holds nothing but comments", "state the pack")
        data, mark = self.root
        return Source(self.path, data, mark, tuple(sorted(self.faults)))

    def _read(self, text: str) -> None:
        from ruamel.yaml.events import (
            AliasEvent,
            DocumentStartEvent,
            MappingEndEvent,
            MappingStartEvent,
            ScalarEvent,
            SequenceEndEvent,
            SequenceStartEvent,
        )

        act = {
            ScalarEvent: self._on_scalar,
            SequenceStartEvent: lambda event: self._on_start(event, [], []),
            MappingStartEvent: lambda event: self._on_start(event, {}, {}),
            SequenceEndEvent: self._on_end,
            MappingEndEvent: self._on_end,
            AliasEvent: self._on_alias,
            DocumentStartEvent: self._on_document,
        }
        for event in self._events(text):
            handler = act.get(event.__class__)
            if handler is not None:
                handler(event)

    def _events(self, text: str) -> Iterator[Event]:
        """Yield the parser's events; what it cannot read becomes a located fault."""
        from ruamel.yaml import YAML
        from ruamel.yaml.error import MarkedYAMLError

        line, column = 1, 1
        try:
            for event in YAML(typ="safe", pure=True).parse(text):
                line, column = event.start_mark.line + 1, event.start_mark.column + 1
                yield event
        except MarkedYAMLError as error:
            mark = error.problem_mark or error.context_mark
            if mark is not None:
                line, column = mark.line + 1, mark.column + 1
            raise _StopError(*self.faults, self._syntax(error, text, line, column)) from None
        except (_StopError, GeneratorExit):
            raise
        except Exception as error:  # noqa: BLE001 the parser has errors of its own: they are the file's
            what = f"not sound YAML from here on ({type(error).__name__})"
            raise self._stop(line, column, "P008", what, "write it more plainly") from None

    def _syntax(self, error: Event, text: str, line: int, column: int) -> Fault:
        """Put the parser's complaint into a fault."""
        lines = text.splitlines()
        rest = lines[line - 1][: column + 1] if line <= len(lines) else ""
        if "'\\t'" in (error.problem or "") or "\t" in rest[: len(rest) - len(rest.lstrip())]:
            what, hint = "a tab stands where YAML wants spaces", "indent with spaces"
            return Fault(shown(self.path), line, column, "P007", what, hint)
        problem = " ".join((error.problem or "not sound YAML").split())
        if "undefined alias" in problem:
            return Fault(shown(self.path), line, column, "P012", problem)
        context, mark = " ".join((error.context or "").split()), error.context_mark
        hint = f"{context} that starts in line {mark.line + 1}" if context and mark else context
        hint = hint or "check quotes, brackets and indentation here and in the line above"
        return Fault(shown(self.path), line, column, "P008", problem, hint)

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
        plain = event.style is None
        if event.ctag is not None:
            self._tagged(line, column, event.tag)
        if event.style == '"' and _NOT_TEXT.search(text):
            bad = f"U+{ord(_NOT_TEXT.search(text).group()):04X}"  # type: ignore[union-attr]
            self._note(line, column, "P005", f"control character {bad} in quotes", "delete it")
            text = _NOT_TEXT.sub("?", text)
        frame = self.frames[-1] if self.frames else None
        if frame is not None and frame.key is None and frame.data.__class__ is dict:
            if event.anchor:
                self._anchor(event.anchor, _Anchored(text, Mark(line, column), 1, 0))
            self._key(frame, text, line, column, plain=plain)
            return
        self._count(line, column)
        value = _scalar(text) if plain else text
        if event.anchor:
            self._anchor(event.anchor, _Anchored(value, Mark(line, column), 1, 0))
        self._add(value, Mark(line, column))

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
        if event.ctag is not None:
            self._tagged(line, column, event.tag)
        self._not_a_key(line, column)
        if len(self.frames) >= DEEPEST:
            hint = "packs nest about eight levels deep; is a bracket left open?"
            raise self._stop(line, column, "P010", f"nests deeper than {DEEPEST} levels", hint)
        self._count(line, column)
        if event.anchor:
            self.anchors[event.anchor] = None
        frame = _Frame(data, inner, line, column, event.anchor, self.count - 1)
        self.frames.append(frame)

    def _on_end(self, _event: Event) -> None:
        frame = self.frames.pop()
        data = tuple(frame.data) if frame.data.__class__ is list else frame.data
        mark = Mark(frame.line, frame.column, frame.inner)
        if frame.anchor:
            size = self.count - frame.before
            self._anchor(frame.anchor, _Anchored(data, mark, size, frame.height))
        if self.frames:
            self.frames[-1].height = max(self.frames[-1].height, frame.height + 1)
        self._add(data, mark)

    def _on_alias(self, event: Event) -> None:
        mark = event.start_mark
        line, column = mark.line + 1, mark.column + 1
        found = self.anchors.get(event.anchor)
        if event.anchor not in self.anchors:
            what, hint = (
                f"alias '*{event.anchor}' has no anchor",
                f"write '&{event.anchor}' before it",
            )
            raise self._stop(line, column, "P012", what, hint)
        if found is None:
            what = f"alias '*{event.anchor}' lies within its own anchor"
            raise self._stop(line, column, "P012", what, "write the value out")
        if not self._not_a_key(line, column):
            frame = self.frames[-1]
            frame.key, frame.dropped = "", True
            return
        if len(self.frames) + found.height > DEEPEST:
            what = f"nests deeper than {DEEPEST} levels once '*{event.anchor}' is written out"
            raise self._stop(line, column, "P010", what, "write it more plainly")
        self._count(line, column, found.size)
        if self.frames:
            self.frames[-1].height = max(self.frames[-1].height, found.height + 1)
        self._add(found.data, found.mark)

    def _anchor(self, name: str, value: _Anchored) -> None:
        self.anchors[name] = value

    def _tagged(self, line: int, column: int, tag: str) -> None:
        what = f"tags such as '{tag}' are not supported"
        self._note(line, column, "P014", what, "delete it; quotes make text of anything")

    def _not_a_key(self, line: int, column: int) -> bool:
        """Say whether a value is due; a list, mapping or alias in a key's place is a fault."""
        frame = self.frames[-1] if self.frames else None
        if frame is None or frame.data.__class__ is list or frame.key is not None:
            return True
        what, hint = "a key must be plain text", "is a colon missing, or one too many?"
        self._note(line, column, "P016", what, hint)
        return False

    def _count(self, line: int, column: int, size: int = 1) -> None:
        self.count += size
        if self.count > MOST_NODES:
            what = f"more than {MOST_NODES} values, once aliases are written out"
            raise self._stop(line, column, "P011", what, "split it into several packs")

    def _add(self, data: Data, mark: Mark) -> None:
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
