"""A file of timings, decoded as text, JSON or XML on demand."""

import codecs
import json
import re
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.base.files.reading import MIB_BYTES, marked_encoding, read_input
from lipsync_lang.base.json_object import Json

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MAX_TIMINGS_BYTES = 64 * MIB_BYTES

NAME_ENCODING = ", or name its encoding (`encoding='cp1252'`)"
"""Advice on text in another encoding, for callers who can name it."""

HEAD_BYTES = 4096
"""Number of first bytes that identify a format."""

MAX_TIME = 1e15
"""Upper limit of times, in any unit."""

QUOTED = re.compile(r"\s*-?\d{1,15}(\.\d*)?\s*", re.ASCII)
"""A number in quotes, as programs in JavaScript write it."""

DOCTYPE = re.compile(
    r"""<!DOCTYPE\s++[\w.:-]++(?:\s++(?:SYSTEM|PUBLIC|"[^"]*+"|'[^']*+'))*+\s*+>"""
)
"""A type of documents that is only named; the file with its definition is never read."""

ROOT_TAG = re.compile(
    r"\s*+(?:(?><\?.*?\?>|<!--.*?-->|<!DOCTYPE\b[^<>\[]*+>)\s*+)*+<([A-Za-z_][\w.:-]*)", re.DOTALL
)
"""The first element of an XML file."""

XML_ENCODING = re.compile(rb"""\s*<\?xml\s[^>]{0,200}?\bencoding\s*=\s*["']([A-Za-z][\w.-]*)["']""")
"""The encoding that an XML file states."""


