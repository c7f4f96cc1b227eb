"""Which recognisers are known, and what all of them take and give."""

from typing import TYPE_CHECKING, Protocol

from lipsync_lang.speech.recognise.pocketsphinx_recogniser import PocketsphinxRecogniser

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Audio, Schedule
    from lipsync_lang.speech.speaking import Speaker


class Recogniser(Protocol):
    """What a recogniser does; a studio's own is one small class in `RECOGNISERS`."""

    def recognise(self, audio: "Audio", speaker: "Speaker", model: str | None = None) -> "Schedule":
        """Return what is heard, from 0 to the end of the sound, with words where there are some.

        The schedule has the sound and a confidence, and says that it was recognised.
        """
        ...


RECOGNISERS: dict[str, Recogniser] = {"pocketsphinx": PocketsphinxRecogniser()}
"""Recognisers by name; add to it to make one known."""
