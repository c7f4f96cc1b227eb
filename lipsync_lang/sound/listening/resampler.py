"""Resampling of sound that arrives in parts, by a windowed sinc; the parts do not matter."""

from math import ceil, gcd

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.sound.speech.sound import SPEECH_RATE

ZERO_CROSSINGS = 12
"""Length of the sinc on each side, 0.8 ms at `SPEECH_RATE`; longer ones cut off more sharply."""

PASSED_SHARE = 0.94
"""Frequencies that are kept, as a share of those that both rates have."""


class Resampler:
    """Sound at `SPEECH_RATE`, from sound at another rate that arrives in parts."""

    def __init__(self, rate: int) -> None:
        self._rate = rate
        common = gcd(rate, SPEECH_RATE)
        self._step, self._parts = rate // common, SPEECH_RATE // common
        share = PASSED_SHARE * min(1.0, SPEECH_RATE / rate)
        self._half = ceil(ZERO_CROSSINGS / share)
        # a filter for each place of a sample between two samples of the input
        places = np.arange(1 - self._half, self._half + 1)
        away = places - np.arange(self._parts)[:, None] / self._parts
        self._filters = share * np.sinc(share * away) * np.cos(np.pi / 2 * away / self._half) ** 2
        self._sound = np.zeros(self._half - 1)
        self._first = 1 - self._half
        """Place in the input of the first sample that is kept."""
        self._heard = self._given = 0

    @property
    def look_ahead(self) -> float:
        """Seconds of sound after a sample that it needs."""
        return self._half / self._rate

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
