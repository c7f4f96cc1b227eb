"""Text in a language: which voice speaks it is the language pack's word."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from lipsync_lang.errors import SpeechError
from lipsync_lang.schedules.schedule import Schedule


def speak(
    text: str,
    language: str,
    *,
    engine: str | None = None,
    words_per_minute: int | None = None,
    paths: Sequence[str | Path] = (),
) -> Schedule:
    """Speak text with the voice its language pack names.

    Parameters
    ----------
    text : what to say
    language : a language pack's name or tag
    engine : another speech engine than the pack's
    words_per_minute : the speed of speech; None is the engine's own
    paths : folders to search for packs before all others

    Raises
    ------
    SpeechError
        There is nothing to say, the language has no voice, or the engine failed.
    """
    from lipsync_lang.packs.library import Library

    pack = Library(paths).language(language).model
    voice = (pack.tts.engine, pack.tts.voice or "") if pack.tts else None
    return speak_as(text, pack.name, voice, engine=engine, words_per_minute=words_per_minute)


def speak_as(
    text: str,
    language: str,
    voice: tuple[str, str] | None,
    *,
    engine: str | None = None,
    words_per_minute: int | None = None,
) -> Schedule:
    """Speak text with a voice that is known already: (engine, voice)."""
    from lipsync_lang.speech import speak as say

    if voice is None:
        raise SpeechError(
            f"{language} names no voice: give its pack a `tts`, or give timed phonemes (--schedule)"
        )
    schedule = say(text, voice[1], engine=engine or voice[0], words_per_minute=words_per_minute)
    return replace(schedule, language=language)
