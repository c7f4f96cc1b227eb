"""Speech synthesis by eSpeak NG: text to a schedule with sound.

The library reports events at sample positions; `espeak_events` converts them to contiguous
phonemes, `word_spans` to words.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice
from typing import Any

import numpy as np

from lipsync_lang.errors import SpeechError
from lipsync_lang.phonology.espeak.espeak_stream import FORKS, answers
from lipsync_lang.phonology.espeak.process import EspeakProcess, blank, quoted
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule
from lipsync_lang.speech.espeak_events import intervals, read_events
from lipsync_lang.speech.in_turn import each, in_turn, refused, tried
from lipsync_lang.speech.speech_engines import speech_engine
from lipsync_lang.speech.word_spans import find_words

SLOWEST, FASTEST = 80, 350
"""Maximum words per minute; above this the library compresses the sound but not its events."""

LONGEST = 50_000
"""Text limit in characters, about an hour of speech; longer texts need splitting into lines."""

PAUSE = 0.09
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
        rate = tried(_rate)(words_per_minute)
        if isinstance(rate, SpeechError):
            yield from refused(chain(first, source), rate)
            return
        plain = map(tried(_plain), chain(first, source))
        answered = in_turn(plain, lambda good: answers(self, good, voice, rate))
        yield from each(answered, lambda pair: _schedule(*pair[1], pair[0]))


def _rate(words_per_minute: int | None) -> int:
    if words_per_minute is None:
        return 0
    if not SLOWEST <= words_per_minute <= FASTEST:
        raise SpeechError(
            f"{words_per_minute} words per minute: eSpeak NG speaks {SLOWEST} to {FASTEST}; "
            "stretch the schedule for more"
        )
    return int(words_per_minute)


def _plain(text: str) -> str:
    """Replace control and invalid characters by spaces, one for one to keep text positions."""
    plain = blank(text)
    if not plain.strip():
        raise SpeechError("there is no text to speak; write at least one word")
    if not any(c.isalnum() for c in plain):
        raise SpeechError(
            f"{quoted(text)} has no letter or digit, so there is nothing to say; "
            "write at least one word"
        )
    if len(plain) > LONGEST:
        raise SpeechError(
            f"the text has {len(plain)} characters, more than {LONGEST}; speak it line by line"
        )
    return plain


def _schedule(header: dict[str, Any], sound: bytes, text: str) -> Schedule:
    """Build a schedule from the worker's answer."""
    try:
        samples = np.frombuffer(sound, dtype=np.int16)
        rate = int(header["rate"])
        sounds, marks = read_events(header["events"], header["spelled"], len(samples))
        labels, bounds, index, stress = intervals(sounds, int(PAUSE * rate))
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
