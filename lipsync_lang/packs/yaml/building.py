"""Build the data and marks of a YAML file from the parser's events.

The builder keeps its own stack instead of recursing, and limits size, nesting and aliases. So no
file can exhaust the stack or the memory. Lines and columns count from 1; the parser's own marks
count from 0.
"""

import gc
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

from lipsync_lang.packs.yaml.events import Event, YamlError, events
from lipsync_lang.packs.yaml.faults import Fault, PackFaults
from lipsync_lang.packs.yaml.pack_files import MAX_PACK_BYTES, read_bytes, shown
from lipsync_lang.packs.yaml.source import FILE_START, Data, Position, SourceMark, YamlSource

MAX_NESTING_LEVELS = 40
"""Levels of nesting; packs use about eight."""

TOO_DEEP = f"nests deeper than {MAX_NESTING_LEVELS} levels"
CLOSE_BRACKET = "check for an open bracket; packs nest about eight levels deep"

OTHER_YAML = "the file asks for another version of YAML; packs are YAML 1.2"
DELETE_VERSION = "delete the line `%YAML`"

MAX_INTEGER_DIGITS = 64
"""Digits of an integer; a longer one becomes a float, as `int` refuses thousands of digits."""

_INT = re.compile(r"[-+]?[0-9]+")
_FLOAT_FORM = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
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
_NOT_TEXT = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]")
"""Control characters, among them the line breaks that only YAML 1.1 knows."""


def read_yaml(path: Path, content: bytes | None = None) -> YamlSource:
    """Read a YAML file, or `content` in its place; raise `PackFaults` if it is not sound YAML."""
    source = scan(path, read_bytes(path) if content is None else content)
    if source.faults:
        raise PackFaults(source.faults)
    return source


def scan(path: Path, content: bytes) -> YamlSource:
    """Read YAML as far as possible, and collect mistakes in ``YamlSource.faults``.

    `YamlSource.data` is None after a fault that stops the reader.
    """
    try:
        text = _text(path, content)
        builder = _Builder(path)
        try:
            return builder.build(text)
        except YamlError as error:
            faults = (*builder.faults, _syntax(path, text, error))
    except _StopError as stop:
        faults = stop.faults
    return YamlSource(path, None, faults=tuple(sorted(faults)))


class _StopError(Exception):
    """Stops reading; carries the faults found so far."""

    def __init__(self, *faults: Fault) -> None:
        self.faults = faults


def _text(path: Path, content: bytes) -> str:
    """Decode a file; raise `_StopError` at the first byte or character that is not text."""

    def stop(at: int, code: str, what: str, hint: str) -> _StopError:
        # Columns count characters, not bytes.
        before = content[:at].decode("utf-8", "replace")
        line = before.count("\n") + 1
        column = len(before) - (before.rfind("\n") + 1) + 1
        return _StopError(Fault(shown(path), line, column, code, what, hint))

    if len(content) > MAX_PACK_BYTES:
        hint = "split it into several packs"
        raise stop(0, "P002", f"the file is larger than {MAX_PACK_BYTES >> 20} MB", hint)
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
    if bad := _NOT_TEXT.search(text):
        what = f"control character U+{ord(bad.group()):04X}"
        raise stop(len(text[: bad.start()].encode()), "P005", what, "delete it")
    if not text.strip():
        hint = "start it with `kind: ...`, `format: 1`, `name: ...`"
        raise stop(0, "P006", "the file is empty", hint)
    return text


def _scalar(text: str) -> Data:
    """Resolve a plain scalar by the YAML 1.2 core schema."""
    if text in _SPECIAL:
        return _SPECIAL[text]
    # most scalars are words, and need no look by the expressions below
    if text[0] not in "+-.0123456789":
        return text
    if _INT.fullmatch(text):
        return int(text) if len(text) <= MAX_INTEGER_DIGITS else float(text)
    if _FLOAT_FORM.fullmatch(text):
        return float(text)
    if _BASED.fullmatch(text):
        number = int(text[2:], 8 if text[1] == "o" else 16)
        return number if len(text) <= MAX_INTEGER_DIGITS else float("inf")
    return text


