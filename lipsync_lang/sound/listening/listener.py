"""The listener: sound in, final frames out.

Times are seconds from the first sample. A frame at time t is final once sound until t + `delay` is
known. No later sound changes it. Sound at another rate is resampled by a windowed sinc; in which
parts it arrives does not matter.
"""

from collections.abc import Mapping, Sequence
from math import ceil, gcd

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Floats, Singles
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.pipeline.constrain import constrain
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.perform import FinalFrames
from lipsync_lang.pipeline.tables import Tables
from lipsync_lang.resolver.nearest_phonemes import model_phones
from lipsync_lang.sound.listening.belief import Smoother, thirds
from lipsync_lang.sound.listening.ear import (
    LOOK_AHEAD_SECONDS,
    MIDDLE_SECONDS,
    Ear,
    Heard,
    PhoneScores,
    VoiceGate,
    change_of,
    contrast_of,
    phone_scores,
)
from lipsync_lang.sound.listening.mouth import Mouth, heard_values, state_targets
from lipsync_lang.sound.speech.hearing.sphinx.features import FRAME_SECONDS
from lipsync_lang.sound.speech.hearing.sphinx.folder import find_models
from lipsync_lang.sound.speech.sound import FASTEST, INT16_FULL_SCALE, SLOWEST, SPEECH_RATE
from lipsync_lang.text.phonology.labels import Notation

ZERO_CROSSINGS = 12
"""Length of the sinc on each side, 0.8 ms at `SPEECH_RATE`; longer ones cut off more sharply."""

PASSED_SHARE = 0.94
"""Frequencies that are kept, as a share of those that both rates have."""

MOST_DELAY = 1.0
"""Seconds."""

ROUNDED_FRAMES = 1e-6
"""Tolerance of a frame's time, as a share of a frame."""

EARLIER_SECONDS = 0.04
"""Seconds by which lips are shown earlier, where the delay allows: they move before the sound."""


