"""What drives a model: a rig's channels as arrays, and what each of them is on the model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from graphlib import TopologicalSorter
from math import inf
from typing import Any, Self

import numpy as np

from lipsync_lang.pipeline.arrays import Floats
from lipsync_lang.pipeline.drive import Rig, sides
from lipsync_lang.rigs.channel import Channel

MORPH = (0.0, 1.0)
"""The range of a shape that states none."""

FREE = (-inf, inf)
"""That of a bone."""


@dataclass(frozen=True, eq=False)
class Driver:
    """A rig, ready to drive."""

    channels: tuple[Channel, ...]
    rig: Rig

    @classmethod
    def from_plain(cls, data: Mapping[str, Any], poses: Sequence[str], floors: Floats) -> Self:
        """Return the driver of a rig as `resolver.rigging` states it.

        Parameters
        ----------
        poses : P names, in the order of the curves
        floors : (P,) the highest floor of any contact
        """
        stated = data["channels"]
        gains = np.array([[one["gains"].get(pose, 0.0) for pose in poses] for one in stated], float)
        ranges = np.array([one["range"] or (FREE if one["node"] else MORPH) for one in stated])
        return cls(
            tuple(_channel(one) for one in stated),
            Rig(gains, ranges[:, 0], ranges[:, 1], _order(stated), sides(gains, floors)),
        )


def bare(poses: Sequence[str], names: Mapping[str, Sequence[str]]) -> tuple[Channel, ...]:
    """Return the channels of a face without a rig: its poses, as models spell them."""
    return tuple(Channel(pose, tuple(names.get(pose, ()))) for pose in poses)


def _channel(one: Mapping[str, Any]) -> Channel:
    ways = (tuple(one[way]) if one[way] else None for way in ("rotation", "translation"))
    return Channel(one["name"], tuple(one["names"]), one["mesh"], one["node"], *ways)


def _order(stated: Sequence[Mapping[str, Any]]) -> tuple[tuple[int, int], ...]:
    """Return which channel yields to which, by number: each is final before it is used."""
    number = {one["name"]: index for index, one in enumerate(stated)}
    limits = {number[one["name"]]: number[one["at_most"]] for one in stated if one["at_most"]}
    order = TopologicalSorter({own: {other} for own, other in limits.items()}).static_order()
    return tuple((own, limits[own]) for own in order if own in limits)
