"""Recognition by pocketsphinx: words, or what the sound alone tells if there are none.

Recognised words are force-aligned like a given text.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules.schedule import DOUBTFUL, Audio, Schedule
from lipsync_lang.sound.speech.hearing import progress
from lipsync_lang.sound.speech.hearing.recognise.recognisers import (
    RECOGNISERS,
    doubt_remarks,
    heard_remark,
    recogniser,
)
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import OUTSIDE
from lipsync_lang.sound.speech.hearing.sphinx.decoders import decoded_words, parts
from lipsync_lang.sound.speech.hearing.sphinx.features import (
    FRAME_SECONDS,
    HOP_SAMPLES,
    PreparedSound,
)
from lipsync_lang.sound.speech.hearing.sphinx.folder import Models, find_models
from lipsync_lang.sound.speech.hearing.sphinx.forced import HeardPhoneme, lay
from lipsync_lang.sound.speech.hearing.sphinx.scheduling import Saying, logistic, timed_labels
from lipsync_lang.sound.speech.speaking.speaker import Speaker

CONSTANT, OF_POSTERIOR, OF_FIT = 0.4, 0.53, 0.6
"""Logistic regression of right words on the logarithm of their posterior and on their fit.

Of 500 words in 38 natural recordings, half of them with noise, each predicted from the others:
words said to be right in 12, 30, 50 and 70 of 100 cases were right in 14, 26, 46 and 82. The
posterior alone is near 1 for many wrong words.
"""

MIN_MEAN_CHANCE = 0.2
"""Mean probability of words that are none."""

MIN_POSTERIOR = 1e-6
"""Minimum posterior of a word, since the decoder rounds to 0."""


@recogniser("pocketsphinx")
class PocketsphinxRecogniser:
    """Recogniser for languages with a pocketsphinx model."""

    def recognise(self, audio: Audio, speaker: Speaker, model: str | None = None) -> Schedule:
        """Recognise the speech in a recording, as `Recogniser` states.

        `model` names a pocketsphinx model; one of another language is a `SpeechError`.
        """
        models, notation = find_models(model), speaker.manner.audio.notation
        if not notation:
            raise SpeechError(
                f"{speaker.manner.language} is not the language of the model '{models.folder.name}'"
                ", or its pack does not name the notation of the model's phones "
                "(`audio: {notation: ...}`); `sound` hears any language"
            )
        if models.language_model is None or models.dictionary is None:
            raise SpeechError(
                f"{models.folder}: words need a dictionary (*.dict) and a language model "
                f"({models.folder.name}.lm.bin) beside the acoustic model; `sound` needs neither"
            )
        sound = PreparedSound.of(audio).samples()
        heard: list[HeardPhoneme] = []
        sayings: list[Saying] = []
        chances: list[float] = []
        for start, stop in parts(sound):
            with progress.part(start, stop, len(sound)):
                words, sure, phonemes = _heard(models, sound[start:stop])
            # Frames and words are counted from the start of the part.
            frames = start // HOP_SAMPLES
            for one in phonemes:
                word = one.word if one.word == OUTSIDE else one.word + len(sayings)
                first, last = one.first + frames, one.stop + frames
                heard.append(one._replace(word=word, first=first, stop=last))
            sayings += words
            chances += sure
        if not sayings:
            alone = RECOGNISERS.find("sound", SpeechError).recognise(audio, speaker)
            return replace(alone, remarks=(heard_remark(""), *alone.remarks), confidence=0.0)
        found = timed_labels(models, heard, sayings, audio.seconds)
        said = sorted({one.word for one in heard if OUTSIDE not in (one.word, one.phone)})
        pairs = zip(found.words, said, strict=True)
        recognised = (replace(word, confidence=chances[number]) for word, number in pairs)
        return Schedule(
            found.labels, found.times, tuple(recognised), notation=notation,
            language=speaker.manner.language, audio=audio, source="recording", recognised=True,
            remarks=_remarks(heard, sayings, chances), confidence=float(np.mean(chances)),
        )  # fmt: skip


def _heard(models: Models, sound: Floats) -> tuple[list[Saying], list[float], list[HeardPhoneme]]:
    """Return the words of a part with their probabilities, and its phonemes."""
    progress.tell(0, 1)
    words = decoded_words(models, sound)
    texts = [word.text for word in words]
    sayings = [Saying(*one) for one in zip(texts, models.ways(texts), strict=True)]
    hearing = next(models.model.front_end.hearings([sound]))
    ways = [one.ways for one in sayings]
    if ways and (found := lay(models.model, hearing, ways)) is not None:
        fits: list[list[HeardPhoneme]] = [[] for _ in words]
        for one in found:
            if OUTSIDE not in (one.word, one.phone):
                fits[one.word].append(one)
        chances = [chance(w.posterior, own) for w, own in zip(words, fits, strict=True)]
        if np.mean(chances) >= MIN_MEAN_CHANCE:
            return sayings, chances, found
    return [], [], [HeardPhoneme(OUTSIDE, models.model.silence, 0, len(hearing), 0.0)]


def chance(posterior: float, heard: Sequence[HeardPhoneme]) -> float:
    """Return the probability that a word is right.

    Parameters
    ----------
    posterior : of the word, among those that the decoder considered
    heard : its aligned phonemes
    """
    frames = [one.stop - one.first for one in heard]
    if not frames:
        return 0.0
    fit = np.average([one.fit for one in heard], weights=frames)
    return logistic(CONSTANT + OF_POSTERIOR * np.log(max(posterior, MIN_POSTERIOR)) + OF_FIT * fit)


def _remarks(
    heard: Sequence[HeardPhoneme], sayings: Sequence[Saying], chances: Sequence[float]
) -> tuple[str, ...]:
    starts = {one.word: one.first * FRAME_SECONDS for one in reversed(heard)}
    doubtful = [
        (saying.text, starts[n])
        for n, saying in enumerate(sayings)
        if chances[n] < DOUBTFUL and n in starts
    ]
    return heard_remark(" ".join(one.text for one in sayings)), *doubt_remarks(doubtful)