# A parser tells where it gave up, which may be many lines below the mistake. `cause` finds where it
# began, and says it in plain words.
_WHOLE_QUOTES = re.compile(r"\"(?:\\.|[^\"\\])*\"|'(?:[^']|'')*'|(?<!\S)#.*")
_OPEN_QUOTE = re.compile(r"(?:^|[\s:,\[{-])([\"'])")
_KEY_LINE = re.compile(r"\s*(?:- )?[^\s#\"'\[{][^:#]*:(?:\s|$)")
_SIGN_KEY = re.compile(r"(\s*)([{\[\]},!][^\w\s:,\"']{0,2}|[\"']):(?:\s|$)")
"""A label of X-SAMPA as a key, such as ``{`` and ``!``, that begins with a sign of YAML."""

_CURLY = re.compile("[“”„‘’‚]")
_ODD_SPACE = re.compile("(?:^ *|:)([\u00a0\u1680\u2000-\u200b\u202f\u205f\u3000\ufeff])")
_COLON = re.compile(r":(?=\s|$)")
_WIDE_KEY = re.compile(r"(?:^|[{,-])\s*([^\s:{}\[\],#]+)：(?=\s|$)")
NO_COLON = "a full-width colon is no colon in YAML"
_CLOSING_BRACKETS = {"[": "]", "{": "}"}

_BAD_START = re.compile(
    "cannot start any token|comment or line break|alphabetic or numeric|indentation indic|directive"
)
"""Words of libyaml, and of ruamel.yaml without it, about text that begins with a sign of YAML."""

_BAD_ESCAPE = re.compile("escape c|hexadecimal|hexdecimal")


class Cause(NamedTuple):
    """The place of a mistake from 1, the mistake, and its cure."""

    line: int
    column: int
    what: str
    hint: str


def cause(  # noqa: PLR0911 one return for each cause
    text: str, error: YamlError, place: tuple[int, int]
) -> Cause | None:
    """Return the likely cause of a parser's error; None if the parser's words must do."""
    lines = [_WHOLE_QUOTES.sub(lambda found: "_" * len(found[0]), one) for one in text.splitlines()]
    line, column = place
    first = min(error.started or line, line)
    shown = lines[line - 1]
    if found := _sign_key(lines, (line, first)) or _open_quote(lines, line):
        return found
    if found := _odd_sign(lines, dict.fromkeys((line, first, *range(max(line - 3, 1), line)))):
        return found
    if _BAD_ESCAPE.search(error.problem):
        hint = "write `\\\\` for a backslash, `/` in paths, or use single quotes"
        return Cause(line, column, "a backslash in double quotes begins an escape", hint)
    signs = [at for at, sign in enumerate(shown[:column], 1) if sign in "@`%*&|>"]
    if signs and _BAD_START.search(error.problem):
        what = f"text may not begin with '{shown[signs[-1] - 1]}'"
        return Cause(line, signs[-1], what, "put the text into quotes")
    if "could not find expected ':'" in error.problem:
        return _colon(lines, first)
    if "expected ',' or" in error.problem:
        return _bracket(lines, first, line, column)
    if "flow node" in error.context:  # nothing follows a bracket, or a comma within it
        return _bracket(lines, 1, line, column)
    return _block(lines, line, column)


def _sign_key(lines: list[str], numbers: Iterable[int]) -> Cause | None:
    """Find a key that begins with a sign of YAML, in some lines."""
    for number in numbers:
        if found := _SIGN_KEY.match(lines[number - 1]):
            label = found[2]
            quoted = f'"{label}"' if "'" in label else f"'{label}'"
            sign = f"'{label[0]}'" if label[0] != "'" else '"\'"'
            what = f"a key may not begin with {sign}, a sign of YAML"
            return Cause(number, found.end(1) + 1, what, f"write it in quotes: `{quoted}: ...`")
    return None


def _odd_sign(lines: list[str], numbers: Iterable[int]) -> Cause | None:
    """Find curly quotes, or a space that is none in YAML, in some lines."""
    for number in numbers:
        if curly := _CURLY.search(lines[number - 1]):
            what = f"curly quotes ({curly[0]}) are no quotes in YAML"
            return Cause(number, curly.start() + 1, what, 'write straight quotes (") instead')
        if space := _ODD_SPACE.search(lines[number - 1]):
            what = f"the character U+{ord(space[1]):04X} is no space in YAML"
            return Cause(number, space.start(1) + 1, what, "write an ordinary space instead")
        if wide := _WIDE_KEY.search(lines[number - 1]):
            return Cause(number, wide.end(), NO_COLON, f"write `{wide[1]}: `")
    return None


