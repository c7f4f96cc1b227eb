"""ElevenLabs: the times of characters that come with its speech, as JSON.

An answer has an `alignment` with characters, their starts, and their ends in seconds or durations
in milliseconds. Answers of a stream are in one list, or one on each line. Characters between spaces
make a word.
"""

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from lipsync_lang.schedules.timed_words import TimedWord, TimedWords, timed_words_of
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import reader

MILLISECONDS_PER_SECOND = 1000.0

STARTS = re.compile(r'"char(acter)?_?start_?times?_?\w{2,7}"\s*:', re.IGNORECASE)
"""The name of the list of starts, which ends with its unit."""

FORM = (
    '{"alignment": {"characters": ["H", "i"], "character_start_times_seconds": [0.0, 0.1], '
    '"character_end_times_seconds": [0.1, 0.3]}}'
)

CONTAINERS = ("alignment", "normalizedalignment")
"""Fields that hold times, the better one first: the other's numbers are written out."""


class TimedCharacter(NamedTuple):
    """A character with its start and end, in the file's unit."""

    text: str
    start: float
    end: float


def sniff(source: TimingFile) -> bool:
    """Return True if the file names starts of characters, at its start or within an alignment."""
    if STARTS.search(source.head):
        return True
    whole = source.document
    first = whole[0] if isinstance(whole, list) and whole else whole
    held = [_plain(_plain(first).get(name)) for name in CONTAINERS]
    return any(times.keys() & {"characters", "chars"} for times in held)


@reader("elevenlabs", ".json", ".jsonl", sniff=sniff)
def read_elevenlabs(source: TimingFile) -> TimedWords:
    """Times of characters that ElevenLabs gives with its speech, joined to words."""
    words: list[TimedWord] = []
    spelled: list[TimedCharacter] = []
    rate, latest = None, 0.0
    for line, letters, times in _answers(source):
        rate = MILLISECONDS_PER_SECOND if "charstarttimesms" in times else None
        for one in _timed(source, letters, times, line):
            if one.start < latest:
                raise source.fault(f"{one.text!r} starts before the character before it", line)
            latest = one.start
            if not one.text.isspace():
                spelled.append(one)
            elif spelled:
                words.append(_word(spelled))
                spelled = []
    if spelled:
        words.append(_word(spelled))
    return timed_words_of(source, words, rate=rate)


def _word(spelled: list[TimedCharacter]) -> TimedWord:
    text = "".join(one.text for one in spelled)
    return TimedWord(text, spelled[0].start, spelled[-1].end)


def _answers(source: TimingFile) -> Iterator[tuple[int | None, object, dict[str, Any]]]:
    """Yield the line, the characters and the fields with times of each answer that has any."""
    for line, answer in source.events:
        plain = _plain(answer)
        held = next((plain[name] for name in CONTAINERS if plain.get(name)), plain)
        times = {re.sub("^character", "char", name): one for name, one in _plain(held).items()}
        letters = times.get("chars")
        if letters is not None:  # an answer without times ends a stream
            yield line, letters, times


def _timed(
    source: TimingFile, letters: object, times: dict[str, Any], line: int | None
) -> Iterator[TimedCharacter]:
    """Yield the characters of an answer, whose lists have one item for each."""
    columns = {
        part: next((one for name, one in times.items() if name.startswith(f"char{part}")), None)
        for part in ("start", "end", "duration")
    }
    lists = [one for one in (letters, *columns.values()) if isinstance(one, list)]
    if len(lists) != 3 or len({len(one) for one in lists}) != 1:  # noqa: PLR2004 text and two times
        raise source.fault(f"needs three lists of one length; the form is {FORM}", line)
    for text, first, second in zip(*lists, strict=True):
        start, end = source.number(first, line), source.number(second, line)
        yield TimedCharacter(str(text), start, end if columns["duration"] is None else start + end)


def _plain(whole: object) -> dict[str, Any]:
    """Return an object with one spelling of its names."""
    fields = whole if isinstance(whole, dict) else {}
    return {name.replace("_", "").lower(): value for name, value in fields.items()}
