"""Voices of speech engines, without a language."""

from lipsync_lang.sound.speech import speak_many
from lipsync_lang.sound.speech.results import raised


def speak(text, voice, **how):
    """Speak a text with a voice, as `speak_many` speaks several."""
    return raised(next(speak_many([text], voice, **how)))
