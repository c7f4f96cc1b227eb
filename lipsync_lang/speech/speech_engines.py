"""Which speech engines are known, and speaking with one of them."""

import logging
from collections.abc import Callable
from typing import Protocol, TypeVar

from lipsync_lang.errors import SpeechError
from lipsync_lang.extensions import Extensions
from lipsync_lang.schedules import Schedule

_log = logging.getLogger(__name__)


class Engine(Protocol):
    """What a speech engine does; `speech_engine` makes one known."""

    def speak(self, text: str, voice: str, *, words_per_minute: int | None = None) -> Schedule:
        """Return timed phonemes from 0 to the end of the sound, with words, pauses and sound."""
        ...

    def voices(self) -> dict[str, str]:
        """Return the voices there are: what `speak` takes, and a title to show."""
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
    """Register a class that is made without arguments as a speech engine."""

    def register(made: type[E]) -> type[E]:
        ENGINES.add(name, made(), made.__module__)
        return made

    return register


def speak(
    text: str, voice: str, *, engine: str = "espeak", words_per_minute: int | None = None
) -> Schedule:
    """Turn text into sound with timed phonemes.

    Parameters
    ----------
    text : what to say; markup in it is not interpreted
    voice : the engine's name of a voice, as a language pack's ``tts.voice`` gives it
    engine : a name in `ENGINES`
    words_per_minute : the speed of speech; None is the engine's own

    Raises
    ------
    SpeechError
        There is nothing to say, no such engine or voice, or the engine failed.
    """
    _log.info("%s speaks with the voice %s", engine, voice)
    speaking = ENGINES.find(engine, SpeechError)
    return speaking.speak(text, voice, words_per_minute=words_per_minute)
