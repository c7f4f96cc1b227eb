"""Models of measures: the checks of finished animations, and read-outs of sensors."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lipsync_lang.packs.models.fields import (
    Name,
    NotNegative,
    PackModel,
    Positive,
    Sound,
    Strict,
    Text,
    Unit,
)


class MeasureRule(Strict):
    """A bound that a measure must reach in some frame of each of the listed phonemes."""

    phonemes: tuple[Sound, ...] = Field(min_length=1)
    """The phonemes checked."""
    measure: Text
    """A measure of the pose set."""
    at_least: float | None = None
    """The value that the measure must reach."""
    at_most: float | None = None
    """The value that the measure must fall to."""
    missed: Unit = 0.0
    """Share of the phonemes that may miss the bounds."""

    @model_validator(mode="after")
    def _can_be_met(self) -> Self:
        if self.at_least is None and self.at_most is None:
            what = "the rule has no bound: give `at_least`, `at_most` or both"
            raise PydanticCustomError("P115", what, {"field": "measure"})
        if self.at_least is not None and self.at_most is not None and self.at_least > self.at_most:
            what = "`at_least` is more than `at_most`, so no value meets both"
            raise PydanticCustomError("P115", what, {"field": "at_least"})
        return self


class Checks(Strict):
    """Limits for the quality of a finished animation; unstated limits have their defaults."""

    rules: dict[Text, MeasureRule] = Field(default={})
    """Bounds for measures of the pose set at certain phonemes, by name."""
    contacts: Unit | None = None
    """Share of the phonemes with a contact that may miss it."""
    false_contacts: Unit | None = None
    """Share of the other phonemes that may make a contact."""
    clashes: NotNegative | None = None
    """Seconds for which two contacts that exclude each other may both be half made."""
    closure_late: NotNegative | None = None
    """Seconds by which a contact may come late."""
    closure_early: NotNegative | None = None
    """Seconds by which a contact may come early."""
    closure_offset: NotNegative | None = None
    """Seconds by which the median contact may be early or late."""
    unopened: Unit | None = None
    """Share of the vowels that may leave the mouth closed."""
    seen_opening: NotNegative | None = None
    """Times by which the mouth of a model may open farther or less far than in film."""
    seen_flaps: Unit | None = None
    """Share of the consonants that may open the mouth of a model far more than in film."""
    seen_slits: Unit | None = None
    """Share of the rounded vowels that may be nearly shut on a model."""
    seen_gaps: Unit | None = None
    """Share of the sounds with shut lips that may leave the lips of a model apart."""
    seen_width: NotNegative | None = None
    """Range of the width of a model's mouth, in widths of the mouth."""
    seen_rounding: NotNegative | None = None
    """Times by which rounded lips of a model may narrow less far than in film."""
    constraints: Unit | None = None
    """Share of frames in which poses may break a constraint."""
    speed: Positive | None = None
    """Highest speed of a pose, in weight per second; by default the motion's `speed_limit`."""
    jitter: NotNegative | None = None
    """Flickers per second of speech of the worst pose."""
    changes: NotNegative | None = None
    """Changes of the strongest pose per second of speech."""
    short_holds: Unit | None = None
    """Share of the strongest pose's holds that may be shorter than 0.06 s."""
    silence: NotNegative | None = None
    """Largest change of a pose's weight during silence."""
    saturation: Unit | None = None
    """Share of the frames of speech in which a pose may stand at its maximum."""
    still: Unit | None = None
    """Share of the frames of speech without movement."""
    jerk: NotNegative | None = None
    """Jerk of the jaw (95th percentile), in shares of its peak per second cubed."""
    high_power: Unit | None = None
    """Share of the jaw's power above 8 Hz."""
    shelves: Unit | None = None
    """Share of the frames with an open jaw in which it stands still."""
    turns: NotNegative | None = None
    """Turns of the jaw per second."""
    lead_missing: NotNegative | None = None
    """Seconds by which poses that look ahead may begin later than 0.1 s before their sound."""
    shut_vowels: Unit | None = None
    """Share of the sounds beside a contact that should open the mouth and may stay shut."""
    opening_lag: NotNegative | None = None
    """Seconds until the mouth opens after a contact (median)."""


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