def _open_quote(lines: list[str], last: int) -> Cause | None:
    """Find a quote without an end in its line, before lines that look like keys."""
    for number, line in enumerate(lines[:last], 1):
        found = _OPEN_QUOTE.search(line)
        if found and (number == len(lines) or any(map(_KEY_LINE.match, lines[number:last]))):
            what = f"the text that begins with a quote ({found[1]}) here has no closing quote"
            return Cause(number, found.start(1) + 1, what, f"write {found[1]} at its end")
    return None


def _colon(lines: list[str], number: int) -> Cause:
    """Explain a line that lacks a colon, or the space after it."""
    line = lines[number - 1]
    key = line.strip()
    column = len(line) - len(line.lstrip()) + 1
    if tight := re.match(r"\s*(?:- )?[^\s:]+:(?=\S)", line):
        what = "a space is missing after the colon"
        return Cause(number, tight.end(), what, f"write `{line[: tight.end()].strip()} ...`")
    if "：" in key:
        mended = key.replace("：", ": ", 1)
        return Cause(number, line.index("：") + 1, NO_COLON, f"write `{mended}`")
    first, _, rest = key.partition(" ")
    mended = f"{first}: {rest}".rstrip()
    return Cause(number, column, f"'{first}' has no colon after it", f"write `{mended}`")


def _bracket(lines: list[str], first: int, line: int, column: int) -> Cause:
    """Explain a bracket that is not closed, or is closed by another."""
    opened: list[tuple[int, int, str]] = []
    for number, text in enumerate(lines[first - 1 : line], first):
        for at, sign in enumerate(text, 1):
            if (number, at) >= (line, column):
                break
            if sign in _CLOSING_BRACKETS:
                opened.append((number, at, sign))
            elif sign in _CLOSING_BRACKETS.values() and opened:
                opened.pop()
    number, at, sign = opened[-1] if opened else (first, 1, "[")
    closing = _CLOSING_BRACKETS[sign]
    if lines[line - 1][column - 1 : column] in set("]}") - {closing}:
        what = f"'{sign}' is closed by '{lines[line - 1][column - 1]}'"
        return Cause(line, column, what, f"write '{closing}' here")
    what = f"the bracket '{sign}' that opens here is not closed"
    return Cause(number, at, what, f"write '{closing}' at its end")


def _block(  # noqa: PLR0911 one return for each cause
    lines: list[str], line: int, column: int
) -> Cause | None:
    """Explain a line that does not fit those above: a colon, a bracket, a dash or a margin."""
    shown = lines[line - 1]
    stripped, margin = shown.strip(), len(shown) - len(shown.lstrip())
    above = next((n for n in range(line - 1, 0, -1) if lines[n - 1].strip()), 0)
    sign = shown[column - 1 : column]
    if sign and sign in "]}":
        return Cause(line, column, f"there is no open bracket for '{sign}'", "delete it")
    if re.match(r"-[^\s-]", stripped):
        return Cause(line, margin + 1, "a space is missing after the dash", "write `- ` before it")
    if re.search(r"(?:^|: )[\[{][^\]}]*[\]}]\s*[^\s,\]}#]", stripped):
        what = "text that begins with a bracket is read as a list or a mapping"
        return Cause(line, column, what, "put the text into quotes")
    if re.search(r"_{2,} *\S", shown) and shown[: column - 1].rstrip().endswith("_"):
        return Cause(line, column, "text goes on after its closing quote", "end it with the quote")
    if len(_COLON.findall(re.sub(r"[\[{].*", "", stripped))) > 1:
        what = "text with a colon and a space must be in quotes"
        return Cause(line, column, what, "put the text after the first colon into quotes")
    if above and not _COLON.search(lines[above - 1]) and lines[above - 1].lstrip()[:1] != "-":
        return _colon(lines, above)
    beside = len(lines[above - 1]) - len(lines[above - 1].lstrip()) if above else 0
    if margin != beside:
        what = f"the line is indented by {margin}, unlike the lines beside it"
        return Cause(line, margin + 1, what, f"line {above} is indented by {beside} spaces")
    return None


