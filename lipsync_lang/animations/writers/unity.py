"""A Unity animation clip, in the text serialisation of the editor.

Based on clips of Unity 2018 and later (`AnimationClip`, serialized version 6). Each blend shape has
a curve with the attribute `blendShape.<name>` (class 137: SkinnedMeshRenderer). Weights are in
percent. `path` leads from the Animator object at the top of the model to the mesh object, by the
names of the nodes; it is empty if the model is a single mesh. A shape has no curve on a mesh where
it moves no point. Keys have broken linear tangents (mode 69), or free ones with `keys` (mode 0, and
1 where both sides differ); slopes are percent per second. Derived data, such as editor curves and
bindings, is omitted because Unity rebuilds it. Clips have no negative time.
"""

import re
from functools import partial
from itertools import pairwise
from typing import TextIO

from lipsync_lang.animations.keys import ERROR, KeyedCurve
from lipsync_lang.animations.moving_shapes import keys, node_paths, shapes, unshown
from lipsync_lang.animations.writers import Animation, writer

UNITY = "Unity"
PERCENT_OF_WEIGHT = 100
LINEAR = 69
"""Tangent mode of broken, linear tangents; free ones are 0, broken ones 1."""
PLAIN_YAML = r"(?ai)(?!(?:true|false|yes|no|on|off|null|y|n)$)[a-z][\w./-]*"
"""Text that YAML accepts without quotes."""

UNITY_HEAD = """\
%YAML 1.1
%TAG !u! tag:unity3d.com,2011:
--- !u!74 &7400000
AnimationClip:
  m_ObjectHideFlags: 0
  m_CorrespondingSourceObject: {{fileID: 0}}
  m_PrefabInstance: {{fileID: 0}}
  m_PrefabAsset: {{fileID: 0}}
  m_Name: {name}
  serializedVersion: 6
  m_Legacy: 0
  m_Compressed: 0
  m_UseHighQualityCurve: 1
  m_RotationCurves: []
  m_CompressedRotationCurves: []
  m_EulerCurves: []
  m_PositionCurves: []
  m_ScaleCurves: []
  m_FloatCurves:
"""

UNITY_CURVE = """\
  - curve:
      serializedVersion: 2
      m_Curve:
{keys}\
      m_PreInfinity: 2
      m_PostInfinity: 2
      m_RotationOrder: 4
    attribute: {attribute}
    path: {path}
    classID: 137
    script: {{fileID: 0}}
"""

KEY = """\
      - serializedVersion: 3
        time: {time}
        value: {value}
        inSlope: {before}
        outSlope: {after}
        tangentMode: {mode}
        weightedMode: 0
        inWeight: 0.33333334
        outWeight: 0.33333334
"""

TAIL = """\
  m_PPtrCurves: []
  m_SampleRate: {fps}
  m_WrapMode: 0
  m_Bounds:
    m_Center: {{x: 0, y: 0, z: 0}}
    m_Extent: {{x: 0, y: 0, z: 0}}
  m_ClipBindingConstant:
    genericBindings: []
    pptrCurveMapping: []
  m_AnimationClipSettings:
    serializedVersion: 2
    m_AdditiveReferencePoseClip: {{fileID: 0}}
    m_AdditiveReferencePoseTime: 0
    m_StartTime: 0
    m_StopTime: {stop}
    m_OrientationOffsetY: 0
    m_Level: 0
    m_CycleOffset: 0
    m_HasAdditiveReferencePose: 0
    m_LoopTime: 0
    m_LoopBlend: 0
    m_LoopBlendOrientation: 0
    m_LoopBlendPositionY: 0
    m_LoopBlendPositionXZ: 0
    m_KeepOriginalOrientation: 0
    m_KeepOriginalPositionY: 1
    m_KeepOriginalPositionXZ: 0
    m_HeightFromFeet: 0
    m_Mirror: 0
  m_EditorCurves: []
  m_EulerEditorCurves: []
  m_HasGenericRootTransform: 0
  m_HasMotionFloatCurves: 0
  m_Events: []
"""


@writer("unity", suffix=".anim", remarks=partial(unshown, program=UNITY))
def write_unity(animation: Animation, out: TextIO) -> None:
    """A Unity animation clip: keyframes of blend shapes."""
    found, paths = shapes(animation), node_paths(animation)
    out.write(UNITY_HEAD.format(name=_text(animation.title)))
    for shape, curve in zip(found, keys(animation, found, ERROR), strict=True):
        told, attribute = _keys(curve), _text(f"blendShape.{shape.name}")
        out.writelines(
            UNITY_CURVE.format(keys=told, attribute=attribute, path=_text(path))
            for path in paths.get(shape.mesh, [shape.mesh])
        )
    stop = _number(float(animation.timeline[-1]))
    out.write(TAIL.format(fps=_number(animation.fps), stop=stop))


def _keys(curve: KeyedCurve) -> str:
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
        rows.append(KEY.format(time=_number(time), value=_number(value), mode=mode, **sides))
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
