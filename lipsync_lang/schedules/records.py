"""Records of JSON, found by a path and read by the names of their fields.

A path such as ``NBest[0].Words`` names fields from the outermost object on. A list on the way
stands for all its objects, with ``[0]`` for its first alone. Without a path, the outermost objects
are the records. A format that differs from others by path and names alone is a `RecordFormat`:
a row of `readers/record_formats.py`, or of a project.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules.rows import LabelRow, schedule_of
from lipsync_lang.schedules.timed_words import timed_words_of
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import ScheduleReader, Timings

RECORD_UNITS = {"s": None, "ms": 1000.0, "ticks": 1e7}
"""Units per second of times, by name; None for seconds."""

FIRST_ONLY = "[0]"


@dataclass(frozen=True)
class RecordList:
    """A list of records, and the names of their fields."""

    text: str
    start: str
    records: str = ""
    end: str | None = None
    duration: str | None = None
    """Field that takes the place of `end`."""
    unnamed: bool = False
    """True if a record without a text is silence."""


@dataclass(frozen=True)
class RecordFormat:
    """A format of timings in JSON, stated as data."""

    name: str
    title: str
    phonemes: RecordList | None = None
    words: RecordList | None = None
    unit: str = "s"
    """A name of `RECORD_UNITS`."""
    rate: float | None = None
    """Units in a second, such as frames, instead of `unit`."""
    notation: str | None = None
    mentions: tuple[str, ...] = ()
    """Fields of which a file has one; without them, the fields of its first record tell."""
    suffixes: tuple[str, ...] = (".json", ".jsonl")
    form: str | None = None
    """An example, for messages."""

    def lists(self) -> list[RecordList]:
        """Return the lists that the format has."""
        return [one for one in (self.phonemes, self.words) if one is not None]

    def sniff(self, source: TimingFile) -> bool:
        """Return True if the file looks like this format."""
        if self.mentions:
            return source.mentions(*self.mentions)
        return source.document is not None and any(_fits(source, one) for one in self.lists())

    def read(self, source: TimingFile) -> Timings:
        """Read the phonemes and words of a file."""
        phones, words = (
            [] if one is None else list(_rows(source, one, self.form))
            for one in (self.phonemes, self.words)
        )
        rate = self.rate or RECORD_UNITS[self.unit]
        if not phones and not words:
            paths = " or ".join(f"`{one.records}`" for one in self.lists() if one.records)
            where = f" at {paths}" if paths else ""
            raise source.fault(f"has no records of {self.name}{where}; {_mend(self.form)}")
        if phones:
            return schedule_of(source, phones, words=words, notation=self.notation, rate=rate)
        return timed_words_of(source, words, rate=rate)

    def reader(self) -> ScheduleReader:
        """Return the reader of the format."""
        return ScheduleReader(self.name, self.suffixes, self.title, self.sniff, self.read)


def record_format(name: str, row: Mapping[str, Any]) -> RecordFormat:
    """Make a format of the fields that a project states, which may leave the title out."""
    facts = {"title": f"Timings of {name}.", **row}
    for kind in ("phonemes", "words"):
        if facts.get(kind) is not None:
            facts[kind] = RecordList(**facts[kind])
    return RecordFormat(name, **facts)


def records_at(
    source: TimingFile, whole: object, path: str, form: str | None, line: int | None = None
) -> Iterator[Json]:
    """Yield the objects at a path; none where a field is missing."""
    name, _, rest = path.partition(".")
    first = name.endswith(FIRST_ONLY)
    name = name.removesuffix(FIRST_ONLY)
    found = whole.get(name, []) if isinstance(whole, dict) else None
    found = [found] if isinstance(found, dict) else found
    parts = source.object_list(found, f"`{name}` must be a list of objects; {_mend(form)}", line)
    for part in parts[:1] if first else parts:
        if rest:
            yield from records_at(source, part, rest, form, line)
        else:
            yield part


def _mend(form: str | None) -> str:
    return f"the form is {form}" if form else "check the file, and the path of its format"


def _records(
    source: TimingFile, given: RecordList, form: str | None
) -> Iterator[tuple[int | None, Json]]:
    for line, value in source.events:
        # A list of one field lets the outermost objects pass the same check as all others.
        whole, path = (value, given.records) if given.records else ({"records": value}, "records")
        for record in records_at(source, whole, path, form, line):
            yield line, record


def _fits(source: TimingFile, given: RecordList) -> bool:
    """Return True if the first record has all fields of the format."""
    try:
        _, first = next(_records(source, given, None), (None, {}))
    except ScheduleError:
        return False
    return {given.text, given.start, given.end or given.duration} <= first.keys()


def _rows(source: TimingFile, given: RecordList, form: str | None) -> Iterator[LabelRow]:
    """Yield the rows of records, in the file's unit; faults count the records from 1."""
    for number, (line, record) in enumerate(_records(source, given, form), 1):
        stop = given.end or given.duration
        for name in (given.text, given.start, stop):
            if name not in record and not (given.unnamed and name == given.text):
                raise source.fault(f"record {number} has no '{name}'", line)
        text = record.get(given.text)
        start, end = (source.number(record[one], line) for one in (given.start, str(stop)))
        end = end if given.end else start + end
        yield LabelRow("" if text is None else str(text), start, end, line)
