"""Recognised words in stretches between pauses, and one schedule from the alignments of stretches.

Each stretch is aligned apart, so that a word that was not said misplaces its stretch alone.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, zip_longest
from typing import NamedTuple

import numpy as np

from lipsync_lang.schedules.schedule import SILENCE, SNAP_SECONDS, Audio, Schedule, Word

STRETCH_PAUSE_SECONDS = 0.3
"""Shortest pause between stretches; recognisers place words to within 0.1 s."""

STRETCH_MARGIN_SECONDS = 0.5
"""Sound before and after the words of a stretch, for words placed too late or too early."""

QUIET_SECONDS = 0.05
"""Window of the loudness measure."""

QUIET_SHARE = 0.1
"""Loudness of the quietest moment of a pause, at most, as a share of the words' own."""


class RecognisedWord(NamedTuple):
    """A word of a recogniser: its text as written, its time in seconds, and its probability.

    A space in front of the text separates it from the word before.
    """

    text: str
    start: float
    end: float
    chance: float


class Stretch(NamedTuple):
    """Words between two pauses, and the part of the sound that holds them, in seconds."""

    words: tuple[RecognisedWord, ...]
    start: float
    stop: float

    @property
    def text(self) -> str:
        """The words as written."""
        return "".join(word.text for word in self.words).strip()


def stretches(words: Sequence[RecognisedWord], audio: Audio) -> list[Stretch]:
    """Divide words at their pauses, each cut at the quietest moment of a pause."""
    if not words:
        return []
    groups, cuts = [[words[0]]], []
    window = round(QUIET_SECONDS * audio.rate)
    for before, word in pairwise(words):
        first, last, stop = (round(at * audio.rate) for at in (before.end, word.start, word.end))
        # A word without length is not where it was placed: the aligner looks for it.
        if word.start - before.end < STRETCH_PAUSE_SECONDS or word.end <= word.start:
            groups[-1].append(word)
            continue
        spoken = audio.samples[round(before.start * audio.rate) : stop].astype(np.float64)
        # Energy of each window as the difference of running sums; float64, as squares of int16
        # overflow.
        energy = np.cumsum(np.square(audio.samples[first:last].astype(np.float64)))
        moments = energy[window:] - energy[:-window]
        if moments.min() > QUIET_SHARE * window * np.square(spoken).mean():
            groups[-1].append(word)
        else:
            groups.append([word])
            cuts.append((first + int(moments.argmin()) + window / 2) / audio.rate)
    edges = [0.0, *cuts, audio.seconds]
    return [
        Stretch(
            tuple(group),
            max(before, group[0].start - STRETCH_MARGIN_SECONDS),
            min(after, group[-1].end + STRETCH_MARGIN_SECONDS),
        )
        for group, before, after in zip(groups, edges[:-1], edges[1:], strict=True)
    ]


def part(audio: Audio, stretch: Stretch) -> Audio:
    """Return the sound of a stretch."""
    first, stop = (round(seconds * audio.rate) for seconds in (stretch.start, stretch.stop))
    return replace(audio, samples=audio.samples[first:stop])


def joined(pieces: Sequence[tuple[float, Schedule]], audio: Audio) -> Schedule:
    """Return one schedule from those of stretches, with silence between them.

    Parameters
    ----------
    pieces : start of each stretch in seconds, and its schedule, in order; at least one
    audio : the whole sound

    Returns
    -------
    The first schedule with the labels, words and stress of all, from 0 s to the end of the sound
    """
    rows: list[tuple[str, float, int | None]] = []
    words: list[Word] = []
    end = 0.0
    for offset, one in pieces:
        if offset - end > SNAP_SECONDS:
            _add(rows, SILENCE, end)
        places = [
            _add(rows, label, offset + start, mark)
            for label, start, mark in zip_longest(one.labels, one.times[:-1].tolist(), one.stress)
        ]
        words += [
            replace(word, first=places[word.first], stop=places[word.stop - 1] + 1)
            for word in one.words
        ]
        end = offset + one.end
    if audio.seconds - end > SNAP_SECONDS:
        _add(rows, SILENCE, end)
    labels, starts, marks = zip(*rows, strict=True)
    return replace(
        pieces[0][1],
        labels=labels,
        times=np.array([0.0, *starts[1:], audio.seconds]),
        words=tuple(words),
        stress=marks if any(mark is not None for mark in marks) else (),
        audio=audio,
    )


def _add(
    rows: list[tuple[str, float, int | None]], label: str, start: float, mark: int | None = None
) -> int:
    """Append a label, adjacent silences as one; return its index."""
    if not rows or (label, rows[-1][0]) != (SILENCE, SILENCE):
        rows.append((label, start, mark))
    return len(rows) - 1