def _syntax(path: Path, text: str, error: YamlError) -> Fault:
    """Turn the parser's error into a fault."""
    line, column = error.place or FILE_START
    lines = text.splitlines()
    if line > len(lines):  # the end of the text
        line, column = len(lines), len(lines[-1]) + 1
    rest = lines[line - 1][: column + 1]
    if rest[column - 1 : column] == "\t" or "\t" in rest[: len(rest) - len(rest.lstrip())]:
        what, hint = "a tab is used for indentation; YAML needs spaces", "indent with spaces"
        return Fault(shown(path), line, column, "P007", what, hint)
    problem = error.problem or "not valid YAML"
    if "incompatible YAML" in problem:
        return Fault(shown(path), line, column, "P017", OTHER_YAML, DELETE_VERSION)
    if "nesting depth" in problem:  # newer libyaml stops scanning before its first event
        return Fault(shown(path), line, column, "P010", TOO_DEEP, CLOSE_BRACKET)
    if found := cause(text, error, (line, column)):
        return Fault(shown(path), found.line, found.column, "P008", found.what, found.hint)
    hint = error.context or "check quotes, brackets and indentation here and in the line above"
    if error.context and error.started is not None:
        hint = f"{error.context} that starts in line {error.started}"
    return Fault(shown(path), line, column, "P008", problem, hint)


@dataclass(slots=True)
class _Frame:
    """A mapping or sequence whose end has not been read yet."""

    data: Data
    inner: Data
    start: Event
    """The parser's mark, counted from 0."""
    anchor: str | None
    key: str | None = None
    """The key whose value comes next; None while the next event must be a key."""
    key_at: Position = FILE_START
    dropped: bool = False
    """The next value belongs to a faulty key and is discarded."""


class _Anchor(NamedTuple):
    """A value that aliases may repeat, with the number of characters that state it."""

    data: Data
    mark: SourceMark
    chars: int


