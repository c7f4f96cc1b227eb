"""Records of JSON, found by a path and read by the names of their fields.

A path such as ``NBest[0].Words`` names fields from the outermost object on. A list on the way
stands for all its objects, with ``[0]`` for its first alone. Without a path, the outermost objects
are the records. Several paths have a bar between them, and the first that leads to records counts.
A field of a record may be a path, or several, too.

A format that differs from others by path and names alone is a `RecordFormat`: an entry of
`readers/record_formats.json`, or of a project.
"""

import json
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import islice
from typing import Any, NamedTuple
from unicodedata import category

from lipsync_lang.base.errors import ScheduleError, shortlist
from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules.rows import (
    LabelRow,
    Start,
    listed_rows,
    schedule_of,
    shapes_of,
    until_next,
)
from lipsync_lang.schedules.tiers import read_speakers
from lipsync_lang.schedules.timed_words import timed_words_of
from lipsync_lang.schedules.timing_file import TimingFile, first_item
from lipsync_lang.schedules.timing_readers import ScheduleReader, Timings

RECORD_UNITS = {"s": None, "ms": 1000.0, "ticks": 1e7}
"""Units per second of times, by name; None for seconds."""

FIRST_ONLY = "[0]"

SNIFFED_RECORDS = 8
"""Number of first records that tell a format: the very first may be a mark without times."""

STRESS_MARKS = "ˈˌ"
"""Marks before the sound that they belong to; all others follow it."""


class RecordList(NamedTuple):
    """A list of records, and the names of their fields."""

    text: str
    start: str | None = None
    """Field with the start; None if a record starts where the one before it ends."""
    records: str = ""
    end: str | None = None
    duration: str | None = None
    """Field that takes the place of `end`; without both, a record lasts until the next."""
    unnamed: bool = False
    """True if a record without a text is silence."""
    untimed: bool = False
    """True if records without times, such as punctuation, are left out."""
    from_zero: bool = False
    """True if a record without a start begins at 0."""
    speaker: str | None = None
    """Field with the speaker of words, in a record or in an object around it."""
    columns: bool = False
    """True if the fields are lists of one length, with an item for each record."""

    @property
    def times(self) -> list[str]:
        """The fields with times."""
        return [one for one in (self.start, self.end or self.duration) if one is not None]


class RecordFormat(NamedTuple):
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
    shapes: bool = False
    """True if the phonemes are mouth shapes."""
    characters: bool = False
    """True if each phoneme is a character: marks, spaces and punctuation among them."""
    mentions: tuple[str, ...] = ()
    """Fields of which a file has one; without them, the fields of its first records tell."""
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
        return source.head.lstrip()[:1] in ("{", "[") and any(
            _fits(source, one) for one in self.lists()
        )

    def read(self, source: TimingFile) -> Timings:
        """Read the phonemes and words of a file."""
        rate = self.rate or RECORD_UNITS[self.unit]
        remarks: list[str] = []
        phones, words = (
            [] if one is None else self._rows(source, one, rate or 1.0, remarks)
            for one in (self.phonemes, self.words)
        )
        if not phones and not words:
            stated = [one.records for one in self.lists() if one.records]
            paths = " or ".join(f"`{one}`" for one in stated)
            where = f" at {paths}{_path_end(source, stated)}" if paths else ""
            raise source.fault(f"has no records of {self.name}{where}; {_mend(self.form)}")
        words = [row for row in words if any(map(str.isalnum, row.label))]
        if self.words is not None and self.words.speaker and not phones:
            speakers = _speakers(_rows(source, self.words, self.form))
            if any(speakers) or source.tier is not None:
                return read_speakers(replace(source, rate=source.rate or rate), speakers, remarks)
        if not phones:
            return timed_words_of(source, words, rate=rate, remarks=remarks)
        if self.characters:
            phones = _without_marks(phones)
        make: Callable[..., Timings] = shapes_of if self.shapes else schedule_of
        return make(source, phones, words=words, notation=self.notation, rate=rate, remarks=remarks)

    def reader(self) -> ScheduleReader:
        """Return the reader of the format."""
        tiers = any(one.speaker for one in self.lists())
        return ScheduleReader(self.name, self.suffixes, self.title, self.sniff, self.read, tiers)

    def _rows(
        self, source: TimingFile, given: RecordList, rate: float, remarks: list[str]
    ) -> list[LabelRow]:
        """Return the rows of records, in the file's unit; services repeat some as they are."""
        rows = list(dict.fromkeys(row for _, row in _rows(source, given, self.form)))
        if given.end or given.duration:
            return rows
        starts: list[Start] = [(row.label, row.start, row.line) for row in rows]
        rows, told = until_next(source, starts, rest="", rate=rate)
        remarks += told
        return rows


