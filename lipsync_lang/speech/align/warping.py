"""Alignment by dynamic time warping of a synthetic voice to the recording.

No acoustic model is needed: any language with a voice can be aligned. The voice supplies the start
time of each phoneme; dynamic time warping (Sakoe and Chiba 1978) maps these times to the recording.
Pauses come from the recording.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lipsync_lang.errors import SpeechError
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule, Word
from lipsync_lang.speech.align.aligners import aligner
from lipsync_lang.speech.align.locating import spans
from lipsync_lang.speech.align.spectrum import (
    HOP,
    Floats,
    Ints,
    SpeechSpectrum,
    alike,
    heard_in,
    mel_power,
    pooled,
    samples_of,
    speech_frames,
)
from lipsync_lang.speech.align.spoken_voice import TRACTS, SpokenVoice
from lipsync_lang.speech.in_turn import each, in_turn, raised, refused
from lipsync_lang.speech.listening import tell

if TYPE_CHECKING:
    from lipsync_lang.speech.speaking import Speaker

REACH = 0.15
"""Maximum distance in seconds from a pause to the word start after it."""

REST = 0.35
"""The same for a word before which the voice pauses, too; it comes first."""

HESITATION = 0.4
"""Seconds; a longer pause needs no word start."""

SHORTEST = 0.01
"""Minimum phoneme duration in seconds, where space allows."""

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

DOUBTFUL = 0.5
"""Confidence limit for a remark."""

SURE = 0.8
"""Confidence above which the text is not looked for in parts of the recording."""

LIKELY = 0.4
"""Least confidence of a text in a part of the recording."""

BETTER = 0.1
"""Gain of confidence that a part of the recording must bring."""

LASTING = 0.5
"""Minimum seconds of sound without text for a remark."""


class Fit(NamedTuple):
    """Warping of the voice onto the recording, in frames of speech."""

    edges: Floats
    """(n,) start of each phoneme."""
    cost: float
    """Mean frame distance along the path."""
    backwards: float
    """Mean frame distance of the time-reversed voice, as a baseline for unrelated speech."""


@aligner("warp")
class Warp:
    """Aligner for any language with a voice."""

    def align(
        self, audio: Audio, text: str, speaker: "Speaker", model: str | None = None
    ) -> Schedule:
        """Find the times of a text's phonemes in a recording.

        Parameters
        ----------
        audio : the recording
        text : the spoken text
        speaker : its language
        model : unused; the language pack selects the voice

        Raises
        ------
        SpeechError
            The language has no voice, the text is empty, or the recording is too short for it.
        """
        (found,) = self.align_many([(lambda: audio, text)], speaker, model)
        return raised(found)

    def align_many(
        self,
        recordings: Iterable[tuple[Callable[[], Audio], str]],
        speaker: "Speaker",
        model: str | None = None,
    ) -> Iterator[Schedule | SpeechError]:
        """Align as `align` does, with all texts spoken by one process."""
        if model is not None:
            error = SpeechError(
                f"warping needs no model, but '{model}' is given: leave it out, or choose another "
                "aligner"
            )
            return refused(recordings, error)
        said = in_turn(recordings, lambda good: speaker.speak_many(text for _, text in good))
        return each(said, lambda pair: self._warped(pair[0][0](), pair[1]))

    @staticmethod
    def _warped(audio: Audio, said: Schedule) -> Schedule:
        """Lay what the voice says on the recording, or on the part of it that has the text."""
        voice = SpokenVoice.of(said)
        (power,) = mel_power(samples_of(audio))
        best = raised_late = None
        try:
            best = _bent(power, 0, voice, audio.seconds)
        except SpeechError as error:
            raised_late = error
        if best is None or best.confidence < SURE:
            for first, last in spans(power, voice):
                part = _part(power, first, last, voice, audio.seconds)
                least = max(LIKELY, best.confidence + BETTER if best else 0)
                if part and part.confidence > least:
                    best = part
                    if best.confidence >= SURE:
                        break
        if best is None:
            assert raised_late is not None  # noqa: S101 nothing was found
            raise raised_late
        return replace(
            voice.schedule,
            labels=best.labels,
            times=best.times,
            words=best.words,
            stress=_stress(best.labels, voice.schedule),
            audio=audio,
            source="recording",
            remarks=tuple(_doubts(best, power, said.language)),
            confidence=best.confidence,
        )


class Bent(NamedTuple):
    """A text laid on a recording or a part of it."""

    labels: tuple[str, ...]
    times: Floats
    words: tuple[Word, ...]
    confidence: float
    span: tuple[int, int]
    """First and last frame of the part."""


def _bent(power: Floats, first: int, voice: SpokenVoice, seconds: float) -> Bent:
    """Lay the voice on a part of a recording, (T, BANDS) from frame `first` on."""
    heard = heard_in(power)
    kept = speech_frames(heard.spoken)
    if len(kept) * HOP < len(voice.labels) * SHORTEST:
        raise SpeechError(
            f"the recording has {len(kept) * HOP:.2f} s of speech, too short for the "
            f"{len(voice.labels)} phonemes of the text; is it another line's?"
        )
    fit = _fit(heard, kept, voice)
    labels, times, words = _laid(fit.edges, kept + first, voice, seconds)
    lasts = np.diff(times)[[label != SILENCE for label in labels]]
    confidence = _confidence(fit, lasts, voice.ends - voice.starts)
    return Bent(labels, times, words, confidence, (first, first + len(power)))


def _part(power: Floats, first: int, last: int, voice: SpokenVoice, seconds: float) -> Bent | None:
    """Lay the voice on one part of a recording; None where it does not fit in."""
    try:
        return _bent(power[first:last], first, voice, seconds)
    except SpeechError:
        return None


def _doubts(bent: Bent, power: Floats, language: str | None) -> Iterator[str]:
    """Describe mismatches of sound and text in messages."""
    if bent.confidence < DOUBTFUL:
        yield (
            f"the recording and the text hardly agree (confidence {bent.confidence:.2f}); "
            f"is it this text that is said, and in {language}?"
        )
    places = []
    for first, last in ((0, bent.span[0]), (bent.span[1], len(power))):
        try:
            sounding = np.flatnonzero(heard_in(power).spoken[first:last])
        except SpeechError:
            continue
        if len(sounding) * HOP >= LASTING:
            begin, end = (first + sounding[[0, -1]]) * HOP
            places.append(f"{begin:.1f} to {end:.1f} s")
    if places:
        yield f"sound that the text does not have: {', '.join(places)}"


def _fit(heard: SpeechSpectrum, kept: Ints, voice: SpokenVoice) -> Fit:
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
    return Fit(_edges(a, b, path)[starts], cost, _coarse(a, backwards)[1])


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
            'get it with: pip install "lipsync-lang[audio]"'
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
            times = [min(at, low) for at in times]
            starts[number:] = np.maximum(starts[number:], high)
            labels.append(SILENCE)
            times.append(low)
        elif number == 0 and starts[0] >= SHORTEST:
            labels.append(SILENCE)
            times.append(0.0)
        place.append(len(labels))
        labels.append(label)
        times.append(float(starts[number]))
    if seconds - end >= SHORTEST:
        labels.append(SILENCE)
        times.append(end)
    words = tuple(
        Word(word.text, place[word.first], place[word.stop - 1] + 1) for word in voice.words
    )
    return tuple(labels), _spaced(np.array(times), seconds), words


def _stress(labels: tuple[str, ...], spoken: Schedule) -> tuple[int | None, ...]:
    """Return the stress of labels that differ from a schedule's in their pauses alone."""
    pairs = zip(spoken.labels, spoken.stress, strict=False)
    marks = iter([mark for label, mark in pairs if label != SILENCE])
    stress = tuple(None if label == SILENCE else next(marks, None) for label in labels)
    return stress if spoken.stress else ()


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
        for known, reach in ((voice.rests, REST), (words, REACH), (every, np.inf)):
            if not len(known) or (known is every and high - low < HESITATION):
                continue
            apart = np.abs(edges[known] - (at + 0.5))
            nearest = int(known[apart.argmin()])
            if apart.min() * HOP <= reach and nearest not in found:
                found[nearest] = (float(low), float(high))
                break
    return found


def _spaced(starts: Floats, end: float) -> Floats:
    """Enforce minimum spacing of boundaries within the recording, from 0 to its end."""
    least = min(SHORTEST, end / (2 * len(starts)))
    steps = least * np.arange(len(starts) + 1)
    apart = np.maximum(np.append(starts, end) - steps, 0)
    starts = np.maximum.accumulate(apart) + steps
    out: Floats = np.minimum(starts, end - steps[::-1])
    out[0] = 0.0
    return out


def _confidence(fit: Fit, lasts: Floats, said: Floats) -> float:
    """Return the confidence from 0 to 1 that the recording contains the text.

    A correct text fits better forwards than reversed, and its durations correlate with the voice's.
    The weights separate correct texts from wrong texts.
    """
    better = 1 - fit.cost / fit.backwards
    uneven = float(np.std(np.log(np.maximum(lasts, 0.02) / np.maximum(said, 0.02))))
    return float(1 / (1 + np.exp(-25 * (better - 0.5 * uneven + 0.17))))
