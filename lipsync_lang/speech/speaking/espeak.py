"""Speech synthesis by eSpeak NG: text to a schedule with sound.

The library reports events at sample positions; `espeak_events` converts them to contiguous
phonemes, `word_spans` to words.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice, tee
from typing import Any

import numpy as np

from lipsync_lang.errors import SpeechError
from lipsync_lang.phonology.espeak.espeak_stream import FORKS, answers
from lipsync_lang.phonology.espeak.process import EspeakProcess, blank, quoted
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule
from lipsync_lang.speech.results import exhaust, next_result, raised, tried
from lipsync_lang.speech.speaking.espeak_events import intervals, read_events
from lipsync_lang.speech.speaking.speech_engines import (
    refuse_rate,
    refuse_unspeakable,
    speech_engine,
)
from lipsync_lang.speech.speaking.word_spans import find_words

MAX_ESPEAK_CHARS = 50_000
"""Text limit in characters, about an hour of speech; longer texts need splitting into lines."""

MIN_SILENCE_SECONDS = 0.09
"""Minimum pause in seconds; a shorter silence between sounds counts as articulation."""


USUAL_LEVEL = -19.0
"""Level of its voices in dBFS over sounds, without pauses: -20.3 to -17.4 in nine languages."""


@speech_engine("espeak")
@dataclass
class Espeak(EspeakProcess):
    """eSpeak NG as a speech engine."""

    def speak(self, text: str, voice: str, *, words_per_minute: int | None = None) -> Schedule:
        """Speak a text with a voice of the library: a language code, title or identifier.

        A variant may follow the voice, as in ``en-us+f3``.

        Raises
        ------
        SpeechError
            The text is empty, the voice is unknown, the library is missing, or it failed.
        """
        rate = _rate(words_per_minute)
        spoken = _plain(text)
        header, sound = self.ask("speak", text=spoken, voice=voice, rate=rate)
        return _schedule(header, sound, spoken)

    def speak_many(
        self, texts: Iterable[str], voice: str, *, words_per_minute: int | None = None
    ) -> Iterator[Schedule | SpeechError]:
        """Speak texts as `speak` does, by one process; yield the error of each that fails."""
        source = iter(texts)
        first = list(islice(source, 2))
        if len(first) == 1 or not FORKS:
            say = partial(self.speak, voice=voice, words_per_minute=words_per_minute)
            yield from map(tried(say), chain(first, source))
            return
        try:
            rate = _rate(words_per_minute)
        except SpeechError as error:
            yield from (error for _ in chain(first, source))
            return
        ours, workers = tee(map(tried(_plain), chain(first, source)))
        spoken = answers(self, (one for one in workers if isinstance(one, str)), voice, rate)
        for text in ours:
            if isinstance(text, SpeechError):
                yield text
                continue
            try:
                yield _schedule(*raised(next_result(spoken)), text)
            except SpeechError as error:
                yield error
        exhaust(spoken)


def _rate(words_per_minute: int | None) -> int:
    if words_per_minute is None:
        return 0
    # Above its limit, the library compresses the sound, but not the times of its events.
    refuse_rate("eSpeak NG", words_per_minute)
    return int(words_per_minute)


def _plain(text: str) -> str:
    """Replace control and invalid characters by spaces, one for one to keep text positions."""
    plain = blank(text)
    if not plain.strip():
        raise SpeechError("there is no text to speak; write at least one word")
    refuse_unspeakable(plain, quoted(text), "", MAX_ESPEAK_CHARS)
    return plain


def _schedule(header: dict[str, Any], sound: bytes, text: str) -> Schedule:
    """Build a schedule from the worker's answer."""
    try:
        samples = np.frombuffer(sound, dtype=np.int16)
        rate = int(header["rate"])
        sounds, marks = read_events(header["events"], header["spelled"], len(samples))
        labels, bounds, index, stress = intervals(sounds, int(MIN_SILENCE_SECONDS * rate))
    except (KeyError, ValueError, TypeError, AttributeError):
        raise SpeechError("eSpeak NG gave an unreadable answer; try again") from None
    if all(label == SILENCE for label in labels):
        raise SpeechError(
            f"eSpeak NG says nothing for {quoted(text)} in this voice{header['said']}; "
            "check that the text is in the script of the voice"
        )
    return Schedule(
        tuple(labels),
        np.array(bounds) / rate,
        words=find_words(text, [(at, index[number]) for at, number in marks], labels),
        notation="ipa",
        audio=Audio(samples, rate, USUAL_LEVEL),
        source=f"speech {quoted(text)}",
        stress=tuple(stress) if any(stress) else (),
    )
