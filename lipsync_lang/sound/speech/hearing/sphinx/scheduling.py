"""Conversion of aligned phonemes to schedules, with the confidence of a line and of its words.

The aligner and the recogniser share it. Confidences are logistic functions of what the search
found, fitted to right and wrong texts (decision 0026).
"""

from collections.abc import Container, Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import shortlist
from lipsync_lang.base.grouping import grouped
from lipsync_lang.schedules.schedule import SILENCE, Word
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import OUTSIDE
from lipsync_lang.sound.speech.hearing.sphinx.features import FRAME_SECONDS, WINDOW_SAMPLES
from lipsync_lang.sound.speech.hearing.sphinx.folder import Models
from lipsync_lang.sound.speech.hearing.sphinx.forced import HeardPhoneme
from lipsync_lang.sound.speech.sound import SPEECH_RATE

WINDOW_CENTRE_SECONDS = (WINDOW_SAMPLES / SPEECH_RATE - FRAME_SECONDS) / 2
"""Offset in seconds from a frame's start to the middle of its window."""

CLOSURE_SECONDS = 0.06
"""Minimum pause in seconds; a shorter silence is the closure of the next sound."""

MIN_FIT = -5.0
"""Fit limit; a lower value means a mismatch of phoneme and sound."""

MAX_BESIDE_FRAMES = 30
"""Most frames of other speech before the words, and after them, that count against a line.

More is music or another voice beside it. None would let a wrong text pass, which finds its place
between sounds that it does not fit.
"""

OTHER_SOUND_SECONDS = 0.5
"""Minimum seconds of sound without text for a remark."""

MIN_TOLD_PHONEMES = 3
"""Minimum phonemes of a word for a remark; shorter words are often reduced in normal speech."""

LINE_FIT_WEIGHTS = (0.9, -4.0, 12.0, -10.0, -3.75)
"""Weights in the logit of a line's confidence: of the fit, of the hurried share, of the share of
speech, of 1 for each phoneme, and of 1."""

WORD_FIT_WEIGHTS = (0.45, -1.4, 3.0)
"""Weights in the logit of a word's confidence: of the fit, of the hurried share, and of 1."""

SPEECH_NOISE_FIT = -3.0
"""Fit of silence and noises below which a sound is speech; that of speech is -5 to -10, and
-3 to -7 with noise 10 dB below it."""

DIN_WEIGHT = 3.0
"""Weight of the excess over that in the logit of a line's confidence."""

DOUBTED_CONFIDENCE = 0.4
"""Greatest confidence of a word beside speech that the text does not have."""

HURRIED_FRAMES = 3
"""Frames; a phoneme of no more has the minimum duration of the model."""


class Saying(NamedTuple):
    """A word in its own spelling, with pronunciations as phoneme numbers.

    `spelled` are the labels of each pronunciation, with their numbers of phonemes; without it, the
    model's own names are the labels.
    """

    text: str
    ways: tuple[tuple[int, ...], ...]
    spelled: tuple[tuple[tuple[str, int], ...], ...] = ()


def confidence(models: Models, heard: Sequence[HeardPhoneme]) -> float:
    """Return the share of word phonemes with a good fit and more than minimum duration."""
    said = [one for one in heard if one.phone not in models.quiet]
    return sum(map(_borne_out, said)) / len(said) if said else 0.0


def _borne_out(one: HeardPhoneme) -> bool:
    return one.word != OUTSIDE and one.fit > MIN_FIT and one.stop - one.first > HURRIED_FRAMES


class TimedLabels(NamedTuple):
    """Labels with boundaries in seconds, and the words they belong to."""

    labels: tuple[str, ...]
    times: Floats
    words: tuple[Word, ...]