def record_format(name: str, row: Mapping[str, Any]) -> RecordFormat:
    """Make a format of the fields that are stated; a project may leave the title out."""
    facts = {"title": f"Timings of {name}.", **row}
    if "form" in facts:
        facts["form"] = json.dumps(facts["form"], ensure_ascii=False)
    for kind in ("phonemes", "words"):
        if facts.get(kind) is not None:
            facts[kind] = RecordList(**facts[kind])
    return RecordFormat(name, **facts)


def records_at(  # noqa: PLR0913 a path and its place
    source: TimingFile,
    whole: object,
    path: str,
    form: str | None,
    line: int | None = None,
    *,
    inherited: str | None = None,
) -> Iterator[Json]:
    """Yield the objects at a path; none where a field is missing.

    A field that is `inherited` comes from an object around those that lack it.
    """
    name, _, rest = path.partition(".")
    first = name.endswith(FIRST_ONLY)
    name = name.removesuffix(FIRST_ONLY)
    found = whole.get(name) if isinstance(whole, dict) else ()
    found = [] if found is None else [found] if isinstance(found, dict) else found
    parts = source.object_list(found, f"`{name}` must be a list of objects; {_mend(form)}", line)
    around: Json = {}
    if inherited and isinstance(whole, dict) and inherited in whole:
        around = {inherited: whole[inherited]}
    for part in parts[:1] if first else parts:
        inner = {**around, **part} if around else part
        if rest:
            yield from records_at(source, inner, rest, form, line, inherited=inherited)
        else:
            yield inner


def _mend(form: str | None) -> str:
    return f"the form is {form}" if form else "check the file, and the path of its format"


def _path_end(source: TimingFile, stated: list[str]) -> str:
    """Return which field of the first path is missing in the first object, in words."""
    found = first_item([value for _, value in source.events[:1]])
    for name in stated[0].split("|")[0].strip().split("."):
        if not isinstance(found, dict):
            break
        own = name.removesuffix(FIRST_ONLY)
        if own not in found:
            return f": there is no `{own}` among {shortlist(found, SNIFFED_RECORDS) or 'nothing'}"
        found = found[own]
        found = first_item(found) if isinstance(found, list) else found
    return ""


def _records(
    source: TimingFile, given: RecordList, form: str | None, events: int | None = None
) -> Iterator[tuple[int | None, Json]]:
    """Yield (line, record) of the first path that has records, in the first `events`."""
    for path in given.records.split("|"):
        found = _at_path(source, path.strip(), form, events, given.speaker)
        if first := next(found, None):
            yield first
            yield from found
            return


def _at_path(
    source: TimingFile, given: str, form: str | None, events: int | None, inherited: str | None
) -> Iterator[tuple[int | None, Json]]:
    for line, value in source.events[:events]:
        # A list of one field lets the outermost objects pass the same check as all others.
        whole, path = (value, given) if given else ({"records": value}, "records")
        for record in records_at(source, whole, path, form, line, inherited=inherited):
            yield line, record


def _fits(source: TimingFile, given: RecordList) -> bool:
    """Return True if one of the first records has all fields of the format."""
    named = [] if given.unnamed else [given.text]
    needed = [*named, *(given.times[1:] if given.from_zero else given.times)]
    try:
        first = list(islice(_records(source, given, None, SNIFFED_RECORDS), SNIFFED_RECORDS))
    except ScheduleError:
        return False
    return any(all(field_at(one, name) is not None for name in needed) for _, one in first)


