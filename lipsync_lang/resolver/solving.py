"""Targets solved on a model: the weights of its shapes that give the mouth of each sound best.

A common phoneme states its mouth in measures (`mouth` in `common.yaml`), and a model says what each
of its shapes does to them. A target is the solution of a bounded least-squares problem. Each
measure counts by how firmly it is held. The declared target counts too, as the look that an
animator chose. Each shape has a price, so that few of them carry a sound; declared ones are the
cheapest.

Poses of contacts, and those that move no measure, such as the tongue's, keep their declared weight.
"""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.base.errors import ModelError
from lipsync_lang.faces.rigs.channel import bare
from lipsync_lang.packs import models
from lipsync_lang.packs.models import PhonemeTarget
from lipsync_lang.packs.models.rig_models import pose_names

if TYPE_CHECKING:
    from lipsync_lang.faces.rigs.model import Model

_log = logging.getLogger(__name__)

FIRMNESS = np.array([1.0, 1.5, 0.5, 0.8])
"""Weight of an error of each measure that a sound states."""

IDLE_FIRMNESS = np.array([0.0, 0.0, 0.05, 0.0])
"""The same of a measure that it leaves open: hardly any, so that idle lips are not pushed out."""

SHAPE_PRICE, OWN_SHARE = 0.004, 0.2
"""Price of a shape at full weight, and the share of it that a declared shape of the sound costs."""

SPREADING = 0.03
"""Firmness with which each weight is drawn to 0: two shapes that do the same share the work."""

OPENING_LOOK = 0.1
"""Highest firmness of the look of a shape that opens the mouth, whose weight is to be solved."""

STILL_GAIN = 0.01
"""Smallest effect on a measure, in widths of the mouth, of a shape that is solved."""

MOST_SHAPE = 0.7
"""Highest weight of a shape that does not open the mouth, unless a declared target has more."""

OPENING_SHARE = 1.5
"""A shape opens the mouth if it changes the aperture this many times as much as the width."""

LEAST_OPENING = 0.03
"""Smallest aperture of the widest shape of a mouth that opens, in widths of the mouth."""

FAR_GOAL = 1e3
"""Distance of the goal that stands for a price."""

DECIMALS = 4
"""Places of a solved weight, so that processors agree."""


@dataclass(frozen=True, eq=False)
class SolvedFace:
    """Targets that were solved on a model."""

    model: Path
    targets: Mapping[str, tuple[PhonemeTarget, ...]] = field(default_factory=dict)
    reached: Mapping[str, Floats] = field(default_factory=dict)
    """(steps, 4) measures of the targets, by phoneme."""


def solved_face(
    poseset: models.PoseSet,
    mouths: Mapping[str, Sequence[models.SoundMouth]],
    model: "Model",
    rig: Mapping[str, Any] | None = None,
    reach: float | None = None,
) -> SolvedFace | None:
    """Solve the targets of a pose set on a model; None if its mouth cannot be measured.

    Parameters
    ----------
    mouths : the mouths of sounds in running speech, by phoneme
    rig : the rig that drives it, as plain data; None if its shapes are the poses
    reach : factor of all measures; None for that of the pose set

    Raises
    ------
    ModelError
        None of the poses opens the mouth of the model.

    Examples
    --------
    >>> library = Library()
    >>> poseset, mouths = library.poseset("arkit").model, library.common().model.mouths()
    >>> face = solved_face(poseset, mouths, read_model(Path("head.glb")))  # doctest: +SKIP
    >>> face.targets["aa"][0].weights  # doctest: +SKIP
    {'jawOpen': 0.31, 'mouthClose': 0.0}
    """
    gains = pose_gains(poseset, model, rig)
    if gains is None:
        _log.info("%s: its mouth cannot be measured", model.path)
        return None
    if gains[0].max(initial=0.0) < LEAST_OPENING:
        raise ModelError(
            f"{model.path}: no shape of it that is a pose of {poseset.name} opens the mouth: the "
            f"widest parts the lips by {max(0.0, gains[0].max(initial=0.0)):.3f} of its width. "
            "Make the shapes that open it poses of their own with `lipsync-lang posesets new`, or "
            "keep the targets of the pose set with `mouth: declared` in a character"
        )
    face = _FaceToSolve.of(poseset, gains)
    targets = {
        name: face.target(name, steps, mouths[name], reach or poseset.reach)
        for name, steps in poseset.targets.items()
        if mouths.get(name)
    }
    reached = {
        name: np.array([gains @ face.weights(one) for one in targets[name]]) for name in targets
    }
    return SolvedFace(model.path, targets, reached)


def pose_gains(
    poseset: models.PoseSet, model: "Model", rig: Mapping[str, Any] | None = None
) -> Floats | None:
    """Return what each pose does to the measures of the mouth at full weight: (4, P).

    Limits of a rig's channels are left out. None for a model that moves bones, that is too large to
    be measured, or on which no shape opens a mouth.
    """
    from lipsync_lang.faces.rigs.driver import Driver
    from lipsync_lang.faces.rigs.recognise import mouth_gains

    poses = (*poseset.poses,)
    if rig is None:
        return mouth_gains(bare(poses, pose_names(poseset)), model)
    driver = Driver.from_plain(rig, poses, np.zeros(len(poses)))
    found = mouth_gains(driver.channels, model)
    return None if found is None else found @ driver.rig.gains


