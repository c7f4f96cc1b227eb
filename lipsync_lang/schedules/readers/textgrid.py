"""Praat TextGrid, the format of most aligners.

Like Praat, the reader takes only free-standing tokens: numbers, texts in quotes (a quote within is
doubled) and flags in angle brackets. It skips everything else, such as ``xmin =``,
``intervals [1]:`` and comments after ``!``. So one reader serves the long, the short and the old
short form.

In the binary form, numbers are big-endian. A text has its length in 16 bits before it; those with
letters beyond ASCII have -1 there, then the number of their 16-bit units. The class of a tier has
its length in 8 bits.
"""

import re
from bisect import bisect_left
from collections.abc import Iterator
from struct import calcsize, unpack_from

from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.schedules import LabelRow, TimingFile, Timings, reader
from lipsync_lang.schedules.tiers import Tier, read_tiers

# possessive throughout: a long line without a quote must not be tried in every division
TEXTGRID_FORM = r"""
    [\s=]*+ (?: [^\s="<!+\-\d][^\s=]*+ [\s=]++ )*+    # words for people
    (?: "(?P<text> [^"]*+ (?:""[^"]*+)*+ )" (?!\S)
      | (?P<number> [+-]?\d[\d.eE+-]*+ ) (?!\S)
      | (?P<flag> <exists> | <absent> ) (?!\S)
      | (?P<quote> " )
      | !.* | [^\s=]++
    )
    """

HOLDS = {"IntervalTier": "interval", "TextTier": "point"}
"""Classes of tiers, with the word for their items."""

MAX_COUNT_DIGITS = 9
SIGNATURE = b"ooBinaryFile"
OBJECT = b"TextGrid"

WIDE = -1
"""In place of a length: the text is in UTF-16."""


def sniff(source: TimingFile) -> bool:
    """Return True if the file has Praat's header."""
    return "ooTextFile" in source.head[:300] or source.content.startswith(SIGNATURE)


@reader("textgrid", ".textgrid", sniff=sniff, tiers=True)
def read_textgrid(source: TimingFile) -> Timings:
    """Praat TextGrid with a tier of phones, of words or of both."""
    if source.content.startswith(SIGNATURE):
        return read_tiers(source, list(binary_tiers(source)))
    if not sniff(source):
        raise source.fault("is not a text TextGrid; in Praat, use 'Save as text file'")
    return read_tiers(source, list(_tiers(_Tokens(source))))


def _tiers(tokens: "_Tokens") -> Iterator[Tier]:
    """Yield the interval tiers; raise an error if the file's own counts are wrong."""
    tokens.take("text", "the type of the file")
    if tokens.take("text", "the kind of object") != "TextGrid":
        raise tokens.fault("the file has no TextGrid; in Praat, select a TextGrid and save it")
    tokens.take("number", "the start of the TextGrid")
    tokens.take("number", "the end of the TextGrid")
    there = tokens.take("flag", "<exists>") == "<exists>"
    for number in range(tokens.count("the number of tiers") if there else 0):
        holds = HOLDS.get(tokens.take("text", f"the class of tier {number + 1}"))
        if holds is None:
            raise tokens.fault(f"a tier is one of {' and '.join(HOLDS)}; save it again in Praat")
        name, line = tokens.take("text", f"the name of tier {number + 1}"), tokens.line
        tokens.take("number", f"the start of tier '{name}'")
        tokens.take("number", f"the end of tier '{name}'")
        count = tokens.count(f"the number of {holds}s of tier '{name}'")
        numbered = (f"{holds} {at + 1} of {count} of tier '{name}'" for at in range(count))
        if holds == "interval":
            yield Tier(name.strip(), tuple(map(tokens.row, numbered)), line)
            continue
        for what in numbered:
            tokens.take("number", what)
            tokens.take("text", what)
    tokens.end()


