"""Dynamic time warping of a synthetic voice to a recording, for sounds of any length."""

from typing import NamedTuple

import numpy as np

from lipsync_lang.errors import SpeechError
from lipsync_lang.extras import install_line
from lipsync_lang.speech.align.spectrum import (
    HOP,
    Floats,
    Ints,
    SpeechSpectrum,
    alike,
    mel_power,
    pooled,
)
from lipsync_lang.speech.align.spoken_voice import TRACTS, SpokenVoice
from lipsync_lang.speech.listening import tell

PENALTY = 2.0
"""Cost per frame of drift between the sounds; typical frame distance is 5."""

WHOLE = 3000
"""Frame limit of direct comparison; longer sounds are compared coarsely, then in parts."""

PART, MARGIN = 1500, 200
"""Frames per part, and frames of context on either side."""

FINER = 5
"""Gain of resolution from one refinement of a long sound to the next."""

TEMPO = (0.4, 2.5)
"""Tempo limits of the voice relative to the recording, lowest and highest."""


class Fit(NamedTuple):
    """Warping of the voice onto the recording, in frames of speech."""

    edges: Floats
    """(n,) start of each phoneme."""
    cost: float
    """Mean frame distance along the path."""
    costs: Floats
    """(n,) the same of each phoneme."""
    drift: float
    """Share of the path where one of the sounds runs ahead."""
    backwards: float
    """Mean frame distance of the time-reversed voice, as a baseline for unrelated speech."""


def fitted(heard: SpeechSpectrum, kept: Ints, voice: SpokenVoice) -> Fit:
    """Warp the voice onto the recording, at matched tempo and the best vocal tract length."""
    tempo = float((voice.ends - voice.starts).sum()) / (len(kept) * HOP)
    hop = HOP * float(np.clip(tempo, *TEMPO))
    best: tuple[float, float, Ints] | None = None
    for tract in TRACTS:  # in turn, for the memory that long voices take
        a, b, _ = _pair(heard, kept, voice, hop, tract)
        path, cost = _coarse(a, b)
        if best is None or cost < best[0]:
            best = cost, tract, path
    assert best is not None  # noqa: S101 there are tracts
    cost, tract, path = best
    a, b, starts = _pair(heard, kept, voice, hop, tract)
    backwards = b[::-1] * np.repeat([1, -1], b.shape[1] // 2)
    return Fit(
        _edges(a, b, path)[starts],
        cost,
        _phoneme_costs(a, b, path, starts),
        float((np.diff(path, axis=0) == 0).any(axis=1).sum() / len(path)),
        _coarse(a, backwards)[1],
    )


def _phoneme_costs(a: Floats, b: Floats, path: Ints, starts: Ints) -> Floats:
    """Return the mean frame distance of each phoneme along a path of `_coarse`: (n,)."""
    step = _step(a, b)
    apart = np.linalg.norm(pooled(a, step)[path[:, 0]] - pooled(b, step)[path[:, 1]], axis=1)
    total = np.append(0.0, np.bincount(path[:, 1], apart).cumsum())
    count = np.append(0, np.bincount(path[:, 1]).cumsum())
    first, last = starts // step, np.append(starts[1:], len(b)) // step
    last = np.minimum(np.maximum(last, first + 1), len(total) - 1)
    return np.asarray((total[last] - total[first]) / (count[last] - count[first]))


def _pair(
    heard: SpeechSpectrum, kept: Ints, voice: SpokenVoice, hop: float, tract: float
) -> tuple[Floats, Floats, Ints]:
    """Return features of recorded and spoken frames, and the first frame of each phoneme."""
    (power,) = mel_power(voice.samples, hop, (tract,))
    sounding, starts = voice.frames(hop, len(power))
    recorded, spoken = alike(heard, power, sounding)
    return recorded[kept], spoken[sounding], starts


def _step(a: Floats, b: Floats) -> int:
    """Return the pooling factor that makes a direct comparison affordable."""
    return -(-max(len(a), len(b)) // WHOLE)


def _coarse(a: Floats, b: Floats) -> tuple[Ints, float]:
    """Return the best path through two pooled sounds, and its mean cost."""
    step = _step(a, b)
    return _path(pooled(a, step), pooled(b, step))


def _path(a: Floats, b: Floats) -> tuple[Ints, float]:
    """Return the best path through two sounds, (K, 2) frame numbers, and its mean cost."""
    try:
        from dtaidistance import dtw_ndim
    except ImportError:
        raise SpeechError(
            "aligning by warping needs dtaidistance, which is not installed; "
            f"get it with: {install_line('audio')}"
        ) from None
    way = dtw_ndim.warping_path(
        np.ascontiguousarray(a),
        np.ascontiguousarray(b),
        use_c=True,
        penalty=PENALTY,
        inner_dist="euclidean",
    )
    path = np.array(way, np.intp)
    apart = np.linalg.norm(a[path[:, 0]] - b[path[:, 1]], axis=1)
    return path, float(apart.mean())


def _starts(path: Ints, count: int) -> Floats:
    """Return the start in the first sound of each frame of the second: (count,)."""
    at = np.searchsorted(path[:, 1], np.arange(count))
    starts: Floats = (path[at, 0] + path[np.maximum(at - 1, 0), 0]) / 2
    return starts


def _edges(a: Floats, b: Floats, path: Ints) -> Floats:
    """Return the start in the recording of each voice frame, for any length: (M,).

    `path` is that of `_coarse`. It is refined by `FINER` at a time, in parts that overlap.
    """
    step = _step(a, b)
    edges = _starts(path, -(-len(b) // step))
    while step > 1:
        finer = max(1, step // FINER)
        at, b_finer = np.arange(len(edges)) * step / finer, pooled(b, finer)
        near = np.interp(np.arange(len(b_finer) + 1), at, edges * step / finer)
        edges, step = _refined(pooled(a, finer), b_finer, near), finer
    return edges


def _refined(a: Floats, b: Floats, near: Floats) -> Floats:
    """Return the start in the first sound of each frame of the second, known roughly: (M,)."""
    out = np.empty(len(b))
    for low in range(0, len(b), PART):
        tell(low, len(b))
        high = min(low + PART, len(b))
        first, last = max(0, low - MARGIN), min(len(b), high + MARGIN)
        begin = int(near[first]) if first else 0
        end = max(int(near[last]), begin + 1) if last < len(b) else len(a)
        found = _starts(_path(a[begin:end], b[first:last])[0], last - first)
        out[low:high] = begin + found[low - first : high - first]
    return np.maximum.accumulate(out)
