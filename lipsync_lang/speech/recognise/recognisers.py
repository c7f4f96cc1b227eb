"""Which recognisers are known, and what all of them take and give."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeVar

from lipsync_lang.extensions import Extensions

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Audio, Schedule
    from lipsync_lang.speech.speaking import Speaker


class Recogniser(Protocol):
    """What a recogniser does; `recogniser` makes one known."""

    def recognise(self, audio: "Audio", speaker: "Speaker", model: str | None = None) -> "Schedule":
        """Return what is heard, from 0 to the end of the sound, with words where there are some.

        The schedule has the sound and a confidence, and says that it was recognised.
        """
        ...


RECOGNISERS: Extensions[Recogniser] = Extensions(
    "recognisers",
    "recogniser",
    modules={
        "pocketsphinx": f"{__package__}.pocketsphinx_recogniser",
    },
)
"""Recognisers by name."""

R = TypeVar("R", bound=Recogniser)


def recogniser(name: str) -> Callable[[type[R]], type[R]]:
    """Register a class that is made without arguments as a recogniser."""

    def register(made: type[R]) -> type[R]:
        RECOGNISERS.add(name, made(), made.__module__)
        return made

    return register
