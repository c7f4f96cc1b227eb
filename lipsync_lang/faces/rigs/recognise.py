"""Model recognition: pose sets and rigs with channels among the model's shapes and bones.

A rig may lose poses: they have no effect, a weak one, or that of another pose. Each pose is
examined alone, at full weight. The effect on a channel is the distance from rest divided by the
channel's span, so that degrees and weights are comparable. Negative gains from rest have no visible
effect. Limits between channels are ignored. Of two poses that look alike, the one with the larger
effect counts as shown and the other as lost.

A pose set that opens the mouth on the mesh comes before all that hardly do.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from lipsync_lang.base.errors import ModelError, PackError, shortlist
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.faces.rigs.driver import Driver
from lipsync_lang.faces.rigs.face_on_model import MEND, ChannelPlaces, FaceOnModel
from lipsync_lang.faces.rigs.model import Model
from lipsync_lang.faces.rigs.read_outs import measured, still_shapes

if TYPE_CHECKING:  # workers measure mouths without the models of packs
    from lipsync_lang.packs import models
    from lipsync_lang.packs.library import Library
    from lipsync_lang.packs.pack import Pack

ALIKE = 0.97
"""Minimum cosine between the channels of two poses for the same look."""

MAX_CELL_CHARS = 120
"""Width of the table's columns, which holds the name of any pose."""

WEAK_SHARE = 0.5
"""Fraction of the range that the largest channel of a pose should reach."""

MAX_SHOWN_MATCHES = 3
"""Number of lost poses that outweigh one shown pose."""

MIN_SHOWN_SHARE = 0.25
"""Smallest share of shown poses for the automatic choice of a pose set."""

MIN_OPEN_SHARE = 0.3
"""Smallest opening of a pose set's shapes, as a fraction of the widest of the model."""


@dataclass(frozen=True)
class Loss:
    """A pose that a rig loses wholly or in part; `str` gives a message."""

    pose: str
    shown: float
    """Fraction of the range reached by the largest channel; 0 for no effect."""
    like: str | None
    """The pose with the same look, if any."""
    why: str
    """Reason given by the rig; empty if none."""

    @property
    def what(self) -> str:
        """Description of the loss; empty if only the rig's reason applies."""
        if not self.shown:
            return "not shown"
        found = [f"looks like {self.like}"] if self.like else []
        return ", ".join([*found, *["weak"] * (self.shown < WEAK_SHARE)])

    def __str__(self) -> str:
        told = self.what or f"shown at {self.shown:.2f}"
        return f"{self.pose}: {told}" + (f" ({self.why})" if self.why else "")

    def to_dict(self) -> dict[str, Any]:
        """Convert to plain data for JSON."""
        return {**asdict(self), "what": self.what}


def losses(library: "Library", rig: "Pack[models.RigPack]") -> tuple[Loss, ...]:
    """List the losses of a rig in the order of its pose set, by effects on channels, (C, P)."""
    from lipsync_lang.packs.models.rig_models import plain_channels

    poses = tuple(library.poseset(rig.model.poseset).model.poses)
    data = {"channels": plain_channels(rig.model, None)}
    made = Driver.from_plain(data, poses, np.zeros(len(poses))).rig
    low, high, span = made.low[:, None], made.high[:, None], made.span[:, None]
    moves = np.clip(made.gains, low, high) - np.clip(0.0, low, high)
    moves /= np.where(span > 0, span, 1)
    shown = np.minimum(np.abs(moves).max(axis=0), 1)
    lengths = np.linalg.norm(moves, axis=0)
    unit = moves / np.where(lengths > 0, lengths, 1)
    # Of two alike poses, the first or stronger one is kept.
    rank = np.argsort(np.argsort(-shown, kind="stable"))
    alike = np.where(rank[:, None] > rank, unit.T @ unit, 0)
    lost, found = rig.model.lost, []
    for pose, share, others in zip(poses, shown.tolist(), alike, strict=True):
        nearest = int(others.argmax())
        like = poses[nearest] if others[nearest] > ALIKE else None
        if share < WEAK_SHARE or like or pose in lost:
            found.append(Loss(pose, share, like, lost.get(pose, "")))
    return tuple(found)


def loss_table(found: Sequence[Loss]) -> str:
    """Format the losses of a rig as a table, a pose per line."""
    if not found:
        return "every pose is shown as itself"
    rows = [("pose", "shown", "lost", "why")]
    rows += [(loss.pose, f"{loss.shown:.2f}", loss.what or "-", loss.why) for loss in found]
    return "\n".join(columns(rows, widest=MAX_CELL_CHARS))


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
    opens: bool
    """False if the shapes that should open the mouth do not, and others of the model do."""
    optional: tuple[str, ...] = ()
    """Optional poses of the set that the model has; they are among `poses`."""
    dead: frozenset[str] = frozenset()
    """The poses that should open the mouth farthest, if none of them moves a point."""
    ahead: tuple[str, ...] = ()
    """Why the best match comes before a pose set that the model knows; also among the doubts."""

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
        return (not self.opens, -worth, -self.shown, self.rig is not None, -self.own, self.name)

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


