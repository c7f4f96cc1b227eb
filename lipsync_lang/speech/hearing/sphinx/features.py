"""Acoustic features: cepstra of a sound and their time derivatives.

Processing steps and constants match the training of the CMU Sphinx models.
"""

from functools import cache

import numpy as np

from lipsync_lang.arrays import Floats
from lipsync_lang.speech.sound import SPEECH_RATE

HOP_SAMPLES = 160
"""Frame step in samples."""

FRAME_SECONDS = HOP_SAMPLES / SPEECH_RATE
"""Frame step in seconds."""

WINDOW_SAMPLES = 410
"""Frame window in samples."""

FFT_POINTS = 512
"""Size of the Fourier transform."""

PRE_EMPHASIS = 0.97

BANDS, LOWEST, HIGHEST = 25, 130.0, 6800.0
"""Number of mel bands, and their limits in hertz."""

FIRST_BAND = np.maximum(np.arange(BANDS) - 4, 0)
LAST_BAND = np.minimum(np.arange(BANDS) + 5, BANDS)
"""(`BANDS`,) first band, and the one after the last, of the nine around each."""

CEPSTRA = 13
LIFTER = 22


DELTA_FRAMES = 3
"""Frames on each side of a frame on which its derivatives depend."""


def features(samples: Floats) -> Floats:
    """Return three streams of features for each frame of a sound.

    Parameters
    ----------
    samples : (N,) at `SPEECH_RATE`

    Returns
    -------
    (T, 3, 13): cepstra less their mean, first and second derivatives; T = N / `HOP_SAMPLES`
    """
    cepstra = CepstralFrames().last(samples)
    # Cepstral mean normalisation: a microphone adds a constant to the logarithm of each band.
    cepstra -= cepstra.mean(axis=0)
    return derived(np.pad(cepstra, ((DELTA_FRAMES, DELTA_FRAMES), (0, 0)), mode="edge"))


def derived(wide: Floats) -> Floats:
    """Return cepstra, (T + 2 `DELTA_FRAMES`, 13), with their derivatives: (T, 3, 13)."""
    count = len(wide) - 2 * DELTA_FRAMES

    def at(later: int) -> Floats:
        return wide[DELTA_FRAMES + later : DELTA_FRAMES + later + count]

    # The decoder of the models takes these differences over 4 and 6 frames, without the usual
    # weights: other derivatives fit none of their Gaussians.
    change = at(2) - at(-2)
    turn = (at(3) - at(-1)) - (at(1) - at(-3))
    return np.concatenate([at(0), change, turn], axis=1).reshape(count, 3, CEPSTRA)


