"""Pitch of a voice at given times, by autocorrelation."""

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Floats

LOWEST, HIGHEST = 60.0, 400.0
"""Range of voices in hertz."""

RATE = 8000.0
"""Samples per second that distinguish semitones even of a high voice."""

PITCH_WINDOW_SECONDS = 0.05
"""Length of sound in which a pitch is sought: three periods of the lowest voice."""

VOICED_LEAST = 0.5
"""Least correlation of a voiced sound with itself a period later."""

BLOCK_PITCHES = 1024
"""Pitches sought at once, so that an hour of sound needs little memory."""

FIRST_PEAK = 0.9
"""The first peak this close to the highest is the period, for two periods correlate as well."""


def pitches(samples: npt.NDArray[np.int16], rate: float, times: Floats) -> Floats:
    """Return the pitch around each time in hertz, (n,); 0 for a sound without voice.

    Examples
    --------
    >>> tone = (8000 * np.sin(2 * np.pi * 120 * np.arange(8000) / 16000)).astype(np.int16)
    >>> pitches(tone, 16000, np.array([0.2])).round()
    array([121.])
    """
    if len(times) > BLOCK_PITCHES:
        parts = np.split(times, range(BLOCK_PITCHES, len(times), BLOCK_PITCHES))
        return np.concatenate([pitches(samples, rate, part) for part in parts])
    step = max(int(rate / RATE), 1)  # voices need no more; what is folded in is not periodic
    samples, rate = samples[::step], rate / step
    size = int(PITCH_WINDOW_SECONDS * rate)
    # at fewer than two samples a period, no pitch can be told
    if rate < 2 * HIGHEST or len(samples) < size or not len(times):
        return np.zeros(len(times))
    firsts = np.clip((times * rate).astype(int) - size // 2, 0, len(samples) - size)
    sound = samples[firsts[:, None] + np.arange(size)].astype(float)
    sound -= sound.mean(axis=1, keepdims=True)
    spectrum = np.fft.rfft(sound, 2 * size)
    alike = np.fft.irfft(spectrum * spectrum.conj())[:, :size]
    # fewer samples overlap at longer lags
    alike *= size / (size - np.arange(size)) / np.maximum(alike[:, :1], 1.0)
    low = max(int(rate / HIGHEST), 1)
    lags = alike[:, low : int(rate / LOWEST) + 1]
    peak = np.zeros(lags.shape, bool)
    peak[:, 1:-1] = (lags[:, 1:-1] >= lags[:, :-2]) & (lags[:, 1:-1] > lags[:, 2:])
    tops = np.where(peak, lags, 0.0)
    best = tops.max(axis=1)
    first = (tops >= FIRST_PEAK * best[:, None]).argmax(axis=1)
    return np.where(best >= VOICED_LEAST, rate / (low + first), 0.0)
