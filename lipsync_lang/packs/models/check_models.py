"""The form of what a finished animation is held against: rules of a face, and limits."""

from typing import Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lipsync_lang.packs.models.fields import NotNegative, Positive, Sound, Strict, Text, Unit


class MeasureRule(Strict):
    """What a measure of the pose set must show at some frame of each of certain phonemes."""

    phonemes: tuple[Sound, ...] = Field(min_length=1)
    """The phonemes it is about."""
    measure: Text
    """A measure of the pose set."""
    at_least: float | None = None
    """What it must reach."""
    at_most: float | None = None
    """What it must come down to."""
    missed: Unit = 0.0
    """The share of the phonemes that may miss it."""

    @model_validator(mode="after")
    def _can_be_met(self) -> Self:
        if self.at_least is None and self.at_most is None:
            what = "the rule bounds nothing: give `at_least`, `at_most` or both"
            raise PydanticCustomError("P115", what, {"field": "measure"})
        if self.at_least is not None and self.at_most is not None and self.at_least > self.at_most:
            what = "`at_least` is more than `at_most`, so that nothing is both"
            raise PydanticCustomError("P115", what, {"field": "at_least"})
        return self


class Checks(Strict):
    """Limits of a finished animation's quality; what is not stated is the usual."""

    rules: dict[Text, MeasureRule] = Field(default={})
    """What measures of the pose set must show at certain phonemes, by a name of its own."""
    contacts: Unit | None = None
    """Share of the phonemes that demand a contact that may miss it."""
    false_contacts: Unit | None = None
    """Share of the other sounds that may make one all the same."""
    closure_late: NotNegative | None = None
    """Seconds by which a contact may come late."""
    closure_early: NotNegative | None = None
    """Seconds by which a contact may come early."""
    closure_offset: NotNegative | None = None
    """Seconds by which the median contact may be off, either way."""
    constraints: Unit | None = None
    """Share of frames in which poses may break a constraint."""
    speed: Positive | None = None
    """Weight per second that no pose may pass; the motion's `speed_limit` unless stated."""
    jitter: NotNegative | None = None
    """Flickers that the worst pose may make in a second of speech."""
    changes: NotNegative | None = None
    """Changes of the strongest pose in a second of speech."""
    short_holds: Unit | None = None
    """Share of the strongest pose's stays that may be shorter than 0.1 s."""
    silence: NotNegative | None = None
    """How far a pose may move while nothing is said."""
    saturation: Unit | None = None
    """Share of the frames of speech in which a pose may stand at its most."""
    still: Unit | None = None
    """Share of the frames of speech in which nothing may move."""
