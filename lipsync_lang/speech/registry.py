"""Which speech engines are known, and speaking with one of them."""

from typing import Protocol

from lipsync_lang.errors import SpeechError, did_you_mean
from lipsync_lang.schedules import Schedule
from lipsync_lang.speech.espeak import Espeak
from lipsync_lang.speech.festival import Festival


class Engine(Protocol):
    """What a speech engine does; a studio's own is one small class in `ENGINES`."""

    def speak(self, text: str, voice: str, *, words_per_minute: int | None = None) -> Schedule:
        """Return timed phonemes from 0 to the end of the sound, with words, pauses and sound."""
        ...

    def voices(self) -> dict[str, str]:
        """Return the voices there are: what `speak` takes, and a title to show."""
        ...


ENGINES: dict[str, Engine] = {"espeak": Espeak(), "festival": Festival()}
"""Engines by name; add to it to make one known."""


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
    if engine not in ENGINES:
        raise SpeechError(f"no speech engine '{engine}'; {did_you_mean(engine, ENGINES)}")
    return ENGINES[engine].speak(text, voice, words_per_minute=words_per_minute)
