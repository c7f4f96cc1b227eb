"""Alignment by warping: the language's own voice says the text, and is bent to the recording.

Needs no model of the language: what its pack's voice speaks can be aligned. The voice knows when
each of its phonemes starts; dynamic time warping (Sakoe and Chiba 1978) of the two sounds says
when that is in the recording. Pauses are the recording's own.
"""

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from lipsync_lang.errors import SpeechError
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule, Word
from lipsync_lang.speech.align.aligners import aligner
from lipsync_lang.speech.align.spectrum import (
    HOP,
    Bools,
    Floats,
    Ints,
    SpeechSpectrum,
    alike,
    listen,
    mel_power,
    samples_of,
)

if TYPE_CHECKING:
    from lipsync_lang.speech.speaking import Speaker

TRACTS = (0.88, 0.94, 1.0, 1.06)
"""Lengths of vocal tract to try the voice with; the one that fits best is taken."""

PAUSE = 0.2
"""Seconds; a shorter silence is a closed mouth, not a pause."""

ISLAND = 0.06
"""Seconds; a shorter sound between two pauses is a click, not speech."""

REACH = 0.15
"""Seconds between a pause and the start of a word that it stands before."""

HESITATION = 0.4
"""Seconds; a longer pause is one even where no word starts."""

SHORTEST = 0.01
"""Seconds of a phoneme, where there is room."""

PENALTY = 2.0
"""What each frame costs by which the two sounds drift apart; frames are about 5 apart."""

WHOLE = 3000
"""Frames compared at once; longer sounds are compared coarsely first, then in parts."""

PART, MARGIN = 1500, 200
"""Frames of such a part, and those on either side that help to find its ends."""

TEMPO = (0.4, 2.5)
"""The voice may be so much slower or faster than the recording."""

DOUBTFUL = 0.5
"""A confidence below this is remarked upon."""


class SpokenVoice(NamedTuple):
    """What the voice says: its phonemes without pauses, and the sound."""

    labels: tuple[str, ...]
    words: tuple[Word, ...]
    starts: Floats
    """(n,) seconds"""
    ends: Floats
    """(n,)"""
    samples: Floats
    schedule: Schedule

    @classmethod
    def of(cls, speaker: "Speaker", text: str) -> Self:
        """Let a language's voice say a text."""
        said = speaker.speak(text)
        if said.audio is None:
            raise SpeechError(
                f"{speaker.manner.language} has no voice to compare the recording with; give its "
                "pack a `tts`, or align with another program and give its file (`schedule`)"
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
            said,
        )

    def frames(self, hop: float, count: int) -> tuple[Bools, Ints]:
        """Return which of its frames sound (M,), and among these where phonemes start (n,)."""
        times = np.arange(count) * hop
        phone = np.searchsorted(self.starts, times, side="right") - 1
        sounding = (phone >= 0) & (times < self.ends[np.maximum(phone, 0)])
        return sounding, np.searchsorted(phone[sounding], np.arange(len(self.labels)))


class Fit(NamedTuple):
    """How the voice lies on the recording, in frames of speech."""

    edges: Floats
    """(n,) where each phoneme starts."""
    cost: float
    """How far the two are apart on the way, on average."""
    backwards: float
    """How far a voice is that runs backwards, and so says something else."""


@aligner("warp")
class Warp:
    """The aligner for any language that has a voice."""

    def align(
        self, audio: Audio, text: str, speaker: "Speaker", model: str | None = None
    ) -> Schedule:
        """Find when each phoneme of a text is said in a recording of it.

        Parameters
        ----------
        audio : the recording
        text : what is said in it
        speaker : its language
        model : none; the voice is the language pack's

        Raises
        ------
        SpeechError
            The language has no voice, nothing is said, or more than there is time for.
        """
        if model is not None:
            raise SpeechError(
                f"warping needs no model, but '{model}' is given: leave it out, or choose another "
                "aligner"
            )
        voice = SpokenVoice.of(speaker, text)
        heard = listen(samples_of(audio))
        kept = _speech(heard.spoken)
        if len(kept) * HOP < len(voice.labels) * SHORTEST:
            raise SpeechError(
                f"the recording has {len(kept) * HOP:.2f} s of speech, too short for the "
                f"{len(voice.labels)} phonemes of the text; is it another line's?"
            )
        fit = _fit(heard, kept, voice)
        labels, times, words = _laid(fit.edges, kept, voice, audio.seconds)
        lasts = np.diff(times)[[label != SILENCE for label in labels]]
        confidence = _confidence(fit, lasts, voice.ends - voice.starts)
        doubt = (
            f"the recording and the text hardly agree (confidence {confidence:.2f}); "
            f"is it this text that is said, and in {speaker.manner.language}?"
        )
        return replace(
            voice.schedule,
            labels=labels,
            times=times,
            words=words,
            audio=audio,
            source="recording",
            remarks=(doubt,) if confidence < DOUBTFUL else (),
            confidence=confidence,
        )


def _speech(spoken: Bools) -> Ints:
    """Return the frames to compare: those of speech and of its short silences, clicks aside."""
    kept = [run for run in _runs(np.flatnonzero(spoken)) if len(run) * HOP >= ISLAND]
    return np.concatenate(kept) if kept else np.flatnonzero(spoken)


