"""Models of the packs that animators write: pose sets, banks and characters.

A validator here sees one file; `packs.checking` compares files. Times are in seconds, normalised
times and weights in [0, 1], angles in degrees.
"""

import re
from collections.abc import Iterable
from itertools import pairwise
from math import inf
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from lipsync_lang.packs.models.check_models import Checks
from lipsync_lang.packs.models.fields import (
    BigramKey,
    Common,
    Curves,
    Label,
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
    TrigramKey,
    Unit,
    descriptions,
)
from lipsync_lang.packs.models.gesture_models import (
    Gesture,
    GestureByHand,
    GesturePose,
    GestureScale,
)
from lipsync_lang.packs.models.language_models import Mouths
from lipsync_lang.packs.models.motion_models import MotionFields
from lipsync_lang.packs.yaml.source import Data

SPEED_ITEM = "motion.speed_limit"
"""The setting of motion that a fit may write, by its place in a character."""

NEUTRAL_STYLE = "neutral"
"""The style of a bank that names none."""

NO_THRESHOLD = 2.0
"""The threshold of an unconstrained pair: two weights never add up to more."""

Softness = Annotated[float, Field(ge=0, le=0.2)]
"""Seconds from the middle of a kernel to its end."""

AnticipateSeconds = Annotated[float, Field(ge=0, le=1)]
"""Seconds by which a pose begins before its sound."""

MouthOrigin = Literal["declared", "solved"]
"""Origin of the targets of a face with a model."""

MouthReach = Annotated[float, Field(gt=0, le=3)]
"""Factor of the measures of all mouths."""


class Pose(Strict):
    """A shape of the face or tongue."""

    title: str = ""
    """The shape in words."""
    region: str = ""
    """The part of the face that the pose moves; a dial scales the poses of one region."""
    softness: Softness | None = None
    """Seconds of rounding off, if they differ from the region's."""
    anticipate: AnticipateSeconds = 0
    """Seconds by which the pose begins before its sound, as far as no other sound opposes it."""
    names: tuple[Text, ...] = ()
    """Other names of the pose in models; `{Left,Right}` stands for two names, `*` for any text."""
    aperture: Annotated[float, Field(gt=0)] | None = None
    """The opening of the mouth on faces that the targets suit, in widths of the mouth."""


class PosturePose(Strict):
    """A shape that speech does not move, and that styles hold under speech."""

    title: str = ""
    """The shape in words."""
    names: tuple[Text, ...] = ()
    """Other names of the pose in models; `{Left,Right}` stands for two names, `*` for any text."""
    corners: Annotated[float, Field(ge=-1, le=1)] = 0
    """Way of the mouth's corners, up if above 0: a shape that goes the other way is misnamed."""
    softness: Softness = 0.1
    """Seconds of rounding off."""
    together: dict[PoseName, Annotated[float, Field(gt=0, le=2)]] = Field(default={})
    """The largest sum of its weight and that of a pose of speech, to which it yields."""
    ceiling: dict[Text, Unit] = Field(default={})
    """The largest weight during a contact."""


class Threshold(Strict):
    """Two poses whose weights may not add up to more than a threshold."""

    between: tuple[PoseName, PoseName]
    """The two poses."""
    threshold: Annotated[float, Field(gt=0, le=2)]
    """The largest sum of their weights."""
    paper: Annotated[float, Field(gt=0, le=2)] | None = None
    """The largest sum for a motion with the thresholds of the paper."""


class AtMost(Strict):
    """A pose whose weight never exceeds that of another."""

    pose: PoseName
    """The pose that yields."""
    at_most: PoseName
    """The pose with the larger or equal weight."""


def _constraint_form(value: Data) -> str:
    """Return the tag of a constraint's form, by its fields."""
    stated = isinstance(value, dict) and ("at_most" in value or "pose" in value)
    # a tag in `<...>` is no step of the file, and faults leave it out of their place
    return "<at_most>" if stated or isinstance(value, AtMost) else "<between>"


Constraint = Annotated[
    Annotated[Threshold, Tag("<between>")] | Annotated[AtMost, Tag("<at_most>")],
    Discriminator(_constraint_form),
]