class CepstralFrames:
    """Cepstra of a sound that arrives in parts, before any mean is taken away."""

    def __init__(self) -> None:
        self._sound = np.zeros(0)
        self._before = 0.0
        self._noise: _BandNoise | None = None

    def push(self, samples: Floats) -> Floats:
        """Return the cepstra of the frames that are complete with these samples: (k, 13)."""
        # Pre-emphasis, across the parts.
        earlier = np.concatenate([[self._before], samples])
        self._before = float(earlier[-1])
        sound = np.concatenate([self._sound, samples - PRE_EMPHASIS * earlier[:-1]])
        count = max((len(sound) - WINDOW_SAMPLES) // HOP_SAMPLES + 1, 0)
        self._sound = sound[count * HOP_SAMPLES :]
        if count == 0:
            return np.zeros((0, CEPSTRA))
        spectra = _spectra(sound, count)
        if self._noise is None:
            self._noise = _BandNoise(spectra[0])
        waves, lifter = _cosines()
        cepstra: Floats = (np.log(self._noise.quieted(spectra) + 1e-4) @ waves.T) * lifter
        return cepstra

    def last(self, samples: Floats) -> Floats:
        """Return the cepstra of the last samples, the rest of them filled up with zeros."""
        whole = len(self._sound) + len(samples)
        # Ceiling division: the last frame may hold less sound than a hop.
        count = max(-(-whole // HOP_SAMPLES), 1)
        missing = max(count * HOP_SAMPLES + WINDOW_SAMPLES - HOP_SAMPLES - whole, 0)
        return self.push(np.pad(samples, (0, missing)))[:count]


@cache
def _cosines() -> tuple[Floats, Floats]:
    """Return the cosine transform of bands to cepstra, and the factor of each cepstrum."""
    order = np.arange(CEPSTRA)[:, None]
    waves = np.cos(np.pi * order * (np.arange(BANDS) + 0.5) / BANDS) * np.sqrt(2 / BANDS)
    # The unitary cosine transform has another factor for the constant.
    waves[0] = np.sqrt(1 / BANDS)
    return waves, 1 + LIFTER / 2 * np.sin(np.pi * np.arange(CEPSTRA) / LIFTER)


@cache
def _filters() -> tuple[Floats, Floats]:
    """Return the Hamming window of a frame, and the filter of each band."""
    window = 0.54 - 0.46 * np.cos(2 * np.pi * np.arange(WINDOW_SAMPLES) / (WINDOW_SAMPLES - 1))
    spacing = SPEECH_RATE / FFT_POINTS
    # The trainer rounds the corners of the filters to bins of the Fourier transform, and gives all
    # filters one area.
    edges = np.floor(mel_edges(LOWEST, HIGHEST, BANDS) / spacing + 0.5) * spacing
    return window, triangles(edges) * (2 / (edges[2:] - edges[:-2]))


def _spectra(sound: Floats, count: int) -> Floats:
    """Return the power of each band in some frames: (`count`, `BANDS`)."""
    window, bands = _filters()
    starts, within = np.arange(count)[:, None] * HOP_SAMPLES, np.arange(WINDOW_SAMPLES)
    spectra = np.empty((count, BANDS))
    for start in range(0, count, 1000):  # in blocks, to bound memory
        block = slice(start, start + 1000)
        frames = sound[starts[block] + within]
        spectra[block] = (np.abs(np.fft.rfft(frames * window, FFT_POINTS)) ** 2) @ bands
    return spectra


def mel_edges(lowest: float, highest: float, bands: int) -> Floats:
    """Return the corners of bands that are evenly spaced in mel, in hertz: (bands + 2,)."""
    low, high = (2595 * np.log10(1 + hertz / 700) for hertz in (lowest, highest))
    edges: Floats = 700 * (10 ** (np.linspace(low, high, bands + 2) / 2595) - 1)
    return edges


def triangles(edges: Floats) -> Floats:
    """Return triangular filters between corners in hertz: (257, bands)."""
    hertz = np.arange(FFT_POINTS // 2 + 1)[:, None] * SPEECH_RATE / FFT_POINTS
    left, middle, right = edges[:-2], edges[1:-1], edges[2:]
    rising, falling = (hertz - left) / (middle - left), (right - hertz) / (right - middle)
    return np.maximum(0, np.minimum(rising, falling))


class _BandNoise:
    """Slowly varying noise in each band, tracked over frames."""

    def __init__(self, first: Floats) -> None:
        self.power = first.copy()
        # The start of a sound counts as 13 dB above its noise, until the envelopes have settled.
        self.noise = first / 20
        self.floor = self.noise.copy()
        self.peak = np.zeros(BANDS)

    def quieted(self, spectra: Floats) -> Floats:
        """Subtract the noise from the next frames: (k, `BANDS`)."""
        powers, signals = np.empty_like(spectra), np.empty_like(spectra)
        power, noise, floor, peak = self.power, self.noise, self.floor, self.peak
        for number, here in enumerate(spectra):
            powers[number] = power = 0.7 * power + 0.3 * here
            noise = _envelope(power, noise)
            signal = np.maximum(power - noise, 1.0)
            floor = _envelope(signal, floor)
            # Temporal masking: after a peak, a weaker sound is lowered to a share of the fading
            # peak (Kim and Stern 2016, power-normalized cepstra).
            peak = 0.85 * peak
            heard = signal
            signal = np.where(signal < 0.85 * peak, 0.2 * peak, signal)
            peak = np.maximum(peak, heard)
            np.maximum(signal, floor, out=signals[number])
        self.power, self.noise, self.floor, self.peak = power, noise, floor, peak
        gain = np.clip(signals / np.maximum(powers, 1e-300), 1 / 20, 20)
        # A moving mean over nine bands from differences of the running sum, which has a 0 in front.
        whole = np.zeros((len(gain), BANDS + 1))
        np.cumsum(gain, axis=1, out=whole[:, 1:])
        quieted: Floats = spectra * (whole[:, LAST_BAND] - whole[:, FIRST_BAND])
        quieted /= LAST_BAND - FIRST_BAND
        return quieted


def _envelope(values: Floats, below: Floats) -> Floats:
    """Track the lower envelope of values: slow rise, fast fall."""
    slow = np.where(values >= below, 0.995, 0.5)
    return slow * below + (1 - slow) * values
