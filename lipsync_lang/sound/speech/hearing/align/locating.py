"""Location of a text in a recording with other sounds: music, noise, other speech.

The voice is laid on each stretch of the recording, with both ends free, as in spoken term
detection. Levels and noise are those of the stretch alone, so that a loud neighbour does not count.
The cost of a pair of frames is relative to the frames' distances at large, so that sound
that resembles nothing and sound that resembles everything are alike.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.sound.speech.hearing.align.bending import TRACTS, SpokenVoice
from lipsync_lang.sound.speech.hearing.align.spectrum import (
    HOP,
    alike,
    heard_in,
    mel_power,
    pooled,
    runs,
    speech_frames,
)

TEMPOS = (0.8, 1.0, 1.25)
"""Candidate tempos of the recording relative to the voice."""

STRETCH_WIDTHS = (1.4, 2.2)
"""Lengths of a stretch relative to the voice's speech; stretches overlap by two thirds."""

SHORTEST_STRETCH = 150
"""Frames of a stretch for a short text: levels need some sound to be measured."""

LEAST_SPEECH = 0.5
"""Share of the voice's length that a stretch must have of speech."""

UNRELATED_SHARE = 0.4
"""Share of frames that are nearer than a frame counted as unrelated."""

DRIFT_COST = 0.12
"""Cost of each frame that one of the sounds runs ahead."""

COARSE, FINE = 4, 2
"""Frames pooled in search and in refinement."""

MAX_SEARCH_FRAMES = 600
"""Most frames of the voice to search with; longer voices are pooled more."""

REFINE_FRAMES = 50
"""Frames on either side of a span in which its ends are refined."""

SNAP_FRAMES = 30
"""Frames from an end of a span to the pause that bounds it."""

PAUSE_MARGIN_FRAMES = 15
"""Frames of a pause that are kept with the span."""

MAX_CANDIDATES = 3
"""Maximum number of spans to try."""

_FAR = 1e9


class LikelySpan(NamedTuple):
    """Frames of a recording that may hold the text."""

    cost: float
    """Mean cost per frame of the voice; unrelated speech is near 0."""
    first: int
    last: int
    tempo: float

    def shares(self, other: "LikelySpan") -> bool:
        """Return True if two spans are mostly the same."""
        both = min(self.last, other.last) - max(self.first, other.first)
        return both > 0.8 * max(self.last - self.first, other.last - other.first)


def spans(power: Floats, voice: SpokenVoice) -> Iterator[tuple[int, int]]:
    """Yield the stretches that are likeliest to hold a text, first and last frame, best first.

    Parameters
    ----------
    power : (T, BANDS) of the recording
    voice : the text as the language's voice says it
    """
    found: list[LikelySpan] = []
    for tempo in TEMPOS:
        found += _searched(power, voice, tempo)
    chosen: list[LikelySpan] = []
    for span in sorted(found):
        if len(chosen) < MAX_CANDIDATES and not any(span.shares(one) for one in chosen):
            chosen.append(span)
            yield _bounded(power, voice, span)


