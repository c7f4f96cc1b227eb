"""Animation curves of Maya, in the ASCII form of its animImportExport plug-in.

Version 1.1 of the format, as Autodesk documents it: a header, then for each attribute an ``anim``
line and its keys. With `keys`, tangents are ``fixed`` and not weighted, so that a curve is cubic in
time. Their angles are in degrees of the value's change over one frame, whatever the unit of the key
times: Maya takes the angle by the frame rate of the scene. Frame rates without a name in the format
have key times in seconds. The sound starts at frame 1 plus the offset; movement before the sound is
at earlier frames.
"""

import re
from collections.abc import Iterator
from functools import partial
from itertools import count
from typing import TextIO

import numpy as np

from lipsync_lang.animations.fixed import boneless
from lipsync_lang.animations.keys import ERROR, KeyedCurve
from lipsync_lang.animations.moving_shapes import keys, shapes
from lipsync_lang.animations.writers import Animation, template, writer

MAYA = "Maya"

FIRST_FRAME = 1
"""Frame number at which scenes of Maya begin."""

TIME_UNITS = {15: "game", 24: "film", 25: "pal", 30: "ntsc", 48: "show", 50: "palf", 60: "ntscf"}
"""Names of frame rates in the format."""

NODE = "face"
"""Node of the attributes if the model does not name one; keys are pasted to the selected node."""

ODD = re.compile(r"\W", re.ASCII)
"""Characters that names of attributes and nodes cannot have."""


@writer("maya", suffix=".maya.anim", remarks=partial(boneless, program=MAYA))
def write_maya(animation: Animation, out: TextIO) -> None:
    """Animation curves of Maya as ASCII, for its animImportExport plug-in."""
    rate = animation.fps
    unit = TIME_UNITS.get(round(rate)) if rate == round(rate) else None
    per_second = rate if unit else 1.0
    first = (FIRST_FRAME / rate + animation.offset - animation.begins) * per_second
    start, end = (first + float(time) * per_second for time in animation.timeline[[0, -1]])
    named = {"fps": _number(rate), "unit": unit or "sec"}
    head, curve_form = template(__file__)
    out.write(head.format(start=_number(start), end=_number(end), **named))
    found = shapes(animation)
    taken: set[tuple[str, str]] = set()
    for number, (shape, curve) in enumerate(zip(found, keys(animation, found, ERROR), strict=True)):
        # Names hold letters, digits and underscores, and begin with no digit; no pair comes twice.
        node, name = (ODD.sub("_", text) for text in (shape.mesh or NODE, shape.name))
        node, name = (f"_{text}" if text[:1].isdigit() else text for text in (node, name))
        numbered = (name if n == 1 else f"{name}_{n}" for n in count(1))
        own = next(each for each in numbered if (node, each) not in taken)
        taken.add((node, own))
        rows = _keys(curve, (first + curve.times * per_second).tolist(), rate)
        out.write(curve_form.format(name=own, node=node, number=number, keys="".join(rows)))


def _keys(curve: KeyedCurve, times: list[float], fps: float) -> Iterator[str]:
    """Yield a line for each key: time, value, tangents, locks, and angles with weights of 1."""
    values = curve.values.tolist()
    if not curve.cubic:
        for time, value in zip(times, values, strict=True):
            yield f"    {_number(time)} {_number(value)} linear linear 1 1 0;\n"
        return
    slopes = np.column_stack((curve.arriving, curve.leaving)) / fps
    angles = np.degrees(np.arctan(slopes)).round(7).tolist()
    for time, value, (before, after) in zip(times, values, angles, strict=True):
        # An animator turns locked tangents as one, so those that make a corner are not locked.
        locked = int(before == after)
        yield (
            f"    {_number(time)} {_number(value)} fixed fixed {locked} 1 0 "
            f"{_number(before)} 1 {_number(after)} 1;\n"
        )


def _number(value: float) -> str:
    """Format a number with six decimals, without trailing zeros or a negative zero."""
    return f"{round(value, 6) + 0.0:.6f}".rstrip("0").rstrip(".")
