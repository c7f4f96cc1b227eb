"""Decoders of pocketsphinx: words, or phonemes without words, of a sound.

A sound is decoded in parts, cut at the quietest frames.
"""

import re
from collections.abc import Iterator
from functools import partial
from threading import local
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Floats
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import OUTSIDE
from lipsync_lang.sound.speech.hearing.sphinx.features import HOP_SAMPLES
from lipsync_lang.sound.speech.hearing.sphinx.folder import Models
from lipsync_lang.sound.speech.hearing.sphinx.forced import HeardPhoneme
from lipsync_lang.sound.speech.sound import SPEECH_RATE

MIN_PART_SAMPLES, MAX_PART_SAMPLES = 10 * SPEECH_RATE, 20 * SPEECH_RATE
"""Target part length in samples."""

QUIET_FRAMES = 20
"""Window of the loudness measure in frames."""

MAX_ACTIVE_STATES = 3000
"""Most states that are followed at once.

A tenth of the usual number takes half the time, and errs in 67 of 100 words of natural speech
instead of 64.
"""

PHONE_WEIGHT = 2.0
"""Weight of the order of phonemes in the model's language."""

PHONE_BEAM = 1e-20
"""Likelihood of the unlikeliest phonemes that are followed, relative to the likeliest."""

VARIANT = re.compile(r"\(\d+\)$")
"""Number of a further pronunciation, after a word of the dictionary."""

threads = local()
"""Decoders; each takes a second to load and some 100 MB, and serves one thread at a time."""


class DecodedWord(NamedTuple):
    """A word of the dictionary with its posterior probability."""

    text: str
    posterior: float


def parts(
    sound: Floats | npt.NDArray[np.int16],
    shortest: int = MIN_PART_SAMPLES,
    longest: int = MAX_PART_SAMPLES,
) -> Iterator[tuple[int, int]]:
    """Yield start and stop samples of parts: whole frames, cut at the quietest frames."""
    start = 0
    while len(sound) - start > longest:
        # Energy of a window from the difference of running sums; every sum at a frame's start.
        energy = np.cumsum(np.square(sound[start + shortest : start + longest], dtype=np.float64))[
            ::HOP_SAMPLES
        ]
        quietest = int((energy[QUIET_FRAMES:] - energy[:-QUIET_FRAMES]).argmin())
        stop = start + shortest + (quietest + QUIET_FRAMES // 2) * HOP_SAMPLES
        yield start, stop
        start = stop
    yield start, len(sound)


def decoded_words(models: Models, sound: Floats) -> list[DecodedWord]:
    """Return the recognised words; entries outside the dictionary are pauses or noises."""
    language = str(models.language_model)
    found = _segments(models, sound, "words", lm=language, maxhmmpf=MAX_ACTIVE_STATES)
    named = [DecodedWord(VARIANT.sub("", one.word), min(one.prob, 1.0)) for one in found]
    ways = models.ways(word.text for word in named)
    return [word for word, known in zip(named, ways, strict=True) if known]


def decoded_phones(models: Models, sound: Floats) -> list[HeardPhoneme]:
    """Return the phonemes of a sound without words, one after the other."""
    settings = {"lw": PHONE_WEIGHT, "beam": PHONE_BEAM, "pbeam": PHONE_BEAM}
    language = str(models.folder / f"{models.folder.name}-phone.lm.bin")
    found = _segments(models, sound, "phones", allphone=language, **settings)
    names = [(one.word, one.start_frame) for one in found] or [("", 0)]
    stops = [first for _, first in names[1:]] + [-(-len(sound) // HOP_SAMPLES)]
    return [
        HeardPhoneme(OUTSIDE, models.numbers.get(name, OUTSIDE), first, stop, 0.0)
        for (name, first), stop in zip(names, stops, strict=True)
    ]


def _segments(models: Models, sound: Floats, kind: str, **settings: Any) -> list[Any]:
    """Return the segments of this thread's decoder of a kind, which is loaded once."""
    from pocketsphinx import Decoder

    loaded: dict[tuple[Models, str], Any] = threads.__dict__.setdefault("loaded", {})
    if (models, kind) not in loaded:
        make = partial(Decoder, hmm=str(models.acoustic), dict=str(models.dictionary))
        loaded[models, kind] = make(loglevel="FATAL", **settings)
    decoder = loaded[models, kind]
    decoder.reinit_feat()  # as good as new
    # `process_raw` takes 16-bit bytes, and a peak above full scale would wrap round.
    samples = np.clip(np.rint(sound), -(2**15), 2**15 - 1).astype(np.int16)
    decoder.start_utt()
    decoder.process_raw(samples.tobytes(), full_utt=True)
    decoder.end_utt()
    # `seg` is None where nothing was recognised, and its items are valid only until the next sound.
    return list(decoder.seg() or ())
