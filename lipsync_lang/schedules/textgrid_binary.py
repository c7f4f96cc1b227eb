"""Praat's binary TextGrid.

Numbers are big-endian. A text has its length in 16 bits before it; those with letters beyond ASCII
have -1 there, then the number of their 16-bit units. The class of a tier has its length in 8 bits.
"""

from collections.abc import Iterator
from struct import calcsize, unpack_from

from lipsync_lang.errors import ScheduleError
from lipsync_lang.schedules.rows import LabelRow
from lipsync_lang.schedules.tiers import Tier
from lipsync_lang.schedules.timing_file import TimingFile

SIGNATURE = b"ooBinaryFile"

OBJECT = b"TextGrid"

WIDE = -1
"""In place of a length: the text is in UTF-16."""


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
        text = self.text()
        return LabelRow(text, self.source.number(start), self.source.number(end))
