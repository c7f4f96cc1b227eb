"""Decoders of pocketsphinx: words, or phonemes without words, of a sound.

A sound is decoded in parts, cut at the quietest frames.
"""

from collections.abc import Iterator
from functools import partial
from threading import local
from typing import Any, NamedTuple

import numpy as np

from lipsync_lang.speech.sphinx.acoustic_model import OUTSIDE
from lipsync_lang.speech.sphinx.features import RATE, STEP, Floats
from lipsync_lang.speech.sphinx.folder import Models, without_variant
from lipsync_lang.speech.sphinx.forced import HeardPhoneme

SHORTEST, LONGEST = 10 * RATE, 20 * RATE
"""Target part length in samples."""

QUIET = 20
"""Window of the loudness measure in frames."""

ACTIVE = 3000
"""Most states that are followed at once.

A tenth of the usual number takes half the time, and errs in 67 of 100 words of natural speech
instead of 64.
"""

PHONE_WEIGHT = 2.0
"""Weight of the order of phonemes in the model's language."""

PHONE_BEAM = 1e-20
"""Likelihood of the unlikeliest phonemes that are followed, relative to the likeliest."""

threads = local()
"""Decoders; each takes a second to load and some 100 MB, and serves one thread at a time."""


class DecodedWord(NamedTuple):
    """A word of the dictionary with its posterior probability."""

    text: str
    posterior: float


def parts(
    sound: Floats, shortest: int = SHORTEST, longest: int = LONGEST
) -> Iterator[tuple[int, int]]:
    """Yield start and stop samples of parts: whole frames, cut at the quietest frames."""
    start = 0
    while len(sound) - start > longest:
        energy = np.cumsum(np.square(sound[start + shortest : start + longest]))[::STEP]
        quietest = int((energy[QUIET:] - energy[:-QUIET]).argmin())
        stop = start + shortest + (quietest + QUIET // 2) * STEP
        yield start, stop
        start = stop
    yield start, len(sound)


def decoded_words(models: Models, sound: Floats) -> list[DecodedWord]:
    """Return the recognised words; entries outside the dictionary are pauses or noises."""
    found = _segments(models, sound, "words", lm=str(models.words), maxhmmpf=ACTIVE)
    named = (DecodedWord(without_variant(one.word), min(one.prob, 1.0)) for one in found)
    return [word for word in named if models.ways(word.text)]


def decoded_phones(models: Models, sound: Floats) -> list[HeardPhoneme]:
    """Return the phonemes of a sound without words, one after the other."""
    settings = {"lw": PHONE_WEIGHT, "beam": PHONE_BEAM, "pbeam": PHONE_BEAM}
    found = _segments(models, sound, "phones", allphone=str(models.phones), **settings)
    names = [(one.word, one.start_frame) for one in found] or [("", 0)]
    stops = [first for _, first in names[1:]] + [-(-len(sound) // STEP)]
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
    samples = np.clip(np.rint(sound), -(2**15), 2**15 - 1).astype(np.int16)
    decoder.start_utt()
    decoder.process_raw(samples.tobytes(), full_utt=True)
    decoder.end_utt()
    return list(decoder.seg() or ())
