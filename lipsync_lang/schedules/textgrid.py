"""Praat TextGrid: what most aligners write.

Text files in the long and the short form, and TextGrid JSON. Binary ones are refused.
Time zero stays the zero of the sound: what comes before the first interval is silence, and so
are gaps and intervals without a label.

One tier must hold the phones. It is known by its name (`phones`, `MAU`, `Name - phones`, ...)
or, if no name says so, by its looks: many short labels, quickly one after the other. A tier of
words is used where there is one.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from statistics import median
from typing import Any

from lipsync_lang.errors import ScheduleError, did_you_mean
from lipsync_lang.schedules.registry import reader
from lipsync_lang.schedules.schedule import SILENCE, SNAP, Schedule, words_from_spans
from lipsync_lang.schedules.source import Source

Row = tuple[str, float, float]

PHONES = re.compile(r"(phon(e(me)?)?s?|segments?|mau|phonalign)", re.IGNORECASE)
"""Names of phone tiers: MFA, FAVE, Praat users; MAUS; SPPAS."""

WORDS = re.compile(r"(words?|tokens?|ort(-mau)?|tokensalign)", re.IGNORECASE)
"""Names of word tiers, of the same tools."""

SPEAKER = re.compile(r"(?:(?P<speaker>.*\S)\s+-\s+)?(?P<role>.*)", re.DOTALL)
"""Aligners put the speaker before the tier's name: `Name - phones`."""

NUMBER = re.compile(
    r"^([ \t]*(?:xmin|xmax|number)[ \t]*=[ \t]*)(-?\d[\d.]*(?:[eE][-+]?\d+)?)[ \t]*$", re.MULTILINE
)
"""A time in the long form, where praatio overlooks a minus and cannot read 1e-05."""

LONG_SIZE = re.compile(
    r"^[ \t]*(?:intervals|points)[ \t]*:[ \t]*size[ \t]*=[ \t]*(\d+)[ \t]*$", re.MULTILINE
)
SHORT_SIZE = re.compile(
    r'^[ \t]*"(?:IntervalTier|TextTier)"[ \t]*\n[ \t]*"(?:[^"]|"")*"[ \t]*\n.*\n.*\n[ \t]*(\d+)',
    re.MULTILINE,
)
"""How many intervals the file says a tier has: praatio takes what it finds."""


@dataclass(frozen=True)
class Tier:
    """One interval tier: rows of label, start and end in seconds."""

    name: str
    rows: tuple[Row, ...]

    @property
    def speaker(self) -> str:
        """Who speaks, where the name says so."""
        return _part(self.name, "speaker")

    @property
    def role(self) -> str:
        """The name without the speaker."""
        return _part(self.name, "role")

    @property
    def spoken(self) -> list[Row]:
        """The rows that have a label."""
        return [row for row in self.rows if row[0]]

    def looks_like_phones(self) -> bool:
        """Whether the labels are short, varied, and soon over."""
        labels = [label for label, _, _ in self.spoken]
        short = [label for label in labels if len(label) <= 4]  # noqa: PLR2004 letters and marks
        return (
            len(set(labels)) >= 4  # noqa: PLR2004 fewer is a tier of marks
            and len(short) >= 0.9 * len(labels)
            and not any(re.search(r"\s", label) for label in labels)
            and median(end - start for _, start, end in self.spoken) < 0.25  # noqa: PLR2004 seconds
        )


def looks(source: Source) -> bool:
    """Tell whether it says that it is Praat's."""
    start = source.head[:300]
    return "ooTextFile" in start or source.content.startswith(b"ooBinaryFile")


@reader("textgrid", ".textgrid", looks=looks)
def read_textgrid(source: Source) -> Schedule:
    """Praat TextGrid with a tier of phones; words are taken along where there is a tier of them."""
    return read_tier(source.path, source.content, source.tier)


def read_tier(path: Path, content: bytes, tier: str | None = None) -> Schedule:
    """Read one speaker's phones.

    `path` is for messages. `tier` names the phone tier, or a speaker who has one; with None
    there must be only one.
    """
    tiers = parse(path, text_of(path, content))
    phones = choose(path, tiers, tier)
    schedule = Schedule.from_intervals(without_gaps(phones.rows), source=str(path))
    words = [t for t in tiers if WORDS.fullmatch(t.role) and t.speaker == phones.speaker]
    if len(words) != 1:
        return schedule
    spans = words_from_spans(schedule, sorted(words[0].rows, key=lambda row: row[1:]))
    heard = [w for w in spans if set(schedule.labels[w.first : w.stop]) != {SILENCE}]
    return replace(schedule, words=tuple(heard))


def text_of(path: Path, content: bytes) -> str:
    """Decode a text TextGrid: UTF-8 or UTF-16, with a byte order mark or without."""
    if content.startswith(b"ooBinaryFile"):
        raise ScheduleError(f"{path}: is Praat's binary form; in Praat, use Save as text file")
    encoding = "utf-8-sig"
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        encoding = "utf-16"
    elif content[1:2] == b"\0":
        encoding = "utf-16-le"
    elif content[:1] == b"\0":
        encoding = "utf-16-be"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        raise ScheduleError(
            f"{path}: is not UTF-8 or UTF-16 text (byte {error.start}); in Praat, set Text writing "
            "preferences to UTF-8 and save the TextGrid again"
        ) from None
    return re.sub(r"\r\n?", "\n", text) + "\n"


