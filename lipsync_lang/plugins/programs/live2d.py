"""A motion of Live2D Cubism, `.motion3.json` version 3.

Each parameter of the model has a curve: a first point, then segments, each with its type and its
points (github.com/Live2D/CubismSpecs, FileFormats). Linear segments (0) have one point. With
`keys`, curves are cubic Bezier segments (1) of three points; their handles lie at thirds of the
time, which `AreBeziersRestricted` states, so that they are cubic in time.

The motion fades neither in nor out, because its curves do so themselves. Without times of fading,
players fade for a second.

A column whose name is that of a parameter and a minus lowers this parameter. Motions have no
negative time. There is no curve of the group `LipSync`, because Cubism adds it to the curves of the
parameters in this group.
"""

import json
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, TextIO

import numpy as np

from lipsync_lang.animations.fixed import shape_columns, shapes_from_zero
from lipsync_lang.animations.keys import ERROR, KeyedCurve
from lipsync_lang.animations.writers import Animation, writer

if TYPE_CHECKING:
    from lipsync_lang.base.arrays import Floats

LINEAR_SEGMENT, BEZIER_SEGMENT = 0, 1

LOWERS = "-"
"""End of the name of a column that lowers a parameter."""


@writer("live2d", suffix=".motion3.json", remarks=partial(shapes_from_zero, program="Live2D"))
def write_live2d(animation: Animation, out: TextIO) -> None:
    """A motion of Live2D Cubism: a curve for each parameter of the model."""
    curves = [(curve.name, *_segments(curve, 1 / animation.fps)) for curve in _curves(animation)]
    stop = max(float(animation.timeline[-1]), 1 / animation.fps)
    meta = {
        "Duration": round(stop, 6),
        "Fps": animation.fps,
        "Loop": False,
        "AreBeziersRestricted": True,
        "FadeInTime": 0.0,
        "FadeOutTime": 0.0,
        "CurveCount": len(curves),
        "TotalSegmentCount": sum(segments for _, _, segments, _ in curves),
        "TotalPointCount": sum(points for _, _, _, points in curves),
        "UserDataCount": 0,
        "TotalUserDataSize": 0,
    }
    rows = [{"Target": "Parameter", "Id": name, "Segments": row} for name, row, _, _ in curves]
    json.dump({"Version": 3, "Meta": meta, "Curves": rows}, out, ensure_ascii=False)
    out.write("\n")


def _curves(animation: Animation) -> list[KeyedCurve]:
    """Return the keyframes of each parameter: its column, less the column that lowers it."""
    sums: dict[str, Floats] = {}
    floors: dict[str, float] = {}
    for column in shape_columns(animation):
        name = animation.columns[column].name
        parameter = name.removesuffix(LOWERS)
        values = animation.weights[:, column] * (1 if parameter == name else -1)
        sums[parameter] = sums[parameter] + values if parameter in sums else values
        if parameter == name:
            floors[name] = animation.contacts.get(animation.poses[column], 0.0)
    weights = np.column_stack([*sums.values()])
    shown = replace(animation, poses=(*sums,), channels=(), weights=weights, contacts=floors)
    return shown.keyframes(ERROR)


def _segments(curve: KeyedCurve, frame: float) -> tuple[list[float], int, int]:
    """Return the numbers of a curve, and how many segments and points they make."""
    row, segments, points = [curve.times[0], curve.values[0]], 0, 1
    for k, n in pairwise(range(len(curve.times))):
        (start, end), (low, high) = curve.times[[k, n]], curve.values[[k, n]]
        third = (end - start) / 3
        handles = (low + third * curve.leaving[k], high - third * curve.arriving[n])
        held = low == high == handles[0] == handles[1]
        if curve.cubic and not held:
            row += [BEZIER_SEGMENT, start + third, handles[0], end - third, handles[1]]
            points += 2
        else:
            row.append(LINEAR_SEGMENT)
        row += [end, high]
        segments, points = segments + 1, points + 1
    if not segments:  # a curve needs a segment
        row += [LINEAR_SEGMENT, curve.times[0] + frame, curve.values[0]]
        segments, points = 1, 2
    # Adding 0.0 turns the negative zeros of rounding into zeros.
    return [round(float(value), 6) + 0.0 for value in row], segments, points
