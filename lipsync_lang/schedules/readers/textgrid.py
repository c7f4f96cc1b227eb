"""Praat TextGrid, the format of most aligners.

Like Praat, the reader takes only free-standing tokens: numbers, texts in quotes (a quote within is
doubled) and flags in angle brackets. It skips everything else, such as ``xmin =``,
``intervals [1]:`` and comments after ``!``. So one reader serves the long, the short and the old
short form.
"""

import re
from bisect import bisect_left
from collections.abc import Iterator

from lipsync_lang.errors import ScheduleError
from lipsync_lang.schedules.rows import LabelRow
from lipsync_lang.schedules.textgrid_binary import SIGNATURE, binary_tiers
from lipsync_lang.schedules.tiers import Tier, read_tiers
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import Timings, reader

TEXTGRID_TOKEN = re.compile(
    r"""
    [\s=]*+ (?: [^\s="<!+\-\d][^\s=]*+ [\s=]++ )*+    # words for people
    (?: "(?P<text> [^"]*+ (?:""[^"]*+)*+ )" (?!\S)
      | (?P<number> [+-]?\d[\d.eE+-]*+ ) (?!\S)
      | (?P<flag> <exists> | <absent> ) (?!\S)
      | (?P<quote> " )
      | !.* | [^\s=]++
    )
    """,
    re.VERBOSE,
)

HOLDS = {"IntervalTier": "interval", "TextTier": "point"}
"""Classes of tiers, with the word for their items."""

MAX_COUNT_DIGITS = 9
"""Maximum digits of a number of intervals."""


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
        self.left = (one for one in TEXTGRID_TOKEN.finditer(source.text) if one.lastgroup)
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
            raise self.fault(
                f"expected {what} here, not {found[kind][:40]!r}; correct the number of items "
                "that the file states, or save it again in Praat"
            )
        return found[kind].replace('""', '"')

    def count(self, what: str) -> int:
        """Return a whole number."""
        text = self.take("number", what)
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
            raise self.fault(
                "there is more text than the file states; correct the number, or save it again in "
                "Praat"
            )
