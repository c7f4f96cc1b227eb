"""Registry and interface of aligners."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from lipsync_lang.base.extensions import Extensions
from lipsync_lang.schedules.schedule import Audio, Schedule
from lipsync_lang.sound.speech.results import raised

if TYPE_CHECKING:
    from lipsync_lang.base.errors import SpeechError
    from lipsync_lang.sound.speech.speaking.speaker import Speaker

UnreadRecordings = Iterable[tuple[Callable[[], Audio], str]]
"""Functions that read recordings, each with the text of its recording."""


class Aligner(Protocol):
    """Interface of an aligner; register implementations with `aligner`."""

    def align(
        self, audio: Audio, text: str, speaker: "Speaker", model: str | None = None
    ) -> Schedule:
        """Return the phoneme times of a text, from 0 s to the end of the sound, with words.

        The schedule has the sound, a confidence, and remarks on mismatches of text and sound.
        """


@runtime_checkable
class BatchAligner(Aligner, Protocol):
    """Interface of an aligner that aligns many texts at less cost than one by one."""

    def align(
        self, audio: Audio, text: str, speaker: "Speaker", model: str | None = None
    ) -> Schedule:
        """Align as `align_many` does; a text that does not fit its sound is a `SpeechError`."""
        (found,) = self.align_many([(lambda: audio, text)], speaker, model)
        return raised(found)

    def align_many(
        self, recordings: UnreadRecordings, speaker: "Speaker", model: str | None = None
    ) -> "Iterable[Schedule | SpeechError]":
        """Return for each text, in order, the schedule of `align`, or the error that it raises.

        Texts may be taken ahead; each recording comes as a function that reads it.
        """


ALIGNERS: Extensions[Aligner] = Extensions(
    "aligners",
    "aligner",
    modules={
        "pocketsphinx": f"{__package__}.pocketsphinx_aligner",
        "warp": f"{__package__}.warping",
    },
)
"""Aligners by name."""

aligner = ALIGNERS.register_instance
"""Decorator that registers a class as the aligner of a name."""