@dataclass(frozen=True, eq=False)
class TimingFile:
    """A file of timings, with the options for reading it."""

    path: Path
    content: bytes
    tier: str | None = None
    """Name of the tier, speaker or channel to read; None if the file has only one."""
    rate: float | None = None
    """Units per second of its times; None for the format's own."""
    encoding: str | None = None
    """Encoding of its text; None to detect it."""
    silences: Collection[str] = ()
    """Labels that are silence in this file, besides blank ones, in small letters."""

    @classmethod
    def of(cls, path: Path, **options: Any) -> "TimingFile":
        """Read a file with some of the options; a ScheduleError if it cannot be read."""
        return cls(path, timing_bytes(path), **options)

    def fault(self, what: str, line: int | None = None, column: int | None = None) -> ScheduleError:
        """Return an error at a place of the file; `what` is the mistake and the cure."""
        where = ":".join(str(part) for part in (self.path, line, column) if part is not None)
        return ScheduleError(f"{where}: {what}")

    @cached_property
    def text(self) -> str:
        r"""The text; every line ends in ``\n``.

        UTF-8 and UTF-16 are detected with or without a byte order mark, UTF-32 only with one. XML
        may state another encoding.
        """
        encoding = self.encoding or _encoding(self.content)
        try:
            text = self.content.decode(encoding)
        except UnicodeDecodeError as error:
            line = self.content.count(b"\n", 0, error.start) + 1
            asked = encoding if self.encoding else "UTF-8 or UTF-16"
            what = f"is not {asked} text (byte {error.start}); save it as UTF-8{NAME_ENCODING}"
            raise self.fault(what, line) from None
        except (LookupError, ValueError):  # ValueError: a name with a zero byte
            what = f"unknown encoding '{encoding}'; try utf-8, utf-16, cp1252 or shift_jis"
            raise self.fault(what) from None
        if "\0" in text:
            line = text.count("\n", 0, text.index("\0")) + 1
            what = "has zero bytes, so it is not text; check the program that wrote it"
            raise self.fault(what, line)
        # An encoding that states its byte order, such as `utf-16-le`, leaves the mark in the text.
        return re.sub(r"\r\n?", "\n", text.removeprefix("\ufeff"))

    @cached_property
    def lines(self) -> list[tuple[int, str]]:
        """Lines that are not blank, with their numbers."""
        rows = enumerate(self.text.split("\n"), 1)
        return [(number, line) for number, line in rows if line.strip()]

    @cached_property
    def head(self) -> str:
        """The start of the text, for recognising a format; decoding errors are ignored."""
        encoding = self.encoding or _encoding(self.content)
        try:
            text = self.content[:HEAD_BYTES].decode(encoding, "ignore")
        except (LookupError, ValueError):
            return ""
        return re.sub(r"\r\n?", "\n", text.removeprefix("\ufeff"))

    @cached_property
    def json(self) -> Any:
        """The file as JSON; raises an error if it is not JSON."""
        return self._loaded(self.text)

    @cached_property
    def events(self) -> list[tuple[int | None, Any]]:
        """(line, value) of each JSON value: the items of one list, or one value per line."""
        if self.document is not None:
            whole = self.document
            return [(None, one) for one in (whole if isinstance(whole, list) else [whole])]
        return [(number, self._loaded(line, number)) for number, line in self.lines]

    def _loaded(self, text: str, line: int = 1) -> Any:
        try:
            return json.loads(text)
        except json.JSONDecodeError as error:
            what = f"not JSON: {error.msg}; correct the file, or save it again"
            raise self.fault(what, line + error.lineno - 1, error.colno) from None
        except (RecursionError, ValueError) as error:
            what = "is nested too deep" if isinstance(error, RecursionError) else str(error)
            raise self.fault(f"not JSON of timings: {what}; check what wrote it") from None

    @cached_property
    def document(self) -> Any:
        """The file as JSON; None if it is not JSON."""
        if self.head.lstrip()[:1] not in ("{", "["):
            return None
        try:
            return self.json
        except ScheduleError:
            return None

    def holds(self, *keys: str) -> bool:
        """Return True if the file is a JSON object with all these keys."""
        return isinstance(self.document, dict) and self.document.keys() >= set(keys)

    def mentions(self, *keys: str) -> bool:
        """Return True if the file looks like JSON, and any of these keys is anywhere in it."""
        if self.head.lstrip()[:1] not in ("{", "["):
            return False
        try:
            return any(f'"{key}"' in self.text for key in keys)
        except ScheduleError:
            return False

    @property
    def root(self) -> str | None:
        """The name of the outermost element; None if the file does not look like XML."""
        found = ROOT_TAG.match(self.head)
        return found[1] if found else None

    def has_root(self, name: str) -> bool:
        """Return True for XML with an outermost element of this name."""
        return self.root == name

    @property
    def first_line(self) -> str:
        """The first line of `head` that is not blank."""
        return self.head.lstrip().split("\n", 1)[0]

    @cached_property
    def xml(self) -> "Element":
        """The file as XML; raises an error if it is not XML, or declares entities."""
        from xml.etree import ElementTree as ET

        # its line ends stay, so that faults keep their lines
        text = DOCTYPE.sub(lambda found: "\n" * found[0].count("\n"), self.text, count=1)
        declared = re.search(r"<!(DOCTYPE|ENTITY)", text)
        if declared:
            line = text.count("\n", 0, declared.start()) + 1
            what = f"has a <!{declared[1]}>, which is never read; remove it from the file"
            raise self.fault(what, line)
        try:
            # the text is decoded already, and a stated encoding would contradict that
            return ET.fromstring(re.sub(r"^\s*<\?xml.*?\?>", "", text, flags=re.DOTALL))  # noqa: S314 no entities
        except ET.ParseError as error:
            what = f"not XML: {error.msg.split(':')[0]}; correct the file, or export it again"
            raise self.fault(what, error.position[0]) from None

    def number(self, value: object, line: int | None = None) -> float:
        """Return a number from JSON, or one in quotes, as a time; other values are errors."""
        if isinstance(value, str) and QUOTED.fullmatch(value):
            value = float(value)
        # True is a number too, and NaN fails every comparison
        if (
            isinstance(value, bool)
            or not isinstance(value, (int, float))
            or not abs(value) < MAX_TIME
        ):
            shown = type(value).__name__ if isinstance(value, (list, dict)) else repr(value)[:40]
            raise self.fault(f"{shown} is not a time; times are finite numbers", line)
        return float(value)

    def time(self, text: str | None, line: int | None = None) -> float:
        """Return the time in a text; raise an error if it is not a number."""
        try:
            number = float(text or "")
        except ValueError:
            return self.number(text, line)
        return number if abs(number) < MAX_TIME else self.number(number, line)

    def objects(self, whole: object, name: str, form: str, line: int | None = None) -> list[Json]:
        """Return the list of objects in a field, empty without it; `form` is for errors."""
        parts = whole.get(name, []) if isinstance(whole, dict) else None
        what = f"`{name}` must be a list of objects; the form is {form}"
        return self.object_list(parts, what, line)

    def object_list(self, value: object, what: str, line: int | None = None) -> list[Json]:
        """Return a list of objects; raise an error about `what` for anything else."""
        if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
            raise self.fault(what, line)
        return value

    def matches(
        self,
        form: re.Pattern[str],
        what: str,
        *,
        after: int = 0,
        comments: str | tuple[str, ...] = (),
    ) -> Iterator[tuple[int, re.Match[str]]]:
        """Yield (number, match) of each line; raise an error for a line of another form.

        `what` is the form in words, for the error. The first lines, as many as `after`, and lines
        that start with `comments` are skipped.
        """
        for number, line in self.lines[after:]:
            if line.startswith(comments):
                continue
            found = form.fullmatch(line)
            if found is None:
                raise self.fault(f"{line.strip()[:40]!r} is not {what}", number)
            yield number, found

    def line_of(self, text: str) -> int | None:
        """Return the first line that holds a text; None if there is none."""
        at = self.text.find(text)
        return None if at < 0 else self.text.count("\n", 0, at) + 1

    def beside(self, suffix: str) -> "TimingFile | None":
        """Return the file of the same name with another suffix, in either case; None if missing."""
        for one in (suffix, suffix.upper()):
            path = self.path.with_suffix(one)
            if path.is_file():
                return replace(self, path=path, content=timing_bytes(path))
        return None


