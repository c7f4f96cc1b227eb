"""Model of a read-out: what the columns of a table of sensors say of the measures of a pose set."""

from typing import Annotated, Literal

from pydantic import Field

from lipsync_lang.packs.models.fields import Name, PackModel, Text


class ReadOut(PackModel):
    """Measures of a pose set as sums of the columns of sensors, for captures without weights."""

    kind: Literal["readout"]
    """The kind of file."""
    name: Name = "readout"
    """Name of the read-out."""
    measures: Annotated[
        dict[Text, Annotated[dict[Text, float], Field(min_length=1)]], Field(min_length=1)
    ]
    """For each measure of the pose set, columns with their weights; the measure follows their sum.
    Its scale and its zero are unknown, and are fitted."""
    lost: float | None = None
    """Value of a column while its sensor is lost. Empty cells and `nan` always mean that."""
    notation: Text | None = None
    """Notation of the labels in the timings. By default the language pack tells it."""
    silences: tuple[Text, ...] = ()
    """Labels of silence in the timings, besides those of the language pack."""
