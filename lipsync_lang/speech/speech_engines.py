"""Registry and interface of speech engines."""

import logging
from collections.abc import Callable
from typing import Protocol, TypeVar

from lipsync_lang.errors import SpeechError
from lipsync_lang.extensions import Extensions
from lipsync_lang.schedules import Schedule

_log = logging.getLogger(__name__)


class Engine(Protocol):
    """Interface of a speech engine; register implementations with `speech_engine`."""

    def speak(self, text: str, voice: str, *, words_per_minute: int | None = None) -> Schedule:
        """Return timed phonemes from 0 s to the end of the sound, with words, pauses and sound."""
        ...

    def voices(self) -> dict[str, str]:
        """Map available voice names, as taken by `speak`, to display titles."""
        ...


ENGINES: Extensions[Engine] = Extensions(
    "speech_engines",
    "speech engine",
    modules={
        "espeak": "lipsync_lang.speech.espeak",
        "festival": "lipsync_lang.speech.festival",
    },
)
"""Engines by name."""

E = TypeVar("E", bound=Engine)


def speech_engine(name: str) -> Callable[[type[E]], type[E]]:
    """Register a class with a constructor without arguments as a speech engine."""

    def register(made: type[E]) -> type[E]:
        ENGINES.add(name, made(), made.__module__)
        return made

    return register


def speak(
    text: str, voice: str, *, engine: str = "espeak", words_per_minute: int | None = None
) -> Schedule:
    """Synthesise text to sound with timed phonemes.

    Parameters
    ----------
    text : plain text; markup is not interpreted
    voice : voice name of the engine, as in a language pack's ``tts.voice``
    engine : a name in `ENGINES`
    words_per_minute : speech rate; None for the engine's default

    Raises
    ------
    SpeechError
        The text is empty, the engine or voice is unknown, or the engine failed.
    """
    _log.info("%s speaks with the voice %s", engine, voice)
    speaking = ENGINES.find(engine, SpeechError)
    return speaking.speak(text, voice, words_per_minute=words_per_minute)
