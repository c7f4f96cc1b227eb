"""Move a bank of bigrams from one face to another: by measures of the mouth, then by meaning.

Each control point of a bigram is a mouth. Its measures on the mesh of the first face are asked of
the second one, and its weights are the solution of a bounded least-squares problem. They stay near
what the artist's poses mean there. Curves are linear in their control points, so the whole course
follows, in the artist's own times.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lipsync_lang import LipsyncError, PackFaults
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import count
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.faults import visible
from lipsync_lang.packs.yaml.value_text import block_lines
from lipsync_lang.pipeline.curve import bspline, polyline
from lipsync_lang.plugins.mouths.measured_face import SEEN_MEASURES, MeasuredFace, meaning

MEASURE_FIRMNESS = np.array([1.0, 1.5, 0.5])
"""Weight of an error of each measure."""

LOOK_FIRMNESS = 0.2
"""Firmness with which a solved weight stays near what the artist's poses mean."""

SIDES_FIRMNESS = 3.0
"""Firmness with which mirrored poses keep the difference that the artist drew."""

MOST_KNOTS = 12
"""Highest number of control points of a moved curve; a person can still edit these."""

AT = np.linspace(0, 1, 65)
"""Normalised times at which curves are compared."""

SAME_CURVE = 5e-3
"""Largest change of a control point that leaves an artist's own curve as it is."""

FAINT, DECIMALS = 0.015, 3
"""Smaller control values are set to rest; the places of a solved weight."""

LEAST_LOSS = 0.02
"""Smallest loss that is named, in widths of the mouth: 1 mm of a human mouth."""

SHOWN = 12
"""Number of losses in the text."""


class MeasureLoss(NamedTuple):
    """The largest miss of a measure in a bigram or trigram."""

    bigram: str
    measure: str
    at: float
    """Normalised time of the miss."""
    asked: float
    reached: float

    @property
    def loss(self) -> float:
        """The size of the miss, in widths of the mouth."""
        return abs(self.asked - self.reached)


class LostPose(NamedTuple):
    """A pose of the first face that nothing on the second one shows."""

    pose: str
    bigrams: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class MovedBank:
    """A bank for another face, and what the move lost."""

    source: MeasuredFace
    goal: MeasuredFace
    bank: Mapping[str, Any]
    """The content of its file."""
    losses: tuple[MeasureLoss, ...]
    """The loss of each measure of each bigram, the largest first."""
    lost: tuple[LostPose, ...]
    stands: Mapping[str, Mapping[str, float]]
    """Poses that no measure shows and that moved under another name, with their weights."""

    @property
    def units(self) -> int:
        """Number of bigrams and trigrams."""
        return len(self.bank["bigrams"]) + len(self.bank.get("trigrams", {}))

    def yaml(self, name: str) -> str:
        """Return the content as the file of a bank of some name."""
        head = {key: one for key, one in self.bank.items() if not isinstance(one, dict)}
        head["name"] = name
        names = [visible(face.name) for face in (self.source, self.goal)]
        lines = [f"# Moved from {names[0]} to {names[1]} by the mouths that they show."]
        lines += block_lines(head)
        for key in ("bigrams", "trigrams"):
            if key in self.bank:
                lines += [f"{key}:"] if self.bank[key] else [f"{key}: {{}}"]
                for unit, own in self.bank[key].items():
                    lines += block_lines({unit: own}, 2)
        return "\n".join(lines) + "\n"

    def to_dict(self) -> dict[str, Any]:
        """Return what was moved and lost as JSON data."""
        return {
            "from": self.source.name,
            "to": self.goal.name,
            "poseset": self.goal.poseset.name,
            "moved": [*self.bank["bigrams"], *self.bank.get("trigrams", {})],
            "losses": [{**one._asdict(), "loss": round(one.loss, 4)} for one in self.losses],
            "stands": {pose: dict(own) for pose, own in self.stands.items()},
            "not_moved": [one._asdict() for one in self.lost],
        }

    def told(self) -> str:
        """Return what was moved and lost in words, the worst first."""
        goal, units = self.goal.poseset.name, count(self.units, "bigram")
        whole = f"{units} moved from {self.source.name} to {self.goal.name}"
        lines = [f"{whole}, for the poses of {goal}"]
        far = [one for one in self.losses if one.loss > LEAST_LOSS]
        rows = [
            (f"  {one.bigram}", one.measure, f"{one.at:.2f}", f"{one.asked:+.3f}",
             f"{one.reached:+.3f}")
            for one in far[:SHOWN]
        ]  # fmt: skip
        if rows:
            lines += columns([("  bigram", "measure", "at", "asked", "reached"), *rows])
        if len(far) > SHOWN:
            lines.append(f"  ... and {len(far) - SHOWN} more (--json lists them)")
        kept = len(self.losses) - len(far)
        lines.append(
            f"{kept} of {len(self.losses)} measures are within {LEAST_LOSS:g} of the mouth"
        )
        for pose, own in self.stands.items():
            mix = ", ".join(f"{name} {share:.2f}" for name, share in own.items())
            lines.append(f"{pose} moves as {mix}, by the sounds that both make with them")
        for one in self.lost:
            lines.append(
                f"not moved: {one.pose} of {', '.join(one.bigrams)}; {goal} shows it nowhere"
            )
        return "\n".join(lines)


