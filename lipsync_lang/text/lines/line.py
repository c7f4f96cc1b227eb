"""`Line`, one spoken line of a script with its place in the file."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Schedule


@dataclass(frozen=True)
class Line:
    """A line of a script.

    Parameters
    ----------
    text : the spoken text, without markup and placeholders
    place : `file:line`
    name : the line's own name in its file; may be empty
    speaker : the speaker's name; empty if unknown
    schedule : its timed phonemes, if the file has some
    dropped : markup and placeholders that are not spoken, in order
    gaps : offsets in the text, in order, of speech that the file does not contain
    original : the text that this one translates; empty if the file does not have it
    """

    text: str
    place: str
    name: str = ""
    speaker: str = ""
    schedule: "Schedule | None" = None
    dropped: tuple[str, ...] = ()
    gaps: tuple[int, ...] = ()
    original: str = ""

    @property
    def file(self) -> str:
        """The file in its place."""
        return self.place.rpartition(":")[0]
