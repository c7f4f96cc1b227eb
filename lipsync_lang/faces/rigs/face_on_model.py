"""A pose set on a model: the places of its channels, and what its poses do to the mouth.

Names may promise what a mesh does not keep. Shapes that move no point are left out. A shape is
judged by what it does, beside the `measures` of the pose set.
"""

from collections import defaultdict
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import ModelError, shortlist
from lipsync_lang.faces.rigs.channel import Channel, bare
from lipsync_lang.faces.rigs.driver import Driver
from lipsync_lang.faces.rigs.model import Model
from lipsync_lang.faces.rigs.read_outs import (
    LEAST_MOUTH,
    SOUND_MEASURES,
    measured,
    still_shapes,
    unmeasured,
)
from lipsync_lang.faces.rigs.shape_matching import on_mesh

if TYPE_CHECKING:  # workers measure mouths without the models of packs
    from lipsync_lang.packs import models

OFF_SHARE = 0.7
"""Error of a misnamed shape, which moves the mouth the wrong way, as a share of the farthest."""

WRONG_SHARE = 0.25
"""Smallest movement of a misnamed shape, as a share of the farthest of the model."""

ONE_SIDE = 0.1
"""Least distance of what a shape of one side moves from the middle, in widths of the mouth."""

SEEN_CORNERS = 0.02
"""Least way of the corners of a misnamed shape of a style, up or down."""

MEND = "keep the declared targets with `mouth: declared` in a character or `lipsync.yaml`"
"""Advice for a mouth that does not open."""

WAYS = {
    "aperture": ("opens", "shuts"), "width": ("widens", "narrows"),
    "corners": ("raises the corners of", "lowers the corners of"),
}  # fmt: skip
"""Measures by which shapes are judged, in words for more of it and for less."""