class Constraints(Strict):
    """Limits on the weights of two poses at the same time."""

    default: Annotated[float, Field(gt=0, le=2)] = 2.0
    """The threshold of pairs that are not listed; 2 means none."""
    pairs: tuple[Constraint, ...] = ()
    """Pairs of poses with a threshold, or with one pose at most as high as the other."""


class ContactRule(Strict):
    """Weights that certain phonemes require, such as closed lips."""

    phonemes: tuple[Sound, ...] = Field(min_length=1)
    """The phonemes with the contact."""
    floor: dict[PoseName, Unit] = Field(default={})
    """Weights that poses must reach."""
    ceiling: dict[PoseName, Unit] = Field(default={})
    """Weights that poses may not exceed."""


class Intensity(Strict):
    """The effect of loudness and stress on poses."""

    regions: tuple[Text, ...] = Field(min_length=1)
    """The regions whose poses are scaled."""
    stressed: Annotated[float, Field(ge=1, le=2)] = 1.08
    """Scale for vowels with primary stress."""
    unstressed: Unit = 0.94
    """Scale for vowels without stress."""
    emphasised: Annotated[float, Field(ge=1, le=2)] = 1.25
    """Scale for words with emphasis."""
    least: Unit = 0.6
    """Scale for a sound much softer than others of its class, and for lines of a low level."""
    most: Annotated[float, Field(ge=1, le=2)] = 1.4
    """Scale for a sound much louder than others of its class, and for lines of a high level."""


class StyleDraft(Strict):
    """A style drafted from neutral; its posture, speed and softness hold for drawn bigrams too."""

    regions: dict[Text, Annotated[float, Field(ge=0, le=2)]] = Field(default={})
    """Scale for the poses of each region."""
    scale: dict[PoseName, Annotated[float, Field(ge=0, le=2)]] = Field(default={})
    """Scale for single poses, on top of that of their region."""
    offset: dict[PoseName, Annotated[float, Field(ge=-1, le=1)]] = Field(default={})
    """Weight added to poses, except in silence."""
    posture: dict[PoseName, Unit] = Field(default={})
    """Weight added to poses of speech or posture, in sounds and pauses alike."""
    speed: Annotated[float, Field(ge=0.3, le=1)] = 1
    """Scale for the highest speed of a pose."""
    softness: Annotated[float, Field(ge=0, le=2)] = 1
    """Scale for the seconds over which poses are rounded off."""


class PhonemeTarget(Strict):
    """The weights of poses at a phoneme, and their dominance over neighbouring phonemes."""

    weights: dict[PoseName, Unit] = Field(default={})
    """The weight of each pose."""
    dominance: dict[PoseName, NotNegative] = Field(default={})
    """The dominance of each pose over the neighbours' targets; or one number for all poses."""
    overall: NotNegative | None = None
    """Dominance of all poses except those constrained against a pose of the target."""
    status: Literal["fitted"] | None = None
    """`fitted` on the first target of a phoneme that a fit wrote; a person wrote all others."""


_STEP_FIELDS = ("dominance", "status")
"""Keys of the flat form of a target that are not poses."""


def _target(value: Data) -> Data:
    """Expand the flat form of a target: poses beside the reserved keys."""
    if not isinstance(value, dict) or "weights" in value:
        return value
    full = {"weights": {pose: one for pose, one in value.items() if pose not in _STEP_FIELDS}}
    full |= {key: value[key] for key in _STEP_FIELDS if key in value}
    # one number for all poses has a field of its own, so that the model has one type for each
    stated = full.get("dominance", {})
    # True is an int as well; the model refuses it
    if isinstance(stated, bool) or not isinstance(stated, (int, float)):
        return full
    if not 0 <= stated < inf:
        what = "`dominance` must be a finite number and at least 0, got {got}"
        raise PydanticCustomError("P104", what, {"got": f"{stated:g}", "field": "dominance"})
    del full["dominance"]
    return full | {"overall": stated}


_AMOUNT = {"type": "number", "minimum": 0}