def move_bank(library: Library, path: Path, source: str | None, goal: str) -> MovedBank:
    """Move a bank of bigrams to another face.

    Parameters
    ----------
    source : the face it was drawn for: a character, a pose set or a model; None for the bare pose
        set of the bank
    goal : the other face

    Raises
    ------
    PackFaults
        The bank has faults, such as an unknown pose.
    LipsyncError
        The bank is for other poses than those of the first face, or the mouth of a face cannot be
        measured.
    """
    pack: Any = library.load(path, "bank", path.stem)
    faults = [one for one in validate(library, [path]) if one.severity == "fault"]
    if faults:
        raise PackFaults(faults)
    bank = pack.model
    first = MeasuredFace.open(library, source or bank.poseset)
    if first.poseset.name != bank.poseset:
        raise LipsyncError(
            f"{pack.where(('poseset',))}: the bank moves the poses of {bank.poseset}, and "
            f"{first.name} has those of {first.poseset.name}; name a face of {bank.poseset} with "
            "--from"
        )
    second = MeasuredFace.open(library, goal)
    change = _FaceMove(first, second, meaning(first, second))
    stated = bank.model_dump(mode="json", exclude_defaults=True)
    made: dict[str, Any] = {"kind": "bank", "format": 1} | {
        key: one for key, one in stated.items() if key not in {"bigrams", "trigrams"}
    }
    made["poseset"] = second.poseset.name
    losses: list[MeasureLoss] = []
    for field in ("bigrams", "trigrams"):
        units = getattr(bank, field)
        if not units and field == "trigrams":
            continue
        made[field] = {}
        for name, unit in units.items():
            kind = unit.interpolation or bank.interpolation
            curves, own = change.moved(name, unit.curves, linear=kind == "linear")
            losses += own
            rest = unit.model_dump(mode="json", exclude_defaults=True, exclude={"curves"})
            if unit.status == "approved":  # nobody has approved these curves on this face
                rest["status"] = "edited"
            made[field][name] = rest | {"curves": curves}
    losses.sort(key=lambda one: -one.loss)
    units = {**bank.bigrams, **bank.trigrams}
    return MovedBank(
        first, second, made, tuple(losses), tuple(change.lost(units)), change.stands(units)
    )


