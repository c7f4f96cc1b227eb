"""Alignment by dynamic time warping of a synthetic voice to the recording.

No acoustic model is needed: any language with a voice can be aligned. The voice supplies the start
time of each phoneme; dynamic time warping (Sakoe and Chiba 1978) maps these times to the recording.
Pauses come from the recording. The confidence is calibrated evidence that it contains the text.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import tee
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule, Word
from lipsync_lang.sound.speech.hearing.align.aligners import BatchAligner, aligner
from lipsync_lang.sound.speech.hearing.align.bending import Fit, SpokenVoice, fitted
from lipsync_lang.sound.speech.hearing.align.locating import spans
from lipsync_lang.sound.speech.hearing.align.spectrum import (
    HOP,
    heard_in,
    mel_power,
    samples_of,
    speech_frames,
)
from lipsync_lang.sound.speech.hearing.sphinx.scheduling import logistic
from lipsync_lang.sound.speech.results import exhaust, next_result, raised, tried

if TYPE_CHECKING:
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
        self,
        recordings: Iterable[tuple[Callable[[], Audio], str]],
        speaker: "Speaker",
        model: str | None = None,
    ) -> Iterator[Schedule | SpeechError]:
        """Align as `align` does, with all texts spoken by one process."""
        if model is not None:
            error = SpeechError(
                f"warping takes no model, but '{model}' is given: leave it out, or choose another "
                "aligner"
            )
            yield from (error for _ in recordings)
            return
        ours, voices = tee(recordings)
        said = speaker.speak_many(text for _, text in voices)
        for sound, _ in ours:
            try:
                spoken = raised(next_result(said))
                yield _warped(sound(), spoken)
            except SpeechError as error:
                yield error
        exhaust(said)


def _warped(audio: Audio, said: Schedule) -> Schedule:
    """Warp the voice to the recording, or to the part of it with the text."""
    voice = SpokenVoice.of(said)
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
            # The warp may put a boundary into the pause; sound of a phoneme ends where the pause
            # starts.
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
