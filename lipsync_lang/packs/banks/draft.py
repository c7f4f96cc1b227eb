"""Drafts of bigrams from targets: a complete bank, which a person can improve.

The paper's animators draw every bigram by hand (3.1.2, 5.2). Here all bigrams are drafted from the
pose set, which states the weight and the dominance of each pose at each common phoneme. Between
two phonemes, their targets are averaged by dominance (Cohen and Massaro 1993)::

    f(x) = sum_i D_i(x) T_i(x) / sum_i D_i(x),   D_i(x) = dominance_i exp(-SHARPNESS |x - m_i|)

over the bigram's normalised time x, with the two phonemes' middles m at 1/4 and 3/4. A
dominant target therefore starts within its neighbour: rounding starts before a rounded vowel, and
a "p" raises the jaw during the vowel before it.

Outside the two middles f fades to rest, because the neighbouring bigrams cover these parts: if two
bigrams overlap, the larger curve wins. Each bigram therefore determines the transition from the
middle of its first phoneme to the middle of its second.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.pipeline.curve import bspline

TIMES: Floats = np.array([0, 0.15, 0.35, 0.5, 0.65, 0.85, 1])
"""(n,) control times of a drafted curve: few, round, and densest between the phonemes."""

SHARPNESS = 10.0
"""Decay of a phoneme's dominance with the distance from its middle, per unit of normalised time."""

PASSIVE = 0.01
"""Dominance of a pose that a phoneme does not mention; the neighbour's target spreads into it."""

STIFFNESS = 0.03
"""Weight of an even control polygon, which is easy to edit, relative to the error of the fit."""

DECIMALS = 2
"""Decimals of drafted values, the same as in a bank file, so that writing is lossless."""

FAINT = 0.015
"""Smaller control values are set to rest."""


@dataclass(frozen=True, eq=False)
class Target:
    """Pose weights at one phoneme."""

    weights: Floats
    """(m, P) in [0, 1]; several rows for a phoneme that moves, such as a diphthong."""
    dominance: Floats
    """(P,) positive; poses with a higher dominance give way less to the neighbour's target."""


def draft(first: list[Target], second: list[Target], *, exact: bool = False) -> Floats:
    """Draft bigrams.

    Bigram b passes from ``first[b]`` to ``second[b]``; there are B of each. With `exact`, values
    are not rounded and follow small changes of a target. Returns (B, P, n) control values in [0, 1]
    at `TIMES`; the smooth curve approximates f, although its control points may not.
    """
    at, solve, curves = _fit()
    each = list(dict.fromkeys([*first, *second]))  # few distinct targets in many pairs
    number = {target: index for index, target in enumerate(each)}
    one, other = [number[t] for t in first], [number[t] for t in second]
    early, late = _dominance(each, at, 0.25), _dominance(each, at, 0.75)
    coming = early * np.stack([_profile(t, at) for t in each])
    going = late * np.stack([_profile(t, at - 0.5) for t in each])
    # In place, because thousands of bigrams make large arrays.
    wanted = coming[one]
    wanted += going[other]
    weight = early[one]
    weight += late[other]
    wanted /= weight
    wanted *= np.stack([_rise(t, at) for t in each])[one, :, None]
    wanted *= np.stack([_rise(t, 1 - at) for t in each])[other, :, None]
    # v + (f - v C) S, with the products of C and S taken first: v is shorter than f
    fitted = wanted.swapaxes(1, 2) @ solve
    values = np.zeros_like(fitted)
    # Bounds move some values, and each round fits the others again.
    for _ in range(4):
        values = (values + fitted - values @ (curves @ solve)).clip(0, 1)
        # A bigram begins and ends at rest, whatever the fit says.
        values[..., [0, -1]] = 0
    if exact:
        return values
    values[values < FAINT] = 0
    return values.round(DECIMALS)


def _middles(target: Target) -> Floats:
    """Return (m,) middles of a target's steps, which share half a bigram."""
    steps = len(target.weights)
    return (np.arange(steps) + 1) / (steps + 1) / 2


def _profile(target: Target, at: Floats) -> Floats:
    """Return (K, P) weights of a phoneme's target; `at` counts from its start."""
    steps = np.eye(len(target.weights))
    shares: Floats = np.stack([np.interp(at, _middles(target), step) for step in steps], axis=1)
    return shares @ target.weights


def _rise(target: Target, at: Floats) -> Floats:
    """Return (K,): the rise from rest at a bigram's edge to the first step of its phoneme."""
    return np.minimum(1, at / _middles(target)[0])


def _dominance(targets: list[Target], at: Floats, middle: float) -> Floats:
    """Return (B, K, P) dominance of each phoneme over normalised time."""
    fall: Floats = np.exp(-SHARPNESS * np.abs(at - middle))
    return fall[:, None] * np.stack([t.dominance for t in targets])[:, None, :]


def shape(at: Floats) -> Floats:
    """Return (n, K) shares of each control value at `TIMES` in a drafted curve at (K,) times."""
    units = np.stack([np.column_stack((TIMES, unit)) for unit in np.eye(len(TIMES))])
    return bspline(units, at)


@cache
def _fit() -> tuple[Floats, Floats, Floats]:
    """Return times (K,), the stiffened least-squares fit (K, n) and each point's curve (n, K)."""
    at = np.linspace(0, 1, 49)
    curves = shape(at)
    # Second differences, which an even polygon does not have.
    bend = np.diff(np.eye(len(TIMES)), 2, axis=0)
    stiff = STIFFNESS * len(at) / len(TIMES) * bend.T @ bend
    return at, curves.T @ np.linalg.inv(curves @ curves.T + stiff), curves