class Resampler:
    """Sound at `SPEECH_RATE`, from sound at another rate that arrives in parts."""

    def __init__(self, rate: int) -> None:
        common = gcd(rate, SPEECH_RATE)
        self._step, self._parts = rate // common, SPEECH_RATE // common
        share = PASSED_SHARE * min(1.0, SPEECH_RATE / rate)
        self._half = ceil(ZERO_CROSSINGS / share)
        self.look_ahead = self._half / rate
        """Seconds of sound after a sample that it needs."""
        # a filter for each place of a sample between two samples of the input
        places = np.arange(1 - self._half, self._half + 1)
        away = places - np.arange(self._parts)[:, None] / self._parts
        self._filters = share * np.sinc(share * away) * np.cos(np.pi / 2 * away / self._half) ** 2
        self._sound = np.zeros(self._half - 1)
        self._first = 1 - self._half
        """Place in the input of the first sample that is kept."""
        self._heard = self._given = 0

    def push(self, samples: Floats) -> Floats:
        """Return the samples that are complete with these."""
        self._heard += len(samples)
        self._sound = np.concatenate([self._sound, samples])
        last = self._first + len(self._sound) - 1 - self._half
        return self._until(last * self._parts // self._step + 1)

    def finish(self) -> Floats:
        """Return the last samples."""
        self._sound = np.concatenate([self._sound, np.zeros(self._half)])
        return self._until(ceil(self._heard * self._parts / self._step))

    def _until(self, stop: int) -> Floats:
        if stop <= self._given:
            return np.zeros(0)
        before, phases = np.divmod(np.arange(self._given, stop) * self._step, self._parts)
        self._given = stop
        wide = np.lib.stride_tricks.sliding_window_view(self._sound, self._filters.shape[1])
        starts = before - self._half + 1 - self._first
        made: Floats = (wide[starts] * self._filters[phases]).sum(axis=1)
        # The next sample needs sound from here on.
        kept = stop * self._step // self._parts - self._half + 1
        self._sound, self._first = self._sound[kept - self._first :], kept
        return made


class Listener:
    """Lips of a voice that arrives in parts; see `Performer.listen`.

    Examples
    --------
    >>> listener = ll.resolve("english", "facefx").listen(rate=16000, delay=0.08, fps=60)
    >>> times, weights = listener.push(np.zeros(1600, np.int16))
    >>> weights.shape
    (2, 9)
    """

    def __init__(  # noqa: PLR0913 what it hears with, what it moves, and three settings
        self,
        scores: PhoneScores,
        mouth: Mouth,
        poses: tuple[str, ...],
        *,
        rate: int,
        delay: float,
        fps: float,
    ) -> None:
        if not SLOWEST <= rate <= FASTEST:
            raise LipsyncError(
                f"{rate} samples per second; speech needs {SLOWEST} to {FASTEST}: resample it"
            )
        self._resampler = Resampler(rate) if rate != SPEECH_RATE else None
        # The ear's own frames are 10 ms apart, and a frame between two of them awaits the second.
        self.delays = {"features": LOOK_AHEAD_SECONDS, "frames": FRAME_SECONDS}
        if self._resampler is not None:
            self.delays["rate"] = self._resampler.look_ahead
        least = sum(self.delays.values())
        if not least <= delay <= MOST_DELAY:
            raise LipsyncError(
                f"a delay of {delay:g} s is out of range; sound needs {least:.3f} to "
                f"{MOST_DELAY:g} s"
            )
        lag = int(max(delay - least - EARLIER_SECONDS, 0) / FRAME_SECONDS + 1e-9)
        self.delays["belief"] = lag * FRAME_SECONDS
        self.delays["lead"] = delay - sum(self.delays.values())
        self.poses, self.rate, self.fps = poses, rate, fps
        self.phones = scores.model.names
        self.scores, self._ear = scores, Ear()
        self._smoother = Smoother(scores.loop, lag)
        self._mouth = mouth
        self._gate, self._voiced = VoiceGate(), np.zeros(1)
        self._given = self._frames = 0
        self._last = np.zeros((0, len(mouth.tables.priority)))
        self.belief = scores.loop.start.sum(axis=-1)
        """(N,) probability of each phone in the newest frame."""

    @property
    def delay(self) -> float:
        """Seconds of sound after a frame that must be known before it is final."""
        return sum(self.delays.values())

    def push(self, samples: npt.ArrayLike) -> FinalFrames:
        """Hear the next samples, and return the frames that are final now.

        Raises LipsyncError if the samples have another form.

        Parameters
        ----------
        samples : (n,) int16, or floats from -1 to 1, at `rate`
        """
        return self.push_together([self], [samples])[0]

    def finish(self) -> FinalFrames:
        """Return the last frames; the mouth comes to rest."""
        rest = np.zeros(0) if self._resampler is None else self._resampler.finish()
        both = zip(self._ear.hear(rest), self._ear.finish(), strict=True)
        heard = Heard(*map(np.concatenate, both))
        belief, last = self._calmed(heard, self.scores.of(heard.features)), self._smoother.finish()
        calmed = self._smoother.loop.calmed(last, np.repeat(self._voiced, len(last)))
        return self._moved(np.concatenate([belief, calmed]))

    @staticmethod
    def push_together(
        listeners: "Sequence[Listener]", sounds: Sequence[npt.ArrayLike]
    ) -> list[FinalFrames]:
        """Push the next samples of many voices, which costs less than one after the other.

        Raises LipsyncError if samples have another form; no voice has heard anything then.

        Parameters
        ----------
        listeners : each once
        sounds : samples of each, as for `push`; an empty array waits

        Examples
        --------
        >>> voices = [ll.resolve("english", "facefx").listen() for _ in range(20)]
        >>> found = voices[0].push_together(voices, [np.zeros(1600, np.int16)] * 20)
        >>> found[19].weights.shape
        (2, 9)
        """
        checked = [_samples(sound) for sound in sounds]
        if len({one.scores for one in listeners}) > 1:
            return [one.push(sound) for one, sound in zip(listeners, sounds, strict=True)]
        heard = [one.hear(sound) for one, sound in zip(listeners, checked, strict=True)]
        if not heard:
            return []
        scores = listeners[0].scores.of(np.concatenate([one.features for one in heard]))
        parts = np.split(scores, np.cumsum([len(one.features) for one in heard])[:-1])
        both = zip(listeners, heard, parts, strict=True)
        return [one.move(own, part) for one, own, part in both]

    def hear(self, sound: Floats) -> Heard:
        """Return the frames that are complete with these samples."""
        return self._ear.hear(sound if self._resampler is None else self._resampler.push(sound))

    def move(self, heard: Heard, scores: Singles) -> FinalFrames:
        """Return the frames that are final with the next ones heard, given their scores."""
        return self._moved(self._calmed(heard, scores))

    def _calmed(self, heard: Heard, scores: Singles) -> Floats:
        """Return the belief of the frames that are final; it is quiet where nobody speaks."""
        belief = self._smoother.push(scores)
        contrast = contrast_of(scores, self.scores.loop.quiet)
        voiced = self._gate.push(change_of(heard.features), heard.tones, contrast)
        self._voiced = voiced[-1:] if len(voiced) else self._voiced
        # the newest frames tell most about those that the smoother returns
        return self._smoother.loop.calmed(belief, voiced[len(voiced) - len(belief) :])

    def _moved(self, belief: Floats) -> FinalFrames:
        """Return the frames that are final with the belief of the ear's next frames."""
        if len(belief):
            self.belief = belief[-1].sum(axis=-1)
        first = self._frames - len(self._last)
        curves = np.concatenate([self._last, self._mouth.push(thirds(belief))])
        self._frames += len(belief)
        self._last = curves[-2:]
        late = MIDDLE_SECONDS - self.delays["lead"]
        newest = (self._frames - 1) * FRAME_SECONDS + late
        count = int(np.floor(newest * self.fps + ROUNDED_FRAMES)) + 1 if self._frames else 0
        times = np.arange(self._given, max(count, self._given)) / self.fps
        self._given += len(times)
        if not len(times):
            return FinalFrames(times, np.zeros((0, len(self.poses))))
        weights = np.zeros((len(times), len(self.poses)))
        # straight between the frames of the ear; the first one stands in for those before it
        at = np.clip((times - late) / FRAME_SECONDS - first, 0, len(curves) - 1)
        low = np.minimum(at.astype(int), max(len(curves) - 2, 0))
        share = (at - low)[:, None]
        high = np.minimum(low + 1, len(curves) - 1)
        shown = curves[low] * (1 - share) + curves[high] * share
        tables = self._mouth.tables
        weights[:, : shown.shape[1]] = constrain(shown.T, tables.binding, tables.at_most).T
        return FinalFrames(times, weights)


def _samples(samples: npt.ArrayLike) -> Floats:
    """Return samples in the range of int16."""
    sound = np.asarray(samples)
    if sound.ndim != 1:
        raise LipsyncError(f"samples of shape {sound.shape}: give one channel, shape (n,)")
    if sound.dtype != np.int16:
        if sound.dtype.kind != "f" or not np.isfinite(sound).all():
            raise LipsyncError(
                f"samples of type {sound.dtype} that are no sound: give int16, or finite floats "
                "from -1 to 1"
            )
        sound = sound * float(INT16_FULL_SCALE)
    return sound.astype(np.float64)


def open_listener(  # noqa: PLR0913 what moves, the language, and three settings
    tables: Tables,
    motion: Motion,
    poses: tuple[str, ...],
    notation: Notation | None,
    numbers: Mapping[str, int],
    *,
    rate: int,
    delay: float,
    fps: float,
) -> Listener:
    """Open a listener for the poses of some tables; see `Performer.listen`.

    Parameters
    ----------
    poses : names of the columns; those after the poses of the tables stay 0
    notation : of the language, in IPA
    numbers : number of each common phoneme in the tables
    """
    known = model_phones()
    if known is None:
        raise LipsyncError("the pack of the IPA names no acoustic model (`hearing`)")
    if notation is None:
        raise LipsyncError("the language has no notation 'ipa', which listening needs")
    scores = phone_scores(find_models(known.model).model, known.neighbours)
    values = heard_values(known, notation)
    heard = [values.get(name, ()) for name in scores.model.names]
    mouth = Mouth(tables, motion, *state_targets(tables, heard, numbers))
    return Listener(scores, mouth, poses, rate=rate, delay=delay, fps=fps)
