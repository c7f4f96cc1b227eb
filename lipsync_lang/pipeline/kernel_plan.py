"""Performances by the compiled kernel: its copies of tables and settings, and its calls.

Conventions: N common phonemes, P poses, T frames; times are seconds. The kernel checks the sizes of
arrays and the range of indices; their types are seen to here.
"""

from collections.abc import Sequence
from math import ceil
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.pipeline import kernel
from lipsync_lang.pipeline.levels import Dial
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.prepare import StageValues
from lipsync_lang.pipeline.soften import Blur
from lipsync_lang.pipeline.tables import Tables

if TYPE_CHECKING:
    from lipsync_lang.pipeline.perform import Frames
    from lipsync_lang.pipeline.track import Track

BLOCK = 512
"""Frames worked on at once, or more at high frame rates; a block stays in the processor's cache."""

TAPS = 3
"""The kernel of a blur is filled up to a multiple of so many weights on each side."""

UNBOUNDED = 1e300
"""Substitute for infinity, whose products are always defined."""


def serves(motion: Motion) -> bool:
    """Return True if there is a compiled kernel, and it knows the settings.

    It neither fills valleys nor shows single poses, and always puts silence around the phonemes.
    """
    plain = motion.smooth == "none" and motion.ends == "rest" and not motion.hold
    return kernel.compiled is not None and plain


class KernelCopy(NamedTuple):
    """The compiled kernel's copy of tables and settings, and its calls."""

    bank: Any
    """Curves of the neutral bank."""
    plan: Any
    """A motion at a frame rate."""

    def weigh(
        self, track: "Track", frames: "Frames", span: tuple[int, int], dials: Sequence[Dial]
    ) -> Floats:
        """Perform a span of frames of a track without the frames around it: (T, P) weights."""
        arrays = _ints(track.ids), track.bounds, track.reach, track.moving, _ints(track.rows)
        place = track.waived, frames.start, frames.first, frames.count, *span
        return kernel.compiled.weigh(*self, *arrays, *place, _given(dials))

    def utter(self, ids: Ints, times: Floats, dials: Sequence[Dial]) -> tuple[Floats, Floats]:
        """Lay a track of phonemes, and perform it: (T,) seconds and (T, P) weights.

        They are those of `perform` on the track of `lay_track`.

        Parameters
        ----------
        ids : (m,) common phonemes, as `numpy.intp`
        times : (m + 1,) boundaries in seconds, as `numpy.float64`
        """
        return kernel.compiled.utter(*self, ids, times, _given(dials) if dials else ())


def keep(tables: Tables, motion: Motion, prepared: StageValues, fps: float) -> KernelCopy:
    """Give tables and settings to the kernel; the tables cache its copy.

    Parameters
    ----------
    tables : with the thresholds that the motion asks for
    prepared : of these tables, this motion and this frame rate
    """
    banks, plans = vars(tables), vars(prepared)
    # a copy of the neutral curves takes megabytes, and all motions share it
    if "_bank" not in banks:
        rows, _, poses = tables.curves.shape
        banks["_bank"] = kernel.compiled.bank(
            rows, poses, len(tables.pairs), tables.silence,
            np.ascontiguousarray(tables.curves, np.float32),
            _floats(tables.boundary), _bools(tables.free), _ints(tables.pairs),
        )  # fmt: skip
    if "_plan" not in plans:
        plans["_plan"] = _plan(tables, motion, prepared, fps)
    return KernelCopy(banks["_bank"], plans["_plan"])


def block_of(halo: int) -> int:
    """Return the number of frames of a block, of which the overlaps are a small part."""
    return max(BLOCK, 4 * halo)


def _given(dials: Sequence[Dial]) -> tuple[tuple[Bools, Floats, Floats], ...]:
    return tuple(
        (_bools(poses), _floats(level.times), _floats(level.values)) for poses, level, _ in dials
    )