def recognise(library: "Library", model: Model) -> tuple[Match, ...]:
    """Match every pose set and every rig against a model.

    Matches that open the mouth on the mesh come first. Then the number of poses shown as themselves
    decides the order, but three lost poses outweigh a shown one. Among equals, a pose set without a
    rig comes first. Empty matches are left out. Invalid packs are skipped, because `validate`
    reports their faults. A ModelError refuses a model whose shapes all move no point, unless the
    project keeps declared targets: then the names count.
    """
    from lipsync_lang.packs.project import stated_mouth

    found: list[Match] = []
    dead = 0 < len(still_shapes(model)) == len(model.shape_names)
    by_name = dead and stated_mouth(library.project) == "declared"
    for name in dict.fromkeys(one.name for one in library.names("poseset")):
        try:
            found += _matches(library, library.poseset(name).model, model, by_name=by_name)
        except PackError:
            continue
    if dead and not found:
        told = f"{model.path}: on the mesh, nothing moves with {shortlist(model.shape_names)}"
        raise ModelError(f"{told}. Sculpt these shapes, or {MEND}")
    ranked = sorted(found, key=lambda match: match.rank)
    shut = {one.poseset: one.dead for one in ranked if one.enough and one.dead}
    if shut and ranked[0].poseset not in shut:
        lost = shortlist(sorted(frozenset[str]().union(*shut.values())))
        instead = f"{ranked[0].name} replaces {shortlist(shut)}"
        told = f"on the mesh, nothing moves with {lost}, so {instead}"
        places = replace(ranked[0].found, doubts=(*ranked[0].found.doubts, told))
        ranked[0] = replace(ranked[0], found=places, ahead=(told,))
    return tuple(ranked)


def _matches(
    library: "Library", poseset: "models.PoseSet", model: Model, *, by_name: bool
) -> Iterator[Match]:
    """Yield non-empty matches: the pose set alone, and each of its valid rigs."""
    from lipsync_lang.packs.checking.rig_checks import check_rig
    from lipsync_lang.packs.models.rig_models import channels_of, plain_channels

    poses, every = (*poseset.poses,), poseset.having(poseset.optional_poses)
    face = FaceOnModel.of(every, model)
    found = _played(face, by_name=by_name)
    if found.places:
        optional = tuple(name for name in poseset.optional_poses if name in found.places)
        lost = tuple(Loss(pose, 0, None, "") for pose in poses if pose not in found.places)
        missing, opens = tuple(loss.pose for loss in lost), _opens(face, found)
        left, shown = _left(model, found), (*poses, *optional)
        dead = face.wide if face.wide <= found.still.keys() else frozenset()
        yield Match(poseset.name, None, shown, found, missing, left, lost, opens, optional, dead)
    known = {found.name for found in library.names("poseset")}
    for path in library.rigs_of(poseset.name):
        try:
            rig = cast("Pack[models.RigPack]", library.load(path, "rig", path.stem))
            to = library.poseset(rig.model.to).model if rig.model.to in known else None
        except PackError:
            continue
        if any(fault.severity == "fault" for fault in check_rig(rig, poseset, known, to)):
            continue
        face = FaceOnModel.of(poseset, model, {"channels": plain_channels(rig.model, to)})
        found = _played(face, by_name=by_name)
        if found.places:
            held = {n: one for n, one in channels_of(rig.model).items() if n in found.places}
            for name, one in held.items():
                # A channel that the model lacks cannot limit another.
                if one.at_most not in held:
                    held[name] = one.model_copy(update={"at_most": None})
            missing = tuple(one.name for one in face.channels if one.name not in found.places)
            kept = replace(rig, model=rig.model.model_copy(update={"channels": held}))
            left, lost, opens = _left(model, found), losses(library, kept), _opens(face, found)
            yield Match(poseset.name, rig.model.name, poses, found, missing, left, lost, opens)


def _played(face: FaceOnModel, *, by_name: bool) -> ChannelPlaces:
    """Find channels; on an avatar whose expressions open its mouth, those that players move."""
    found, moved = face.found, measured(face.model)
    if by_name:
        found = replace(found, places=found.still | found.places)
    bound = {shape for mesh in face.model.meshes for _, shape, _ in mesh.binds}
    if any(moved[shape].aperture > 0 for shape in bound & moved.keys()):
        own = {name: shapes for name, shapes in found.places.items() if name in found.bound}
        found = replace(found, places=own)
    return replace(found, doubts=face.doubts)


def _opens(face: FaceOnModel, found: ChannelPlaces) -> bool:
    """Test for a shape of the widest pose, or any, that opens the mouth; bones are not measured."""
    moved = measured(face.model)
    places = {name: own for name, own in found.places.items() if not face.wide or name in face.wide}
    own = {shape for shapes in places.values() for shape in shapes}
    widest = max((one.aperture for one in moved.values()), default=0.0)
    if widest <= 0 or not own <= moved.keys():
        return True
    return max((moved[name].aperture for name in own), default=0.0) >= MIN_OPEN_SHARE * widest


def _left(model: Model, found: ChannelPlaces) -> tuple[str, ...]:
    """List the shapes that move without a channel."""
    driven = still_shapes(model) | {shape for shapes in found.places.values() for shape in shapes}
    return tuple(shape for shape in model.shape_names if shape not in driven)
