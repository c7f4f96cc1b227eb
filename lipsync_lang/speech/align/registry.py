"""Which aligners are known, and what all of them take and give."""

from typing import TYPE_CHECKING, Protocol

from lipsync_lang.speech.align.pocketsphinx_aligner import PocketsphinxAligner
from lipsync_lang.speech.align.warping import Warp

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Audio, Schedule
    from lipsync_lang.speech.speaking import Speaker


class Aligner(Protocol):
    """What an aligner does; a studio's own is one small class in `ALIGNERS`."""

    def align(
        self, audio: "Audio", text: str, speaker: "Speaker", model: str | None = None
    ) -> "Schedule":
        """Return when each phoneme of a text is said, from 0 to the end of the sound, with words.

        The schedule has the sound, a confidence, and remarks where text and sound disagree.
        """
        ...


ALIGNERS: dict[str, Aligner] = {"pocketsphinx": PocketsphinxAligner(), "warp": Warp()}
"""Aligners by name; add to it to make one known."""