FlatTarget = Short(
    _target,
    forms=lambda _: [
        {
            "type": "object",
            "description": PhonemeTarget.__doc__,
            "properties": {
                "dominance": {
                    "description": descriptions(PhonemeTarget)["dominance"],
                    "anyOf": [{"type": "object", "additionalProperties": _AMOUNT}, _AMOUNT],
                },
                "status": {"description": descriptions(PhonemeTarget)["status"], "const": "fitted"},
            },
            "additionalProperties": {**_AMOUNT, "maximum": 1},
        }
    ],
)

Targets = Annotated[tuple[Annotated[PhonemeTarget, FlatTarget], ...], Field(min_length=1), OrOne]


class PoseSet(PackModel):
    """The poses of a family of faces, their constraints, and their targets in speech."""

    kind: Literal["poseset"]
    """The kind of pack."""
    extends: Text | None = None
    """The parent pose set, or a YAML file beside this one. This file states only the differences:
    mappings are joined by entry, lists replaced. Its own name means the one that it shadows."""
    renamed: dict[PoseName, PoseName] = Field(default={})
    """New names of poses of the parent, by its names."""
    poses: dict[PoseName, Annotated[Pose, OrEmpty]] = Field(min_length=1)
    """Every pose, in the order of the curves."""
    neutral: Text | None = None
    """The name of the face at rest, for programs in which every shape has a name."""
    constraints: Constraints = Constraints()
    """Limits on the weights of two poses at the same time."""
    softness: dict[Text, Softness] = Field(default={})
    """Seconds over which the poses of a region are rounded off; 0.04 unless stated."""
    priority: tuple[PoseName, ...] = ()
    """Poses that yield to others, lowest priority first; unlisted poses never yield."""
    contacts: dict[Text, ContactRule] = Field(default={})
    """Contacts, which are met at any speed and frame rate."""
    motion: MotionFields = MotionFields()
    """Settings for joining, smoothing and limiting curves."""
    intensity: Intensity | None = None
    """The effect of loudness and stress on poses."""
    styles: dict[Text, StyleDraft] = Field(default={})
    """Styles drafted from the neutral bigrams, by name."""
    posture_poses: dict[PoseName, PosturePose] = Field(default={})
    """Shapes that only styles move; they are columns after speech where a style holds them."""
    targets: dict[Common, Targets] = Field(default={})
    """The weights of poses at each phoneme; a list of several for a sound that moves."""
    looks: dict[Common, Targets] = Field(default={})
    """The looks that solved targets hold to, if they are other than the targets."""
    gesture_poses: dict[PoseName, GesturePose] = Field(default={})
    """Shapes and turns that only gestures move."""
    optional_poses: dict[PoseName, Annotated[Pose, OrEmpty]] = Field(default={})
    """Poses of speech that few models have; they move, after the others, where a model has them."""
    front: Literal["z", "-z"] = "z"
    """The way in which the face looks, along an axis of its model, for turns of the head live."""
    gestures: dict[Text, Gesture] = Field(default={})
    """Blinks, raised brows, nods and the like; `--gestures` turns them on."""
    mirrored: dict[Text, Text] = Field(default={})
    """Parts of names of mirrored poses, left first: `Left: Right`; timelines show a pair as one."""
    measures: dict[Text, dict[PoseName, float]] = Field(default={})
    """Sums of gain times pose, for reports; drawn mouths show `aperture` and `protrusion`."""
    checks: Checks = Checks()
    """Limits for the quality of finished animations."""
    model: Text | None = None
    """A model file that shows the poses."""
    mouth: MouthOrigin = "declared"
    """`solved`: on a model, the targets are those weights of its shapes that give the mouth of each
    sound best. The targets of this file serve without one, and on the model of this file."""
    reach: MouthReach = 1.0
    """Factor of solved mouths and the targets here: 1 for natural speech, more for a cartoon."""
    look: Annotated[float, Field(ge=0, le=10)] = 0.1
    """Firmness with which solved targets hold to those of this file, the look of a sound."""

    def having(self, optional: Iterable[str]) -> Self:
        """Return the pose set with some of its optional poses among those of speech."""
        own = {name: self.optional_poses[name] for name in optional if name in self.optional_poses}
        return self.model_copy(update={"poses": {**self.poses, **own}}) if own else self

    def mirrors(self, part: str) -> "dict[str, str]":
        """Return the mirrored poses of a part of names: by pose, its counterpart."""
        every = (*self.poses, *self.posture_poses, *self.gesture_poses)
        # the last place alone: "left" may be within another word before it
        pairs = {one: self.mirrored[part].join(one.rsplit(part, 1)) for one in every if part in one}
        return {one: other for one, other in pairs.items() if other in every}


