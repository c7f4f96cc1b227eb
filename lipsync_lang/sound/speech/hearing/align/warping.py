"""Alignment by dynamic time warping of a synthetic voice to the recording.

No acoustic model is needed: any language with a voice can be aligned. The voice supplies the start
time of each phoneme; dynamic time warping (Sakoe and Chiba 1978) maps these times to the recording.
Pauses come from the recording. The confidence is calibrated evidence that it contains the text.

A recording may have other sounds: music, noise, other speech. The voice is laid on each stretch of
it, with both ends free, as in spoken term detection. Levels and noise are those of the stretch
alone, so that a loud neighbour does not count. The cost of a pair of frames is relative to the
frames' distances at large, so that sound that resembles nothing and sound that resembles everything
are alike.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import tee
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule, Word
from lipsync_lang.sound.speech.hearing.align.aligners import BatchAligner, UnreadRecordings, aligner
from lipsync_lang.sound.speech.hearing.align.bending import TRACTS, Fit, SpokenVoice, fitted
from lipsync_lang.sound.speech.hearing.align.spectrum import (
    HOP,
    alike,
    heard_in,
    mel_power,
    pooled,
    runs,
    samples_of,
    speech_frames,
)
from lipsync_lang.sound.speech.hearing.sphinx.scheduling import logistic
from lipsync_lang.sound.speech.results import each, exhaust, next_result, raised, tried
from lipsync_lang.sound.speech.speaking.speaker import Speaker

LEAST_SECONDS = 0.02
"""Duration below which phonemes count as equally short."""

LEAST_UNEVEN = 0.05
"""Unevenness below which durations count as equal."""

MOST_BETTER = 0.15
"""Gain over the reversed voice above which more tells nothing: two synthetic voices are alike."""

LINE_WEIGHTS = (-1.7, 30.0, -1.8, -5.5)
"""Logistic weights of a line: constant, `better`, logarithm of `uneven`, `drift`."""

WORD_WEIGHTS = (0.4, 6.7, -3.3, 0.7)
"""Logistic weights of a word: constant, `better`, `uneven`, log odds of its line."""

PART_ODDS = 3.0
"""Log odds that a text loses where it was looked for in parts of the recording."""

TELLING_PHONEMES = 24
"""Phonemes of a text below which it loses more: a short one is like some part of any speech."""

REACH_SECONDS = 0.15
"""Maximum distance in seconds from a pause to the word start after it."""

REST_REACH_SECONDS = 0.35
"""The same for a word before which the voice pauses, too; it comes first."""

HESITATION_SECONDS = 0.4
"""Seconds; a longer pause needs no word start."""

MIN_PHONEME_SECONDS = 0.01
"""Minimum phoneme duration in seconds, where space allows."""

SURE_CONFIDENCE = 0.8
"""Confidence above which parts of the recording are not searched for the text."""

MIN_PART_CONFIDENCE = 0.4
"""Least confidence of a text in a part of the recording."""

MIN_GAIN = 0.1
"""Gain of confidence that a part of the recording must bring."""

OTHER_SOUND_SECONDS = 0.5
"""Minimum seconds of sound without text for a remark."""

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
    found = [span for tempo in TEMPOS for span in _searched(power, voice, tempo)]
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
    places = subsequences([costs for *_, costs in tries])
    for (first, kept, _), (cost, begin, end) in zip(tries, places, strict=True):
        if cost < _FAR / 2:
            low, high = kept[begin * step], kept[min((end + 1) * step, len(kept)) - 1]
            found.append(LikelySpan(cost, first + int(low), first + int(high), tempo))
    return found


def relative_costs(a: Floats, b: Floats) -> Floats:
    """Return the distance of each pair of frames relative to unrelated pairs: (T, M), about 0."""
    # |a - b|^2 = a^2 + b^2 - 2ab: a matrix product, not all differences. Rounding may pass 0.
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
        # From `went` alone: the voice stands still once in a row, so it is at most twice as slow.
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


class WarpEvidence(NamedTuple):
    """Agreement of a recording with a line or a word of the text."""

    better: float
    """Gain in distance over the time-reversed voice; 0 for unrelated speech, 1 for equal sounds."""
    uneven: float
    """Deviation of durations from the voice's, as a natural logarithm."""
    drift: float
    """Share of the path where one of the sounds runs ahead."""