def field_at(record: Json, paths: str) -> object:
    """Return what a record has at the first of the paths; None where something is missing."""
    path, _, others = paths.partition("|")
    found: object = record
    for name in path.split("."):
        found = found.get(name.removesuffix(FIRST_ONLY)) if isinstance(found, dict) else None
        found = first_item(found) if name.endswith(FIRST_ONLY) else found
    return field_at(record, others) if found is None and others else found


def _rows(
    source: TimingFile, given: RecordList, form: str | None
) -> Iterator[tuple[str, LabelRow]]:
    """Yield (speaker, row) of records, in the file's unit; faults count the records from 1."""
    end = 0.0
    names = [given.text, *given.times]
    for number, (line, record) in enumerate(_records(source, given, form), 1):
        if given.columns:
            lists: list[object] = [
                record.get(name) if given.text in record else [] for name in names
            ]
            example = form or f"lists of {', '.join(names)}"
            rows = listed_rows(source, *lists, form=example, line=line, durations=given.end is None)
            yield from (("", row) for row in rows)
            continue
        found = {name: field_at(record, name) for name in names}
        if given.from_zero and given.start and found[given.start] is None:
            found[given.start] = 0
        if given.untimed and any(found[name] is None for name in given.times):
            continue
        for name, value in found.items():
            if value is None and not (given.unnamed and name == given.text):
                what = name.replace("|", "' or '")
                raise source.fault(f"record {number} has no '{what}'", line)
        start = end if given.start is None else _time(source, found[given.start], line)
        stop = found.get(str(given.end or given.duration), start)
        end = _time(source, stop, line) + (start if given.duration else 0.0)
        text = found[given.text]
        speaker = None if given.speaker is None else field_at(record, given.speaker)
        row = LabelRow("" if text is None else str(text), start, end, line)
        yield "" if speaker is None else str(speaker), row


def _speakers(rows: Iterable[tuple[str, LabelRow]]) -> dict[str, list[LabelRow]]:
    """Return the words of each speaker; those that are repeated with a speaker count once."""
    said: dict[str, list[LabelRow]] = defaultdict(list)
    for speaker, row in dict.fromkeys(rows):
        if any(map(str.isalnum, row.label)):
            said[speaker].append(row)
    named = {row for speaker, own in said.items() if speaker for row in own}
    nobody = [row for row in said.pop("", []) if row not in named]
    return {**said, **({"": nobody} if nobody else {})}


def _time(source: TimingFile, value: object, line: int | None) -> float:
    """Return a time: a number, seconds with their unit (`"1.300s"`), or with nanoseconds apart."""
    if isinstance(value, dict) and value.keys() <= {"seconds", "nanos"}:
        seconds, nanos = (
            source.number(value.get(name) or 0, line) for name in ("seconds", "nanos")
        )
        return seconds + nanos / 1e9
    return source.number(value.removesuffix("s") if isinstance(value, str) else value, line)


def _without_marks(rows: list[LabelRow]) -> list[LabelRow]:
    """Return characters of a phonetic text as sounds.

    Marks join the sound that they belong to, and a space the sound before it, because it is not
    heard. Punctuation and the marks of the ends of a text are silence.
    """
    joined: list[LabelRow] = []
    stress: LabelRow | None = None
    for row in rows:
        mark = bool(row.label) and category(row.label[0]) in {"Lm", "Mn", "Sk"}
        if row.label in STRESS_MARKS and mark:
            stress = stress or row
        elif joined and (mark or row.label.isspace()):
            label = joined[-1].label + (row.label if mark and joined[-1].label else "")
            joined[-1] = joined[-1]._replace(label=label, end=row.end)
        else:
            sound = any(map(str.isalnum, row.label)) and not mark
            before = stress if stress and sound else row._replace(label="")
            label = before.label + row.label if sound else ""
            joined.append(row._replace(label=label, start=before.start))
            stress = None
    return joined