@dataclass(frozen=True, eq=False)
class _FaceToSolve:
    """A face to solve: the part of the problem that all sounds share."""

    poseset: models.PoseSet
    gains: Floats
    """(4, P) measures of each pose at full weight."""
    groups: list[Ints]
    """Numbers of the poses that move alike: those of a mirrored pair, or one."""
    opening: Bools
    """(P,) True for poses that open the mouth."""
    most: Floats
    """(P,) highest weight; 0 for a pose that keeps its declared weight."""

    @classmethod
    def of(cls, poseset: models.PoseSet, gains: Floats) -> "_FaceToSolve":
        """Find which poses may be solved, and how far they may go."""
        number = {pose: index for index, pose in enumerate(poseset.poses)}
        other = {
            number[one]: number[two]
            for part in poseset.mirrored
            for one, two in poseset.mirrors(part).items()
            if one in number and two in number
        }
        groups = [
            np.array([one, *([other[one]] if one in other else [])])
            for one in number.values()
            if one not in other.values()
        ]
        opening = gains[0] > OPENING_SHARE * np.abs(gains[1])
        made = cls(poseset, gains, groups, opening, np.ones(len(number)))
        steps = [made.weights(one) for steps in poseset.targets.values() for one in steps]
        most = np.where(opening, 1.0, np.maximum(np.max(steps, axis=0), MOST_SHAPE))
        touching = {pose for contact in poseset.contacts.values() for pose in contact.floor}
        still = np.abs(gains).max(axis=0) <= STILL_GAIN
        kept = still | [pose in touching for pose in poseset.poses]
        return replace(made, most=np.where(kept, 0.0, most))

    def weights(self, step: PhonemeTarget) -> Floats:
        """Return the weights (P,) of a target."""
        return np.array([step.weights.get(pose, 0.0) for pose in self.poseset.poses])

    def target(
        self,
        name: str,
        steps: Sequence[PhonemeTarget],
        mouth: Sequence[models.SoundMouth],
        reach: float,
    ) -> tuple[PhonemeTarget, ...]:
        """Solve the target of a phoneme, step by step."""
        most = self.most
        for contact in self.poseset.contacts.values():
            if name in contact.phonemes:
                ceiling = [contact.ceiling.get(pose, 1.0) for pose in self.poseset.poses]
                most = np.minimum(most, ceiling)
        groups = [group for group in self.groups if most[group].min() > 0]
        free = np.isin(np.arange(len(most)), np.concatenate([*groups, np.array([], int)]))
        own = np.any([self.weights(step) > 0 for step in steps], axis=0)
        price = np.array([len(g) ** 0.5 * (OWN_SHARE if own[g].any() else 1.0) for g in groups])
        found = []
        for number, step in enumerate(steps):
            weights = self.weights(step)
            wanted = mouth[min(number, len(mouth) - 1)]
            stated = [getattr(wanted, measure) for measure in models.MOUTH_MEASURES]
            firm = np.where([one is not None for one in stated], FIRMNESS, IDLE_FIRMNESS)
            aim = reach * np.array([one or 0.0 for one in stated])
            aim -= self.gains[:, ~free] @ weights[~free]
            gains = (
                np.array([self.gains[:, group].sum(axis=1) for group in groups]).reshape(-1, 4).T
            )
            look = np.array([weights[group].max() for group in groups])
            top = np.array([most[group].min() for group in groups])
            opens = np.array([self.opening[group[0]] for group in groups])
            firmly = np.where(opens, min(OPENING_LOOK, self.poseset.look), self.poseset.look)
            solved = _fitted(firm[:, None] * gains, firm * aim, firmly, look, price, top)
            for group, weight in zip(groups, solved, strict=True):
                weights[group] = weight
            # An opening pose that is not named would spread into the sound from its neighbours.
            named = [pose in step.weights for pose in self.poseset.poses] | (self.opening & free)
            rows = zip(self.poseset.poses, np.round(weights, DECIMALS).tolist(), named, strict=True)
            kept = {pose: weight for pose, weight, stays in rows if stays or weight}
            found.append(step.model_copy(update={"weights": kept}))
        return tuple(found)


def _fitted(  # noqa: PLR0913, PLR0917 the parts of one problem
    gains: Floats, aim: Floats, firmly: Floats, look: Floats, price: Floats, top: Floats
) -> Floats:
    """Return the weight (n,) of each group: near the aim, near the look, and of few shapes."""
    from scipy.optimize import lsq_linear

    if not len(look):
        return look
    every = np.eye(len(look))
    # A price is linear in the weight: a far goal that hardly counts has the same slope.
    rows = np.vstack([gains, SPREADING * every, firmly * every, price / FAR_GOAL])
    goals = np.concatenate([aim, 0 * look, firmly * look, [-SHAPE_PRICE * FAR_GOAL]])
    solved: Floats = lsq_linear(rows, goals, (0.0, top), method="bvls").x
    return solved
