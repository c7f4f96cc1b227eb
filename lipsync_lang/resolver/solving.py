"""Targets solved on a model: the weights of its shapes that give the mouth of each sound best.

A common phoneme states its mouth in measures (`mouth` in `common.yaml`), and a model says what each
of its shapes does to them. A target is the solution of a bounded least-squares problem. Each
measure counts by how firmly it is held. The declared target counts too, as the look that an
animator chose. Each shape has a price, so that few of them carry a sound; declared ones are the
cheapest.

Poses of contacts, and those that move no measure, such as the tongue's, keep their declared weight.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.faces.rigs.face_on_model import FaceOnModel
from lipsync_lang.packs import models
from lipsync_lang.packs.models import PhonemeTarget

FIRMNESS = np.array([1.3, 2.0, 0.5, 0.8])
"""Weight of an error of each measure that a sound states."""

IDLE_FIRMNESS = np.array([0.0, 0.0, 0.05, 0.0])
"""The same of a measure that it leaves open: hardly any, so that idle lips are not pushed out."""

SHAPE_PRICE, OWN_SHARE = 0.004, 0.2
"""Price of a shape at full weight, and the share of it that a declared shape of the sound costs."""

OPENING_LOOK = 0.1
"""Highest firmness of the look of a shape that opens the mouth, whose weight is to be solved."""

STILL_GAIN = 0.01
"""Smallest effect on a measure, in widths of the mouth, of a shape that is solved."""

MOST_SHAPE = 0.7
"""Highest weight of a shape that does not open the mouth, unless a declared target has more."""

OPENING_SHARE = 1.5
"""A shape opens the mouth if it changes the aperture this many times as much as the width."""

FAR_GOAL = 1e3
"""Distance of the goal that stands for a price."""

MISSED_SHARE, LEAST_MISS = 1 / 3, 0.03
"""A measure is missed by this share of what was asked, and by so many widths of the mouth."""

LEAST_REACH = 0.9
"""Least reach of a mouth that states its jaw: with less, "oo" is a slit, and "th" has no tongue."""

DECIMALS = 4
"""Places of a solved weight, so that processors agree."""


@dataclass(frozen=True, eq=False)
class SolvedFace:
    """Targets that were solved on a model."""

    model: Path
    targets: Mapping[str, tuple[PhonemeTarget, ...]] = field(default_factory=dict)
    asked: Mapping[str, Floats] = field(default_factory=dict)
    """(steps, 4) measures of the mouths, by phoneme; NaN for one that is left open."""
    reached: Mapping[str, Floats] = field(default_factory=dict)
    """(steps, 4) measures of the targets, by phoneme."""

    def told(self, phoneme: str) -> str:
        """Return where a target was solved, with the measures that miss what was asked by far."""
        missed = [
            f"{measure} {given:.3f} for {asked:.3f}"
            for rows in zip(self.asked[phoneme], self.reached[phoneme], strict=True)
            for measure, asked, given in zip(models.MOUTH_MEASURES, *rows, strict=True)
            if abs(given - asked) > max(LEAST_MISS, MISSED_SHARE * abs(asked))
        ]
        return f"solved on {self.model.name}" + (f", with {', '.join(missed)}" if missed else "")


def solved_face(
    shown: FaceOnModel,
    mouths: Mapping[str, Sequence[models.SoundMouth]],
    likes: Mapping[str, str] | None = None,
) -> SolvedFace | None:
    """Solve the targets of a pose set on a model; None if its mouth is not measured.

    Parameters
    ----------
    shown : the pose set on the model, of which a pose opens the mouth
    mouths : the mouths of sounds in running speech, by phoneme
    likes : phonemes that a language adds, each with one whose target is its look

    Examples
    --------
    >>> shown = FaceOnModel.of(poseset, known_model(path))  # doctest: +SKIP
    >>> solved_face(shown, mouths).targets["aa"][0].weights  # doctest: +SKIP
    {'jawOpen': 0.31, 'mouthClose': 0.0}
    """
    poseset, gains, model = shown.poseset, shown.gains, shown.model
    if gains is None:
        return None
    looks = {**poseset.targets, **poseset.looks}
    face = _FaceToSolve.of(poseset, gains)
    like = {**(likes or {}), **{name: name for name in looks}}
    asked = {
        name: asked_measures(mouths[name], len(looks[look]), poseset.reach)
        for name, look in like.items()
        if mouths.get(name) and look in looks
    }
    targets = {
        name: face.target(like[name], looks[like[name]], rows, mouths[name][0].firm)
        for name, rows in asked.items()
    }
    reached = {n: np.array([gains @ face.weights(one) for one in targets[n]]) for n in targets}
    return SolvedFace(model.path, targets, asked, reached)


def asked_measures(mouth: Sequence[models.SoundMouth], steps: int, reach: float) -> Floats:
    """Return the measures (steps, 4) of a mouth; NaN for one that it leaves open.

    The last mouth serves all steps that follow.
    """
    rows = [mouth[min(number, len(mouth) - 1)] for number in range(steps)]
    stated = [[getattr(row, measure) for measure in models.MOUTH_MEASURES] for row in rows]
    return np.array(stated, float) * [[own_reach(row, reach)] for row in rows]


def own_reach(mouth: models.SoundMouth, reach: float) -> float:
    """Return the reach of a mouth: a small hole, or near teeth, stay readable at any reach."""
    return reach if mouth.jaw is None else max(reach, LEAST_REACH)


def farther(
    poseset: models.PoseSet, factor: float, mouths: Mapping[str, Sequence[models.SoundMouth]]
) -> dict[str, tuple[models.PhonemeTarget, ...]]:
    """Return declared targets times a factor, as far as contacts and mouths let them move."""
    touching = (pose for contact in poseset.contacts.values() for pose in contact.floor)
    kept = dict.fromkeys(touching, 1.0)

    def moved(step: PhonemeTarget, own: float) -> PhonemeTarget:
        far = ((pose, weight * kept.get(pose, own)) for pose, weight in step.weights.items())
        weights = {pose: min(1.0, round(weight, DECIMALS)) for pose, weight in far}
        return step.model_copy(update={"weights": weights})

    found = {}
    for name, steps in poseset.targets.items():
        own = [own_reach(mouth, factor) for mouth in mouths.get(name, ())] or [factor]
        every = own + own[-1:] * len(steps)
        found[name] = tuple(moved(*one) for one in zip(steps, every, strict=False))
    return found


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
        twins = dict(pair for part in poseset.mirrored for pair in poseset.mirrors(part).items())
        found = [[n for n in (one, twins.get(one)) if n in number] for one in number]
        seconds = {both[1] for both in found if len(both) > 1}
        groups = [np.array([number[n] for n in one]) for one in found if one[0] not in seconds]
        opening = gains[0] > OPENING_SHARE * np.abs(gains[1])
        made = cls(poseset, gains, groups, opening, np.ones(len(number)))
        looks = {**poseset.targets, **poseset.looks}
        steps = [made.weights(one) for steps in looks.values() for one in steps]
        most = np.where(opening, 1.0, np.maximum(np.max(steps, axis=0), MOST_SHAPE))
        still = np.abs(gains).max(axis=0) <= STILL_GAIN
        touching = {pose for contact in poseset.contacts.values() for pose in contact.floor}
        kept = still | [pose in touching for pose in poseset.poses]
        return replace(made, most=np.where(kept, 0.0, most))

    def weights(self, step: PhonemeTarget) -> Floats:
        """Return the weights (P,) of a target."""
        return np.array([step.weights.get(pose, 0.0) for pose in self.poseset.poses])

    def target(
        self, name: str, steps: Sequence[PhonemeTarget], asked: Floats, firm: float | None = None
    ) -> tuple[PhonemeTarget, ...]:
        """Solve a target for measures (steps, 4); `firm` is the dominance of poses that open it."""
        most = self.most
        for contact in self.poseset.contacts.values():
            if name in contact.phonemes:
                ceiling = [contact.ceiling.get(pose, 1.0) for pose in self.poseset.poses]
                most = np.minimum(most, ceiling)
        groups = [group for group in self.groups if most[group].min() > 0]
        share = np.zeros((len(groups), len(most)))
        for row, group in zip(share, groups, strict=True):
            row[group] = 1.0
        free, gains = share.any(axis=0), self.gains @ share.T
        own = np.any([self.weights(step) > 0 for step in steps], axis=0)
        price = share.sum(axis=1) ** 0.5 * np.where(share @ own > 0, OWN_SHARE, 1.0)
        top = np.array([most[group].min() for group in groups])
        opens = np.array([self.opening[group[0]] for group in groups])
        firmly = np.where(opens, min(OPENING_LOOK, self.poseset.look), self.poseset.look)
        poses = (*self.poseset.poses,)
        opened = [poses[number] for number in np.flatnonzero(self.opening & free)]
        held = {} if firm is None else dict.fromkeys(opened, firm)
        found = []
        for step, wanted in zip(steps, asked, strict=True):
            declared = self.weights(step)
            weight = np.where(np.isnan(wanted), IDLE_FIRMNESS, FIRMNESS)
            aim = np.nan_to_num(wanted) - self.gains[:, ~free] @ declared[~free]
            look = np.array([declared[group].max() for group in groups])
            solved = _fitted(weight[:, None] * gains, weight * aim, firmly, look, price, top)
            weights = np.round(np.where(free, solved @ share, declared), DECIMALS)
            # An opening pose that is not named would spread into the sound from its neighbours.
            named = {*step.weights, *opened}
            rows = zip(poses, weights.tolist(), strict=True)
            kept = {pose: weight for pose, weight in rows if weight or pose in named}
            changed = {"weights": kept, "dominance": held | step.dominance}
            found.append(step.model_copy(update=changed))
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
    rows = np.vstack([gains, firmly * every, price / FAR_GOAL])
    goals = np.concatenate([aim, firmly * look, [-SHAPE_PRICE * FAR_GOAL]])
    solved: Floats = lsq_linear(rows, goals, (0.0, top), method="bvls").x
    return solved
