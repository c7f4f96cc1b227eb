"""A Unity animation clip, in the text serialisation of the editor.

Based on clips of Unity 2018 and later (`AnimationClip`, serialized version 6). Each blend shape has
a curve with the attribute `blendShape.<name>` (class 137: SkinnedMeshRenderer). Weights are in
percent. `path` leads from the Animator object at the top of the model to the mesh object, by the
names of the nodes; it is empty if the model is a single mesh and nothing else. A shape has no curve
on a mesh where it moves no point. Keys have broken linear tangents (mode 69), or free ones with
`keys` (mode 0, and 1 where both sides differ); slopes are percent per second. Derived data, such as
editor curves and bindings, is omitted because Unity rebuilds it. Clips have no negative time.
"""

import re
from functools import partial
from itertools import pairwise
from typing import TextIO

from lipsync_lang.animations.keys import ERROR, KeyedCurve
from lipsync_lang.animations.moving_shapes import keys, node_chains, shapes, unshown
from lipsync_lang.animations.writers import Animation, template, writer

UNITY = "Unity"
PERCENT_OF_WEIGHT = 100
LINEAR = 69
"""Tangent mode of broken, linear tangents; free ones are 0, broken ones 1."""
PLAIN_YAML = r"(?ai)(?!(?:true|false|yes|no|on|off|null|y|n)$)[a-z][\w./-]*"
"""Text that YAML accepts without quotes."""


@writer("unity", suffix=".anim", remarks=partial(unshown, program=UNITY))
def write_unity(animation: Animation, out: TextIO) -> None:
    """A Unity animation clip: keyframes of blend shapes."""
    found, chains = shapes(animation), node_chains(animation)
    head, curve_form, key_form, tail = template(__file__)
    out.write(head.format(name=_text(animation.title)))
    for shape, curve in zip(found, keys(animation, found, ERROR), strict=True):
        told, attribute = _keys(curve, key_form), _text(f"blendShape.{shape.name}")
        out.writelines(
            curve_form.format(keys=told, attribute=attribute, path=_text("/".join(chain)))
            for chain in chains.get(shape.mesh, [[shape.mesh]])
        )
    stop = _number(float(animation.timeline[-1]))
    out.write(tail.format(fps=_number(animation.fps), stop=stop))


def _keys(curve: KeyedCurve, form: str) -> str:
    """Format the keys, with the slopes on both sides in percent per second."""
    points = list(zip(curve.times.round(6).tolist(), curve.values.tolist(), strict=True))
    points = [(time, round(value * PERCENT_OF_WEIGHT, 4)) for time, value in points]
    if curve.cubic:
        before, after = (
            (PERCENT_OF_WEIGHT * part).round(4).tolist() for part in (curve.arriving, curve.leaving)
        )
    else:  # of the rounded points, so that the line is straight
        slopes = [(w - v) / (u - t) for (t, v), (u, w) in pairwise(points)]
        before, after = [0.0, *slopes], [*slopes, 0.0]
    rows = []
    for (time, value), m, n in zip(points, before, after, strict=True):
        sides = {"before": _number(m), "after": _number(n)}
        mode = int(m != n) if curve.cubic else LINEAR
        rows.append(form.format(time=_number(time), value=_number(value), mode=mode, **sides))
    return "".join(rows)


def _number(value: float) -> str:
    """Format a number without trailing zeros or a negative zero."""
    return f"{value + 0.0:.9g}"


def _text(text: str) -> str:
    """Format text for YAML: plain if possible, else quoted and escaped."""
    if not text or re.fullmatch(PLAIN_YAML, text):
        return text
    letters = []
    for letter in text:
        code = ord(letter)
        if " " <= letter <= "~":
            letters.append(f"\\{letter}" if letter in '"\\' else letter)
        else:
            letters.append(f"\\u{code:04X}" if code < 1 << 16 else f"\\U{code:08X}")
    return f'"{"".join(letters)}"'
