"""Model recognition: pose sets and rigs with channels among the model's shapes and bones."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from lipsync_lang.errors import PackError
from lipsync_lang.packs.checking.rig_checks import check_rig
from lipsync_lang.packs.models.rig_channels import channels_of, plain_channels, pose_names
from lipsync_lang.rigs.driver import Driver, bare
from lipsync_lang.rigs.loss import Loss, losses
from lipsync_lang.rigs.shape_matching import on_mesh

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lipsync_lang.packs import models
    from lipsync_lang.packs.library import Library, Pack
    from lipsync_lang.rigs.channel import Channel
    from lipsync_lang.rigs.model import Model

MAX_SHOWN_MATCHES = 3
"""Number of lost poses that outweigh one shown pose."""

MIN_SHOWN_SHARE = 0.25
"""Smallest share of shown poses for the automatic choice of a pose set."""


@dataclass(frozen=True, eq=False)
class ChannelPlaces:
    """Positions of channels on a model."""

    places: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Found channel -> its shapes, over all meshes, or its bone."""
    shared: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Shape without a side -> the left and right channels that share it."""
    doubts: tuple[str, ...] = ()
    """Descriptions of ambiguous matches."""


@dataclass(frozen=True, eq=False)
class Match:
    """Fit of a pose set, alone or with a rig, to a model."""

    poseset: str
    rig: str | None
    """Rig between poses and model; None if the poses themselves are the shapes."""
    poses: tuple[str, ...]
    """All poses of the set."""
    found: ChannelPlaces
    missing: tuple[str, ...]
    """Channels absent from the model."""
    left: tuple[str, ...]
    """Shapes of the model without a channel."""
    losses: tuple[Loss, ...]
    """Poses lost wholly or in part."""

    @property
    def shown(self) -> int:
        """Number of poses shown as themselves."""
        return len(self.poses) - len(self.losses)

    @property
    def enough(self) -> bool:
        """True if the match shows enough poses for the automatic choice."""
        return self.shown >= MIN_SHOWN_SHARE * len(self.poses)

    @property
    def complete(self) -> bool:
        """True if every channel has a shape or bone of its own."""
        return not self.missing and not self.found.shared

    @property
    def rank(self) -> tuple[object, ...]:
        """Sort key of matches; the smallest is the best."""
        worth = self.shown * MAX_SHOWN_MATCHES - len(self.losses)
        return (-worth, -self.shown, self.rig is not None, -self.own, self.name)

    @property
    def own(self) -> int:
        """Number of channels with exactly the model's spelling."""
        return sum(channel in shapes for channel, shapes in self.found.places.items())

    @property
    def name(self) -> str:
        """Name of the pose set, and of the rig if any."""
        return f"{self.poseset} with rig {self.rig}" if self.rig else self.poseset

    def __str__(self) -> str:
        return f"{self.shown} of {len(self.poses)} poses of {self.name}"

    def to_dict(self) -> dict[str, Any]:
        """Convert to plain data for JSON."""
        return {
            "poseset": self.poseset,
            "rig": self.rig,
            "poses": len(self.poses),
            "shown": self.shown,
            "channels": {channel: list(names) for channel, names in self.found.places.items()},
            "shared": {shape: list(channels) for shape, channels in self.found.shared.items()},
            "doubts": list(self.found.doubts),
            "missing": list(self.missing),
            "left": list(self.left),
            "lost": [loss.to_dict() for loss in self.losses],
        }


def recognise(library: "Library", model: "Model") -> tuple[Match, ...]:
    """Match every pose set and every rig against a model.

    The number of poses shown as themselves decides the order, but three lost poses outweigh a
    shown one. Among equals, a pose set without a rig comes first. Empty matches are left out.
    Invalid packs are skipped, because `validate` reports their faults.
    """
    found: list[Match] = []
    for name in dict.fromkeys(one.name for one in library.names("poseset")):
        try:
            found += _matches(library, library.poseset(name).model, model)
        except PackError:
            continue
    return tuple(sorted(found, key=lambda match: match.rank))


def find(channels: "Sequence[Channel]", model: "Model") -> ChannelPlaces:
    """Find channels among the shapes of all meshes and among the bones."""
    places: dict[str, dict[str, None]] = {}
    shared: dict[str, tuple[str, ...]] = {}
    doubts: dict[str, None] = {}
    for mesh in model.meshes:
        on = on_mesh(channels, mesh)
        for number, shapes in on.shapes.items():
            places.setdefault(channels[number].name, {}).update(dict.fromkeys(shapes))
        for shape, numbers in on.shared.items():
            shared[shape] = tuple(channels[number].name for number in numbers)
        doubts.update(dict.fromkeys(on.doubts))
    for channel in channels:
        if channel.node in model.nodes:
            places[channel.name] = {str(channel.node): None}
    return ChannelPlaces({name: (*own,) for name, own in places.items()}, shared, (*doubts,))


def reduced(rig: "models.RigPack", found: ChannelPlaces) -> "models.RigPack":
    """Restrict a rig to the channels found on a model."""
    kept = {name: one for name, one in channels_of(rig).items() if name in found.places}
    plain = {
        name: one if one.at_most in kept else one.model_copy(update={"at_most": None})
        for name, one in kept.items()
    }
    return rig.model_copy(update={"channels": plain})


def _matches(library: "Library", poseset: "models.PoseSet", model: "Model") -> Iterator[Match]:
    """Yield non-empty matches: the pose set alone, and each of its valid rigs."""
    poses = tuple(poseset.poses)
    found = find(bare(poses, pose_names(poseset)), model)
    if found.places:
        lost = tuple(Loss(pose, 0, None, "") for pose in poses if pose not in found.places)
        missing = tuple(loss.pose for loss in lost)
        yield Match(poseset.name, None, poses, found, missing, _left(model, found), lost)
    known = {found.name for found in library.names("poseset")}
    for path in library.rigs_of(poseset.name):
        try:
            rig = cast("Pack[models.RigPack]", library.load(path, "rig", path.stem))
            to = library.poseset(rig.model.to).model if rig.model.to in known else None
        except PackError:
            continue
        if any(fault.severity == "fault" for fault in check_rig(rig, poseset, known, to)):
            continue
        plain = {"channels": plain_channels(rig.model, to)}
        channels = Driver.from_plain(plain, poses, np.zeros(len(poses))).channels
        found = find(channels, model)
        if found.places:
            kept = replace(rig, model=reduced(rig.model, found))
            missing = tuple(one.name for one in channels if one.name not in found.places)
            left, lost = _left(model, found), losses(library, kept)
            yield Match(poseset.name, rig.model.name, poses, found, missing, left, lost)


def _left(model: "Model", found: ChannelPlaces) -> tuple[str, ...]:
    """List the shapes without a channel."""
    driven = {shape for shapes in found.places.values() for shape in shapes}
    return tuple(shape for shape in model.shape_names if shape not in driven)
