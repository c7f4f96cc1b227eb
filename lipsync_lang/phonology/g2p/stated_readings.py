"""Readings of characters that a pack states, syllable by syllable.

A reading counts where its letters are whole words of the text, and what its contexts demand stands
around them.
"""

from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import NamedTuple

from lipsync_lang.errors import SpeechError
from lipsync_lang.phonology.g2p.contexts import ContextError, Surroundings
from lipsync_lang.phonology.g2p.g2p_engines import Rule


class StatedReading(NamedTuple):
    """A stated reading: its letters, their syllables, and what must stand around them."""

    letters: str
    syllables: tuple[str, ...]
    around: Surroundings

    def spans(self, text: str) -> Iterator[tuple[int, int]]:
        """Yield where it applies in a text."""
        at = text.find(self.letters)
        while at >= 0:
            stop = at + len(self.letters)
            if self.around.fit(text, at, stop):
                yield at, stop
            at = text.find(self.letters, at + 1)


def compiled_readings(readings: Sequence[Rule]) -> tuple[StatedReading, ...]:
    """Compile the readings of a pack.

    Raises
    ------
    SpeechError
        A context cannot be used, or a reading has not one syllable for each character.
    """
    made: list[StatedReading] = []
    for number, rule in enumerate(readings, start=1):
        if len(rule.to) != len(rule.spelling):
            raise SpeechError(
                f"reading {number} ('{rule.spelling}') has {len(rule.to)} syllables for "
                f"{len(rule.spelling)} characters; state one for each"
            )
        try:
            around = Surroundings.compiled(rule.before, rule.after)
        except ContextError as error:
            raise SpeechError(f"reading {number} ('{rule.spelling}'): {error}") from None
        made.append(StatedReading(rule.spelling, rule.to, around))
    return tuple(made)


def stated_syllables(
    text: str, phrases: Sequence[str], readings: Sequence[StatedReading]
) -> dict[int, str]:
    """Return the stated syllable of each character that has one, by its place."""
    ends = {0, *accumulate(map(len, phrases))}
    found: dict[int, str] = {}
    for reading in readings:
        for start, stop in reading.spans(text):
            if {start, stop} <= ends and start not in found:
                found |= dict(zip(range(start, stop), reading.syllables, strict=True))
    return found
