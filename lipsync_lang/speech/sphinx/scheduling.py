"""From sound and words to a schedule, through a model: what aligning and recognising share."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lipsync_lang.schedules.schedule import SILENCE, Audio, Word
from lipsync_lang.speech.sound import resampled
from lipsync_lang.speech.sphinx.acoustic_model import OUTSIDE
from lipsync_lang.speech.sphinx.features import FRAME, RATE, WINDOW, Floats
from lipsync_lang.speech.sphinx.forced import HeardPhoneme

if TYPE_CHECKING:
    from lipsync_lang.speech.sphinx.folder import Models

LOUD = 16_000.0
"""The peak to which a sound is brought: what follows does not depend on its loudness."""

HISS = 3.0
"""The noise that is added, so that digital silence is heard as what it is."""

CENTRE = (WINDOW / RATE - FRAME) / 2
"""Seconds by which a frame looks ahead: the middle of its window, not of its step."""

PAUSE = 0.06
"""Seconds; a shorter silence between sounds is the closure of what follows."""

UNLIKE = -5.0
"""A fit below this says that something else is heard."""

HURRIED = 3
"""Frames; a phoneme that gets no more has only what it must have."""

LASTING = 0.5
"""Seconds of sound without text that are worth a remark."""

TELLING = 3
"""Phonemes of a word; shorter ones are swallowed in good speech, too."""

SHOWN = 5
"""Places that one remark names."""


class Saying(NamedTuple):
    """A word in its own spelling, and the ways to say it, as numbers of phonemes."""

    text: str
    ways: tuple[tuple[int, ...], ...]


def prepared(audio: Audio) -> Floats:
    """Return a sound as the features are taken of it: at `RATE`, equally loud, never silent."""
    samples = resampled(audio, RATE).samples.astype(np.float64)
    peak = np.abs(samples).max(initial=0.0)
    noise = np.random.default_rng(0).normal(0.0, HISS, len(samples))
    scaled: Floats = samples * (LOUD / peak if peak > 0 else 1.0) + noise
    return scaled


def confidence(models: "Models", heard: Sequence[HeardPhoneme]) -> float:
    """Return the share of phonemes that the sound bears out: of a word, alike, in no hurry."""
    said = [one for one in heard if one.phone not in models.quiet]
    return sum(map(_borne_out, said)) / len(said) if said else 0.0


def _borne_out(one: HeardPhoneme) -> bool:
    return one.word != OUTSIDE and one.fit > UNLIKE and one.stop - one.first > HURRIED


class Laid(NamedTuple):
    """Labels with their boundaries in seconds, and which of them are whose."""

    labels: tuple[str, ...]
    times: Floats
    words: tuple[Word, ...]


def laid(
    models: "Models", heard: Sequence[HeardPhoneme], sayings: Sequence[Saying], seconds: float
) -> Laid:
    """Return what was heard as labels from 0 to the end of the sound; pauses in one piece."""
    rows: list[tuple[str, int, float]] = []
    for one in heard:
        label = SILENCE if one.phone in models.quiet else models.model.names[one.phone]
        if label != SILENCE or not rows or rows[-1][0] != SILENCE:
            rows.append((label, one.word, one.first * FRAME + CENTRE))
    starts = [0.0, *(start for _, _, start in rows[1:]), seconds]
    kept = [
        n
        for n, (label, _, _) in enumerate(rows)
        if label != SILENCE or n in (0, len(rows) - 1) or starts[n + 1] - starts[n] >= PAUSE
    ]
    labels = tuple(rows[n][0] for n in kept)
    # what is left out becomes the start of what follows
    times = [0.0, *(starts[before + 1] for before in kept[:-1]), seconds]
    owners = [rows[n][1] for n in kept]
    words = []
    for number, saying in enumerate(sayings):
        own = [n for n, owner in enumerate(owners) if owner == number]
        if own:
            words.append(Word(saying.text, own[0], own[-1] + 1))
    return Laid(labels, np.array(times), tuple(words))


def doubts(heard: Sequence[HeardPhoneme], sayings: Sequence[Saying]) -> list[str]:
    """Say in words where sound and text disagree."""
    remarks: list[str] = []
    others = [
        f"{one.first * FRAME:.1f} to {one.stop * FRAME:.1f} s"
        for one in heard
        if one.word == one.phone == OUTSIDE and (one.stop - one.first) * FRAME >= LASTING
    ]
    if others:
        remarks.append(f"sound that the text does not have: {_listed(others)}")
    said: dict[int, list[HeardPhoneme]] = {}
    for one in heard:
        said.setdefault(one.word, []).append(one)
    missing = [
        f"'{saying.text}' at {said[number][0].first * FRAME:.1f} s"
        for number, saying in enumerate(sayings)
        if len(said.get(number, ())) >= TELLING and not any(map(_borne_out, said[number]))
    ]
    if missing:
        remarks.append(f"words that are not heard: {_listed(missing)}")
    return remarks


def _listed(places: Sequence[str]) -> str:
    more = len(places) - SHOWN
    return ", ".join(places[:SHOWN]) + (f" and {more} more" if more > 0 else "")
