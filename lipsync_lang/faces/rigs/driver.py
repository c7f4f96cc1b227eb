"""Drivers of a model: the channels of a rig as arrays, with their targets on the model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from graphlib import TopologicalSorter
from math import inf
from typing import Any, Self

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.pipeline.drive import Rig, drive, sides
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.prepare import channel_kernel

MORPH = (0.0, 1.0)
"""Default range of a morph target weight."""

UNLIMITED = (-inf, inf)
"""Default range of a bone channel."""


@dataclass(frozen=True, eq=False)
class Driver:
    """A rig in array form, ready for evaluation."""

    channels: tuple[Channel, ...]
    rig: Rig

    @classmethod
    def from_plain(cls, data: Mapping[str, Any], poses: Sequence[str], floors: Floats) -> Self:
        """Build a driver from a rig in the form of `resolver.rigging`; floors are (P,)."""
        stated = data["channels"]
        gains = np.array([[one["gains"].get(pose, 0.0) for pose in poses] for one in stated], float)
        ranges = np.array([one["range"] or (UNLIMITED if one["node"] else MORPH) for one in stated])
        channels = []
        for one in stated:
            moves: Any = (one[way] and tuple(one[way]) for way in ("rotation", "translation"))
            names = tuple(one["names"])
            channels.append(Channel(one["name"], names, one["mesh"], one["node"], *moves))
        number = {one["name"]: index for index, one in enumerate(stated)}
        limits = {number[one["name"]]: number[one["at_most"]] for one in stated if one["at_most"]}
        # Each value is final before its use as a limit.
        order = TopologicalSorter({own: {other} for own, other in limits.items()}).static_order()
        pairs = tuple((own, limits[own]) for own in order if own in limits)
        rig = Rig(gains, ranges[:, 0], ranges[:, 1], pairs, sides(gains, floors))
        return cls(tuple(channels), rig)

    def driven(self, weights: Floats, motion: Motion, fps: float) -> Floats:
        """Return the channels (T, C) for poses (T, P), within the speed limit of a motion."""
        return drive(weights, self.rig, motion.speed_limit / fps, channel_kernel(motion, fps))