@dataclass(frozen=True, eq=False)
class _FaceMove:
    """The move from one face to another."""

    source: MeasuredFace
    goal: MeasuredFace
    means: Floats
    """(P goal, P source)"""

    def moved(
        self, name: str, curves: Mapping[str, Sequence[tuple[float, float]]], *, linear: bool
    ) -> tuple[dict[str, list[list[float]]], list[MeasureLoss]]:
        """Return curves of the second face for those of the first, and the losses."""
        draw = polyline if linear else bspline
        own = {pose: np.array(points, float) for pose, points in curves.items()}
        times = _knots([points[:, 0] for points in own.values()])
        shape = draw(np.stack([np.column_stack((times, one)) for one in np.eye(len(times))]), AT)
        drawn = np.zeros((len(self.source.poses), len(AT)))
        values = np.zeros((len(self.source.poses), len(times)))
        for number, pose in enumerate(self.source.poses):
            if pose in own:
                drawn[number] = draw(own[pose][None], AT)[0]
                same = np.array_equal(own[pose][:, 0], times)
                fit = np.linalg.lstsq(shape.T, drawn[number], rcond=None)[0]
                values[number] = own[pose][:, 1] if same else fit.clip(0, 1)
        found = self._solved(values)
        found[found < FAINT] = 0.0
        made: dict[str, list[list[float]]] = {}
        reached = np.zeros((len(self.goal.poses), len(AT)))
        for number, pose in enumerate(self.goal.poses):
            points = self._artists(number, own, values, found[number])
            if points is None and found[number].any():
                points = np.column_stack((times, found[number])).round(DECIMALS)
            if points is not None:
                made[pose] = points.tolist()
                reached[number] = draw(points[None], AT)[0]
        return made, [*self._losses(name, drawn, reached)]

    def _artists(
        self, number: int, own: Mapping[str, Floats], values: Floats, found: Floats
    ) -> Floats | None:
        """Return the artist's own curve of a pose, in its own times and perhaps less high.

        None if several poses stand for this one, or if its weights were solved.
        """
        like = np.flatnonzero(self.means[number])
        if len(like) != 1 or self.source.poses[like[0]] not in own:
            return None
        share, points = float(self.means[number, like[0]]), own[self.source.poses[like[0]]]
        if np.abs(found - share * values[like[0]]).max() > SAME_CURVE + FAINT:
            return None
        return points if share == 1 else (points * (1, min(1.0, share))).round(DECIMALS)

    def _asked(self, weights: Floats) -> Floats:
        """Return the measures (3, n) that the mouths of the first face ask of the second."""
        return self.goal.reach / self.source.reach * self.source.gains @ weights

    def _solved(self, values: Floats) -> Floats:
        """Solve each control point: weights (P goal, n) for those of the first face."""
        from scipy.optimize import lsq_linear

        goal, asked, look = self.goal, self._asked(values), (self.means @ values).clip(0, 1)
        # Lips that press together are shut, however hard either face presses them.
        shut = np.minimum(0.0, (goal.gains @ look)[0])
        asked[0] = np.where(asked[0] < 0, np.maximum(asked[0], shut), asked[0])
        free, alike = ~goal.kept, SIDES_FIRMNESS * goal.sides
        found = look.copy()
        firm = LOOK_FIRMNESS * np.eye(int(free.sum()))
        rows = np.vstack([MEASURE_FIRMNESS[:, None] * goal.gains[:, free], firm, alike[:, free]])
        for number in range(asked.shape[1] if free.any() else 0):
            near, fixed = look[free, number], np.where(free, 0.0, look[:, number])
            aim = MEASURE_FIRMNESS * (asked[:, number] - goal.gains @ fixed)
            most = np.maximum(goal.most[free], near)
            wanted = np.concatenate([aim, LOOK_FIRMNESS * near, alike[:, free] @ near])
            if not np.allclose(rows @ near, wanted):
                found[free, number] = lsq_linear(rows, wanted, (0.0, most), method="bvls").x
        return found

    def _losses(self, name: str, drawn: Floats, reached: Floats) -> Iterator[MeasureLoss]:
        """Yield the largest miss of each measure. Lips do not pass each other."""
        pairs = [self._asked(drawn), self.goal.gains @ reached]
        for one in pairs:
            one[0] = np.maximum(0.0, one[0])
        for number, measure in enumerate(SEEN_MEASURES):
            asked, has = (one[number] for one in pairs)
            at = int(np.abs(asked - has).argmax())
            told = (float(AT[at]), float(asked[at]), float(has[at]))
            yield MeasureLoss(name, measure, *(round(one, 4) for one in told))

    def lost(self, units: Mapping[str, Any]) -> Iterator[LostPose]:
        """Yield the poses of a bank that no measure shows, and that nothing stands for."""
        for number, pose in enumerate(self.source.poses):
            used = tuple(name for name, unit in units.items() if pose in unit.curves)
            if used and self.source.still[number] and not self.means[:, number].any():
                yield LostPose(pose, used)

    def stands(self, units: Mapping[str, Any]) -> dict[str, dict[str, float]]:
        """Return the poses that replace, by another name, each pose that no measure shows."""
        used = {pose for unit in units.values() for pose in unit.curves}
        found = {}
        for number, pose in enumerate(self.source.poses):
            shares = self.means[:, number]
            mix = {
                self.goal.poses[one]: round(float(shares[one]), 3) for one in shares.nonzero()[0]
            }
            if pose in used and self.source.still[number] and mix and pose not in mix:
                found[pose] = mix
        return found


def _knots(each: Sequence[Floats]) -> Floats:
    """Return the times of all curves of a bigram; the nearest ones are joined if they are many."""
    times = np.unique(np.concatenate(each))
    while len(times) > MOST_KNOTS:
        gaps = np.diff(times)
        near = int(gaps.argmin())
        # The ends stay, so that the bigram keeps its span.
        times = np.delete(times, max(near, 1))
    return times
