"""Words with times, but without phonemes, from recognisers, subtitles and word tiers.

A reader of timings returns `TimedWords` in place of a schedule if its file times words alone. The
phonemes within each word depend on the language: `speech.filling` adds them.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from operator import attrgetter
from unicodedata import category

from lipsync_lang.schedules.rows import (
    ROUNDING_SECONDS,
    LabelRow,
    Overlaps,
    check_span,
    guessed_rate,
    is_pause,
    overlap,
    without_length,
)
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.schedules.timing_file import TimingFile

TYPICAL_WORD_SECONDS = 0.3

LONG_WORD_SECONDS = 30.0
"""Longest plausible median duration in seconds, of words and cues; longer is another unit."""

SILENT_WORD = re.compile(
    r"!\w+|sil[be]?|sil_\w|sp|spn|pau|<[^>]*>|\[[^]]*]|\{[^}]*}|ipu_\d+|[^\w<\[{&%$€£=]+",
    re.IGNORECASE,
)
"""Marks of silence and noise among words, punctuation alone, and the names of SPPAS's units."""

SPEECH_TAG = re.compile(r"</?[A-Za-z][^<>]{0,200}>")
"""Markup of a text for a voice, which services repeat among the words: ``<break time="1s"/>``."""

UNIT_NAME = re.compile(r"^\s*ipu_\d+\s+")
"""The name of SPPAS's unit before its text."""

MAX_PHONE_LETTERS = 3
"""Maximum letters of a usual label of a phone; words have more."""

WORD_SCRIPTS = (("\u3400", "\u9fff"), ("\uac00", "\ud7a3"))
"""First and last letters of Han and of Hangul syllables, which never label phones."""


@dataclass(frozen=True)
class TimedWord:
    """A word, or several with one pair of times, such as the text of a subtitle."""

    text: str
    start: float
    end: float
    confidence: float | None = None
    """Probability that it is said there, in [0, 1]; None if unknown."""
    line: int | None = None
    """Its line in the file, for messages."""


@dataclass(frozen=True)
class TimedWords:
    """Words in order of time, not overlapping, each with a length; the rest is silence."""

    words: tuple[TimedWord, ...]
    """At least one; times in seconds, from 0 on."""
    source: str
    """Name of the file in messages."""
    remarks: tuple[str, ...] = ()
    """Doubts about the file."""

    @property
    def text(self) -> str:
        """The words with spaces between them."""
        return " ".join(word.text for word in self.words)


def are_words(labels: Iterable[str]) -> bool:
    """Return True if labels are too long for phones, or in a script that has words alone."""
    from statistics import median

    counts = [found for found in map(_letters, labels) if found is not None]
    return bool(counts) and median(counts) > MAX_PHONE_LETTERS


@lru_cache(maxsize=4096)  # lines share their phones
def _letters(label: str) -> int | None:
    """Return the letters of a label, many for a word without letters of phones; None for noise."""
    label = label.strip()
    if not label or SILENT_WORD.fullmatch(label):
        return None
    # Signs of length, breath and tone are no letters.
    letters = [c for c in label if c.isalpha() and category(c) != "Lm"]
    is_word = any(first <= c <= last for c in letters for first, last in WORD_SCRIPTS)
    return MAX_PHONE_LETTERS + 1 if is_word else len(letters)


def words_without_phonemes(schedule: Schedule) -> list[int]:
    """Return the numbers of words that have labels of noise alone, as an aligner gives them."""
    spans = [schedule.labels[word.first : word.stop] for word in schedule.words]
    return [
        number
        for number, (word, span) in enumerate(zip(schedule.words, spans, strict=True))
        if SILENCE not in span and all(map(is_pause, span)) and not SILENT_WORD.fullmatch(word.text)
    ]


def timed_words_of(
    source: TimingFile,
    words: Iterable[LabelRow],
    *,
    rate: float | None = None,
    guess: bool = False,
    remarks: Iterable[str] = (),
) -> TimedWords:
    """Make timed words of the words of a file, in any order, without marks of silence.

    A word without length shares the time of its neighbour, as recognisers give such times to short
    words. Neighbours that overlap by no more than `OVERLAP_SECONDS` meet in the middle. Raises
    ScheduleError if no word is left; or a time is below zero, runs backwards or overlaps another.
    The `rate` of the source, if given, overrides that of the format: units per second of all times,
    None for seconds. `guess` guesses the unit of a format that does not state one, and adds a
    remark.
    """
    named = [
        row._replace(label=" ".join(UNIT_NAME.sub("", row.label, count=1).split())) for row in words
    ]
    spoken = [
        row for row in _without_tags(named) if row.label and not SILENT_WORD.fullmatch(row.label)
    ]
    found = sorted(spoken, key=attrgetter("start", "end"))
    if not found:
        raise source.fault("has no words; check that the file is complete")
    rate, told = source.rate or rate, tuple(remarks)
    if rate is None and guess:
        usual = TYPICAL_WORD_SECONDS, LONG_WORD_SECONDS
        rate, guessed = guessed_rate(source, found, "words", *usual)
        told += guessed
    if rate is not None:
        found = [row._replace(start=row.start / rate, end=row.end / rate) for row in found]
    overlaps = Overlaps(source)
    timed = [
        TimedWord(row.label, row.start, row.end, row.confidence, row.line)
        for row in _parted(source, found, overlaps)
    ]
    return TimedWords(tuple(timed), str(source.path), (*told, *overlaps.remarks()))


def _without_tags(words: list[LabelRow]) -> list[LabelRow]:
    """Return words without markup, which may be split at its spaces over several of them."""
    if not words:
        return []
    # Each line end within a tag stays, so that every word keeps its label.
    text = SPEECH_TAG.sub(
        lambda tag: "\n" * tag[0].count("\n") or " ", "\n".join(row.label for row in words)
    )
    labels = (" ".join(label.split()) for label in text.split("\n"))
    return [row._replace(label=label) for row, label in zip(words, labels, strict=True)]


def _parted(source: TimingFile, words: list[LabelRow], overlaps: Overlaps) -> list[LabelRow]:
    """Close overlaps due to rounding; a word without length joins its nearer neighbour."""
    parted: list[LabelRow] = []
    texts: list[list[str]] = [[]]
    waiting: list[LabelRow] = []  # words without length, until the next with one
    for word in words:
        check_span(source, word)
        before = parted[-1] if parted else None
        start = max(word.start, 0.0)
        if before is not None and start < before.end:
            longer = start < before.end - ROUNDING_SECONDS and word.end > word.start
            if longer and not overlaps.parts(word, before):
                raise overlap(source, word, before)
            start = max((start + before.end) / 2, before.start)
            if word.end > start > before.start:
                parted[-1] = before._replace(end=start)
        if word.end <= start:
            waiting.append(word)
            continue
        late = [z for z in waiting if before is None or start - z.start < z.start - before.end]
        texts[-1] += [one.label for one in waiting[: len(waiting) - len(late)]]
        parted.append(word._replace(start=start))
        texts.append([*(one.label for one in late), word.label])
        waiting = []
    if not parted:
        raise without_length(source, waiting[-1])
    texts[-1] += [one.label for one in waiting]
    return [row._replace(label=" ".join(said)) for row, said in zip(parted, texts[1:], strict=True)]
