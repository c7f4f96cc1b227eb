"""Faces whose mouths are measured on a mesh, and the meaning of one face's poses on another."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lipsync_lang import LipsyncError, ModelError
from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.faces.rigs.face_on_model import FaceOnModel
from lipsync_lang.faces.rigs.model import known_model
from lipsync_lang.faces.rigs.read_outs import LEAST_MOUTH, unmeasured
from lipsync_lang.packs.finding import is_model
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import PoseSet
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.resolver.rigging import best_match, model_file, plain_rig
from lipsync_lang.resolver.solving import MOST_SHAPE, OPENING_SHARE, STILL_GAIN

SEEN_MEASURES = ("aperture", "width", "protrusion")
"""Measures of a mouth that a viewer sees, in widths of the closed mouth."""

LEAST_STAND = 0.05
"""Smallest weight of a pose that stands for another one at full weight."""


@dataclass(frozen=True, eq=False)
class MeasuredFace:
    """A face with P poses, whose mouth is measured on a mesh."""

    name: str
    """The character, or the model, as the user names it."""
    poseset: PoseSet
    """With the targets of the character."""
    gains: Floats
    """(3, P) measures of each pose at full weight."""
    reach: float

    @classmethod
    def open(cls, library: Library, named: str) -> "MeasuredFace":
        """Open a character, a pose set or a model.

        Raises a LipsyncError for a face without a model, and a ModelError for one whose mouth
        cannot be measured, or does not open.
        """
        if is_model(named):
            match, _ = best_match(library, Path(named))
            pack, rig, model = library.poseset(match.poseset), match.rig, Path(named)
            poseset, reach = pack.model.having(match.optional), pack.model.reach
        else:
            who = library.character(named)
            pack, rig = library.poseset(who.model.poseset), who.model.rig
            path = model_file(who, pack)
            if path is None:
                raise LipsyncError(
                    f"{shown(who.path)}: {named} has no model, so its mouth cannot be measured; "
                    f"name a model with the poses of {pack.model.name} in its place, such as "
                    "head.glb"
                )
            poseset, reach = pack.model.having(who.model.has), who.model.reach or pack.model.reach
            poseset, model = who.model.own_face(poseset), Path(path)
        plain = plain_rig(library, rig, pack) if rig is not None else None
        gains = FaceOnModel.of(poseset, known_model(model), plain).gains
        if gains is None:
            why = unmeasured(known_model(model)) or "it is moved by bones"
            raise ModelError(f"{model}: its mouth cannot be measured: {why}")
        if gains[0].max(initial=0.0) < LEAST_MOUTH:
            raise ModelError(f"{model}: no pose of {poseset.name} opens its mouth; name another")
        return cls(named, poseset, gains[: len(SEEN_MEASURES)], reach)

    @property
    def poses(self) -> tuple[str, ...]:
        """Names of the poses."""
        return (*self.poseset.poses,)

    @property
    def still(self) -> Bools:
        """(P,) True for poses that a measure does not show, such as those of the tongue."""
        return np.asarray(np.abs(self.gains).max(axis=0) <= STILL_GAIN)

    @property
    def kept(self) -> Bools:
        """(P,) True for poses that are not solved: still ones, those of contacts, and yielding."""
        contacts = self.poseset.contacts.values()
        names = {pose for contact in contacts for pose in contact.floor}
        names |= {getattr(pair, "pose", "") for pair in self.poseset.constraints.pairs}
        return np.asarray(self.still | [pose in names for pose in self.poses])

    @property
    def most(self) -> Floats:
        """(P,) highest weight of each pose that is solved."""
        opening = self.gains[0] > OPENING_SHARE * np.abs(self.gains[1])
        highest = np.max([one for _, one in self.steps()], axis=0, initial=MOST_SHAPE)
        return np.where(opening, 1.0, highest)

    @property
    def sides(self) -> Floats:
        """(n, P) rows that subtract a pose from its mirrored one."""
        parts = (self.poseset.mirrors(part).items() for part in self.poseset.mirrored)
        rows = [
            [float(one == pose) - float(other == pose) for pose in self.poses]
            for pairs in parts
            for one, other in pairs
            if {one, other} <= {*self.poses}
        ]
        return np.array(rows, float).reshape(-1, len(self.poses))

    def steps(self) -> Iterator[tuple[tuple[str, int, int], Floats]]:
        """Yield the weights (P,) of each step of each target, by phoneme, step and their number."""
        for name, steps in self.poseset.targets.items():
            for number, step in enumerate(steps):
                weights = [step.weights.get(pose, 0.0) for pose in self.poses]
                yield (name, number, len(steps)), np.array(weights)


def meaning(source: MeasuredFace, goal: MeasuredFace) -> Floats:
    """Return what each pose of one face means on another: weights (P goal, P source).

    A pose of the same name is the same pose. Any other is that mix of the source's poses which
    tells best how the two pose sets make the same sounds. A still pose is a mix of its own region.
    """
    from scipy.optimize import nnls

    found = np.array([[float(one == other) for other in source.poses] for one in goal.poses])
    ours, theirs = dict(source.steps()), dict(goal.steps())
    sounds = [key for key in ours if key in theirs]
    named = found.any(axis=1)
    if named.all() or not sounds:
        return found
    told, wanted = (np.array([face[key] for key in sounds]) for face in (ours, theirs))
    regions = [face.poseset.poses for face in (source, goal)]
    for number in np.flatnonzero(~named):
        region = regions[1][goal.poses[number]].region
        near = [one.region == region or not region for one in regions[0].values()]
        free = np.array(near) & source.still if goal.still[number] else ~source.still
        # A pose that goes on under its own name means nothing else.
        free &= ~found[named].any(axis=0)
        if free.any():
            found[number, free] = nnls(told[:, free], wanted[:, number])[0]
    found[found < LEAST_STAND] = 0.0
    return found