def _runs(frames: Ints) -> list[Ints]:
    """Cut frames into runs with pauses between them, and fill the shorter silences."""
    cuts = np.flatnonzero(np.diff(frames) * HOP >= PAUSE) + 1
    return [np.arange(run[0], run[-1] + 1) for run in np.split(frames, cuts)]


def _fit(heard: SpeechSpectrum, kept: Ints, voice: SpokenVoice) -> Fit:
    """Lay the voice on the recording, at its tempo and with the tract that is likest."""
    tempo = float((voice.ends - voice.starts).sum()) / (len(kept) * HOP)
    hop = HOP * float(np.clip(tempo, *TEMPO))
    costs = {}
    for tract in TRACTS:
        a, b, _ = _compared(heard, kept, voice, hop, tract)
        costs[tract] = _coarse(a, b)[1]
    tract = min(costs, key=costs.__getitem__)
    a, b, starts = _compared(heard, kept, voice, hop, tract)
    backwards = b[::-1] * np.repeat([1, -1], b.shape[1] // 2)
    return Fit(_edges(a, b)[starts], costs[tract], _coarse(a, backwards)[1])


def _compared(
    heard: SpeechSpectrum, kept: Ints, voice: SpokenVoice, hop: float, tract: float
) -> tuple[Floats, Floats, Ints]:
    """Return the frames of recording and voice, and where among these phonemes start."""
    power = mel_power(voice.samples, hop, tract)
    sounding, starts = voice.frames(hop, len(power))
    recorded, spoken = alike(heard, power, sounding)
    return recorded[kept], spoken[sounding], starts


def _step(a: Floats, b: Floats) -> int:
    """Return how many frames are pooled into one, so that the two can be compared whole."""
    return -(-max(len(a), len(b)) // WHOLE)


def _coarse(a: Floats, b: Floats) -> tuple[Ints, float]:
    """Return the best way through two sounds pooled, and its mean cost."""
    step = _step(a, b)
    return _path(_pool(a, step), _pool(b, step))


def _pool(frames: Floats, step: int) -> Floats:
    """Return the mean of every so many frames."""
    starts = np.arange(0, len(frames), step)
    counts = np.diff([*starts, len(frames)])
    return np.add.reduceat(frames, starts) / counts[:, None]


def _path(a: Floats, b: Floats) -> tuple[Ints, float]:
    """Return the best way through two sounds: (K, 2) frames of each, and its mean cost."""
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
    """Return where in the first sound each frame of the second starts: (count,)."""
    at = np.searchsorted(path[:, 1], np.arange(count))
    starts: Floats = (path[at, 0] + path[np.maximum(at - 1, 0), 0]) / 2
    return starts


def _edges(a: Floats, b: Floats) -> Floats:
    """Return where each frame of the voice starts on the recording, at any length: (M,)."""
    step = _step(a, b)
    coarse = _starts(_coarse(a, b)[0], -(-len(b) // step))
    if step == 1:
        return coarse
    near = np.interp(np.arange(len(b) + 1) / step, np.arange(len(coarse)), coarse) * step
    out = np.empty(len(b))
    for low in range(0, len(b), PART):
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
    """Lay phonemes and pauses on the whole recording: labels, boundaries and words."""
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


def _pauses(edges: Floats, kept: Ints, voice: SpokenVoice) -> dict[int, tuple[float, float]]:
    """Return the recording's pauses by the phoneme that each stands before: start and end.

    A pause stands before a word; a long one, where no word starts near, before a phoneme.
    """
    found: dict[int, tuple[float, float]] = {}
    words = np.array([word.first for word in voice.words if word.first], np.intp)
    every = np.arange(1, len(edges))
    for at in np.flatnonzero(np.diff(kept) > 1):
        low, high = (kept[at] + 0.5) * HOP, (kept[at + 1] - 0.5) * HOP
        for known, reach in ((words, REACH), (every, np.inf)):
            if not len(known) or (known is every and high - low < HESITATION):
                continue
            apart = np.abs(edges[known] - (at + 0.5))
            nearest = int(known[apart.argmin()])
            if apart.min() * HOP <= reach and nearest not in found:
                found[nearest] = (float(low), float(high))
                break
    return found


def _spaced(starts: Floats, end: float) -> Floats:
    """Keep boundaries apart and in the recording, from 0 to its end."""
    least = min(SHORTEST, end / (2 * len(starts)))
    steps = least * np.arange(len(starts) + 1)
    apart = np.maximum(np.append(starts, end) - steps, 0)
    starts = np.maximum.accumulate(apart) + steps
    out: Floats = np.minimum(starts, end - steps[::-1])
    out[0] = 0.0
    return out


def _confidence(fit: Fit, lasts: Floats, said: Floats) -> float:
    """Say how sure it is that the recording says the text, from 0 to 1.

    A text that is said fits better forwards than backwards, and its sounds are longer and shorter
    together with the voice's. Weights are those that part right texts from wrong ones.
    """
    better = 1 - fit.cost / fit.backwards
    uneven = float(np.std(np.log(np.maximum(lasts, 0.02) / np.maximum(said, 0.02))))
    return float(1 / (1 + np.exp(-25 * (better - 0.5 * uneven + 0.17))))
