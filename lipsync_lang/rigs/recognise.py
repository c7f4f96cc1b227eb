"""What a model is: which pose sets and rigs find their channels among its shapes and bones."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from lipsync_lang.errors import PackError
from lipsync_lang.packs.checking.rig_checks import check_rig
from lipsync_lang.packs.models.rig_channels import channels_of, plain_channels, pose_names
from lipsync_lang.rigs.driver import Driver, bare
from lipsync_lang.rigs.loss import Loss, losses
from lipsync_lang.rigs.names import on_mesh

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lipsync_lang.packs import models
    from lipsync_lang.packs.library import Library, Pack
    from lipsync_lang.rigs.channel import Channel
    from lipsync_lang.rigs.model import Model


SHOWN = 3
"""As many lost poses outweigh one that is shown."""


@dataclass(frozen=True, eq=False)
class ChannelPlaces:
    """Where channels are on a model."""

    places: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """A channel that is found -> its shapes, over all meshes, or its bone."""
    shared: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """A shape without a side -> the channels that have one, and share it."""
    doubts: tuple[str, ...] = ()
    """What else could be meant, in words."""


@dataclass(frozen=True, eq=False)
class Match:
    """How well a pose set, alone or with a rig, fits a model."""

    poseset: str
    rig: str | None
    """The rig that drives the model; None where the poses themselves are its shapes."""
    poses: tuple[str, ...]
    """Every pose of the set."""
    found: ChannelPlaces
    missing: tuple[str, ...]
    """Channels that the model does not have."""
    left: tuple[str, ...]
    """Shapes of the model that nothing drives."""
    losses: tuple[Loss, ...]
    """Poses that are not shown, or not as themselves."""

    @property
    def shown(self) -> int:
        """How many poses are shown as themselves."""
        return len(self.poses) - len(self.losses)

    @property
    def complete(self) -> bool:
        """Whether the model has every channel, each as a shape or bone of its own."""
        return not self.missing and not self.found.shared

    @property
    def rank(self) -> tuple[object, ...]:
        """What puts matches in order: the least is the best."""
        worth = self.shown * SHOWN - len(self.losses)
        return (-worth, -self.shown, self.rig is not None, -self.own, self.name)

    @property
    def own(self) -> int:
        """How many channels the model spells letter by letter."""
        return sum(channel in shapes for channel, shapes in self.found.places.items())

    @property
    def name(self) -> str:
        """The pose set, and the rig if there is one."""
        return f"{self.poseset} with rig {self.rig}" if self.rig else self.poseset

    def __str__(self) -> str:
        return f"{self.shown} of {len(self.poses)} poses of {self.name}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, for JSON."""
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
    """Try every pose set and every rig on a model.

    What shows more poses as themselves comes first, but three lost poses outweigh a shown one; of
    equals a pose set without a rig does. Those that find nothing are left out, and unsound packs
    are passed over: `validate` tells their faults.
    """
    found: list[Match] = []
    for name in dict.fromkeys(one.name for one in library.names("poseset")):
        try:
            found += _matches(library, library.poseset(name).model, model)
        except PackError:
            continue
    return tuple(sorted(found, key=lambda match: match.rank))


def find(channels: "Sequence[Channel]", model: "Model") -> ChannelPlaces:
    """Find channels among the shapes of every mesh, and among the bones."""
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
    """Return a rig with those of its channels that are found, one by one."""
    kept = {name: one for name, one in channels_of(rig).items() if name in found.places}
    plain = {
        name: one if one.at_most in kept else one.model_copy(update={"at_most": None})
        for name, one in kept.items()
    }
    return rig.model_copy(update={"channels": plain})


def _matches(library: "Library", poseset: "models.PoseSet", model: "Model") -> Iterator[Match]:
    """Yield what finds something: the pose set alone, and each of its rigs."""
    poses = tuple(poseset.poses)
    found = find(bare(poses, pose_names(poseset)), model)
    if found.places:
        lost = tuple(Loss(pose, 0, None, "") for pose in poses if pose not in found.places)
        missing = tuple(loss.pose for loss in lost)
        yield Match(poseset.name, None, poses, found, missing, _left(model, found), lost)
    for rig in _sound(library, poseset):
        channels = _channels(library, rig.model)
        found = find(channels, model)
        if found.places:
            kept = replace(rig, model=reduced(rig.model, found))
            missing = tuple(one.name for one in channels if one.name not in found.places)
            left, lost = _left(model, found), losses(library, kept)
            yield Match(poseset.name, rig.model.name, poses, found, missing, left, lost)


def _sound(library: "Library", poseset: "models.PoseSet") -> "Iterator[Pack[models.RigPack]]":
    """Yield the rigs of a pose set that nothing is wrong with."""
    known = {found.name for found in library.names("poseset")}
    for path in library.rigs_of(poseset.name):
        try:
            rig = cast("Pack[models.RigPack]", library.load(path, "rig", path.stem))
            to = library.poseset(rig.model.to).model if rig.model.to in known else None
        except PackError:
            continue
        if all(fault.severity != "fault" for fault in check_rig(rig, poseset, known, to)):
            yield rig


def _channels(library: "Library", rig: "models.RigPack") -> "tuple[Channel, ...]":
    to = library.poseset(rig.to).model if rig.to is not None else None
    poses = tuple(library.poseset(rig.poseset).model.poses)
    plain = {"channels": plain_channels(rig, to)}
    return Driver.from_plain(plain, poses, np.zeros(len(poses))).channels


def _left(model: "Model", found: ChannelPlaces) -> tuple[str, ...]:
    """Return the shapes that nothing drives."""
    driven = {shape for shapes in found.places.values() for shape in shapes}
    shapes = dict.fromkeys(shape for mesh in model.meshes for shape in mesh.shapes)
    return tuple(shape for shape in shapes if shape not in driven)