def _searched(power: Floats, voice: SpokenVoice, tempo: float) -> list[LikelySpan]:
    """Return the best span in each stretch, at one tempo."""
    hop = HOP * tempo
    (spoken,) = mel_power(voice.samples, hop, (TRACTS[1],))
    sounding, _ = voice.frames(hop, len(spoken))
    size = int(sounding.sum())
    step = max(COARSE, -(-size // MAX_SEARCH_FRAMES))
    tries: list[tuple[int, Ints, Floats]] = []
    stretches = {(0, len(power))}
    for width in STRETCH_WIDTHS:
        length = max(int(width * size), SHORTEST_STRETCH) + REFINE_FRAMES // 2
        if length < len(power):
            spare = len(power) - length
            starts = np.linspace(0, spare, -(-3 * spare // length) + 1)
            stretches |= {(int(start), int(start) + length) for start in starts}
    for first, last in sorted(stretches):
        try:
            heard = heard_in(power[first:last])
        except SpeechError:
            continue
        kept = speech_frames(heard.spoken)
        if len(kept) >= LEAST_SPEECH * size:
            recorded, said = alike(heard, spoken, sounding)
            costs = relative_costs(pooled(recorded[kept], step), pooled(said[sounding], step))
            tries.append((first, kept, costs))
    found: list[LikelySpan] = []
    for (first, kept, _), (cost, begin, end) in zip(
        tries, subsequences([costs for *_, costs in tries]), strict=True
    ):
        if cost < _FAR / 2:
            low, high = kept[begin * step], kept[min((end + 1) * step, len(kept)) - 1]
            found.append(LikelySpan(cost, first + int(low), first + int(high), tempo))
    return found


def relative_costs(a: Floats, b: Floats) -> Floats:
    """Return the distance of each pair of frames relative to unrelated pairs: (T, M), about 0."""
    # |a - b|^2 = a^2 + b^2 - 2ab: a matrix product in place of all differences. Rounding may take
    # it below 0.
    square = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2 * a @ b.T
    apart: Floats = np.sqrt(np.maximum(square, 0))
    rows, columns = (int(UNRELATED_SHARE * (length - 1)) for length in apart.shape[::-1])
    # The distance to unrelated frames, by order rather than by mean: a part of the frames is
    # related. Only the one value is put in its place, which is faster than sorting.
    across = np.partition(apart, rows, axis=1)[:, rows, None]
    along = np.partition(apart, columns, axis=0)[None, columns]
    return np.asarray(apart / np.sqrt(across * along + 1e-9) - 1)


def subsequences(costs: list[Floats]) -> list[tuple[float, int, int]]:
    """Find the cheapest place of the whole voice in each stretch: mean cost, first and last frame.

    Local tempo is between half and double. All stretches are searched at once.

    Parameters
    ----------
    costs : (T, M) each, of one voice
    """
    if not costs:
        return []
    size = costs[0].shape[1]
    # Past the end of a shorter stretch, a cost that no path survives.
    table = np.full((max(map(len, costs)), len(costs), size), 50.0)
    for number, one in enumerate(costs):
        table[: len(one), number] = one
    shape = table.shape[1:]
    # two states: the voice went on, or it stood still once
    went, stood = np.full(shape, _FAR), np.full(shape, _FAR)
    went_from, stood_from = np.zeros(shape, np.intp), np.zeros(shape, np.intp)
    best, first, last = np.full(len(costs), _FAR), *np.zeros((2, len(costs)), np.intp)
    for t, cost in enumerate(table):
        on = went <= stood
        either, either_from = np.where(on, went, stood), np.where(on, went_from, stood_from)
        # From `went` alone: the voice stands still at most once in a row, so it is at most twice as
        # slow.
        stood, stood_from = went + DRIFT_COST + cost, went_from
        # A cost of 0 in the first column: the voice may start at any frame.
        went, went_from = np.zeros(shape), np.full(shape, t)
        went[:, 1:], went_from[:, 1:] = either[:, :-1], either_from[:, :-1]
        # A skipped frame of the voice, so that it is at most twice as fast.
        skipped = either[:, :-2] + DRIFT_COST
        less = skipped < went[:, 2:]
        went[:, 2:][less], went_from[:, 2:][less] = skipped[less], either_from[:, :-2][less]
        went += cost
        total = np.minimum(went[:, -1], stood[:, -1])
        start = np.where(went[:, -1] <= stood[:, -1], went_from[:, -1], stood_from[:, -1])
        less = total < best
        best[less], first[less], last[less] = total[less], start[less], t
    means = np.where(best < _FAR / 2, best / size, _FAR)
    return [(float(m), int(a), int(z)) for m, a, z in zip(means, first, last, strict=True)]


def _bounded(power: Floats, voice: SpokenVoice, span: LikelySpan) -> tuple[int, int]:
    """Return a span with its ends refined, in pauses where there are any."""
    first, last = max(0, span.first - REFINE_FRAMES), min(len(power), span.last + REFINE_FRAMES)
    try:
        heard = heard_in(power[first:last])
    except SpeechError:
        return span.first, span.last
    kept = speech_frames(heard.spoken)
    # The vocal tract that fits best decides.
    hop = HOP * span.tempo
    powers = mel_power(voice.samples, hop, TRACTS)
    sounding, _ = voice.frames(hop, powers.shape[1])
    step = max(FINE, -(-int(sounding.sum()) // (2 * MAX_SEARCH_FRAMES)))
    matched = (alike(heard, one, sounding) for one in powers)
    cost, low, high = min(
        subsequences(
            [relative_costs(pooled(a[kept], step), pooled(b[sounding], step)) for a, b in matched]
        )
    )
    if cost > _FAR / 2:
        low, high = span.first - first, span.last - first
    else:
        low, high = int(kept[low * step]), int(kept[min((high + 1) * step, len(kept)) - 1])
    parts = runs(kept)
    begins, ends = (np.array([part[at] for part in parts]) for at in (0, -1))
    begin, end = begins[np.abs(begins - low).argmin()], ends[np.abs(ends - high).argmin()]
    low = begin - PAUSE_MARGIN_FRAMES if abs(begin - low) < SNAP_FRAMES else low
    high = end + PAUSE_MARGIN_FRAMES if abs(end - high) < SNAP_FRAMES else high
    return max(0, first + int(low)), min(len(power), first + int(high) + 1)
