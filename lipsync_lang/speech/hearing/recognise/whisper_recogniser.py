"""Recognition by Whisper: its words, aligned by the language's own aligner.

Whisper's own times are some 0.1 s off. They divide the sound into stretches between pauses; within
a stretch the aligner finds the times.
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.errors import SpeechError
from lipsync_lang.schedules.schedule import DOUBTFUL, SILENCE, Audio, Schedule
from lipsync_lang.speech.hearing import progress
from lipsync_lang.speech.hearing.alignment import align_many
from lipsync_lang.speech.hearing.recognise.recognisers import (
    SHOWN_CHARS,
    doubt_remarks,
    heard_remark,
    placed,
    recogniser,
)
from lipsync_lang.speech.hearing.recognise.stretches import (
    RecognisedWord,
    Stretch,
    joined,
    part,
    stretches,
)
from lipsync_lang.speech.hearing.recognise.whisper_models import language_code, whisper_model
from lipsync_lang.speech.hearing.sphinx.decoders import parts
from lipsync_lang.speech.hearing.sphinx.scheduling import listed
from lipsync_lang.speech.sound import INT16_FULL_SCALE, SPEECH_RATE, resampled

if TYPE_CHECKING:
    from lipsync_lang.speech.speaking.speaker import Speaker

PART_SAMPLES = 300 * SPEECH_RATE, 600 * SPEECH_RATE
"""Least and most samples that are transcribed at once; an hour would take gigabytes."""

VOICE_THRESHOLD = 0.15
"""Probability of speech above which sound is heard at all: a whisper passes, noise does not."""

NO_SPEECH = 0.6
"""Probability of no speech above which words are invented; those of noise have 0.8 and more."""

REPETITION = 2.4
"""Compression ratio of text above which the model repeats itself, as it does in music and noise."""

SETTINGS = {
    "beam_size": 5,
    "temperature": 0.0,  # the same words each time
    "condition_on_previous_text": False,  # so that a mistake does not spread
    "word_timestamps": True,
    "vad_filter": True,
    "vad_parameters": {"threshold": VOICE_THRESHOLD},
}
"""Options of transcription."""

NOISES = re.compile(r"\[[^\]]*\]|\([^)]*\)|[♪♫*]")
"""Text of a model for sounds that are not words."""


@recogniser("whisper")
class WhisperRecogniser:
    """Recogniser for every language that a Whisper model knows."""

    def recognise(self, audio: Audio, speaker: "Speaker", model: str | None = None) -> Schedule:
        """Recognise the words of a recording, as `Recogniser` states.

        `model` is the folder of a Whisper model; None stands for one that a Python package ships.
        A language that it does not know is a `SpeechError`, as is sound that nothing aligns with.
        """
        loaded = whisper_model(model)
        code = language_code(loaded, speaker.manner.audio.code, speaker.manner.language)
        heard = stretches(_words(loaded, audio, code), audio)
        if not heard:
            return Schedule(
                (SILENCE,),
                np.array([0.0, audio.seconds]),
                language=speaker.manner.language,
                audio=audio,
                source="recording",
                remarks=(heard_remark(""),),
                recognised=True,
                confidence=0.0,
            )
        return _laid(heard, audio, speaker)


def _words(model: Any, audio: Audio, code: str) -> list[RecognisedWord]:
    """Return the words of a model, without those that it invents in parts without speech."""
    samples = resampled(audio, SPEECH_RATE).samples.astype(np.float32) / INT16_FULL_SCALE
    found: list[RecognisedWord] = []
    for start, stop in parts(samples, *PART_SAMPLES):
        segments, _ = model.transcribe(samples[start:stop], language=code, **SETTINGS)
        with progress.part(start, stop, len(samples)):
            for segment in segments:
                progress.tell(float(segment.end), (stop - start) / SPEECH_RATE)
                invented = segment.no_speech_prob > NO_SPEECH
                if invented or segment.compression_ratio > REPETITION:
                    continue
                for word in segment.words or ():
                    text = NOISES.sub(" ", word.word)
                    # Times count from the start of the part, and some pass the end of the sound.
                    begin, end = (
                        min(start / SPEECH_RATE + float(at), audio.seconds)
                        for at in (word.start, word.end)
                    )
                    if any(map(str.isalnum, text)):
                        found.append(RecognisedWord(text, begin, end, float(word.probability)))
    return found


def _laid(heard: Sequence[Stretch], audio: Audio, speaker: "Speaker") -> Schedule:
    """Align each stretch, and join them; words that do not fit their sound are left out."""
    pairs = [(part(audio, one), one.text) for one in heard]
    with progress.followed(lambda _: None):  # each stretch tells its own share
        found = [*align_many(speaker, pairs)]
        if len({one.notation for one in found if isinstance(one, Schedule)}) > 1:
            found = [*align_many(speaker, pairs, aligner=speaker.manner.audio.align[0])]
    both = [*zip(heard, found, strict=True)]
    laid = [(stretch, _sure(stretch, one)) for stretch, one in both if isinstance(one, Schedule)]
    if not laid:
        text = " ".join(stretch.text for stretch in heard)
        raise SpeechError(f"heard '{text[:SHOWN_CHARS]}', but {found[0]}")
    whole = joined([(stretch.start, one) for stretch, one in laid], audio)
    lost = [
        placed(stretch.text, stretch.start) for stretch, one in both if isinstance(one, SpeechError)
    ]
    doubtful = [
        (word.text, word.start)
        for stretch, _ in laid
        for word in stretch.words
        if word.chance < DOUBTFUL
    ]
    remarks = [heard_remark(" ".join(stretch.text for stretch, _ in laid))]
    remarks += doubt_remarks(doubtful)
    remarks += (
        [f"left out, because the recording does not support it: {listed(lost)}"] if lost else []
    )
    count = sum(len(stretch.words) for stretch in heard)
    return replace(
        whole,
        unread=tuple(dict.fromkeys(sign for _, one in laid for sign in one.unread)),
        remarks=tuple(remarks),
        recognised=True,
        confidence=sum((one.confidence or 0.0) * len(s.words) for s, one in laid) / count,
    )


def _sure(stretch: Stretch, laid: Schedule) -> Schedule:
    """Return an aligned stretch with the confidence on which recogniser and aligner agree.

    Of words with a probability of 0.3, 0.5, 0.7 and 0.99, some 0.32, 0.47, 0.67 and 0.94 are right.
    The aligner lowers this where the words hardly fit the sound, or are not found in it.
    """
    fit = 1.0 if laid.confidence is None else min(1.0, laid.confidence / DOUBTFUL)
    chances = [fit * word.chance for word in stretch.words]
    mean = sum(chances) / len(chances)
    if len(chances) != len(laid.words):  # numbers, and words that the aligner divides or leaves out
        chances = [mean] * len(laid.words)
    words = zip(laid.words, chances, strict=True)
    return replace(
        laid,
        words=tuple(replace(word, confidence=sure) for word, sure in words),
        confidence=mean * min(1.0, len(laid.words) / len(stretch.words)),
    )
