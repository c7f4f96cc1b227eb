"""Subtitles as timings: SubRip (`.srt`) and WebVTT (`.vtt`).

A cue is timed as a whole, or in WebVTT word by word (``hello<00:00:01.500> world``). Cues of one
speaker (``<v Ann>``) are asked for by name where there are several. Captions that roll, as of
YouTube, repeat the row before; the repetition is left out.
"""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import NamedTuple

from lipsync_lang.base.errors import shortlist
from lipsync_lang.schedules import LabelRow, TimingFile, Timings, reader
from lipsync_lang.schedules.tiers import MAX_NAMES, read_speakers

CLOCK = r"(?:\d{1,9}:)?\d\d?:\d\d[.,]\d{1,9}"

CUE_TIMES = re.compile(rf"\s*({CLOCK})\s*-->\s*({CLOCK})", re.ASCII)
"""The row above a cue's text."""

STAMP = re.compile(rf"<({CLOCK})>", re.ASCII)
"""The time at which the next word of a cue starts."""

VOICE = re.compile(r"<v(?:\.[^\s<>]*+)?\s++([^<>]++)>")
"""The speaker of a cue."""

CUE_TAG = re.compile(r"<[^<>]*>|\{\\[^{}]*\}")
"""Styles, in WebVTT and in SubRip."""

DASH = re.compile(r"^\s*[-–]\s*")
"""The start of a row in a dialogue."""

CALLER = re.compile(r"^(\s*(?:<[^<>]*>)*)([^:<>]{2,30}):((?:</[^<>]*>)*)\s+(?=\S)")
"""The speaker before a row, in subtitles for the deaf; in capitals, before a text that is not."""

CUE_ASIDE = re.compile(r"(WEBVTT|NOTE|STYLE|REGION)\b")


class Cue(NamedTuple):
    """The rows of a cue with their lines in the file, its name, and its times as written.

    `times` is None for rows that an empty line parts from their cue.
    """

    rows: list[tuple[int, str]]
    name: str
    times: tuple[str, str] | None


def cues(numbered: Iterable[tuple[int, str]]) -> Iterator[Cue]:
    """Yield the cues of a file's numbered rows; comments and styles are left out."""
    found = False
    for blank, rows in groupby(numbered, key=lambda row: not row[1].strip()):
        if blank:
            continue
        part = list(rows)
        at = next((i for i, (_, text) in enumerate(part) if CUE_TIMES.match(text)), None)
        if at is None:
            if found and not CUE_ASIDE.match(part[0][1]):
                yield Cue(part, "", None)
            continue
        found = True
        times = CUE_TIMES.match(part[at][1])
        start, end = times.groups() if times else ("", "")
        yield Cue(part[at + 1 :], part[at - 1][1].strip() if at else "", (start, end))


def joined(rows: list[tuple[int, str]]) -> str:
    """Return the text of rows, without the dashes of a dialogue and the names before rows."""
    return " ".join(_called(DASH.sub("", text))[1] for _, text in rows)


def speaker_of(rows: list[tuple[int, str]]) -> str:
    """Return the first speaker that a cue names, by a tag or before a row; may be empty."""
    voice = VOICE.search(" ".join(text for _, text in rows))
    names = (_called(DASH.sub("", text))[0] for _, text in rows)
    return voice[1].strip() if voice else next(filter(None, names), "")


def _called(row: str) -> tuple[str, str]:
    """Part a row into the name before it, which may be empty, and the rest."""
    found = CALLER.match(row)
    if found is None or not found[2].isupper() or row[found.end() :].isupper():
        return "", row
    return found[2].strip(), found[1] + found[3] + row[found.end() :]


def sniff(source: TimingFile) -> bool:
    """Return True if a row has the times of a cue."""
    return any(CUE_TIMES.match(row) for row in source.head.split("\n"))


@reader("subtitles", ".srt", ".vtt", sniff=sniff, tiers=True, script=True)
def read_subtitles(source: TimingFile) -> Timings:
    """Subtitles, SubRip and WebVTT: words or whole cues with their times, of one speaker."""
    rolling = STAMP.search(source.text) is not None
    speakers: defaultdict[str, list[LabelRow]] = defaultdict(list)
    before: set[str] = set()
    repeated = 0
    called: dict[str, None] = {}
    for rows, times in _whole(source):
        line = rows[0][0]
        start, end = (_seconds(source, one, line) for one in times)
        # captions that roll show each row twice: below when it is said, and above after that
        fresh = [row for row in rows if not (rolling and _plain(row[1]) in before)]
        before = {_plain(text) for _, text in rows}
        repeated += len(rows) - len(fresh)
        text = joined(fresh)
        called |= dict.fromkeys(name for _, row in fresh if (name := _called(DASH.sub("", row))[0]))
        first, *rest = STAMP.split(text)
        starts = [start, *(_seconds(source, stamp, line) for stamp in rest[::2])]
        spans = zip([first, *rest[1::2]], starts, [*starts[1:], end], strict=True)
        voice = VOICE.search(text)
        speakers[voice[1].strip() if voice else ""] += [
            LabelRow(label, begins, ends, line)
            for said, begins, ends in spans
            if (label := _plain(said))
        ]
    told = []
    if repeated:
        told.append(f"{source.path}: rows that repeat the previous cue are left out: {repeated}")
    if called:
        told.append(
            f"{source.path}: names before rows are not said: {shortlist(called, MAX_NAMES)}"
        )
    return read_speakers(source, speakers, told)


def _whole(source: TimingFile) -> Iterator[tuple[list[tuple[int, str]], tuple[str, str]]]:
    """Yield the rows of each cue, also those after an empty line, and its times."""
    whole: list[tuple[list[tuple[int, str]], tuple[str, str]]] = []
    for cue in cues(enumerate(source.text.split("\n"), 1)):
        if cue.times is not None:
            whole.append(([], cue.times))
        whole[-1][0].extend(cue.rows)  # the first cue has times
    return ((rows, times) for rows, times in whole if rows)


def _plain(text: str) -> str:
    from html import unescape

    return " ".join(unescape(CUE_TAG.sub("", text)).split())


def _seconds(source: TimingFile, clock: str, line: int | None) -> float:
    *larger, seconds = clock.replace(",", ".").split(":")
    minutes = sum(int(part) * 60**place for place, part in enumerate(reversed(larger)))
    return source.number(minutes * 60 + float(seconds), line)
