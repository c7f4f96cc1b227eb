"""Banks of drafted styles: neutral curves, scaled and offset as the pose set states.

A bigram that a bank of the style draws has the drawn curves instead; the posture is added to both.
A bank is as large as the neutral one, so it is made for the first use of a style. Poses that only
postures move come after the poses of speech, and are subject to the same stages. P counts the poses
of speech, and Q those of postures.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.pipeline.constrain import FREE
from lipsync_lang.pipeline.levels import Blend
from lipsync_lang.pipeline.motion import SLOW_SPEED, Motion
from lipsync_lang.pipeline.tables import RESOLUTION, Bank, Contact, Tables
from lipsync_lang.resolver.compiled import CompiledPair

YIELDING = -1.0
"""Priority of a pose of a posture, below those of all poses of speech."""


def with_drafts(compiled: CompiledPair, heard: Collection[str]) -> Tables:
    """Return the tables with a bank for each drafted style, in the order of `style_names`.

    Parameters
    ----------
    heard : styles to draft; the banks of the others stay neutral, and must not be used
    """
    tables, drafts = compiled.tables, compiled.style_drafts
    poses = len(tables.priority)
    if not heard or any(any(drafts[name]["posture"][poses:]) for name in heard):
        tables = _with_postures(tables, compiled.posture)
    sounding = _sounding(compiled)
    drawn = dict(zip(compiled.style_origins, tables.styles, strict=True))
    banks = []
    for name in compiled.style_names:
        bank = drawn.get(name, tables.neutral)
        if name in heard:
            draft = drafts[name]
            scale, offset, posture = (
                np.array(draft[part], np.float32) for part in ("scale", "offset", "posture")
            )
            curves = bank.curves.copy()
            curves[:, :, :poses] *= scale
            for pose in np.flatnonzero(offset):
                # in place: the curves of a pair take some megabytes
                curves[:, :, pose] += offset[pose] * sounding
            own = list(map(int, compiled.style_origins.get(name, ())))
            curves[own] = bank.curves[own]
            curves += posture[: curves.shape[2]]
            np.clip(curves, 0, 1, out=curves)
            curves.setflags(write=False)
            bank = bank._replace(curves=curves)
        banks.append(bank)
    return replace(tables, styles=tuple(banks))


def styled_motion(compiled: CompiledPair, motion: Motion, blends: Sequence[Blend]) -> Motion:
    """Return the motion of a line in which each drafted style has its highest share."""
    names, drafts = compiled.style_names, compiled.style_drafts
    scales = {"speed": 1.0, "softness": 1.0}
    for blend in blends:
        draft, share = drafts.get(names[blend.style], {}), float(blend.share.values.max())
        for part in scales:
            scales[part] *= 1 + share * (draft.get(part, 1) - 1)
    if scales == {"speed": 1.0, "softness": 1.0}:
        return motion
    limit = motion.speed_limit * scales["speed"]
    return replace(
        motion,
        speed_limit=min(max(limit, SLOW_SPEED), motion.speed_limit),
        softness=motion.softness * scales["softness"],
    )


def _with_postures(tables: Tables, posture: dict[str, Any]) -> Tables:
    """Return tables with the poses of postures after those of speech."""
    together = np.array(posture["together"], float)
    count = len(together)

    def beside(array: np.ndarray[Any, Any], value: Any) -> Any:
        """Return an array whose last axis has a column more for each pose of a posture."""
        more = np.broadcast_to(np.asarray(value, array.dtype), (*array.shape[:-1], count))
        return np.concatenate((array, more), axis=-1)

    def square(rules: Floats) -> Floats:
        lower = beside(together, np.full((count, count), FREE))
        return np.vstack((beside(rules, together.T), lower))

    def bank(one: Bank) -> Bank:
        return one._replace(curves=beside(one.curves, 0))

    return replace(
        tables,
        curves=beside(tables.curves, 0),
        styles=tuple(map(bank, tables.styles)),
        contacts=tuple(
            Contact(one.phonemes, beside(one.floor, 0), beside(one.ceiling, ceiling))
            for one, ceiling in zip(tables.contacts, posture["ceilings"], strict=True)
        ),
        thresholds=square(tables.thresholds),
        paper=square(tables.paper),
        priority=beside(tables.priority, YIELDING),
        softness=beside(tables.softness, posture["softness"]),
        anticipate=beside(tables.anticipate, 0),
        highest=beside(tables.highest, 1),
        opposed=beside(tables.opposed, 0),
    )


def _sounding(compiled: CompiledPair) -> Floats:
    """Return the share of an offset over each bigram: (B, RESOLUTION + 1).

    It is 1 in sounds, and falls to 0 in silence.
    """
    at = np.linspace(0, 1, RESOLUTION + 1)[None, :]
    silence = compiled.phonemes[0]
    pairs = [origin.pair for origin in compiled.origins]
    boundary = compiled.tables.boundary[:, None]
    starts = np.array([first == silence for first, _ in pairs])[:, None]
    ends = np.array([second == silence for _, second in pairs])[:, None]
    # a silence is left or entered along a straight line over its own part of the bigram
    share = np.where(starts, np.minimum(at / boundary, 1), 1.0)
    share = np.where(ends, np.minimum(share, np.minimum((1 - at) / (1 - boundary), 1)), share)
    # row 0 is rest, also in a style that smiles
    share[0] = 0
    return share.astype(np.float32)
