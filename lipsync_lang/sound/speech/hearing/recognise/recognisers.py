"""Registry and interface of recognisers."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from lipsync_lang.base.errors import shortlist
from lipsync_lang.base.extensions import Extensions

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Audio, Schedule
    from lipsync_lang.sound.speech.speaking.speaker import Speaker

SHOWN_CHARS = 200
"""Maximum length of recognised text in a remark."""

PUNCTUATION = ' .,;:!?…"-'
"""Signs around words, which remarks leave out."""


class Recogniser(Protocol):
    """Interface of a recogniser; register implementations with `recogniser`."""

    def recognise(self, audio: "Audio", speaker: "Speaker", model: str | None = None) -> "Schedule":
        """Return the recognised phonemes, from 0 s to the end of the sound, with any words.

        The schedule has the sound and a confidence, and is marked as recognised. Threads may call
        this at once; what is slow to load is to be kept for the next recording.
        """


@runtime_checkable
class WordRecogniser(Recogniser, Protocol):
    """Interface of a recogniser of words that hears languages whose packs name no recogniser."""

    def knows(self, speaker: "Speaker") -> bool:
        """Return True if a model is installed that knows the language."""


RECOGNISERS: Extensions[Recogniser] = Extensions(
    "recognisers",
    "recogniser",
    modules={
        "pocketsphinx": f"{__package__}.pocketsphinx_recogniser",
        "sound": "lipsync_lang.sound.listening.recording",
    },
)
"""Recognisers by name."""

recogniser = RECOGNISERS.register_instance
"""Decorator that registers a class as the recogniser of a name."""


def heard_remark(text: str) -> str:
    """Return a remark that repeats recognised words, or says that no word was recognised."""
    if not text:
        return "no words were heard"
    return f"heard: {text[:SHOWN_CHARS]}{' ...' if len(text) > SHOWN_CHARS else ''}"


def doubt_remarks(words: Sequence[tuple[str, float]]) -> list[str]:
    """Return a remark that names doubtful words with their seconds; none without such words."""
    return [f"words in doubt: {shortlist([placed(*word) for word in words])}"] if words else []


def placed(text: str, seconds: float) -> str:
    """Return a word with its time, for remarks."""
    return f"'{text.strip(PUNCTUATION)}' at {seconds:.1f} s"
