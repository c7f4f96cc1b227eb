"""Models of gestures: shapes of the face that speech does not move, and curves placed on them.

Times are in seconds. Amounts are weights, or degrees where a pose turns a bone.
"""

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from lipsync_lang.packs.models.fields import (
    Axis,
    NotNegative,
    OrOne,
    PoseName,
    Positive,
    Strict,
    Text,
    Unit,
    Vector,
)

Trigger = Literal[
    "pause", "phrase_end", "emphasis", "stress", "rise", "question", "denial", "agreement"
]
"""A fact of a line at which a gesture is placed."""

GestureScale = Annotated[float, Field(ge=0, le=2)]
"""Scale of a gesture: 0 leaves it out, 1 is as the pose set states."""

HEAD_REGION = "head"
"""Region whose poses turn the head."""

STEEPEST = 1.5
"""Greatest slope of the rounded step between two points, over that of the straight line."""


class GesturePose(Strict):
    """A shape that only gestures move, or the turn of a bone."""

    title: str = ""
    """The shape in words."""
    region: Text
    """The part of the face that the pose moves, such as eyes, brows or head; other programs get
    the turns of the region `head`."""
    names: tuple[Text, ...] = ()
    """Other names of the pose in models; `{Left,Right}` stands for two names, `*` for any text."""
    node: Text | None = None
    """The bone to turn; without it, the pose is a shape."""
    rotation: Axis | None = None
    """The axis of the turn; amounts are degrees, and those below 0 turn the other way."""
    most: Positive = 1.0
    """The largest amount: a weight up to 1, or degrees either way."""
    speed_limit: Positive
    """The highest speed, in weight or degrees per second."""

    @model_validator(mode="after")
    def _turns(self) -> Self:
        if (self.node is None) != (self.rotation is None):
            what = "a pose in degrees needs `node`, the bone, and `rotation`, its axis"
            field = "node" if self.node is not None else "rotation"
            raise PydanticCustomError("P115", what, {"field": field})
        if self.node is None and self.most > 1:
            what = "a shape has a weight of at most 1; `most` is for degrees"
            raise PydanticCustomError("P115", what, {"field": "most"})
        return self

    def head_axis(self, front: str) -> Vector | None:
        """Return the axis of a turn of the head in axes of the face, which looks along `front`."""
        if self.rotation is None or self.region != HEAD_REGION:
            return None
        x, y, z = self.rotation
        # a face that looks the other way is turned by half a turn about y
        return (x, y, z) if front == "z" else (-x, y, -z)


