"""Speech by eSpeak NG: text in, a schedule with sound out.

The library answers with events at sample positions; `espeak_events` makes contiguous phonemes of
them, `word_spans` the words.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from lipsync_lang.errors import SpeechError
from lipsync_lang.phonology.espeak.process import EspeakProcess, blank, quoted
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule
from lipsync_lang.speech.espeak_events import intervals, read_events
from lipsync_lang.speech.speech_engines import speech_engine
from lipsync_lang.speech.word_spans import find_words

SLOWEST, FASTEST = 80, 350
"""Words per minute; faster speech is squeezed afterwards, and its events are not."""

LONGEST = 50_000
"""Characters, about an hour of speech; a longer text is a book, and comes in lines."""

PAUSE = 0.09
"""Seconds; a shorter silence between two sounds is articulation, not a pause."""


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
            There is nothing to say, no such voice, the library is missing, or it failed.
        """
        rate = _rate(words_per_minute)
        spoken = _plain(text)
        header, sound = self.ask("speak", text=spoken, voice=voice, rate=rate)
        return _schedule(header, sound, spoken)


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
    """Blank out, one for one, characters that steer the library or that are none."""
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
    """Make a schedule of the worker's answer."""
    try:
        samples = np.frombuffer(sound, dtype=np.int16)
        rate = int(header["rate"])
        sounds, marks = read_events(header["events"], header["spelled"], len(samples))
        labels, bounds, index = intervals(sounds, int(PAUSE * rate))
    except (KeyError, ValueError, TypeError, AttributeError):
        raise SpeechError("eSpeak NG gave no answer that makes sense; try again") from None
    if all(label == SILENCE for label in labels):
        raise SpeechError(
            f"eSpeak NG says nothing for {quoted(text)} in this voice{header['said']}; "
            "is the text in the voice's script?"
        )
    return Schedule(
        tuple(labels),
        np.array(bounds) / rate,
        words=find_words(text, [(at, index[number]) for at, number in marks], labels),
        notation="ipa",
        audio=Audio(samples, rate),
        source=f"speech {quoted(text)}",
    )