def _plan(tables: Tables, motion: Motion, prepared: StageValues, fps: float) -> Any:
    """Make a plan; flags, sizes, numbers and arrays are in the order of `kernel.c`."""
    poses, count = len(tables.priority), len(tables.binding)
    holds = motion.contacts == "hold"
    contacts = tables.contacts if holds else ()
    wide, shared = (_half_kernels(blurs, poses) for blurs in (prepared.wide, prepared.shared))
    high = np.zeros((count, poses), bool)
    for row, bound in zip(high, tables.binding, strict=True):
        row[bound.high] = True
    upper = tables.held if holds and motion.limit == "before" else np.zeros(poses)
    numbers = fps, prepared.step, motion.silence_reach, motion.sound_reach, motion.added_silence
    return kernel.compiled.plan(
        # the kernel allocates its results by numpy, and so needs no numpy headers
        np.empty,
        _bools(list(_flags(motion, prepared, bool(contacts)).values())),
        _ints(list(_sizes(tables, prepared, len(contacts), wide, shared).values())),
        _bounded(numbers),
        _floats(prepared.ramps),
        _ints(prepared.early),
        _floats(prepared.left),
        _floats(prepared.blocked),
        _bools(prepared.opposed),
        _bools([contact.phonemes for contact in contacts]),
        _bounded(prepared.levels),
        _floats(prepared.tops),
        _bools(upper),
        _ints([bound.low for bound in tables.binding]),
        _floats([bound.threshold for bound in tables.binding]),
        high,
        _ints(tables.at_most),
        np.concatenate((wide.ravel(), shared.ravel())),
        _ints(prepared.contested),
    )


def _flags(motion: Motion, prepared: StageValues, held: bool) -> dict[str, bool]:  # noqa: FBT001
    before = motion.limit == "before"
    return {
        "crossfade": motion.stitch == "crossfade",
        "linear": motion.warp == "linear",
        "hold": held,
        "before": before,
        "clip held": held and prepared.longer > 0 and not before,
        "clip slow": held and prepared.longer > 0 and before,
        "topped": prepared.topped,
        "again": bool(prepared.shared) and not prepared.convex,
    }


def _sizes(
    tables: Tables, prepared: StageValues, contacts: int, wide: Floats, shared: Floats
) -> dict[str, int]:
    halo = ceil(prepared.halo) + 4
    return {
        "poses": len(tables.priority),
        "phonemes": len(tables.pairs),
        "contacts": contacts,
        "early": len(prepared.early),
        "ahead": prepared.left.shape[1] - 1,
        "binding": len(tables.binding),
        "pairs": len(tables.at_most),
        "ramp": prepared.ramps.shape[1],
        "ease": wide.shape[1] - 1,
        "soften": shared.shape[1] - 1,
        "halo": halo,
        "block": block_of(halo),
        "lead": prepared.lead,
        "contested": len(prepared.contested),
    }


def _half_kernels(blurs: Sequence[Blur], poses: int) -> Floats:
    """Return the middle and the later half of each pose's kernel; 0 for poses without: (P, n)."""
    reach = max((len(weights) // 2 for _, weights in blurs), default=0)
    out = np.zeros((poses, -(-reach // TAPS) * TAPS + 1))
    for own, weights in blurs:
        middle = len(weights) // 2
        # both halves averaged: rounding leaves a kernel not exactly symmetric
        out[own, : middle + 1] = (weights[middle:] + weights[middle::-1]) / 2
    return out


def _bounded(values: Any) -> Floats:
    return _floats(np.clip(_floats(values), -UNBOUNDED, UNBOUNDED))


def _floats(values: Any) -> Floats:
    return np.ascontiguousarray(values, np.float64)


def _ints(values: Any) -> Ints:
    return np.ascontiguousarray(values, np.intp)


def _bools(values: Any) -> Bools:
    return np.ascontiguousarray(values, bool)