class _Tokens:
    """The free-standing tokens of a file, taken one by one."""

    def __init__(self, source: TimingFile) -> None:
        self.source = source
        found = re.finditer(TEXTGRID_FORM, source.text, re.VERBOSE)
        self.left = (one for one in found if one.lastgroup)
        # To count line ends for each token would take the square of the time.
        self.ends = [one.start() for one in re.finditer(r"\n", source.text)]
        self.at = 0

    @property
    def line(self) -> int:
        """The line of the last token taken."""
        return bisect_left(self.ends, self.at) + 1

    def fault(self, what: str) -> ScheduleError:
        """Return an error at the last token taken."""
        return self.source.fault(what, self.line)

    def take(self, group: str, what: str) -> str:
        """Return the next token; raise an error unless it is of the given group."""
        found = next(self.left, None)
        if found is None:
            raise self.fault(f"{what} is missing at the end; check that the file is complete")
        kind = found.lastgroup or ""
        self.at = found.start(kind)
        if kind == "quote":
            raise self.fault('the text has an unpaired quote; double a quote within a text ("")')
        if kind != group:
            mend = "correct the number of items that the file states, or save it again in Praat"
            raise self.fault(f"expected {what} here, not {found[kind][:40]!r}; {mend}")
        return found[kind].replace('""', '"')

    def count(self, what: str) -> int:
        """Return a whole number."""
        text = self.take("number", what)
        # `int` refuses thousands of digits by an error of its own
        if not text.isdecimal() or len(text) > MAX_COUNT_DIGITS:
            raise self.fault(f"expected {what} here, not {text[:40]}; save it again in Praat")
        return int(text)

    def row(self, what: str) -> LabelRow:
        """Take an interval."""
        start = self.take("number", what)
        line = self.line
        end, label = self.take("number", what), self.take("text", what)
        return LabelRow(label, self.source.time(start, line), self.source.time(end, line), line)

    def end(self) -> None:
        """Raise an error if tokens are left."""
        found = next(self.left, None)
        if found:
            self.at = found.start(found.lastgroup or 0)
            what = "there is more text than the file states; correct the number"
            raise self.fault(f"{what}, or save it again in Praat")


def binary_tiers(source: TimingFile) -> Iterator[Tier]:
    """Yield the interval tiers; raise an error if the file is cut off or holds something else."""
    values = _Values(source)
    if values.bytes(*values.take("B")) != OBJECT:
        raise values.fault("the file has no TextGrid; in Praat, select a TextGrid and save it")
    values.take("dd")
    (there,) = values.take("?")
    for _ in range(values.count() if there else 0):
        kind = values.bytes(*values.take("B"))
        if kind not in (b"IntervalTier", b"TextTier"):
            raise values.fault("a tier has an unknown class; save it again in Praat")
        name = values.text()
        values.take("dd")
        count = values.count()
        if kind == b"IntervalTier":
            yield Tier(name.strip(), tuple(values.interval() for _ in range(count)))
        else:
            for _ in range(count):
                values.take("d")
                values.text()


class _Values:
    """The values of a file, taken one after the other."""

    def __init__(self, source: TimingFile) -> None:
        self.source = source
        self.at = len(SIGNATURE)

    def fault(self, what: str) -> ScheduleError:
        """Return an error at the next byte."""
        return self.source.fault(f"at byte {self.at}, {what}")

    def take(self, form: str) -> tuple[int | float | bool, ...]:
        """Return numbers in a form of `struct`."""
        return unpack_from(f">{form}", self.bytes(calcsize(f">{form}")))

    def bytes(self, count: float) -> bytes:
        """Return the next bytes; raise an error if the file ends before."""
        start, self.at = self.at, self.at + int(count)
        if self.at > len(self.source.content):
            self.at = start
            raise self.fault("the file is incomplete; save it again in Praat, or as a text file")
        return self.source.content[start : self.at]

    def count(self) -> int:
        """Return a number of tiers, intervals or points, each of which takes a byte and more."""
        (count,) = self.take("i")
        if not 0 <= count <= len(self.source.content):
            raise self.fault(f"the file states {count:g} items; save it again in Praat")
        return int(count)

    def text(self) -> str:
        """Return the next text."""
        (length,) = self.take("h")
        if length == WIDE:
            (units,) = self.take("H")
            return self.bytes(2 * units).decode("utf-16-be", "replace")
        if length < 0:
            raise self.fault(f"a text has a length of {length:g}; save it again in Praat")
        return self.bytes(length).decode("ascii", "replace")

    def interval(self) -> LabelRow:
        """Return the next interval."""
        start, end = self.take("dd")
        return LabelRow(self.text(), self.source.number(start), self.source.number(end))