Inside = Annotated[float, Field(gt=0, lt=1)]
"""A normalised time between the ends of a unit."""


class BigramCurves(Strict):
    """The curves of one phone bigram, in normalised time."""

    word: str | None = None
    """An example word with the bigram."""
    status: Literal["drafted", "fitted", "edited", "approved"] = "edited"
    """The state of the artist's work; `fitted` to captures, and seen by nobody."""
    boundary: Inside = 0.5
    """The end of the first phoneme, in normalised time."""
    contact: Literal["hold", "free"] = "hold"
    """`free` leaves the contacts of the two phonemes unheld."""
    interpolation: Literal["bspline", "linear"] | None = None
    """The kind of curve, if it differs from the bank's."""
    why: str | None = None
    """The reason for these curves."""
    curves: Curves
    """A curve for each pose that moves."""


SHORTEST_MIDDLE = 0.01
"""Least normalised time of the phoneme in the middle of a trigram; tables have 128 steps."""

MAX_TRIGRAMS = 1000
"""Trigrams of a file; each takes as much room in the tables as two bigrams."""


def _apart(ends: tuple[float, float]) -> tuple[float, float]:
    """Refuse boundaries between which the phoneme in the middle has no time."""
    if ends[1] - ends[0] < SHORTEST_MIDDLE:
        what = "the boundaries {first} and {last} leave no time for the middle phoneme"
        hint = f"make the second at least {SHORTEST_MIDDLE:g} larger than the first"
        told = {"first": f"{ends[0]:g}", "last": f"{ends[1]:g}", "hint": hint}
        raise PydanticCustomError("P104", what, told)
    return ends


class TrigramCurves(Strict):
    """The curves of one trigram, three phonemes in a row, in normalised time."""

    word: str | None = None
    """An example word with the trigram."""
    status: Literal["drafted", "edited", "approved"] = "edited"
    """The state of the artist's work."""
    boundaries: Annotated[tuple[Inside, Inside], AfterValidator(_apart)] | None = None
    """The ends of the first and of the second phoneme, in normalised time; thirds unless stated."""
    contact: Literal["hold", "free"] = "hold"
    """`free` leaves the contacts of the three phonemes unheld."""
    interpolation: Literal["bspline", "linear"] | None = None
    """The kind of curve, if it differs from the bank's."""
    why: str | None = None
    """The reason for these curves."""
    curves: Curves
    """A curve for each pose that moves."""


Trigrams = Annotated[dict[TrigramKey, TrigramCurves], Field(max_length=MAX_TRIGRAMS)]
"""Curves by trigram."""


class BankPack(PackModel):
    """Curves for bigrams over the poses of one pose set."""

    kind: Literal["bank"]
    """The kind of pack."""
    poseset: Name
    """The pose set whose poses move."""
    language: Name | None = None
    """The bank's language; all languages unless stated."""
    style: Text = NEUTRAL_STYLE
    """The style of speaking."""
    interpolation: Literal["bspline", "linear"] = "bspline"
    """The kind of curve."""
    bigrams: dict[BigramKey, BigramCurves] = Field(default={})
    """Curves by bigram."""
    trigrams: Trigrams = Field(default={})
    """Curves by trigram, for the few sequences that two phonemes cannot show."""

    @model_validator(mode="after")
    def _neutral_trigrams(self) -> Self:
        # of a style, bigrams alone are blended over the neutral ones
        if self.trigrams and self.style != NEUTRAL_STYLE:
            what = "a bank of style '{style}' cannot draw trigrams"
            hint = "draw the bigrams of that style; they override neutral trigrams"
            told = {"style": self.style, "field": "trigrams", "hint": hint}
            raise PydanticCustomError("P115", what, told)
        return self


