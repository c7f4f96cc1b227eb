"""Fits of motion: softness and anticipation by region, and the speed limit, one by one.

A pose set states softness for a region or for a single pose; that of a single pose is constant. The
pipeline has one speed limit for all poses.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from lipsync_lang.capture.fit_lines import FitLine
from lipsync_lang.capture.fit_solver import robust_cost
from lipsync_lang.capture.fit_targets import seen_poses
from lipsync_lang.capture.fit_values import FitFace, FitValues
from lipsync_lang.pipeline.arrays import Bools, Floats, Ints
from lipsync_lang.pipeline.motion import LEAST_SPEED

MOST_SOFTNESS, MOST_ANTICIPATION, MOST_SPEED = 0.12, 0.4, 40.0
"""Maximum fitted values: seconds, seconds, and weight per second."""

TRIALS = 9
"""Number of performances of all lines for each value."""

WORTH = 0.01
"""Minimum reduction of the cost by a change of motion, as a share; smaller ones are noise."""


@dataclass(frozen=True, eq=False)
class MotionGroups:
    """Groups of poses with a common value of motion."""

    softness: Mapping[str, Ints]
    """Poses that take the softness of their region, by region."""
    anticipate: Mapping[str, Ints]
    """Poses with anticipation, by region."""


@dataclass(frozen=True)
class _Setting:
    """A value of motion with its bounds, getter and setter."""

    bounds: tuple[float, float]
    get: Callable[[FitValues], float]
    put: Callable[[FitValues, float], FitValues]


def fit_motion(
    face: FitFace, base: FitValues, lines: Sequence[FitLine], groups: MotionGroups
) -> FitValues:
    """Return values with the motion of the lowest error on some lines."""
    from scipy.optimize import minimize_scalar

    now, cost = base, robust_cost(face.errors(base, lines))
    for setting in _settings(groups, seen_poses(lines)):

        def tried(value: float, setting: _Setting = setting, now: FitValues = now) -> float:
            return robust_cost(face.errors(setting.put(now, value), lines))

        found = minimize_scalar(
            tried, bounds=setting.bounds, method="bounded", options={"maxiter": TRIALS}
        )
        if found.fun < cost * (1 - WORTH):
            now, cost = setting.put(now, float(found.x)), float(found.fun)
    return now


def _settings(groups: MotionGroups, seen: Bools) -> Iterator[_Setting]:
    """Yield the values of motion that influence a recorded signal."""
    for poses in groups.softness.values():
        if seen[poses].any():
            yield _Setting(
                (0.0, MOST_SOFTNESS), _first("softness", poses), _filled("softness", poses)
            )
    for poses in groups.anticipate.values():
        if seen[poses].any():
            bounds = (0.0, MOST_ANTICIPATION)
            yield _Setting(bounds, _first("anticipate", poses), _filled("anticipate", poses))
    yield _Setting(
        (LEAST_SPEED, MOST_SPEED),
        lambda values: values.speed,
        lambda values, speed: replace(values, speed=speed),
    )


def _first(name: str, poses: Ints) -> Callable[[FitValues], float]:
    return lambda values: float(getattr(values, name)[poses[0]])


def _filled(name: str, poses: Ints) -> Callable[[FitValues, float], FitValues]:
    def put(values: FitValues, value: float) -> FitValues:
        changed: Floats = getattr(values, name).copy()
        changed[poses] = value
        filled: FitValues = replace(values, **{name: changed})  # type: ignore[arg-type]  # a field by name
        return filled

    return put
