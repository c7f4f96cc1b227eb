"""Dynamic time warping of a synthetic voice to a recording, for sounds of any length.

`SpokenVoice` is what the language's voice says, the known half; `Fit` is where that is recorded.
"""

from typing import NamedTuple, Self

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints, Singles
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.base.extras import needing
from lipsync_lang.schedules.schedule import SILENCE, Schedule, Word
from lipsync_lang.sound.speech.hearing.align.spectrum import (
    HOP,
    SpeechSpectrum,
    alike,
    mel_power,
    pooled,
    samples_of,
)
from lipsync_lang.sound.speech.hearing.progress import tell

DRIFT_PENALTY = 2.0
"""Cost per frame of drift between the sounds; typical frame distance is 5."""

MAX_DIRECT_FRAMES = 3000
"""Frame limit of direct comparison; longer sounds are compared coarsely, then in parts."""

PART_FRAMES, CONTEXT_FRAMES = 1500, 200
"""Frames per part, and frames of context on either side."""

REFINEMENT = 5
"""Gain of resolution from one refinement of a long sound to the next."""

TEMPO_LIMITS = (0.4, 2.5)
"""Tempo limits of the voice relative to the recording, lowest and highest."""

TRACTS = (0.88, 0.94, 1.0, 1.06)
"""Candidate vocal tract lengths of the voice; the best fit is used."""

REST_SECONDS = 0.14
"""Least pause of the voice at punctuation; before conjunctions it makes shorter ones."""


class SpokenVoice(NamedTuple):
    """Synthetic speech of a text: phonemes without pauses, and sound."""

    labels: tuple[str, ...]
    words: tuple[Word, ...]
    starts: Floats
    """(n,) start times in seconds."""
    ends: Floats
    """(n,) end times in seconds."""
    samples: Singles
    rests: Ints
    """Numbers of the phonemes before which the voice pauses."""

    @classmethod
    def of(cls, said: Schedule) -> Self:
        """Take what the language's voice says."""
        if said.audio is None:
            raise SpeechError(
                f"{said.language} has no voice to compare with the recording; add a `tts` "
                "to its pack, or align with another program and give its file (`schedule`)"
            )
        kept = [n for n, label in enumerate(said.labels) if label != SILENCE]
        place = {n: at for at, n in enumerate(kept)}
        spans = [[place[n] for n in range(w.first, w.stop) if n in place] for w in said.words]
        return cls(
            tuple(said.labels[n] for n in kept),
            tuple(
                Word(word.text, span[0], span[-1] + 1)
                for word, span in zip(said.words, spans, strict=True)
                if span
            ),
            said.times[kept],
            said.times[1:][kept],
            samples_of(said.audio),
            np.flatnonzero(said.times[kept][1:] - said.times[1:][kept][:-1] >= REST_SECONDS) + 1,
        )

    def frames(self, hop: float, count: int) -> tuple[Bools, Ints]:
        """Return the mask of sounding frames (M,) and phoneme starts among these (n,)."""
        times = np.arange(count) * hop
        phone = np.searchsorted(self.starts, times, side="right") - 1
        sounding = (phone >= 0) & (times < self.ends[np.maximum(phone, 0)])
        starts = np.searchsorted(phone[sounding], np.arange(len(self.labels)))
        # a last phoneme shorter than a frame shares the last one
        return sounding, np.minimum(starts, max(int(sounding.sum()) - 1, 0))


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
    # A hop as much longer as the voice is slower: both sounds get about as many frames, so the path
    # stays near the diagonal, where drift costs nothing.
    tempo = float((voice.ends - voice.starts).sum()) / (len(kept) * HOP)
    hop = HOP * float(np.clip(tempo, *TEMPO_LIMITS))
    # in turn, for the memory that long voices take
    ways = ((_coarse(*_pair(heard, kept, voice, hop, tract)[:2]), tract) for tract in TRACTS)
    (path, cost), tract = min(ways, key=lambda one: one[0][1])
    a, b, starts = _pair(heard, kept, voice, hop, tract)
    # Reversed in time, slopes change their sign; the cepstra before them do not.
    backwards = b[::-1] * np.repeat([1, -1], b.shape[1] // 2)
    step = _step(a, b)
    apart = np.linalg.norm(pooled(a, step)[path[:, 0]] - pooled(b, step)[path[:, 1]], axis=1)
    # Running sums by frame of the voice: the sum of a phoneme is the difference at its ends.
    total = np.append(0.0, np.bincount(path[:, 1], apart).cumsum())
    count = np.append(0, np.bincount(path[:, 1]).cumsum())
    first, last = starts // step, np.append(starts[1:], len(b)) // step
    last = np.minimum(np.maximum(last, first + 1), len(total) - 1)
    return Fit(
        _edges(a, b, path)[starts],
        cost,
        np.asarray((total[last] - total[first]) / (count[last] - count[first])),
        float((np.diff(path, axis=0) == 0).any(axis=1).sum() / len(path)),
        _coarse(a, backwards)[1],
    )


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
    return -(-max(len(a), len(b)) // MAX_DIRECT_FRAMES)


def _coarse(a: Floats, b: Floats) -> tuple[Ints, float]:
    """Return the best path through two pooled sounds, and its mean cost."""
    step = _step(a, b)
    return _path(pooled(a, step), pooled(b, step))


def _path(a: Floats, b: Floats) -> tuple[Ints, float]:
    """Return the best path through two sounds, (K, 2) frame numbers, and its mean cost."""
    what = "aligning by warping needs dtaidistance, which is not installed; get it with:"
    with needing(SpeechError, what, "audio"):
        from dtaidistance import dtw_ndim
    both = map(np.ascontiguousarray, (a, b))
    way = dtw_ndim.warping_path(*both, use_c=True, penalty=DRIFT_PENALTY, inner_dist="euclidean")
    path = np.array(way, np.intp)
    apart = np.linalg.norm(a[path[:, 0]] - b[path[:, 1]], axis=1)
    return path, float(apart.mean())


def _starts(path: Ints, count: int) -> Floats:
    """Return the start in the first sound of each frame of the second: (count,)."""
    at = np.searchsorted(path[:, 1], np.arange(count))
    # Half-way between the frames that two voice frames are matched with.
    return (path[at, 0] + path[np.maximum(at - 1, 0), 0]) / 2


def _edges(a: Floats, b: Floats, path: Ints) -> Floats:
    """Return the start in the recording of each voice frame: (M,); `path` is that of `_coarse`."""
    step = _step(a, b)
    edges = _starts(path, -(-len(b) // step))
    while step > 1:
        finer = max(1, step // REFINEMENT)
        finer_a, finer_b = pooled(a, finer), pooled(b, finer)
        at, count = np.arange(len(edges)) * step / finer, len(finer_b)
        near = np.interp(np.arange(count + 1), at, edges * step / finer)
        edges, step = np.empty(count), finer
        for low in range(0, count, PART_FRAMES):
            tell(low, count)
            high = min(low + PART_FRAMES, count)
            first, last = max(0, low - CONTEXT_FRAMES), min(count, high + CONTEXT_FRAMES)
            begin = int(near[first]) if first else 0
            end = max(int(near[last]), begin + 1) if last < count else len(finer_a)
            found = _starts(_path(finer_a[begin:end], finer_b[first:last])[0], last - first)
            edges[low:high] = begin + found[low - first : high - first]
        # Parts are warped one by one, so the start of one may lie before the end of the last.
        edges = np.maximum.accumulate(edges)
    return edges