class WordCurves(Strict):
    """Curves of a whole word, in the word's normalised time."""

    curves: Curves
    """A curve for each pose that moves."""


class Edit(Strict):
    """Curves for one word or phoneme of a line, addressed by index."""

    word: Annotated[int, Field(ge=0)] | None = None
    """The word, from 0."""
    phoneme: Annotated[int, Field(ge=0)] | None = None
    """The phoneme, from 0, within the word if `word` is given, else within the line."""
    curves: Curves = Field(default={})
    """A curve for each pose that moves."""


LevelNumber = Annotated[float, Field(ge=0, le=2)]


def _points(value: Data) -> Data:
    """Turn one number into a constant level."""
    # True is a number to Python, and a slip in a pack
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return ((0, value),) if number else value


def _forwards(points: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """Refuse points whose words decrease."""
    for (before, _), (after, _) in pairwise(points):
        if after < before:  # equal ones are a step
            what = "the words of these points are out of order: {after} after {before}"
            context = {"after": f"{after:g}", "before": f"{before:g}"}
            raise PydanticCustomError("P113", what, context)
    return points


OrNumber = Short(_points, forms=lambda full: [full, full["items"]["prefixItems"][1]])
"""Accepts one number as a constant level."""

Levels = Annotated[
    tuple[tuple[NotNegative, LevelNumber], ...],
    Field(min_length=1),
    AfterValidator(_forwards),
    OrNumber,
]
"""A level, or points (word, level). Words count from 0; 2.5 is the middle of the third word."""

Shares = Annotated[
    tuple[tuple[NotNegative, Unit], ...], Field(min_length=1), AfterValidator(_forwards), OrNumber
]
"""A share, or points (word, share)."""


class Delivery(Strict):
    """The delivery of lines: styles are blended in, and regions are scaled."""

    styles: dict[Text, Shares] = Field(default={})
    """The share of each style over neutral; or [word, share] points with straight lines between."""
    dials: dict[Text, Levels] = Field(default={})
    """Scale for the poses of a region: 0 none, 1 unchanged, 2 double; or [word, level] points."""
    gestures: dict[Text, GestureScale] = Field(default={})
    """Scale for single gestures, where gestures are on: 0 leaves one out."""


BendKeys = Annotated[
    tuple[tuple[NotNegative, Annotated[float, Field(ge=-1, le=1)]], ...],
    Field(min_length=1),
    AfterValidator(_forwards),
]
"""Amounts at points: (word, amount). Words count from 0; 2.5 is the middle of the third word."""

SomeLabels = Annotated[tuple[Label, ...], Field(min_length=1)]
"""Labels of phonemes in the notation of a line."""


class SpokenEdits(Strict):
    """Words, sounds and times of one line in one language, as a person changed them."""

    text: Text | None = None
    """The text, for a line that is in no script. If it differs from that of the script in marks of
    emphasis alone, it takes its place."""
    emphasis: tuple[tuple[Annotated[int, Field(ge=0)], LevelNumber], ...] = ()
    """Emphasis of words: [word, level], from word 0."""
    phonemes: tuple[tuple[Annotated[int, Field(ge=0)], SomeLabels, SomeLabels], ...] = ()
    """Changed phonemes: [first, labels before, labels now], from phoneme 0, pauses included."""
    times: tuple[tuple[Annotated[int, Field(ge=0)], float, float], ...] = ()
    """Moved boundaries: [number, seconds before, seconds now]; boundary 0 is the line's start, and
    changed phonemes count as they are now."""


class LineEdits(SpokenEdits, Delivery):
    """Words, times, delivery and edits of one line, as a person changed them."""

    language: Name | None = None
    """The language of the text, emphasis, phonemes and times, which other languages do not use."""
    languages: dict[Name, SpokenEdits] = Field(default={})
    """Text, emphasis, phonemes and times in further languages, in place of those of the line."""
    intensity: LevelNumber | None = None
    """The effect of loudness: 0 none, 1 as the pose set says, 2 double."""
    bends: dict[PoseName, BendKeys] = Field(default={})
    """Keys that are added to poses: [word, amount] from -1 to 1, faded before and after them."""
    placed: tuple[GestureByHand, ...] = ()
    """Gestures that a person placed; those of their kind that come by rule keep clear of them."""
    edits: tuple[Edit, ...] = ()
    """Edits in order; a later edit wins. They stay valid after a new recording."""


def _scalar_item(item: str) -> str:
    """Refuse the name of a value that no fit writes."""
    if item != SPEED_ITEM and not re.fullmatch(r"(softness|anticipate)\..+", item):
        what = (
            f"'{{item}}' is not a value of a fit: write softness.NAME, anticipate.NAME or "
            f"{SPEED_ITEM}"
        )
        raise PydanticCustomError("P106", what, {"item": item})
    return item


class Character(PackModel, Delivery):
    """A face that speaks: a pose set with bigrams, words and lines of its own, and a rig."""

    kind: Literal["character"]
    """The kind of pack."""
    poseset: Name
    """The pose set whose poses move."""
    bigrams: dict[BigramKey, BigramCurves] = Field(default={})
    """The character's own bigrams."""
    trigrams: Trigrams = Field(default={})
    """The character's own trigrams."""
    banks: tuple[Text, ...] = ()
    """Bank files beside the character, with more bigrams."""
    words: dict[Text, WordCurves] = Field(default={})
    """The character's own curves of words."""
    pronunciations: dict[Text, dict[Text, Annotated[tuple[Common, ...], Field(min_length=1)]]] = (
        Field(default={})
    )
    """The character's own pronunciations of words, by language, as common phonemes."""
    lines: dict[Text, LineEdits] = Field(default={})
    """Edits and delivery of single lines, by name."""
    targets: dict[Common, Targets] = Field(default={})
    """Targets by phoneme. Each replaces the whole target of the pose set: a pose that it does not
    name rests. A fit marks its own `status: fitted`."""
    softness: dict[Text, Softness] = Field(default={})
    """Seconds of rounding off by region, in place of the pose set's; a pose's own stay."""
    anticipate: dict[PoseName, AnticipateSeconds] = Field(default={})
    """Seconds by which poses begin before their sounds, in place of the pose set's."""
    fitted: dict[Annotated[str, AfterValidator(_scalar_item)], float] = Field(default={})
    """Values that a fit wrote, such as `softness.jaw: 0.05`; one that differs now is a person's."""
    motion: MotionFields = MotionFields()
    """Differences from the pose set's motion."""
    checks: Checks = Checks()
    """Differences from the pose set's checks."""
    rig: Name | None = None
    """The rig that drives the model."""
    model: Text | None = None
    """The model file."""
    has: tuple[PoseName, ...] = ()
    """Optional poses of the pose set that the model has."""
    mouth: MouthOrigin | None = None
    """`declared` keeps the targets of the pose set; `solved` solves them on the model. A target of
    the character's own always stays. Unless stated, as the pose set says."""
    reach: MouthReach | None = None
    """Factor of solved mouths and of the set's targets, in place of the pose set's."""
    mouths: dict[Common, Mouths] = Field(default={})
    """Mouths that targets are solved for, by phoneme, in place of those of `common.yaml`."""

    def scalar(self, item: str) -> float | None:
        """Return the character's own value of ``softness.REGION`` and the like, or None."""
        field, _, name = item.partition(".")
        if item == SPEED_ITEM:
            return self.motion.speed_limit
        own = {"softness": self.softness, "anticipate": self.anticipate}.get(field, {})
        return own.get(name)

    def own_face(self, poseset: PoseSet) -> PoseSet:
        """Return a pose set with the values that the character states in place of the set's."""
        if not (self.targets or self.softness or self.anticipate):
            return poseset
        poses = dict(poseset.poses)
        for name, seconds in self.anticipate.items():
            if name in poses:  # a check reports names that the set lacks
                poses[name] = poses[name].model_copy(update={"anticipate": seconds})
        changed = {
            "poses": poses,
            "targets": {**poseset.targets, **self.targets},
            "softness": {**poseset.softness, **self.softness},
        }
        return poseset.model_copy(update=changed)
