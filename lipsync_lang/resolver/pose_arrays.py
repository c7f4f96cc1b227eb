"""Rules of a pose set as arrays; poses are numbered in the order of its `poses`."""

from graphlib import TopologicalSorter

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.grouping import grouped
from lipsync_lang.packs.models import AtMost, PoseSet, Threshold

SOFTNESS_SECONDS = 0.04
"""Default rounding of a pose in seconds."""


def thresholds(poseset: PoseSet, *, paper: bool = False) -> Floats:
    """Constraints as a symmetric (P, P) array; `paper` prefers the paper's own values."""
    numbers = _numbers(poseset)
    out = np.full((len(numbers),) * 2, poseset.constraints.default)
    for pair in poseset.constraints.pairs:
        if isinstance(pair, Threshold) and numbers.keys() >= {*pair.between}:
            a, b = (numbers[pose] for pose in pair.between)
            own = pair.threshold if not paper or pair.paper is None else pair.paper
            out[a, b] = out[b, a] = own
    return out


def at_most(poseset: PoseSet) -> list[tuple[int, int]]:
    """Pairs (pose, other), sorted so that each `other` is final before its use."""
    numbers = _numbers(poseset)
    rules = [
        (numbers[rule.pose], numbers[rule.at_most])
        for rule in poseset.constraints.pairs
        if isinstance(rule, AtMost) and numbers.keys() >= {rule.pose, rule.at_most}
    ]
    # a pose may be the other of one rule and the pose of the next: the order must chain
    order = list(TopologicalSorter(grouped(rules)).static_order())
    return sorted(rules, key=lambda rule: order.index(rule[0]))


def priority(poseset: PoseSet) -> Floats:
    """(P,) priorities; larger wins. A pose without a stated priority never yields."""
    # poses are listed from the one that yields first
    rank = {pose: float(number) for number, pose in enumerate(poseset.priority)}
    return np.array([rank.get(pose, np.inf) for pose in poseset.poses])


def softness(poseset: PoseSet) -> Floats:
    """(P,) seconds of rounding for each pose: its own, its region's or the default."""
    own, regions = poseset.poses.values(), poseset.softness
    usual = (regions.get(pose.region, SOFTNESS_SECONDS) for pose in own)
    pairs = zip((pose.softness for pose in own), usual, strict=True)
    return np.array([other if stated is None else stated for stated, other in pairs], float)


def _numbers(poseset: PoseSet) -> dict[str, int]:
    return {pose: number for number, pose in enumerate(poseset.poses)}
