"""Conversion of aligned phonemes to schedules, shared by aligner and recogniser."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lipsync_lang.errors import shortlist
from lipsync_lang.schedules.schedule import SILENCE, Audio, Word
from lipsync_lang.speech.sound import resampled
from lipsync_lang.speech.sphinx.acoustic_model import OUTSIDE
from lipsync_lang.speech.sphinx.features import FRAME, RATE, WINDOW, Floats
from lipsync_lang.speech.sphinx.forced import HeardPhoneme
from lipsync_lang.speech.sphinx.sureness import HURRIED, word_confidence

if TYPE_CHECKING:
    from lipsync_lang.speech.sphinx.folder import Models

LOUD = 16_000.0
"""Peak amplitude after normalisation, for independence from loudness."""

HISS = 3.0
"""Standard deviation of added noise, so that digital silence has the features of silence."""

CENTRE = (WINDOW / RATE - FRAME) / 2
"""Offset in seconds from a frame's start to the middle of its window."""

PAUSE = 0.06
"""Minimum pause in seconds; a shorter silence is the closure of the next sound."""

UNLIKE = -5.0
"""Fit limit; a lower value means a mismatch of phoneme and sound."""

LASTING = 0.5
"""Minimum seconds of sound without text for a remark."""

TELLING = 3
"""Minimum phonemes of a word for a remark; shorter words are often reduced in normal speech."""

SHOWN = 5
"""Maximum number of places in one remark."""


class Saying(NamedTuple):
    """A word in its own spelling, with pronunciations as phoneme numbers.

    `spelled` are the labels of its one pronunciation, each with its number of phonemes; without
    it, the model's own names are the labels.
    """

    text: str
    ways: tuple[tuple[int, ...], ...]
    spelled: tuple[tuple[str, int], ...] = ()


def prepared(audio: Audio) -> Floats:
    """Prepare a sound for feature extraction: `RATE`, normalised peak, added noise."""
    samples = resampled(audio, RATE).samples.astype(np.float64)
    peak = np.abs(samples).max(initial=0.0)
    noise = np.random.default_rng(0).normal(0.0, HISS, len(samples))
    scaled: Floats = samples * (LOUD / peak if peak > 0 else 1.0) + noise
    return scaled


def confidence(models: "Models", heard: Sequence[HeardPhoneme]) -> float:
    """Return the share of word phonemes with a good fit and more than minimum duration."""
    said = [one for one in heard if one.phone not in models.quiet]
    return sum(map(_borne_out, said)) / len(said) if said else 0.0


def _borne_out(one: HeardPhoneme) -> bool:
    return one.word != OUTSIDE and one.fit > UNLIKE and one.stop - one.first > HURRIED


class Laid(NamedTuple):
    """Labels with boundaries in seconds, and the words they belong to."""

    labels: tuple[str, ...]
    times: Floats
    words: tuple[Word, ...]


def laid(
    models: "Models", heard: Sequence[HeardPhoneme], sayings: Sequence[Saying], seconds: float
) -> Laid:
    """Convert phonemes to labels from 0 to the end of the sound, with adjacent pauses merged."""
    rows: list[tuple[str, int, float]] = []
    spelled = {number: _spelled(one) for number, one in enumerate(sayings) if one.spelled}
    for one in heard:
        label = SILENCE if one.phone in models.quiet else models.model.names[one.phone]
        if label != SILENCE and one.word in spelled:
            label = next(spelled[one.word])
            if not label:  # another phoneme of the label before
                continue
        if label != SILENCE or not rows or rows[-1][0] != SILENCE:
            rows.append((label, one.word, one.first * FRAME + CENTRE))
    starts = [0.0, *(start for _, _, start in rows[1:]), seconds]
    kept = [
        n
        for n, (label, _, _) in enumerate(rows)
        if label != SILENCE or n in (0, len(rows) - 1) or starts[n + 1] - starts[n] >= PAUSE
    ]
    labels = tuple(rows[n][0] for n in kept)
    # dropped silences are merged into the next sound
    times = [0.0, *(starts[before + 1] for before in kept[:-1]), seconds]
    owners = [rows[n][1] if rows[n][0] != SILENCE else OUTSIDE for n in kept]
    found = _by_word(heard)
    words = []
    for number, saying in enumerate(sayings):
        own = [n for n, owner in enumerate(owners) if owner == number]
        if own:
            sure = word_confidence(found[number])
            words.append(Word(saying.text, own[0], own[-1] + 1, confidence=sure))
    return Laid(labels, np.array(times), tuple(words))


def _by_word(heard: Sequence[HeardPhoneme]) -> dict[int, list[HeardPhoneme]]:
    words: dict[int, list[HeardPhoneme]] = {}
    for one in heard:
        words.setdefault(one.word, []).append(one)
    return words


def _spelled(saying: Saying) -> Iterator[str]:
    """Yield the label of each phoneme of a word; nothing where it belongs to the label before."""
    for label, count in saying.spelled:
        yield from (label, *[""] * (count - 1))


def doubts(heard: Sequence[HeardPhoneme], sayings: Sequence[Saying]) -> list[str]:
    """Describe mismatches of sound and text in messages."""
    remarks: list[str] = []
    others = [
        f"{one.first * FRAME:.1f} to {one.stop * FRAME:.1f} s"
        for one in heard
        if one.word == one.phone == OUTSIDE and (one.stop - one.first) * FRAME >= LASTING
    ]
    if others:
        remarks.append(f"sound without text: {listed(others)}")
    said = _by_word(heard)
    absent: list[str] = []
    unlike: list[str] = []
    for number, saying in enumerate(sayings):
        own = said.get(number, [])
        place = f"'{saying.text}' at {own[0].first * FRAME:.1f} s" if own else ""
        if any(one.phone == OUTSIDE for one in own):
            absent.append(place)
        elif len(own) >= TELLING and not any(map(_borne_out, own)):
            unlike.append(place)
    if absent:
        remarks.append(f"words that are not spoken are left out: {listed(absent)}")
    if unlike:
        remarks.append(f"words that were not recognised: {listed(unlike)}")
    return remarks


def listed(places: Sequence[str]) -> str:
    """List the first places in a remark, and the number of the others."""
    return shortlist(places, SHOWN)
