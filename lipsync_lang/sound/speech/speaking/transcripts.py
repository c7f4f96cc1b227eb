"""Transcripts: the phonemes of a text, in the labels of its language, before they have times."""

from dataclasses import dataclass

from lipsync_lang.text.phonology.g2p import SpokenWord


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
    def stress(self) -> tuple[int | None, ...]:
        """The stress of each label, as in a schedule; empty if no word states any."""
        if not any(word.stress for word in self.words):
            return ()
        return tuple(
            mark for word in self.words for mark in word.stress or (None,) * len(word.labels)
        )
