"""Control points of performed curves, as a start for curve edits."""

from dataclasses import replace

import numpy as np

from lipsync_lang.performing.performer import Performer
from lipsync_lang.pipeline.curve import bspline
from lipsync_lang.schedules.schedule import Schedule

POINTS_A_SOUND = 3
"""Number of control points for each sound of a span."""

MOST_POINTS, LEAST_POINTS = 32, 5
"""Bounds on the control points of a curve."""

LEAST_WEIGHT = 0.02
"""Minimum weight of a pose; a pose that stays below is left out."""

CORRECTIONS = 6
"""Number of corrections of the control points, since a curve stays below its polygon."""


def performed_curves(
    performer: Performer, schedule: Schedule, first: int, stop: int, fps: float
) -> dict[str, list[list[float]]]:
    """Return the curves of a character over sounds `first` to `stop`, without its curve edits.

    They are control points (time, weight) by pose, in the normalised time of the span.

    Examples
    --------
    >>> performer = ll.resolve("english", "facefx")
    >>> schedule = ll.Schedule(("M", "AA"), [0, 0.1, 0.3])
    >>> curves = performed_curves(performer, schedule, 0, 2, 60)
    >>> curves["open"][0][0], curves["open"][-1][0]
    (0.0, 1.0)
    """
    compiled = replace(performer.compiled, word_edits={}, line_edits={})
    animation = replace(performer, compiled=compiled).perform(schedule, fps)
    start, end = float(schedule.times[first]), float(schedule.times[stop])
    count = min(MOST_POINTS, max(LEAST_POINTS, POINTS_A_SOUND * (stop - first)))
    at = np.linspace(0, 1, count)
    seconds = start + at * (end - start)
    weights = animation.weights
    moving = {
        pose: np.interp(seconds, animation.times, weights[:, number])
        for number, pose in enumerate(animation.poses)
        if weights[(animation.times >= start) & (animation.times <= end), number].max(initial=0)
        > LEAST_WEIGHT
    }
    found = {}
    for pose, values in moving.items():
        points = np.column_stack((at, values))
        # A fixed number instead of a linear system: the clipped points have no exact solution.
        for _ in range(CORRECTIONS):
            missing = values - bspline(points[None], at)[0]
            points[:, 1] = np.clip(points[:, 1] + missing, 0, 1)
        found[pose] = [[round(float(t), 3), round(float(v), 3)] for t, v in points]
    return found