def evidence(
    fit: Fit, lasts: Floats, voice: SpokenVoice
) -> tuple[WarpEvidence, list[WarpEvidence]]:
    """Return the evidence of a line and of each of its words.

    Parameters
    ----------
    lasts : (n,) durations of the phonemes found, in seconds
    """
    said = voice.ends - voice.starts
    ratios = np.log(np.maximum(lasts, LEAST_SECONDS) / np.maximum(said, LEAST_SECONDS))
    backwards = max(fit.backwards, 1e-6)
    line = WarpEvidence(1 - fit.cost / backwards, float(np.std(ratios)), fit.drift)
    usual = float(np.median(ratios))
    words = []
    for word in voice.words:
        own = slice(word.first, word.stop)
        cost = float(np.average(fit.costs[own], weights=lasts[own]))
        ratio = float(np.log(lasts[own].sum() / max(said[own].sum(), LEAST_SECONDS)))
        words.append(WarpEvidence(1 - cost / backwards, abs(ratio - usual), fit.drift))
    return line, words


def confidence_of(line: WarpEvidence) -> float:
    """Return the confidence from 0 to 1 that the recording contains the text."""
    uneven = float(np.log(max(line.uneven, LEAST_UNEVEN)))
    return logistic(_weighted(LINE_WEIGHTS, min(line.better, MOST_BETTER), uneven, line.drift))


def word_confidence_of(word: WarpEvidence, line: float) -> float:
    """Return the confidence from 0 to 1 that a word is spoken in a line of known confidence."""
    return logistic(_weighted(WORD_WEIGHTS, word.better, word.uneven, _odds(line)))


def in_part(confidence: float, phonemes: int) -> float:
    """Return a text's confidence in the best of several parts of the recording."""
    lost = PART_ODDS * max(1.0, TELLING_PHONEMES / phonemes)
    return logistic(_odds(confidence) - lost)


def _odds(confidence: float) -> float:
    return float(np.log((confidence + 1e-3) / (1 - confidence + 1e-3)))


def _weighted(weights: Sequence[float], *values: float) -> float:
    return weights[0] + float(np.dot(weights[1:], values))


@aligner("warp")
class Warp(BatchAligner):
    """Aligner for any language with a voice.

    It takes no `model`: the language pack selects the voice.
    """

    def align_many(
        self, recordings: UnreadRecordings, speaker: Speaker, model: str | None = None
    ) -> Iterator[Schedule | SpeechError]:
        """Align as `align` does, with all texts spoken by one process."""
        if model is not None:
            what = f"warping takes no model, but '{model}' is given"
            error = SpeechError(f"{what}: leave it out, or choose another aligner")
            yield from (error for _ in recordings)
            return
        ours, voices = tee(recordings)
        said = speaker.speak_many(text for _, text in voices)
        for sound, _ in ours:
            yield from each([next_result(said)], partial(_warped, sound))
        exhaust(said)


def _warped(sound: Callable[[], Audio], said: Schedule) -> Schedule:
    """Warp the voice to the recording, or to the part of it with the text."""
    audio, voice = sound(), SpokenVoice.of(said)
    (power,) = mel_power(samples_of(audio))
    best = _surest(power, voice, audio.seconds)
    # The labels differ from the voice's in their pauses alone.
    pairs = zip(said.labels, said.stress, strict=False)
    marks = iter([mark for label, mark in pairs if label != SILENCE])
    stress = tuple(None if label == SILENCE else next(marks, None) for label in best.labels)
    others = []
    for first, last in ((0, best.span[0]), (best.span[1], len(power))):
        try:
            sounding = np.flatnonzero(heard_in(power).spoken[first:last])
        except SpeechError:
            continue
        if len(sounding) * HOP >= OTHER_SOUND_SECONDS:
            begin, end = (first + sounding[[0, -1]]) * HOP
            others.append(f"{begin:.1f} to {end:.1f} s")
    return replace(
        said,
        labels=best.labels,
        times=best.times,
        words=best.words,
        stress=stress if said.stress else (),
        audio=audio,
        source="recording",
        remarks=(f"sound without text: {', '.join(others)}",) if others else (),
        confidence=best.confidence,
    )


def _surest(power: Floats, voice: SpokenVoice, seconds: float) -> "WarpedVoice":
    """Warp the voice to a recording, (T, BANDS), or to the part of it with the text."""
    attempt = tried(partial(_warped_part, power, voice, seconds))
    whole = attempt((0, len(power)))
    best = None if isinstance(whole, SpeechError) else whole
    lowest = best.confidence if best else 0.0
    if lowest >= SURE_CONFIDENCE:
        return raised(whole)
    for span in spans(power, voice):
        part = attempt(span)
        least = max(MIN_PART_CONFIDENCE, best.confidence + MIN_GAIN if best else 0)
        if not isinstance(part, SpeechError) and part.confidence > least:
            best = part
            if best.confidence >= SURE_CONFIDENCE:
                break
    if best is None or best is whole:
        return raised(whole)
    return best._replace(confidence=max(in_part(best.confidence, len(voice.labels)), lowest))


