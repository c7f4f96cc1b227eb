"""What a rig cannot show: poses that drive nothing, little, or what another drives too.

Conventions: a pose is looked at alone, at its full weight. A channel counts by how far it goes
from rest, over its span, so that degrees and weights compare; what a gain below zero takes from a
channel at rest is nothing to see. That a channel yields to another is left out. Of two poses that
look alike, the one that moves the model more is shown, and the other lost.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.packs.models.rig_channels import plain_channels
from lipsync_lang.pipeline.arrays import Floats
from lipsync_lang.rigs.driver import Driver

if TYPE_CHECKING:
    from lipsync_lang.packs import models
    from lipsync_lang.packs.library import Library, Pack

ALIKE = 0.97
"""Cosine between the channels of two poses above which they look the same."""

WEAK = 0.5
"""Share of its range that the largest channel of a pose should move."""


@dataclass(frozen=True)
class Loss:
    """A pose that a rig does not show, or not as itself; prints itself."""

    pose: str
    shown: float
    """Share of its range by which the largest channel moves; 0 where nothing does."""
    like: str | None
    """The pose that it looks like, where there is one."""
    why: str
    """The rig's own words; empty where it has none."""

    @property
    def what(self) -> str:
        """What is lost, in words; empty where only the rig's own words say so."""
        if not self.shown:
            return "not shown"
        found = [f"looks like {self.like}"] if self.like else []
        return ", ".join([*found, *["weak"] * (self.shown < WEAK)])

    def __str__(self) -> str:
        told = self.what or f"shown at {self.shown:.2f}"
        return f"{self.pose}: {told}" + (f" ({self.why})" if self.why else "")

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, for JSON."""
        return {**asdict(self), "what": self.what}


def losses(library: "Library", rig: "Pack[models.RigPack]") -> tuple[Loss, ...]:
    """List the poses that a rig loses something of, in the order of its pose set."""
    poses = tuple(library.poseset(rig.model.poseset).model.poses)
    data = {"channels": plain_channels(rig.model, None)}
    driver = Driver.from_plain(data, poses, np.zeros(len(poses)))
    made = driver.rig
    low, high, span = made.low[:, None], made.high[:, None], made.span[:, None]
    moves = np.clip(made.gains, low, high) - np.clip(0.0, low, high)
    return tuple(_losses(poses, moves / np.where(span > 0, span, 1), rig.model.lost))


def _losses(poses: Sequence[str], moves: Floats, lost: Mapping[str, str]) -> list[Loss]:
    """Compare what poses move, (C, P), with one another."""
    shown = np.minimum(np.abs(moves).max(axis=0), 1)
    lengths = np.linalg.norm(moves, axis=0)
    unit = moves / np.where(lengths > 0, lengths, 1)
    rank = np.argsort(
        np.argsort(-shown, kind="stable")
    )  # of two alike, the first or stronger is it
    alike = np.where(rank[:, None] > rank, unit.T @ unit, 0)
    found = []
    for pose, share, others in zip(poses, shown.tolist(), alike, strict=True):
        nearest = int(others.argmax())
        like = poses[nearest] if others[nearest] > ALIKE else None
        if share < WEAK or like or pose in lost:
            found.append(Loss(pose, share, like, lost.get(pose, "")))
    return found


def loss_table(found: Sequence[Loss]) -> str:
    """Lay out what a rig loses, a pose a line."""
    if not found:
        return "every pose is shown as itself"
    rows = [("pose", "shown", "lost", "why")]
    rows += [(loss.pose, f"{loss.shown:.2f}", loss.what or "-", loss.why) for loss in found]
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    lines = (
        "  ".join([*(c.ljust(w) for c, w in zip(row, widths, strict=False)), row[3]])
        for row in rows
    )
    return "\n".join(line.rstrip() for line in lines)
