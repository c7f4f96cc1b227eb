"""Animation tracks of a model: target node, property, times in seconds and values (T, n).

Splines are piecewise cubic curves of keys with slopes, as in animation editors and glTF; (K, C) is
keys by columns, which share their keys.
"""

from collections.abc import Collection, Iterator
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.accessors import MAX_ACCESSOR_VALUES, Accessors
from lipsync_lang.faces.rigs.container import fail
from lipsync_lang.faces.rigs.model import Model, check_list, is_index

VALUES_PER_KEY = {"LINEAR": 1, "STEP": 1, "CUBICSPLINE": 3}
"""Number of values per key of each interpolation; a spline key also has two tangents."""

PATHS = {"translation": 3, "rotation": 4, "scale": 3, "weights": None}
"""Components of each node property; the number of weights depends on the mesh."""

SPLINE_SECONDS = 1 / 240
"""Seconds between the points of the straight lines that approximate a cubic spline."""

STEPPED_KEY_SECONDS = 1e-4
"""Seconds between the two keys of a step, because tracks are linear."""


class Spline(NamedTuple):
    """Keys of a piecewise cubic curve."""

    frames: Ints
    """(K,) frame numbers, rising; the first and last frames are keys."""
    values: Floats
    """(K, C)"""
    arriving: Floats
    """(K, C) slopes before each key, per second; 0 before the first."""
    leaving: Floats
    """(K, C) slopes after each key, per second; 0 after the last."""


def hermite(u: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the weights of first value, first slope, last value and last slope: (T,) each.

    Between two keys at times a and b, with values p and q and slopes m and n per second, a curve is
    a cubic Hermite polynomial::

        H(u) = (1 + 2u)(1 - u)^2 p + u (1 - u)^2 d m + u^2 (3 - 2u) q + u^2 (u - 1) d n
        d = b - a,   u = (t - a) / d
    """
    return (1 + 2 * u) * (1 - u) ** 2, u * (1 - u) ** 2, u * u * (3 - 2 * u), u * u * (u - 1)


def sample(times: Floats, spline: Spline, at: Floats) -> Floats:
    """Return the values of a spline, (n, C); outside the keys, the nearest value is held."""
    if len(times) == 1:
        return np.repeat(spline.values, len(at), axis=0)
    at = np.clip(at, times[0], times[-1])
    key = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    length = times[key + 1] - times[key]
    p, m, q, n = (part[:, None] for part in hermite((at - times[key]) / length))
    seconds = length[:, None]
    return (
        p * spline.values[key]
        + m * seconds * spline.leaving[key]
        + q * spline.values[key + 1]
        + n * seconds * spline.arriving[key + 1]
    )


class Drive(NamedTuple):
    """A property of a node over time: (T, n) values at (T,) rising seconds, joined by lines."""

    node: int
    path: str
    times: Floats
    values: Floats


def drives(
    model: Model, accessors: Accessors, take: Json, paths: Collection[str] = PATHS
) -> Iterator[Drive]:
    """Yield the tracks of an animation of the model's document; other `paths` are skipped."""
    where, nodes = accessors.path, model.document.get("nodes", [])
    samplers = check_list(where, "samplers of its animation", take.get("samplers", []))
    for channel in check_list(where, "channels of its animation", take.get("channels", [])):
        target = channel.get("target")
        if not isinstance(target, dict):
            fail(where, "a channel of its animation has no target")
        node, path, number = target.get("node"), target.get("path"), channel.get("sampler")
        if node is None or not isinstance(path, str) or path not in paths or path not in PATHS:
            continue  # glTF requires this: extensions define targets of their own
        if not is_index(node, len(nodes)) or not is_index(number, len(samplers)):
            fail(where, "a channel of its animation has a node or sampler that does not exist")
        times, values = _keys(accessors, samplers[number])
        if values.shape[1] != (PATHS[path] or values.shape[1]):
            fail(where, f"its animation has {values.shape[1]} numbers for a {path}")
        yield Drive(node, path, times, values)


def _keys(accessors: Accessors, sampler: Json) -> tuple[Floats, Floats]:
    """Read the times, (T,), and values, (T, n), of a sampler."""
    where = accessors.path
    times = accessors[sampler.get("input")].astype(np.float64)
    values = accessors[sampler.get("output")].astype(np.float64)
    way = sampler.get("interpolation", "LINEAR")
    if not isinstance(way, str) or way not in VALUES_PER_KEY:
        fail(where, f"its keys have an unknown interpolation ('{str(way)[:20]}')")
    if times.shape[1] != 1:
        fail(where, "its animation has times of several numbers")
    times = times[:, 0]
    each = VALUES_PER_KEY[way]
    if values.size % (len(times) * each):
        fail(where, f"its animation has {values.size} values for {len(times)} keys")
    if not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        fail(where, "the times of its animation do not rise")
    if not np.isfinite(values).all():
        fail(where, "a value of its animation is not a number")
    table = values.reshape(len(times), each, -1)
    if way == "CUBICSPLINE":
        # Each key has a slope per second before it, its value, and a slope after it (glTF 2.0,
        # appendix C.5). The spline becomes short straight lines.
        seconds = times[-1] - times[0]
        if (len(times) + seconds / SPLINE_SECONDS) * table.shape[2] > MAX_ACCESSOR_VALUES:
            fail(where, f"its cubic splines last {seconds:.0f} s, too long to read")
        at = np.union1d(times, np.arange(times[0], times[-1], SPLINE_SECONDS))
        spline = Spline(np.arange(len(times)), table[:, 1], table[:, 0], table[:, 2])
        return at, sample(times, spline, at)
    held = table[:, 0]
    if way == "LINEAR":
        return times, held
    # Tracks are linear: the value of a step gets a second key just before the next.
    before = times[1:] - np.minimum(np.diff(times) / 2, STEPPED_KEY_SECONDS)
    order = np.argsort(np.concatenate((times, before)), kind="stable")
    return np.concatenate((times, before))[order], np.concatenate((held, held[:-1]))[order]
