"""Registry and interface of aligners."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeVar

from lipsync_lang.extensions import Extensions

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Audio, Schedule
    from lipsync_lang.speech.speaking import Speaker


class Aligner(Protocol):
    """Interface of an aligner; register implementations with `aligner`."""

    def align(
        self, audio: "Audio", text: str, speaker: "Speaker", model: str | None = None
    ) -> "Schedule":
        """Return the phoneme times of a text, from 0 s to the end of the sound, with words.

        The schedule has the sound, a confidence, and remarks on mismatches of text and sound.
        """
        ...


ALIGNERS: Extensions[Aligner] = Extensions(
    "aligners",
    "aligner",
    modules={
        "pocketsphinx": f"{__package__}.pocketsphinx_aligner",
        "warp": f"{__package__}.warping",
    },
)
"""Aligners by name."""

A = TypeVar("A", bound=Aligner)


def aligner(name: str) -> Callable[[type[A]], type[A]]:
    """Register a class with a constructor without arguments as an aligner."""

    def register(made: type[A]) -> type[A]:
        ALIGNERS.add(name, made(), made.__module__)
        return made

    return register