class WarpedVoice(NamedTuple):
    """A voice warped to a recording or a part of it."""

    labels: tuple[str, ...]
    times: Floats
    words: tuple[Word, ...]
    confidence: float
    span: tuple[int, int]
    """First and last frame of the part."""


def _warped_part(
    power: Floats, voice: SpokenVoice, seconds: float, span: tuple[int, int]
) -> WarpedVoice:
    """Warp the voice to a part of a recording, (T, BANDS)."""
    heard = heard_in(power[slice(*span)])
    kept = speech_frames(heard.spoken)
    if len(kept) * HOP < len(voice.labels) * MIN_PHONEME_SECONDS:
        raise SpeechError(
            f"the recording has {len(kept) * HOP:.2f} s of speech, too short for the "
            f"{len(voice.labels)} phonemes of the text; check that they belong together"
        )
    fit = fitted(heard, kept, voice)
    labels, times, words = _laid(fit.edges, kept + span[0], voice, seconds)
    lasts = np.diff(times)[[label != SILENCE for label in labels]]
    line, each_word = evidence(fit, lasts, voice)
    surely = confidence_of(line)
    sure_words = tuple(
        replace(word, confidence=word_confidence_of(one, surely))
        for word, one in zip(words, each_word, strict=True)
    )
    return WarpedVoice(labels, times, sure_words, surely, span)


def _laid(
    edges: Floats, kept: Ints, voice: SpokenVoice, seconds: float
) -> tuple[tuple[str, ...], Floats, tuple[Word, ...]]:
    """Place phonemes and pauses on the whole recording: labels, boundaries and words."""
    starts = np.interp(edges, np.arange(len(kept)), kept) * HOP
    starts[0] = (kept[0] - 0.5) * HOP
    end = min((kept[-1] + 0.5) * HOP, seconds)
    labels: list[str] = []
    times: list[float] = []
    place: list[int] = []
    pauses = _pauses(edges, kept, voice)
    for number, label in enumerate(voice.labels):
        if number in pauses:
            low, high = pauses[number]
            # The warp may put a boundary into the pause; a phoneme ends where the pause starts.
            times = [min(at, low) for at in times]
            starts[number:] = np.maximum(starts[number:], high)
            labels.append(SILENCE)
            times.append(low)
        elif number == 0 and starts[0] >= MIN_PHONEME_SECONDS:
            labels.append(SILENCE)
            times.append(0.0)
        place.append(len(labels))
        labels.append(label)
        times.append(float(starts[number]))
    if seconds - end >= MIN_PHONEME_SECONDS:
        labels.append(SILENCE)
        times.append(end)
    words = tuple(
        Word(word.text, place[word.first], place[word.stop - 1] + 1) for word in voice.words
    )
    return tuple(labels), _spaced(np.array(times), seconds), words


def _pauses(edges: Floats, kept: Ints, voice: SpokenVoice) -> dict[int, tuple[float, float]]:
    """Map phoneme numbers to the pause before each: start and end in seconds.

    A pause precedes a word, rather one before which the voice pauses, too. A long pause without a
    word start nearby precedes a phoneme.
    """
    found: dict[int, tuple[float, float]] = {}
    words = np.array([word.first for word in voice.words if word.first], np.intp)
    every = np.arange(1, len(edges))
    for at in np.flatnonzero(np.diff(kept) > 1):
        low, high = (kept[at] + 0.5) * HOP, (kept[at + 1] - 0.5) * HOP
        for known, reach in (
            (voice.rests, REST_REACH_SECONDS),
            (words, REACH_SECONDS),
            (every, np.inf),
        ):
            if not len(known) or (known is every and high - low < HESITATION_SECONDS):
                continue
            apart = np.abs(edges[known] - (at + 0.5))
            nearest = int(known[apart.argmin()])
            if apart.min() * HOP <= reach and nearest not in found:
                found[nearest] = (float(low), float(high))
                break
    return found


def _spaced(starts: Floats, end: float) -> Floats:
    """Enforce minimum spacing of boundaries within the recording, from 0 to its end."""
    # Half of an even share at most, so that all boundaries find room in a short recording.
    least = min(MIN_PHONEME_SECONDS, end / (2 * len(starts)))
    steps = least * np.arange(len(starts) + 1)
    apart = np.maximum(np.append(starts, end) - steps, 0)
    # Spacing is order: less the steps, boundaries need only not fall; then the steps return.
    starts = np.maximum.accumulate(apart) + steps
    out: Floats = np.minimum(starts, end - steps[::-1])
    out[0] = 0.0
    return out