def _from_rest_to_rest(points: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """Refuse a curve whose times do not rise from 0, or that does not begin and end at rest."""
    if points[0] != (0, 0) or points[-1][1] != 0:
        what = "a gesture begins at [0, 0] and ends at rest: its last value is 0"
        raise PydanticCustomError(
            "P113", what, {"at": 0 if points[0] != (0, 0) else len(points) - 1}
        )
    # two points at one time would be a jump, which no speed allows
    for index, ((before, _), (time, _)) in enumerate(pairwise(points)):
        if time <= before:
            what = "times fall from {before} to {time}; the times of a gesture must rise"
            told = {"before": f"{before:g}", "time": f"{time:g}", "at": index + 1}
            raise PydanticCustomError("P113", what, told)
    return points


class PerMinute(Strict):
    """Rates of a gesture that comes by itself."""

    speech: Annotated[float, Field(ge=0, le=120)]
    """Times a minute while speech is heard."""
    silence: Annotated[float, Field(ge=0, le=120)]
    """Times a minute in pauses."""


class Gesture(Strict):
    """A movement that is placed in a line by its facts, or by a rate."""

    poses: dict[PoseName, float] = Field(min_length=1)
    """The amount of each pose where the curve is 1."""
    curve: Annotated[
        tuple[tuple[NotNegative, Annotated[float, Field(ge=-1, le=1)]], ...],
        Field(min_length=3, max_length=64),
        AfterValidator(_from_rest_to_rest),
    ]
    """Points [seconds, value] from rest to rest; the movement between two of them is rounded."""
    on: Annotated[tuple[Trigger, ...], OrOne] = ()
    """The facts at which the gesture is placed; or `per_minute`."""
    share: Unit = 1.0
    """The share of those facts that have the gesture."""
    lead: Annotated[float, Field(ge=-0.5, le=0.5)] = 0.0
    """Seconds by which the gesture begins before its fact; below 0, after it."""
    per_minute: PerMinute | None = None
    """Rates of a gesture that comes by itself, at intervals drawn for the line; or `on`."""
    at: Annotated[tuple[Trigger, ...], OrOne] = ()
    """Facts that draw such a gesture to them, if one is near."""
    apart: Annotated[float, Field(ge=0, le=60)] = 0.0
    """Least seconds between the beginnings of two such gestures, if more than its length."""
    spread: Annotated[float, Field(ge=0, le=2)] = 0.7
    """Irregularity of `per_minute`: standard deviation of the logarithm of the intervals."""
    height: Literal["full", "pitch"] = "full"
    """`pitch` scales the gesture by the rise of the voice, where there is sound."""

    @model_validator(mode="after")
    def _placed(self) -> Self:
        if bool(self.on) == (self.per_minute is not None):
            what = "a gesture is placed either `on` a fact, or so many times `per_minute`"
            field = "on" if self.on else "poses"
            raise PydanticCustomError("P115", what, {"field": field})
        if self.at and self.per_minute is None:
            what = "`at` draws gestures that come `per_minute`; write `on` alone instead"
            raise PydanticCustomError("P115", what, {"field": "at"})
        return self

    def speed(self, pose: str) -> float:
        """Return the highest speed of a pose, in its amount per second."""
        # between two points the curve is eased, and steepest in the middle
        slopes = (abs(b - a) / (end - begin) for (begin, a), (end, b) in pairwise(self.curve))
        return STEEPEST * abs(self.poses[pose]) * max(slopes)

    def amounts(self, pose: str) -> tuple[float, float]:
        """Return the least and the greatest amount of a pose."""
        # the amount of a pose may be negative, and then the curve's top is its least
        found = sorted(self.poses[pose] * value for _, value in self.curve)
        return found[0], found[-1]


class GestureByHand(Strict):
    """A gesture that a person placed in a line."""

    gesture: Text
    """The gesture of the pose set."""
    at: Annotated[float, Field(ge=0)] | None = None
    """Seconds in the line at which it begins, for a gesture with `lead` by so much earlier."""
    word: Annotated[int, Field(ge=0)] | None = None
    """The word at whose beginning it is placed, counted from 0; or `at`."""
    after: Annotated[float, Field(ge=-60, le=60)] = 0.0
    """Seconds after the beginning of the word; below 0, before it."""
    scale: GestureScale = 1.0
    """Scale of this one; 0 is none, and keeps those away that come by rule."""

    @model_validator(mode="after")
    def _somewhere(self) -> Self:
        if (self.at is None) == (self.word is None):
            what = "a gesture by hand is placed either `at` seconds, or at a `word`"
            raise PydanticCustomError(
                "P115", what, {"field": "gesture" if self.at is None else "at"}
            )
        # `at` is a time itself: a second one would only be added to it
        if self.word is None and self.after:
            raise PydanticCustomError("P115", "`after` needs the `word`", {"field": "after"})
        return self


class GestureWords(Strict):
    """Words of a language that facts of gestures begin with."""

    question: tuple[Text, ...] = ()
    """Words that ask, such as `who`; the voice asks as well, by the fact `rise`."""
    denial: tuple[Text, ...] = ()
    """Words that deny, such as `no`."""
    agreement: tuple[Text, ...] = ()
    """Words that agree, such as `yes`."""