def timed_labels(
    models: Models,
    heard: Sequence[HeardPhoneme],
    sayings: Sequence[Saying],
    seconds: float,
    doubted: Container[int] = (),
) -> TimedLabels:
    """Convert phonemes to labels from 0 to the end of the sound, with adjacent pauses merged.

    Some words are `doubted`, however well they fit.
    """
    rows: list[tuple[str, int, float]] = []
    # A label with several phonemes comes at the first of these; the others have an empty one.
    found = grouped((one.word, one) for one in heard)
    spelled = {}
    for number, saying in enumerate(sayings):
        way = tuple(sound.phone for sound in found.get(number, ()))
        if saying.spelled and way in saying.ways:  # it is not left out
            pairs = saying.spelled[saying.ways.index(way)]
            names = [name for label, count in pairs for name in (label, *[""] * (count - 1))]
            spelled[number] = iter(names)
    for one in heard:
        label = SILENCE if one.phone in models.quiet else models.model.names[one.phone]
        if label != SILENCE and one.word in spelled:
            label = next(spelled[one.word])
            if not label:  # another phoneme of the label before
                continue
        if label != SILENCE or not rows or rows[-1][0] != SILENCE:
            start = (one.first + one.late) * FRAME_SECONDS + WINDOW_CENTRE_SECONDS
            rows.append((label, one.word, start))
    # The first label starts with the sound, whatever its frame says, and the last one ends with it.
    starts = [0.0, *(start for _, _, start in rows[1:]), seconds]
    kept = [
        n
        for n, (label, _, _) in enumerate(rows)
        if label != SILENCE
        or n in (0, len(rows) - 1)
        or starts[n + 1] - starts[n] >= CLOSURE_SECONDS
    ]
    labels = tuple(rows[n][0] for n in kept)
    # dropped silences are merged into the next sound
    times = [0.0, *(starts[before + 1] for before in kept[:-1]), seconds]
    places = [(rows[n][1], place) for place, n in enumerate(kept) if rows[n][0] != SILENCE]
    first, last = dict(reversed(places)), dict(places)
    words = []
    for number, saying in enumerate(sayings):
        if number in first:
            sure = word_confidence(found[number])
            sure = min(sure, DOUBTED_CONFIDENCE) if number in doubted else sure
            words.append(Word(saying.text, first[number], last[number] + 1, confidence=sure))
    return TimedLabels(labels, np.array(times), tuple(words))


def doubts(heard: Sequence[HeardPhoneme], sayings: Sequence[Saying]) -> list[str]:
    """Describe mismatches of sound and text in messages."""
    others = [
        f"{one.first * FRAME_SECONDS:.1f} to {one.stop * FRAME_SECONDS:.1f} s"
        for one in heard
        if one.word == one.phone == OUTSIDE
        and (one.stop - one.first) * FRAME_SECONDS >= OTHER_SOUND_SECONDS
    ]
    said = grouped((one.word, one) for one in heard)
    absent: list[str] = []
    unlike: list[str] = []
    for number, saying in enumerate(sayings):
        own = said.get(number, [])
        place = f"'{saying.text}' at {own[0].first * FRAME_SECONDS:.1f} s" if own else ""
        if any(one.phone == OUTSIDE for one in own):
            absent.append(place)
        elif len(own) >= MIN_TOLD_PHONEMES and not any(map(_borne_out, own)):
            unlike.append(place)
    told = {
        "sound without text": others,
        "words that are not spoken are left out": absent,
        "words that were not recognised": unlike,
    }
    return [f"{what}: {shortlist(places)}" for what, places in told.items() if places]


def line_confidence(heard: Sequence[HeardPhoneme]) -> float:
    """Return the probability that the sound has these words, in [0, 1].

    The evidence: the mean fit of their phonemes, the share of them that have no time, their share
    of the speech among and beside them, and the fit of silence and noises to them, which is high
    where nobody speaks. Few phonemes fit by chance: they need more of it.
    """
    said = [one for one in heard if OUTSIDE not in (one.word, one.phone)]
    if not said:
        return 0.0
    spoken = sum(map(_frames, said))
    others = [o for o in heard if o.phone == OUTSIDE and o.noise < SPEECH_NOISE_FIT]
    before = sum(_frames(one) for one in others if one.first < said[0].first)
    after = sum(_frames(one) for one in others if one.first > said[-1].first)
    other = sum(map(_frames, others)) - sum(max(0, n - MAX_BESIDE_FRAMES) for n in (before, after))
    noise = sum(one.noise * _frames(one) for one in said) / spoken
    din = DIN_WEIGHT * max(0.0, noise - SPEECH_NOISE_FIT)
    evidence = (*_fit_and_hurry(said), spoken / (spoken + other), 1 / len(said), 1.0)
    return logistic(np.dot(LINE_FIT_WEIGHTS, evidence) - din)


def word_confidence(phonemes: Sequence[HeardPhoneme]) -> float:
    """Return the probability that a word is said where it was found, in [0, 1].

    The evidence: the mean fit of its phonemes, and the share of them that have no time.
    """
    return logistic(np.dot(WORD_FIT_WEIGHTS, (*_fit_and_hurry(phonemes), 1.0)))


def _fit_and_hurry(phonemes: Sequence[HeardPhoneme]) -> Floats:
    """Return the mean fit of phonemes, and the share of them that have no time."""
    return np.mean([(one.fit, _frames(one) <= HURRIED_FRAMES) for one in phonemes], axis=0)


def _frames(one: HeardPhoneme) -> int:
    return one.stop - one.first


def logistic(logit: float) -> float:
    """Return the probability of log odds."""
    # Beyond these limits, `exp` would overflow with a warning, and the result is 0 or 1 anyway.
    # Rounded, because processors differ in later digits.
    return round(float(1 / (1 + np.exp(-np.clip(logit, -50, 50)))), 9)