class _Builder:
    """Builds data and marks from the events of one file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.faults: list[Fault] = []
        self.frames: list[_Frame] = []
        self.anchors: dict[str, _Anchor] = {}
        self.scalars: dict[str, Data] = {}
        """Values of plain scalars; those of a bank repeat a thousand times."""
        self.chars = 0
        """Characters of the text, plus those of every value repeated by an alias so far."""
        self.last: Event = None
        self.root: tuple[Any, SourceMark] | None = None

    def build(self, text: str) -> YamlSource:
        """Return the source of the whole text; raise `_StopError` or `YamlError`."""
        self.chars = len(text)
        collects = gc.isenabled()
        gc.disable()  # collection would walk the growing data again and again
        try:
            self._read(text)
        finally:
            if collects:
                gc.enable()
        if self.root is None:
            what, hint = "the file has only comments", "state the pack"
            raise _StopError(*self.faults, Fault(shown(self.path), 1, 1, "P006", what, hint))
        data, mark = self.root
        return YamlSource(self.path, data, mark, tuple(sorted(self.faults)), text)

    def _read(self, text: str) -> None:
        """Handle every event; add the place of the last event to an error without one."""
        # By name, so that ruamel.yaml is imported only when a text is parsed.
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
            for event in events(text):
                self.last = event.start_mark
                if handler := act.get(event.__class__.__name__):
                    handler(event)
        except YamlError as error:
            error.place = error.place or (self.last.line + 1, self.last.column + 1)
            raise

    def _fault(self, mark: Event, code: str, what: str, hint: str = "") -> Fault:
        """Return a fault at a mark of the parser."""
        return Fault(shown(self.path), mark.line + 1, mark.column + 1, code, what, hint)

    def _stop(self, mark: Event, code: str, what: str, hint: str) -> _StopError:
        return _StopError(*self.faults, self._fault(mark, code, what, hint))

    def _note(self, mark: Event, code: str, what: str, hint: str) -> None:
        self.faults.append(self._fault(mark, code, what, hint))

    def _on_document(self, event: Event) -> None:
        if self.root is not None:
            hint = "delete the line `---`, or move what follows to a file of its own"
            raise self._stop(event.start_mark, "P009", "a second document starts here", hint)
        if event.version is not None and tuple(event.version) != (1, 2):
            self._note(event.start_mark, "P017", OTHER_YAML, DELETE_VERSION)

    def _on_scalar(self, event: Event) -> None:
        mark = event.start_mark
        line, column = mark.line + 1, mark.column + 1
        text: str = event.value
        plain = not event.style
        if event.tag is not None:
            self._tagged(event)
        control = _NOT_TEXT.search(text) if event.style == '"' else None
        if control is not None:
            bad = f"U+{ord(control.group()):04X}"
            self._note(mark, "P005", f"control character {bad} in quotes", "delete it")
            # reading goes on, so that one run tells all faults
            text = _NOT_TEXT.sub("?", text)
        value: Data = text
        frame = self.frames[-1] if self.frames else None
        if frame is not None and frame.key is None and frame.data.__class__ is dict:
            self._key(frame, text, mark, plain=plain)
        else:
            if plain:
                if text not in self.scalars:
                    self.scalars[text] = _scalar(text)
                value = self.scalars[text]
            self._add(value, SourceMark(line, column))
        if event.anchor:
            chars = event.end_mark.index - mark.index
            self.anchors[event.anchor] = _Anchor(value, SourceMark(line, column), chars)

    def _key(self, frame: _Frame, text: str, mark: Event, *, plain: bool) -> None:
        """Store the text as the key of the next value."""
        if plain and (key := text.strip()) != text:  # YAML leaves out ordinary spaces alone
            what = f"a no-break space is part of the key '{key}'"
            self._note(mark, "P005", what, "replace it by an ordinary space")
            text = key
        frame.key, frame.key_at = text, Position(mark.line + 1, mark.column + 1)
        if text == "<<" and plain:
            frame.dropped = True
            hint = "write the fields out; an alias (`*name`) may stand for a whole value"
            self._note(mark, "P013", "merge keys (`<<`) are not supported", hint)
        elif text in frame.inner:
            frame.dropped = True
            first = frame.inner[text][0].line
            hint = f"it is also in line {first}; keep one of the two"
            self._note(mark, "P015", f"'{text}' is stated twice", hint)

    def _on_start(self, event: Event, data: Data, inner: Data) -> None:
        if event.tag is not None:
            self._tagged(event)
        self._not_a_key(event.start_mark)
        if len(self.frames) >= MAX_NESTING_LEVELS:
            raise self._stop(event.start_mark, "P010", TOO_DEEP, CLOSE_BRACKET)
        self.frames.append(_Frame(data, inner, event.start_mark, event.anchor))

    def _on_end(self, event: Event) -> None:
        frame = self.frames.pop()
        # aliases share values, so nothing may change them
        data = tuple(frame.data) if frame.data.__class__ is list else frame.data
        mark = SourceMark(frame.start.line + 1, frame.start.column + 1, frame.inner)
        if frame.anchor:
            chars = event.end_mark.index - frame.start.index
            self.anchors[frame.anchor] = _Anchor(data, mark, chars)
        self._add(data, mark)

    def _on_alias(self, event: Event) -> None:
        """Repeat an anchored value.

        Two rules keep aliases from multiplying data. An anchored value may not contain an alias.
        The text and all repeated values together may not be longer than a file.
        """
        mark = event.start_mark
        around = next((frame.anchor for frame in self.frames if frame.anchor), None)
        if around is not None:
            what = f"alias '*{event.anchor}' lies within the value anchored by '&{around}'"
            raise self._stop(mark, "P012", what, "write the value out")
        found = self.anchors.get(event.anchor)
        if found is None:
            what = f"alias '*{event.anchor}' has no anchor"
            hint = f"put text that begins with '*' into quotes, or write '&{event.anchor}' before"
            raise self._stop(mark, "P012", what, hint)
        if not self._not_a_key(mark):
            frame = self.frames[-1]
            frame.key, frame.dropped = "", True
            return
        self.chars += found.chars
        if self.chars > MAX_PACK_BYTES:
            what = f"the file is over {MAX_PACK_BYTES >> 20} MB once its aliases are written out"
            raise self._stop(mark, "P011", what, "split it into several packs")
        self._add(found.data, found.mark)

    def _tagged(self, event: Event) -> None:
        what = f"tags such as '{event.tag}' are not supported"
        hint = "delete it, or write the label in quotes"
        self._note(event.start_mark, "P014", what, hint)

    def _not_a_key(self, mark: Event) -> bool:
        """Return True where a value is expected; note a fault where a key is expected."""
        frame = self.frames[-1] if self.frames else None
        if frame is None or frame.data.__class__ is list or frame.key is not None:
            return True
        what, hint = "a key must be plain text", "check for a missing colon, or one too many"
        self._note(mark, "P016", what, hint)
        return False

    def _add(self, data: Data, mark: SourceMark) -> None:
        """Add a finished value to the innermost open mapping or sequence."""
        if not self.frames:
            self.root = data, mark
            return
        frame = self.frames[-1]
        if frame.data.__class__ is list:
            frame.data.append(data)
            frame.inner.append(mark)
        elif frame.key is None:  # a collection as a key is a fault: discard its value as well
            frame.key, frame.dropped = "", True
        else:
            if not frame.dropped:
                frame.data[frame.key] = data
                frame.inner[frame.key] = (frame.key_at, mark)
            frame.key, frame.dropped = None, False
