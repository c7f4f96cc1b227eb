"""Texts as they are read, and transcripts: their phonemes, before they have times."""

from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np

from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule
from lipsync_lang.text.phonology.emphasis import touched
from lipsync_lang.text.phonology.g2p import SpokenWord
from lipsync_lang.text.phonology.manner import Manner

MAX_SHOWN_CHARS = 60
"""Characters of a text in a remark."""


class SureText(str):
    """A text with the offsets of passages that are surely spoken: a writer emphasised them."""

    __slots__ = ("spans",)

    spans: tuple[tuple[int, int], ...]

    def __new__(cls, text: str, spans: tuple[tuple[int, int], ...]) -> Self:
        """Return a text with passages."""
        one = super().__new__(cls, text)
        one.spans = spans
        return one


class WrittenText(NamedTuple):
    """A text as it is read: the spoken part of what was written.

    Parameters
    ----------
    text : without markup, in the letters that the language's engine knows
    spans : offsets of the passages with emphasis
    dropped : markup that is not spoken, in order
    remarks : doubts about the markup
    """

    text: str
    spans: tuple[tuple[int, int], ...] = ()
    dropped: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def silent(self) -> bool:
        """True for a text of markup and punctuation alone, so that there is nothing to say."""
        if any(map(str.isalnum, self.text)):
            return False
        signs = any(c.isprintable() and not c.isspace() for c in self.text)
        return signs or bool(self.dropped and not self.text)  # an empty text is a mistake


def as_written(text: WrittenText, schedule: Schedule) -> Schedule:
    """Add to a schedule the emphasis of its text, and the markup that is not spoken."""
    words = schedule.words
    if text.spans:
        marked = touched((word.text for word in words), text.text, text.spans)
        words = tuple(
            replace(word, emphasis=float(one)) for word, one in zip(words, marked, strict=True)
        )
    elif not (text.dropped or text.remarks):
        return schedule
    remarks = (*schedule.remarks, *text.remarks)
    return replace(schedule, words=words, dropped=text.dropped, remarks=remarks)


def silent(text: WrittenText, manner: Manner, audio: Audio | None = None) -> Schedule:
    """Return a schedule of silence, as long as the sound if there is one."""
    seconds = manner.durations["silence"] if audio is None else audio.seconds
    wordless = f"'{text.text[:MAX_SHOWN_CHARS]}' has no letter or digit, so the mouth rests"
    rest = Schedule(
        (SILENCE,),
        np.array([0.0, seconds]),
        notation=manner.notation or None,
        language=manner.language,
        estimated=audio is None,
        audio=audio,
        remarks=(wordless,) if text.text else (),
    )
    return as_written(text, rest)


@dataclass(frozen=True)
class Transcript:
    """Phonemes of a text before timing.

    Parameters
    ----------
    text : the spoken part of the input
    language : the pack's name
    notation : notation of the word labels
    words : words and pauses in order
    phonemes : common phonemes, pauses as silence; the pack's own words in their custom form
    unmapped : labels outside the notation, in order, without duplicates
    unread : characters unreadable by the engine, in order, without duplicates
    gaps : indices in `phonemes` before which an unmapped or unread item is missing
    dropped : markup of the input that is not spoken, in order
    remarks : doubts about the markup
    advice : how to have read what was unread, if the pack says it in a file
    """

    text: str
    language: str
    notation: str
    words: tuple[SpokenWord, ...]
    phonemes: tuple[str, ...] = ()
    unmapped: tuple[str, ...] = ()
    unread: tuple[str, ...] = ()
    gaps: tuple[int, ...] = ()
    dropped: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    advice: tuple[str, ...] = ()

    @property
    def labels(self) -> tuple[str, ...]:
        """All phonemes in order, without pauses."""
        return tuple(label for word in self.words for label in word.labels)

    @property
    def labels_with_pauses(self) -> list[str]:
        """All phonemes in order, and silence for each pause."""
        return [label for word in self.words for label in word.labels or (SILENCE,)]

    @property
    def stress(self) -> tuple[int | None, ...]:
        """The stress of each label, as in a schedule; empty if no word states any."""
        if not any(word.stress for word in self.words):
            return ()
        return tuple(
            mark for word in self.words for mark in word.stress or (None,) * len(word.labels)
        )