@dataclass(frozen=True, eq=False)
class ChannelPlaces:
    """Positions of channels on a model."""

    places: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Found channel -> its shapes, over all meshes, or its bone."""
    shared: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Shape without a side -> the left and right channels that share it."""
    doubts: tuple[str, ...] = ()
    """Descriptions of ambiguous matches, and of shapes that move no point."""
    still: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Channel -> its shapes, where they move no point."""
    bound: dict[str, dict[str, float]] = field(default_factory=dict)
    """Found channel -> the weights of its shapes, where an expression of an avatar binds them."""


def find(channels: Sequence[Channel], model: Model) -> ChannelPlaces:
    """Find channels among the shapes of all meshes that move, and among the bones."""
    places: dict[str, dict[str, None]] = {}
    shared: dict[str, tuple[str, ...]] = {}
    doubts: dict[str, None] = {}
    bound: dict[str, dict[str, float]] = defaultdict(dict)
    for mesh in model.meshes:
        on = on_mesh(tuple(channels), mesh)
        for number, weights in on.bound.items():
            bound[channels[number].name].update(weights)
        for number, shapes in on.shapes.items():
            places.setdefault(channels[number].name, {}).update(dict.fromkeys(shapes))
        for shape, numbers in on.shared.items():
            shared[shape] = tuple(channels[number].name for number in numbers)
        doubts.update(dict.fromkeys(on.doubts))
    still = still_shapes(model)
    dead = {name: shapes for name, shapes in places.items() if shapes.keys() <= still}
    if dead:
        shapes = [shape for own in dead.values() for shape in own]
        doubts[f"on the mesh, nothing moves with {shortlist(shapes)}"] = None
    places = {name: shapes for name, shapes in places.items() if name not in dead}
    for channel in channels:
        if channel.node in model.nodes:
            places[channel.name] = {str(channel.node): None}
    found, unmoved = ({name: (*own,) for name, own in one.items()} for one in (places, dead))
    return ChannelPlaces(found, shared, (*doubts,), unmoved, bound)


def mouth_gains(channels: Sequence[Channel], model: Model) -> Floats | None:
    """Return what each channel does to the measures of the mouth at full weight: (4, C).

    None for channels of bones, and for a model that is too large to be measured, or on which no
    shape opens a mouth.
    """
    moved, bones = measured(model), any(channel.node is not None for channel in channels)
    if not moved or bones:
        return None
    found = find(channels, model)
    gains = np.zeros((len(SOUND_MEASURES), len(channels)))
    for number, channel in enumerate(channels):
        weights = found.bound.get(channel.name, {})
        for shape in found.places.get(channel.name, ()):
            if shape in moved:
                does = [getattr(moved[shape], name) for name in SOUND_MEASURES]
                gains[:, number] += weights.get(shape, 1.0) * np.array(does)
    return gains


@dataclass(frozen=True, eq=False)
class FaceOnModel:
    """A pose set on a model, with or without a rig between them."""

    poseset: "models.PoseSet"
    model: Model
    channels: tuple[Channel, ...]
    driven: Floats
    """(C, P) what each pose adds to each channel at full weight."""

    @classmethod
    def of(cls, poseset: "models.PoseSet", model: Model, rig: Any = None) -> Self:
        """Put a pose set on a model; `rig` is plain data, None if its shapes are the poses."""
        from lipsync_lang.packs.models.rig_models import pose_names

        poses = (*poseset.poses,)
        if rig is None:
            channels = bare(poses, pose_names(poseset.poses))
            return cls(poseset, model, channels, np.eye(len(poses)))
        driver = Driver.from_plain(rig, poses, np.zeros(len(poses)))
        return cls(poseset, model, driver.channels, driver.rig.gains)

    @cached_property
    def found(self) -> ChannelPlaces:
        """The channels on the model."""
        return find(self.channels, self.model)

    @cached_property
    def silent(self) -> ChannelPlaces:
        """The poses that only styles and gestures move, on the model."""
        from lipsync_lang.packs.models.rig_models import pose_names

        poses = {**self.poseset.posture_poses, **self.poseset.gesture_poses}
        return find(bare((*poses,), pose_names(poses)), self.model)

    @cached_property
    def gains(self) -> Floats | None:
        """Measures of the mouth of each pose, (4, P), as `mouth_gains`, without limits."""
        found = mouth_gains(self.channels, self.model)
        return None if found is None else found @ self.driven

    @property
    def wide(self) -> frozenset[str]:
        """Channels that move most in the pose that opens the mouth farthest by its read-outs."""
        stated = self.poseset.measures.get("aperture", {})
        widest = max(stated.values(), default=0.0)
        poses = [0 < widest == stated.get(pose, 0.0) for pose in self.poseset.poses]
        moved = np.abs(self.driven[:, poses]).max(axis=1, initial=0)
        pairs = zip(self.channels, moved, strict=True)
        return frozenset(one.name for one, way in pairs if 0 < way == max(moved))

    @cached_property
    def misnamed(self) -> dict[str, str]:
        """Misnamed poses, each with what its shape does to the mouth against the `measures`.

        A pose without a width may have any, and one without an aperture should not open the mouth.
        """
        moved, told = measured(self.model), {}
        widest = max(moved, key=lambda name: moved[name].aperture, default="")
        for measure in ("aperture", "width"):
            stated = self.poseset.measures.get(measure, {})
            most = max((abs(getattr(one, measure)) for one in moved.values()), default=0.0)
            if self.gains is None or not any(stated.values()) or most < LEAST_MOUTH:
                continue
            gains = self.gains[SOUND_MEASURES.index(measure)]
            for pose, does in zip(self.poseset.poses, gains / most, strict=True):
                asked = stated.get(pose, 0.0) / max(map(abs, stated.values()))
                far = min(abs(does) / WRONG_SHARE, abs(does - asked) / OFF_SHARE) > 1
                off = far and does * asked <= 0 and (asked != 0 or measure == "aperture")
                named = shortlist(self.found.places.get(pose, (pose,)))
                what = _told(named, measure, does * most)
                if measure == "aperture" and asked == 1 and does * most < LEAST_MOUTH:
                    size = moved[widest].aperture
                    off = bool(self.wide & self.found.places.keys()) and size >= LEAST_MOUTH
                    other = f"but {widest} parts the lips by {size:.2f} of its width"
                    what = f"{named} hardly opens the mouth, {other}"
                if off:
                    told[pose] = f"on the mesh, {what}: check the names of the shapes"
        for pose, stated_pose in self.poseset.posture_poses.items():
            shapes = [one for one in self.silent.places.get(pose, ()) if one in moved]
            way = sum(moved[shape].corners for shape in shapes)
            if way * stated_pose.corners < 0 and abs(way) > SEEN_CORNERS:
                what = _told(shortlist(shapes), "corners", way)
                told[pose] = f"on the mesh, {what}: check the names of the shapes"
        return told

    @property
    def swapped(self) -> tuple[str, ...]:
        """A sentence about shapes that move the other side of the face, if there are any."""
        moved, places = measured(self.model), {**self.silent.places, **self.found.places}
        shapes = {pose: [one for one in own if one in moved] for pose, own in places.items()}
        aside = {pose: sum(moved[one].aside for one in own) for pose, own in shapes.items()}
        pairs = (self.poseset.mirrors(part).items() for part in self.poseset.mirrored)
        wrong = [
            shape
            for left, right in chain.from_iterable(pairs)
            if aside.get(left, 0.0) < -ONE_SIDE and aside.get(right, 0.0) > ONE_SIDE
            for shape in (*shapes[left], *shapes[right])
        ]
        what = f"on the mesh, the other side of the face moves with {shortlist(wrong)}"
        return (f"{what}: check the names of the shapes",) if wrong else ()

    @cached_property
    def resting(self) -> frozenset[str]:
        """Misnamed poses, and their counterparts of the other side, which move alike."""
        pairs = [self.poseset.mirrors(part).items() for part in self.poseset.mirrored]
        twins = [{*both} for one in pairs for both in one if self.misnamed.keys() & {*both}]
        return frozenset(self.misnamed).union(*twins)

    def honest(self) -> Self:
        """Return the face with misnamed poses at rest, in its pose set as well."""
        kept = [pose not in self.resting for pose in self.poseset.poses]
        poseset = without(self.poseset, self.resting)
        return replace(self, poseset=poseset, driven=self.driven * kept)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Doubtful matches, dead shapes, misnamed ones, and those of the other side."""
        every = (*self.found.doubts, *self.silent.doubts, *self.misnamed.values(), *self.swapped)
        return (*dict.fromkeys(every),)

    @property
    def told(self) -> tuple[str, ...]:
        """The doubts, each with the file."""
        return tuple(f"{self.model.path}: {doubt}" for doubt in self.doubts)

    @property
    def unsolved(self) -> tuple[str, ...]:
        """Why the targets are not solved, on a model without a measured mouth."""
        why = unmeasured(self.model)
        return (f"{self.model.path}: {why}, so its targets stay as declared",) if why else ()

    def refuse_shut(self) -> None:
        """Raise a ModelError if no pose of the set opens the mouth of the model."""
        path = self.model.path
        if self.gains is None:
            still = still_shapes(self.model)
            dead = 0 < len(still) == len(self.model.shape_names) and not self.found.places
            if not measured(self.model) and (
                dead or frozenset() < self.wide <= self.found.still.keys()
            ):
                lost = [name for name in self.model.shape_names if name in still]
                raise ModelError(
                    f"{path}: no shape opens the mouth: on the mesh, nothing moves with "
                    f"{shortlist(lost)}. Sculpt these, or {MEND}"
                )
        elif (most := self.gains[0].max(initial=0.0)) < LEAST_MOUTH:
            widest, seen = max(measured(self.model).items(), key=lambda one: one[1].aperture)
            raise ModelError(
                f"{path}: no shape of it that is a pose of {self.poseset.name} opens the mouth: "
                f"the widest parts the lips by {most:.3f} of its width, and the widest of all, "
                f"{widest}, by {seen.aperture:.3f}. Make those that open it poses with "
                f"`lipsync-lang posesets new`, or {MEND}"
            )


def _told(named: str, measure: str, does: float) -> str:
    """Say what shapes do to the mouth, by how much of its width."""
    return f"{named} {WAYS[measure][int(does < 0)]} the mouth by {abs(does):.2f} of its width"


def without(poseset: "models.PoseSet", resting: Collection[str]) -> "models.PoseSet":
    """Return a pose set with some poses at rest, in targets, looks, contacts and styles."""

    def kept(one: Any) -> Any:
        if isinstance(one, tuple):
            return tuple(map(kept, one))
        left = {}
        for name in {"weights", "floor", "offset", "posture"} & type(one).model_fields.keys():
            left[name] = {p: w for p, w in getattr(one, name).items() if p not in resting}
        return one.model_copy(update=left)

    parts = {part: getattr(poseset, part) for part in ("targets", "looks", "contacts", "styles")}
    made = {part: {n: kept(one) for n, one in own.items()} for part, own in parts.items()}
    return poseset.model_copy(update=made) if resting else poseset
