"""The form of what animators write: pose sets, banks, characters and rigs.

A validator here sees one file; what needs two files or two places is in `checks`. Times are in
seconds, normalised times and weights from 0 to 1, angles in degrees.
"""

from itertools import pairwise
from math import inf
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from lipsync_lang.packs.models.attribute_docs import descriptions
from lipsync_lang.packs.models.check_models import Checks
from lipsync_lang.packs.models.fields import (
    BigramKey,
    Common,
    Curves,
    Data,
    Name,
    NotNegative,
    OrEmpty,
    OrOne,
    PackModel,
    PoseName,
    Short,
    Sound,
    Strict,
    Text,
    Unit,
)
from lipsync_lang.pipeline.motion import LEAST_SPEED

FREE = 2.0
"""A threshold that two weights never pass: it binds nothing."""

Softness = Annotated[float, Field(ge=0, le=0.2)]
"""Seconds from the middle of a kernel to its end."""


class Pose(Strict):
    """One face or tongue shape."""

    title: str = ""
    """The shape in words."""
    region: str = ""
    """The part of the face it moves; a dial scales the poses of one region."""
    softness: Softness | None = None
    """Seconds over which it is rounded off, where that is not its region's."""
    anticipate: Annotated[float, Field(ge=0, le=1)] = 0
    """Seconds by which it begins before its sound, as far as nothing opposes it."""
    names: tuple[Text, ...] = ()
    """How models spell it otherwise; `{Left,Right}` stands for two names, `*` for anything."""


class Threshold(Strict):
    """Two poses that must not add up to more than a threshold."""

    between: tuple[PoseName, PoseName]
    """The two poses."""
    threshold: Annotated[float, Field(gt=0, le=2)]
    """The most they may add up to."""
    paper: Annotated[float, Field(gt=0, le=2)] | None = None
    """The same where the motion asks for the paper's thresholds."""


class AtMost(Strict):
    """A pose that never passes another."""

    pose: PoseName
    """The pose that yields."""
    at_most: PoseName
    """The pose it never passes."""


def _constraint_form(value: Data) -> str:
    """Tell the two forms of a constraint apart."""
    if isinstance(value, AtMost):
        return "<at_most>"
    at_most = isinstance(value, dict) and ("at_most" in value or "pose" in value)
    return "<at_most>" if at_most else "<between>"


Constraint = Annotated[
    Annotated[Threshold, Tag("<between>")] | Annotated[AtMost, Tag("<at_most>")],
    Discriminator(_constraint_form),
]


class Constraints(Strict):
    """Which poses make way for which."""

    default: Annotated[float, Field(gt=0, le=2)] = 2.0
    """The threshold of pairs that are not listed; 2 leaves them alone."""
    pairs: tuple[Constraint, ...] = ()
    """Pairs with a threshold of their own, and poses that never pass another."""


class ContactRule(Strict):
    """What must be seen whenever certain phonemes are heard."""

    phonemes: tuple[Sound, ...] = Field(min_length=1)
    """The phonemes that demand it."""
    floor: dict[PoseName, Unit] = Field(default={})
    """How far these poses must rise."""
    ceiling: dict[PoseName, Unit] = Field(default={})
    """How far these poses may rise."""


class MotionFields(Strict):
    """How curves are joined and kept from moving too fast; what is not stated is the usual."""

    preset: Text | None = None
    """A named set of values that the others here refine."""
    stitch: Literal["max", "crossfade"] | None = None
    """How overlapping bigrams join."""
    warp: Literal["anchored", "linear"] | None = None
    """How a bigram fits its two phonemes."""
    smooth: Literal["closing", "chord", "none"] | None = None
    """How valleys between peaks are filled."""
    window: NotNegative | None = None
    """Seconds; valleys narrower than this are filled."""
    anticipate: Annotated[float, Field(ge=0, le=4)] | None = None
    """Factor of how early poses begin that look ahead."""
    speed_limit: Annotated[float, Field(ge=LEAST_SPEED)] | None = None
    """Weight per second that no pose passes."""
    silence_reach: NotNegative | None = None
    """Seconds of a pause in which the mouth still moves."""
    contacts: Literal["hold", "free"] | None = None
    """Whether contacts are held."""
    limit: Literal["before", "after"] | None = None
    """Whether speed is limited before or after constraints."""
    thresholds: Literal["own", "paper"] | None = None
    """Whose thresholds constrain."""
    softness: Annotated[float, Field(ge=0, le=4)] | None = None
    """Factor of the seconds over which poses are rounded off."""
    hold: NotNegative | None = None
    """Seconds; poses are shown one at a time, each at least as long; at 0 they blend."""


class Intensity(Strict):
    """How far loudness moves the mouth, where it is asked for."""

    regions: tuple[Text, ...] = Field(min_length=1)
    """The regions whose poses it scales."""
    least: Unit = 0.6
    """How far they move where a sound is much softer than others of its class; 1 is as usual."""
    most: Annotated[float, Field(ge=1, le=2)] = 1.4
    """How far they move where it is much louder."""


