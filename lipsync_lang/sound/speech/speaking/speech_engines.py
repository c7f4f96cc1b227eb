"""Registry and interface of speech engines."""

import logging
from collections.abc import Iterable, Iterator
from functools import partial
from typing import Protocol, runtime_checkable

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.base.extensions import Extensions
from lipsync_lang.schedules import Schedule
from lipsync_lang.sound.speech.results import tried

_log = logging.getLogger(__name__)

NO_ENGINE = "none"
"""Engine name for estimated times without sound."""


class Engine(Protocol):
    """Interface of a speech engine; register implementations with `speech_engine`."""

    def speak(self, text: str, voice: str, *, words_per_minute: int | None = None) -> Schedule:
        """Return timed phonemes from 0 s to the end of the sound, with words, pauses and sound."""

    def voices(self) -> dict[str, str]:
        """Map available voice names, as taken by `speak`, to display titles."""


@runtime_checkable
class BatchEngine(Protocol):
    """Interface of a speech engine that speaks many texts at less cost than one by one."""

    def speak_many(
        self, texts: Iterable[str], voice: str, *, words_per_minute: int | None = None
    ) -> Iterable[Schedule | SpeechError]:
        """Return for each text, in order, the schedule of `speak`, or the error that it raises."""


ENGINES: Extensions[Engine] = Extensions(
    "speech_engines",
    "speech engine",
    modules={"espeak": "lipsync_lang.sound.speech.speaking.espeak"},
)
"""Engines by name."""

MIN_WORDS_PER_MINUTE, MAX_WORDS_PER_MINUTE = 80, 350
"""Speeds of the built-in engines; beyond them, times and sound come apart."""

speech_engine = ENGINES.register_instance
"""Decorator that registers a class as the speech engine of a name."""


def refuse_rate(engine: str, words_per_minute: int) -> None:
    """Raise an error for a speed that a built-in engine cannot speak at."""
    if not MIN_WORDS_PER_MINUTE <= words_per_minute <= MAX_WORDS_PER_MINUTE:
        raise SpeechError(
            f"{words_per_minute} words per minute: {engine} speaks {MIN_WORDS_PER_MINUTE} to "
            f"{MAX_WORDS_PER_MINUTE}; stretch the schedule for more"
        )


def refuse_unspeakable(text: str, quoted_text: str, readable: str, most: int) -> None:
    """Raise an error for a text with nothing to say, or with more characters than `most`.

    Parameters
    ----------
    readable : what the text lacks if it has no letter or digit
    """
    if not any(c.isalnum() for c in text):
        raise SpeechError(
            f"{quoted_text} has no letter or digit{readable}, so there is nothing to say; "
            "write at least one word"
        )
    if len(text) > most:
        raise SpeechError(
            f"the text has {len(text)} characters, more than {most}; speak it line by line"
        )


def speak_many(
    texts: Iterable[str], voice: str, *, engine: str = "espeak", words_per_minute: int | None = None
) -> Iterator[Schedule | SpeechError]:
    """Synthesise texts to sound with timed phonemes; yield for each its schedule, or its error.

    An engine with `speak_many` may take some texts ahead of its results.

    Parameters
    ----------
    texts : plain texts; markup is not interpreted
    voice : voice name of the engine, as in a language pack's ``tts.voice``
    engine : a name in `ENGINES`
    words_per_minute : speech rate; None for the engine's default
    """
    _log.info("%s speaks with the voice %s", engine, voice)
    try:
        speaking = ENGINES.find(engine, SpeechError)
    except SpeechError as error:
        yield from (error for _ in texts)
        return
    if isinstance(speaking, BatchEngine):
        yield from speaking.speak_many(texts, voice, words_per_minute=words_per_minute)
        return
    say = partial(speaking.speak, voice=voice, words_per_minute=words_per_minute)
    yield from map(tried(say), texts)
