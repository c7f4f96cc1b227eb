"""Registry and interface of recognisers."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeVar

from lipsync_lang.extensions import Extensions

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Audio, Schedule
    from lipsync_lang.speech.speaking import Speaker

SHOWN_CHARS = 200
"""Maximum length of recognised text in a remark."""


class Recogniser(Protocol):
    """Interface of a recogniser; register implementations with `recogniser`."""

    def recognise(self, audio: "Audio", speaker: "Speaker", model: str | None = None) -> "Schedule":
        """Return the recognised phonemes, from 0 s to the end of the sound, with any words.

        The schedule has the sound and a confidence, and is marked as recognised. Threads may call
        this at once; what is slow to load is to be kept for the next recording.
        """
        ...


RECOGNISERS: Extensions[Recogniser] = Extensions(
    "recognisers",
    "recogniser",
    modules={
        "pocketsphinx": f"{__package__}.pocketsphinx_recogniser",
        "whisper": f"{__package__}.whisper_recogniser",
    },
)
"""Recognisers by name."""

R = TypeVar("R", bound=Recogniser)


def recogniser(name: str) -> Callable[[type[R]], type[R]]:
    """Register a class with a constructor without arguments as a recogniser."""

    def register(made: type[R]) -> type[R]:
        RECOGNISERS.add(name, made(), made.__module__)
        return made

    return register


def heard_remark(text: str) -> str:
    """Return a remark that repeats recognised words, or says that there are none."""
    if not text:
        return "no words were heard"
    return f"heard: {text[:SHOWN_CHARS]}{' ...' if len(text) > SHOWN_CHARS else ''}"