class PhonemeTarget(Strict):
    """How poses stand at a phoneme, and how strongly they insist."""

    weights: dict[PoseName, Unit] = Field(default={})
    """The weight of each pose."""
    dominance: dict[PoseName, NotNegative] = Field(default={})
    """How strongly each pose insists against the neighbours' targets; or one number for all."""
    overall: NotNegative | None = None
    """One dominance for all poses, but those that a constraint sets against a named one."""


def _target(value: Data) -> Data:
    """Part the poses of a target from its reserved key."""
    if not isinstance(value, dict) or "weights" in value:
        return value
    rest = {pose: weight for pose, weight in value.items() if pose != "dominance"}
    if "dominance" not in value:
        return {"weights": rest}
    stated = value["dominance"]
    if isinstance(stated, bool) or not isinstance(stated, (int, float)):
        return {"weights": rest, "dominance": stated}
    if not 0 <= stated < inf:
        what = "`dominance` must be a finite number and at least 0, got {got}"
        raise PydanticCustomError("P104", what, {"got": f"{stated:g}", "field": "dominance"})
    return {"weights": rest, "overall": stated}


FlatTarget = Short(
    _target,
    forms=lambda _: [
        {
            "type": "object",
            "description": PhonemeTarget.__doc__,
            "properties": {
                "dominance": {
                    "description": descriptions(PhonemeTarget)["dominance"],
                    "anyOf": [
                        {
                            "type": "object",
                            "additionalProperties": {"type": "number", "minimum": 0},
                        },
                        {"type": "number", "minimum": 0},
                    ],
                }
            },
            "additionalProperties": {"type": "number", "minimum": 0, "maximum": 1},
        }
    ],
)

Targets = Annotated[tuple[Annotated[PhonemeTarget, FlatTarget], ...], Field(min_length=1), OrOne]


class PoseSet(PackModel):
    """The poses of a family of faces, how they get along, and where they stand in speech."""

    kind: Literal["poseset"]
    """The kind of pack."""
    poses: dict[PoseName, Annotated[Pose, OrEmpty]] = Field(min_length=1)
    """Every pose, in the order of the curves."""
    neutral: Text | None = None
    """What the face at rest is called, where every shape has a name."""
    constraints: Constraints = Constraints()
    """Which poses make way for which."""
    softness: dict[Text, Softness] = Field(default={})
    """Seconds over which the poses of a region are rounded off; 0.04 unless stated."""
    priority: tuple[PoseName, ...] = ()
    """Poses that yield, lowest first; poses not named never yield."""
    contacts: dict[Text, ContactRule] = Field(default={})
    """What must be seen, at any speed and frame rate."""
    motion: MotionFields = MotionFields()
    """How curves are joined and kept from moving too fast."""
    intensity: Intensity | None = None
    """What loudness moves, and how far."""
    targets: dict[Common, Targets] = Field(default={})
    """How poses stand at each phoneme; several in a row for a sound that moves."""
    measures: dict[Text, dict[PoseName, float]] = Field(default={})
    """Read-outs for quality reports: sums of gain times pose."""
    checks: Checks = Checks()
    """What a finished animation is held against."""
    model: Text | None = None
    """A model file to show the poses on."""


class BigramCurves(Strict):
    """The curves of one phone bigram, in normalised time."""

    word: str | None = None
    """A word in which it is heard."""
    status: Literal["drafted", "edited", "approved"] = "edited"
    """How far a person has seen to it."""
    boundary: Annotated[float, Field(gt=0, lt=1)] = 0.5
    """Where the first phoneme ends."""
    contact: Literal["hold", "free"] = "hold"
    """Whether the contacts of its phonemes are held."""
    interpolation: Literal["bspline", "linear"] | None = None
    """The kind of curve, where it differs from the bank's."""
    why: str | None = None
    """Why it is as it is."""
    curves: Curves
    """A curve for each pose that moves."""


class BankPack(PackModel):
    """Curves for bigrams over the poses of one pose set."""

    kind: Literal["bank"]
    """The kind of pack."""
    poseset: Name
    """The pose set whose poses move."""
    language: Name | None = None
    """The language it is meant for; none means all."""
    style: Text = "neutral"
    """The manner of speaking."""
    interpolation: Literal["bspline", "linear"] = "bspline"
    """The kind of curve."""
    bigrams: dict[BigramKey, BigramCurves] = Field(default={})
    """Curves by bigram."""


class WordCurves(Strict):
    """Curves of a whole word, over the word's normalised time."""

    curves: Curves
    """A curve for each pose that moves."""


class Edit(Strict):
    """Curves for one place of a line, addressed by word and phoneme index."""

    word: Annotated[int, Field(ge=0)] | None = None
    """The word, from 0."""
    phoneme: Annotated[int, Field(ge=0)] | None = None
    """The phoneme, from 0; of the word where one is named, else of the line."""
    curves: Curves = Field(default={})
    """A curve for each pose that moves."""


