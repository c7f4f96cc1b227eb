"""Search for the words of a line in its sound, and in parts of the sound if they hardly fit.

Music or another voice beside a line may be like some of its words. Then these are drawn away from
their place, or a phoneme lasts as long as the music. Without that sound they are found.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from math import log
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.schedules.schedule import DOUBTFUL
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import OUTSIDE
from lipsync_lang.sound.speech.hearing.sphinx.features import HOP_SAMPLES
from lipsync_lang.sound.speech.hearing.sphinx.forced import (
    WINDOW_FRAMES,
    HeardPhoneme,
    Pronunciations,
    centred,
    lay,
)
from lipsync_lang.sound.speech.hearing.sphinx.scheduling import line_confidence, logistic
from lipsync_lang.sound.speech.hearing.sphinx.text_errors import (
    MIN_WORDS,
    ORDER_MARGIN_FRAMES,
    MovedWord,
    TextErrors,
    UnwrittenSpeech,
)

if TYPE_CHECKING:
    from lipsync_lang.sound.speech.hearing.sphinx.folder import Models

MOVED_CONFIDENCE = 0.25
"""Greatest confidence of a line with a word that fits better elsewhere."""

MAX_PARTED_FRAMES = 4000
"""Most frames of a sound that is parted: 40 s."""

MIN_BESIDE_FRAMES = 100
"""Fewest frames of the sound beside a line that is left out, and of each part."""

CHANGE_STEP_FRAMES = 10
"""Frames between the places where a sound may change."""

MIN_VARIANCE = 1e-3
"""Variance of a feature in digital silence."""

CHANGE_DEPTH = 2
"""Number of times that a sound is halved where it changes most: four stretches."""

PART_MARGIN_FRAMES = 30
"""Frames beyond a change that are searched with the part before or after it."""

MIN_PART_PACE = 6
"""Fewest frames of a part for each phoneme of the line."""

PART_LOGIT = -1.0
"""Weight in the logit of a line's confidence of the choice among parts.

A wrong text, too, fits some part better than the whole.
"""


class FoundLine(NamedTuple):
    """Phonemes of a line, if its words were found, with its confidence and errors of its text."""

    heard: list[HeardPhoneme]
    sure: float
    moved: MovedWord | None = None
    unwritten: tuple[UnwrittenSpeech, ...] = ()


def found_line(models: "Models", sound: Floats, words: Sequence[Pronunciations]) -> FoundLine:
    """Search for words in a sound; if they hardly fit, in its parts between changes, too.

    Speech that is not written may be music that holds a word back, as well.
    """
    whole = _found(models, sound, words)
    sure = whole.sure >= DOUBTFUL and not whole.unwritten
    if sure or len(sound) > MAX_PARTED_FRAMES * HOP_SAMPLES:
        return whole
    shortest = MIN_PART_PACE * sum(len(ways[0]) for ways in words)
    features = models.model.front_end(sound)
    parts = [one for one in sound_parts(features) if one[1] - one[0] >= shortest]
    alone = (_alone(models, sound, words, part, len(features)) for part in parts)
    return max([whole, *alone], key=lambda one: one.sure)


def _found(
    models: "Models",
    sound: Floats,
    words: Sequence[Pronunciations],
    margin: int = ORDER_MARGIN_FRAMES,
) -> FoundLine:
    heard, features = best_heard(models, sound, words)
    sure = line_confidence(heard)
    if sure < DOUBTFUL or len(features) > WINDOW_FRAMES or len(words) < MIN_WORDS:
        return FoundLine(heard, sure)
    errors = TextErrors(models.model, centred(features, heard), words, heard, margin)
    moved = errors.moved_word()
    sure = sure if moved is None else min(sure, MOVED_CONFIDENCE)
    return FoundLine(heard, sure, moved, tuple(errors.unwritten()))


def best_heard(
    models: "Models", sound: Floats, words: Sequence[Pronunciations]
) -> tuple[list[HeardPhoneme], Floats]:
    """Align words, as `laid` does, in the features of the sound that fit best; return both."""
    hearings = models.model.front_end.hearings(sound)
    tries = [(laid(models, one, words) or [], one) for one in hearings]
    return max(tries, key=lambda one: line_confidence(one[0]))


def sound_parts(features: Floats) -> Iterator[tuple[int, int]]:
    """Yield the first frame and the end of the parts between changes of a sound."""
    end = len(features)
    edges = [0, *sound_changes(features.reshape(end, -1), CHANGE_DEPTH), end]
    for first, stop in combinations(edges, 2):
        part = max(first - PART_MARGIN_FRAMES, 0), min(stop + PART_MARGIN_FRAMES, end)
        if part[1] - part[0] <= end - MIN_BESIDE_FRAMES:
            yield part


def sound_changes(values: Floats, depth: int) -> list[int]:
    """Return the frames where a sound changes most: its spectrum has another mean and variance."""
    count = np.arange(MIN_BESIDE_FRAMES, len(values) - MIN_BESIDE_FRAMES + 1, CHANGE_STEP_FRAMES)
    if depth == 0 or not len(count):
        return []
    sums = np.cumsum([values, values**2], axis=1)

    def spread(total: Floats, frames: Ints) -> Floats:
        """Return the logarithms of the variances of parts, by their sums, times their frames."""
        mean, power = total / frames[:, None]
        logs: Floats = np.log(power - mean**2 + MIN_VARIANCE).sum(axis=1)
        return frames * logs

    before, whole = sums[:, count - 1], sums[:, -1:]
    cost = spread(before, count) + spread(whole - before, len(values) - count)
    at = int(count[cost.argmin()])
    later = [at + one for one in sound_changes(values[at:], depth - 1)]
    return [*sound_changes(values[:at], depth - 1), at, *later]


def _alone(
    models: "Models",
    sound: Floats,
    words: Sequence[Pronunciations],
    part: tuple[int, int],
    end: int,
) -> FoundLine:
    """Search for words in a part of a sound; the rest is other sound."""
    first, stop = part
    samples = sound[first * HOP_SAMPLES : stop * HOP_SAMPLES]
    # the sound around the words of a part is not theirs
    found = _found(models, samples, words, margin=0)
    left_out = any(one.phone == OUTSIDE != one.word for one in found.heard)
    if left_out or found.sure < DOUBTFUL:
        return FoundLine([], 0.0)
    rest = [HeardPhoneme(OUTSIDE, OUTSIDE, *span, 0.0) for span in ((0, first), (stop, end))]
    before, after = ([one] if one.stop > one.first else [] for one in rest)
    inside = [h._replace(first=h.first + first, stop=h.stop + first) for h in found.heard]
    unwritten = (
        one._replace(first=one.first + first, stop=one.stop + first) for one in found.unwritten
    )
    sure = min(found.sure, 1 - 1e-9)
    logit = log(sure / (1 - sure)) + PART_LOGIT
    return FoundLine([*before, *inside, *after], logistic(logit), None, tuple(unwritten))


def laid(
    models: "Models", sound: Floats, words: Sequence[Pronunciations]
) -> list[HeardPhoneme] | None:
    """Align words in short windows, and again in anchored ones if these lose the text."""
    heard = lay(models.model, sound, words)
    sure = line_confidence(heard) if heard else 0.0
    if sure >= DOUBTFUL or len(sound) <= WINDOW_FRAMES:
        return heard
    again = lay(models.model, sound, words, anchored=True)
    return again if again and line_confidence(again) > sure else heard
