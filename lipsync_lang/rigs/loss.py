"""Losses of a rig: poses without effect, with a weak effect, or with the effect of another pose.

Conventions: each pose is examined alone, at full weight. The effect on a channel is the distance
from rest divided by the channel's span, so that degrees and weights are comparable. Negative gains
from rest have no visible effect. Limits between channels are ignored. Of two poses that look
alike, the one with the larger effect counts as shown and the other as lost.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.packs.models.rig_channels import plain_channels
from lipsync_lang.rigs.driver import Driver

if TYPE_CHECKING:
    from lipsync_lang.packs import models
    from lipsync_lang.packs.library import Library, Pack

ALIKE = 0.97
"""Minimum cosine between the channels of two poses for the same look."""

WEAK_SHARE = 0.5
"""Fraction of the range that the largest channel of a pose should reach."""


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
    """List the losses of a rig, in the order of its pose set.

    The effects of poses on channels, (C, P), are compared with one another.
    """
    poses = tuple(library.poseset(rig.model.poseset).model.poses)
    data = {"channels": plain_channels(rig.model, None)}
    driver = Driver.from_plain(data, poses, np.zeros(len(poses)))
    made = driver.rig
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
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    lines = (
        "  ".join([*(c.ljust(w) for c, w in zip(row, widths, strict=False)), row[3]])
        for row in rows
    )
    return "\n".join(line.rstrip() for line in lines)