Level = Annotated[float, Field(ge=0, le=2)]
Share = Unit


def _points(value: Data) -> Data:
    """Turn one number into a level that stays."""
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return ((0, value),) if number else value


def _forwards(points: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """Refuse points that run back."""
    for (before, _), (after, _) in pairwise(points):
        if after < before:
            what = "the words of these points run back: {after} after {before}"
            context = {"after": f"{after:g}", "before": f"{before:g}"}
            raise PydanticCustomError("P113", what, context)
    return points


OrNumber = Short(_points, forms=lambda full: [full, full["items"]["prefixItems"][1]])
"""One number is a level that stays."""

Levels = Annotated[
    tuple[tuple[NotNegative, Level], ...],
    Field(min_length=1),
    AfterValidator(_forwards),
    OrNumber,
]
"""A level, or points of word and level: words count from 0, and 2.5 is the middle of the third."""

Shares = Annotated[
    tuple[tuple[NotNegative, Share], ...],
    Field(min_length=1),
    AfterValidator(_forwards),
    OrNumber,
]
"""A share, or points of word and share."""


class Delivery(Strict):
    """How a line, or all of them, are spoken: style banks blended in, and regions scaled."""

    styles: dict[Text, Shares] = Field(default={})
    """The share of each style over neutral; or [word, share] points, straight lines between."""
    dials: dict[Text, Levels] = Field(default={})
    """How far the poses of a region move: 0 not at all, 1 as usual, 2 twice as far; or [word,
    level] points."""


class LineEdits(Delivery):
    """What is particular to one recorded line, and survives a new recording."""

    edits: tuple[Edit, ...] = ()
    """Edits in order; a later one wins."""


class Character(PackModel, Delivery):
    """A face that speaks: a pose set, a bank layer of its own, and a rig."""

    kind: Literal["character"]
    """The kind of pack."""
    poseset: Name
    """The pose set whose poses move."""
    bigrams: dict[BigramKey, BigramCurves] = Field(default={})
    """The character's own bigrams."""
    banks: tuple[Text, ...] = ()
    """Files of more of them, beside the character."""
    words: dict[Text, WordCurves] = Field(default={})
    """Words it moves in its own way."""
    pronunciations: dict[Text, dict[Text, Annotated[tuple[Common, ...], Field(min_length=1)]]] = (
        Field(default={})
    )
    """Words it pronounces in its own way, by language, as common phonemes."""
    lines: dict[Text, LineEdits] = Field(default={})
    """Lines with edits of their own."""
    motion: MotionFields = MotionFields()
    """What differs from the pose set's motion."""
    checks: Checks = Checks()
    """What differs from the pose set's checks."""
    rig: Name | None = None
    """The rig that drives the model."""
    model: Text | None = None
    """The model file."""


Vector = tuple[float, float, float]


class RigChannel(Strict):
    """A shape or bone of a model, driven by a sum of gain times pose."""

    gains: dict[PoseName, float]
    """How much of it each pose moves."""
    range: tuple[float, float] | None = None
    """The least and the most it takes."""
    at_most: Text | None = None
    """The channel it never passes."""
    mesh: Text | None = None
    """The one mesh that has it; every mesh with such a shape where none is named."""
    node: Text | None = None
    """The bone it turns or moves; a shape where none is named."""
    rotation: Vector | None = None
    """The axis it turns about, gains being degrees."""
    translation: Vector | None = None
    """The way it moves, in the model's units for a gain of 1."""

    @model_validator(mode="after")
    def _bone_fits(self) -> Self:
        if self.range is not None and self.range[0] > self.range[1]:
            what = "`range` runs from its most to its least; turn it round"
            raise PydanticCustomError("P115", what, {"field": "range"})
        moves = [f for f in ("rotation", "translation") if getattr(self, f) is not None]
        if moves and self.node is None:
            what = "`{field}` moves a bone, but `node` names none"
            raise PydanticCustomError("P115", what, {"field": moves[0]})
        if self.node is not None and len(moves) != 1:
            what = "`node` needs one of `rotation` and `translation`"
            raise PydanticCustomError("P115", what, {"field": "node"})
        return self


class RigPack(PackModel):
    """How poses drive the shapes and bones of a real model, and how those are called."""

    kind: Literal["rig"]
    """The kind of pack."""
    poseset: Name
    """The pose set whose poses drive it."""
    to: Name | None = None
    """The pose set whose poses the channels are, where it is one."""
    channels: dict[Text, RigChannel] = Field(min_length=1)
    """What is driven, by name; `{Left,Right}` in a name stands for two channels alike."""
    names: dict[Text, tuple[Text, ...]] = Field(default={})
    """How models spell a channel otherwise; `{Left,Right}` as in the channel, `*` for anything."""
    lost: dict[PoseName, Text] = Field(default={})
    """Poses that these channels cannot show, or show as another, and why."""