def parse(path: Path, text: str) -> list[Tier]:
    """Return the interval tiers, in the file's order."""
    try:
        tiers = _praatio(NUMBER.sub(_plain, text))
        counts = [len(tier["entries"]) for tier in tiers]
        found = [
            Tier(str(tier["name"]).strip(), tuple(_row(*entry) for entry in tier["entries"]))
            for tier in tiers
            if tier["class"] == "IntervalTier"
        ]
    except _BelowZeroError as error:
        raise ScheduleError(
            f"{path}: has a time below 0 ({error} s); in Praat, shift the times to start at 0"
        ) from None
    except Exception:  # noqa: BLE001 praatio meets damage with whatever Python raises there
        raise ScheduleError(
            f"{path}: is not a sound TextGrid; open it in Praat and save it again as text"
        ) from None
    sizes = [int(size) for size in LONG_SIZE.findall(text) or SHORT_SIZE.findall(text)]
    if len(sizes) == len(counts) and sizes != counts:
        at = next(
            i for i, (size, count) in enumerate(zip(sizes, counts, strict=True)) if size != count
        )
        raise ScheduleError(
            f"{path}: tier {tiers[at]['name']!r} says it has {sizes[at]} intervals, but "
            f"{counts[at]} can be read; the file is cut off or damaged"
        )
    return found


def _praatio(text: str) -> list[dict[str, Any]]:
    from praatio.utilities.textgrid_io import parseTextgridStr

    tiers: list[dict[str, Any]] = parseTextgridStr(text, includeEmptyIntervals=True)["tiers"]
    return tiers


class _BelowZeroError(Exception):
    """A time before the sound."""


def _plain(number: re.Match[str]) -> str:
    head, value = number.groups()
    if value.startswith("-") or "e" in value.lower():
        return f"{head}{_time(value):.12f}"
    return f"{head}{value}"


def _row(start: str | float, end: str | float, label: str) -> Row:
    return str(label).strip(), _time(start), _time(end)


def _time(value: str | float) -> float:
    seconds = float(value)
    if not isfinite(seconds):
        raise ValueError(seconds)
    if seconds < -SNAP:
        raise _BelowZeroError(seconds)
    return max(0.0, seconds)


def _part(name: str, group: str) -> str:
    match = SPEAKER.fullmatch(name)
    return ((match and match[group]) or "").strip()


def choose(path: Path, tiers: Sequence[Tier], wanted: str | None = None) -> Tier:
    """Return the one tier that holds the phones."""
    if wanted is not None:
        return _named(path, tiers, wanted)
    named = [tier for tier in tiers if PHONES.fullmatch(tier.role)]
    found = [tier for tier in named if tier.spoken] or named
    found = found or [tier for tier in tiers if tier.looks_like_phones()]
    if not found:
        raise ScheduleError(
            f"{path}: no tier looks like phones; there is {_list(tiers)}. Name the tier of phones "
            "'phones', or align the file first"
        )
    if len(found) > 1:
        raise ScheduleError(
            f"{path}: {len(found)} tiers look like phones: {_list(found)}. Keep one of them in the "
            "file, one file for each speaker"
        )
    return found[0]


def _named(path: Path, tiers: Sequence[Tier], wanted: str) -> Tier:
    found = [tier for tier in tiers if tier.name == wanted] or [
        tier for tier in tiers if tier.speaker == wanted and PHONES.fullmatch(tier.role)
    ]
    if len(found) == 1:
        return found[0]
    if found:
        raise ScheduleError(f"{path}: {len(found)} tiers are called {wanted!r}; rename all but one")
    raise ScheduleError(
        f"{path}: no tier is called {wanted!r}; {did_you_mean(wanted, [t.name for t in tiers])}"
    )


def _list(tiers: Iterable[Tier]) -> str:
    names = [repr(tier.name) for tier in tiers]
    return ", ".join(names) if names else "no interval tier at all"


def without_gaps(rows: Iterable[Row]) -> list[Row]:
    """Fill gaps, and the time from zero on, with silence; drop blanks that are only rounding."""
    filled: list[Row] = []
    end = 0.0
    for label, start, stop in sorted(rows, key=lambda row: row[1:]):
        if not label and stop - start < SNAP:
            continue
        if start > end + SNAP:
            _append(filled, SILENCE, end, start)
        _append(filled, label or SILENCE, start if filled else 0.0, stop)
        end = stop
    return filled


def _append(rows: list[Row], label: str, start: float, stop: float) -> None:
    if rows and rows[-1][0] == label == SILENCE and abs(start - rows[-1][2]) <= SNAP:
        start = rows.pop()[1]
    rows.append((label, start, stop))