def first_item(value: object) -> Any:
    """Return the first item of a list; None for an empty one, or anything else."""
    return value[0] if isinstance(value, list) and value else None


def plain_fields(value: object) -> Json:
    """Return an object with one spelling of its names, in small letters without underscores."""
    fields = value if isinstance(value, dict) else {}
    return {name.replace("_", "").lower(): field for name, field in fields.items()}


@contextmanager
def unnamed_encoding() -> Iterator[None]:
    """Leave the advice to name an encoding out of errors, where users cannot follow it."""
    try:
        yield
    except ScheduleError as error:
        raise ScheduleError(str(error).replace(NAME_ENCODING, "")) from None


def timing_bytes(path: Path) -> bytes:
    """Return the bytes of a file of timings; a ScheduleError if it is unreadable or too large."""
    mend = "check that it is a schedule"
    return read_input(path, MAX_TIMINGS_BYTES, error=ScheduleError, mend=mend)


def _encoding(content: bytes) -> str:
    if marked := marked_encoding(content):
        return marked
    # UTF-16 without a mark: every second byte of a plain letter is 0
    if content[1:2] == b"\0" and content[:1] != b"\0":
        return "utf-16-le"
    if content[:1] == b"\0" and content[1:2] != b"\0":
        return "utf-16-be"
    stated = XML_ENCODING.match(content[:HEAD_BYTES])
    try:
        known = codecs.lookup(stated[1].decode("ascii")).name if stated else "utf-8"
        # Only an encoding that extends ASCII can have written the statement itself.
        return known if "<?xml".encode(known) == b"<?xml" else "utf-8"
    except (LookupError, ValueError):
        return "utf-8"
