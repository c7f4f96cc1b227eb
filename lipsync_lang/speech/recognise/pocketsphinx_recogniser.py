"""Recognition by pocketsphinx: words where available, otherwise phonemes.

The sound is decoded in parts, cut at the quietest frames. Recognised words are then force-aligned
like a given text.
"""

from collections.abc import Iterator, Sequence
from threading import local
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.schedules.schedule import Audio, Schedule
from lipsync_lang.speech import listening
from lipsync_lang.speech.recognise.recognisers import recogniser
from lipsync_lang.speech.sphinx.acoustic_model import OUTSIDE
from lipsync_lang.speech.sphinx.features import RATE, STEP, Floats, features
from lipsync_lang.speech.sphinx.folder import Models, find_models, without_variant
from lipsync_lang.speech.sphinx.forced import HeardPhoneme, lay
from lipsync_lang.speech.sphinx.scheduling import Saying, confidence, laid, prepared

if TYPE_CHECKING:
    from lipsync_lang.speech.speaking import Speaker

SHORTEST, LONGEST = 10 * RATE, 20 * RATE
"""Target part length in samples."""

QUIET = 20
"""Window of the loudness measure in frames."""

threads = local()
"""Decoders; each takes a second to load and some 100 MB, and serves one thread at a time."""

SHOWN = 200
"""Maximum length in characters of recognised text in a remark."""


@recogniser("pocketsphinx")
class PocketsphinxRecogniser:
    """Recogniser for languages with a pocketsphinx model."""

    def recognise(self, audio: Audio, speaker: "Speaker", model: str | None = None) -> Schedule:
        """Recognise the speech in a recording.

        Parameters
        ----------
        audio : the recording
        speaker : its language
        model : name of a pocketsphinx model

        Raises
        ------
        SpeechError
            The model is unknown.
        """
        models = find_models(model)
        sound = prepared(audio)
        decoder = _decoder(models)
        heard: list[HeardPhoneme] = []
        sayings: list[Saying] = []
        for start, stop in parts(sound):
            part = sound[start:stop]
            words = _words(decoder, models, part)
            said = [Saying(word, models.ways(word)) for word in words]
            with listening.part(start, stop, len(sound)):
                listening.tell(0, 1)
                found = lay(models.model, features(part), [s.ways for s in said]) if said else None
            if found is None:
                said, found = [], _phones(decoder, models, part)
            heard += [_moved(one, start // STEP, len(sayings)) for one in found]
            sayings += said
        return Schedule(
            *laid(models, heard, sayings, audio.seconds),
            notation=speaker.manner.audio.notation,
            language=speaker.manner.language,
            audio=audio,
            source="recording",
            remarks=(_told(sayings),),
            recognised=True,
            confidence=confidence(models, heard),
        )


def parts(sound: Floats) -> Iterator[tuple[int, int]]:
    """Yield start and stop samples of parts: whole frames, cut at the quietest frames."""
    start = 0
    while len(sound) - start > LONGEST:
        energy = np.cumsum(np.square(sound[start + SHORTEST : start + LONGEST]))[::STEP]
        quietest = int((energy[QUIET:] - energy[:-QUIET]).argmin())
        stop = start + SHORTEST + (quietest + QUIET // 2) * STEP
        yield start, stop
        start = stop
    yield start, len(sound)


def _decoder(models: Models) -> Any:
    """Return this thread's decoder of a model, which is loaded once, as good as new."""
    from pocketsphinx import Decoder

    loaded: dict[Models, Any] = threads.__dict__.setdefault("loaded", {})
    if models not in loaded:
        loaded[models] = Decoder(
            hmm=str(models.acoustic),
            dict=str(models.dictionary),
            lm=str(models.words),
            loglevel="FATAL",
        )
    loaded[models].reinit_feat()
    return loaded[models]


def _segments(decoder: Any, sound: Floats) -> list[tuple[str, int]]:
    """Return the decoder's segments: names with first frames."""
    samples = np.clip(np.rint(sound), -(2**15), 2**15 - 1).astype(np.int16)
    decoder.start_utt()
    decoder.process_raw(samples.tobytes(), full_utt=True)
    decoder.end_utt()
    return [(one.word, one.start_frame) for one in decoder.seg() or ()]


def _words(decoder: Any, models: Models, sound: Floats) -> list[str]:
    """Return the recognised words; entries outside the dictionary are pauses or noises."""
    decoder.activate_search()
    names = (without_variant(name) for name, _ in _segments(decoder, sound))
    return [name for name in names if models.ways(name)]


def _phones(decoder: Any, models: Models, sound: Floats) -> list[HeardPhoneme]:
    """Return the phonemes of a sound without words."""
    decoder.add_allphone_file("phones", str(models.phones))
    decoder.activate_search("phones")
    names = _segments(decoder, sound) or [("", 0)]
    stops = [first for _, first in names[1:]] + [-(-len(sound) // STEP)]
    return [
        HeardPhoneme(OUTSIDE, models.numbers.get(name, OUTSIDE), first, stop, 0.0)
        for (name, first), stop in zip(names, stops, strict=True)
    ]


def _moved(one: HeardPhoneme, frames: int, words: int) -> HeardPhoneme:
    word = one.word if one.word == OUTSIDE else one.word + words
    return one._replace(word=word, first=one.first + frames, stop=one.stop + frames)


def _told(sayings: Sequence[Saying]) -> str:
    words = " ".join(saying.text for saying in sayings)
    if not words:
        return "no words were heard; what moves the mouth are single sounds"
    return f"heard: {words[:SHOWN]}{' ...' if len(words) > SHOWN else ''}"
