"""A line: one thing that somebody says, and where it is written."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Schedule


@dataclass(frozen=True)
class Line:
    """One line of a script.

    Parameters
    ----------
    text : what is spoken, markup and placeholders removed
    place : `file:line`
    name : the line's own name in its file; empty where it has none
    speaker : who says it; empty where the file does not tell
    schedule : its timed phonemes, where the file holds some
    dropped : markup and placeholders that are not spoken, in order
    gaps : places in the text, in order, where something is said that the text does not tell
    """

    text: str
    place: str
    name: str = ""
    speaker: str = ""
    schedule: "Schedule | None" = None
    dropped: tuple[str, ...] = ()
    gaps: tuple[int, ...] = ()

    @property
    def file(self) -> str:
        """The file of its place."""
        return self.place.rpartition(":")[0]
