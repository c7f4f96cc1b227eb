"""Acoustic features: cepstra of a sound and their time derivatives.

Processing steps and constants match the training of the CMU Sphinx models.
"""

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

CEPSTRA = 13
LIFTER = 22


def features(samples: Floats) -> Floats:
    """Return three streams of features for each frame of a sound.

    Parameters
    ----------
    samples : (N,) at `SPEECH_RATE`

    Returns
    -------
    (T, 3, 13): cepstra less their mean, first and second derivatives; T = N / `HOP_SAMPLES`
    """
    order = np.arange(CEPSTRA)[:, None]
    waves = np.cos(np.pi * order * (np.arange(BANDS) + 0.5) / BANDS) * np.sqrt(2 / BANDS)
    # The unitary cosine transform has another factor for the constant.
    waves[0] = np.sqrt(1 / BANDS)
    lifter = 1 + LIFTER / 2 * np.sin(np.pi * np.arange(CEPSTRA) / LIFTER)
    cepstra: Floats = (np.log(_quieted(_spectra(samples)) + 1e-4) @ waves.T) * lifter
    # Cepstral mean normalisation: a microphone adds a constant to the logarithm of each band.
    cepstra -= cepstra.mean(axis=0)
    wide = np.pad(cepstra, ((3, 3), (0, 0)), mode="edge")
    count = len(cepstra)

    def at(later: int) -> Floats:
        return wide[3 + later : 3 + later + count]

    # The decoder of the models takes these differences over 4 and 6 frames, without the usual
    # weights: other derivatives fit none of their Gaussians.
    change = at(2) - at(-2)
    turn = (at(3) - at(-1)) - (at(1) - at(-3))
    return np.stack([cepstra, change, turn], axis=1)


def _spectra(samples: Floats) -> Floats:
    """Return the power of each band in each frame: (T, `BANDS`)."""
    # Ceiling division: the last frame may hold less sound than a hop.
    count = max(-(-len(samples) // HOP_SAMPLES), 1)
    padded = np.pad(
        samples, (0, max(count * HOP_SAMPLES + WINDOW_SAMPLES - HOP_SAMPLES - len(samples), 0))
    )
    # NumPy reads the right side before it writes, so no sample is filtered twice.
    padded[1:] -= PRE_EMPHASIS * padded[:-1]
    frames = np.lib.stride_tricks.sliding_window_view(padded, WINDOW_SAMPLES)[
        : count * HOP_SAMPLES : HOP_SAMPLES
    ]
    # A Hamming window.
    window = 0.54 - 0.46 * np.cos(2 * np.pi * np.arange(WINDOW_SAMPLES) / (WINDOW_SAMPLES - 1))
    spacing = SPEECH_RATE / FFT_POINTS
    # The trainer rounds the corners of the filters to bins of the Fourier transform, and gives all
    # filters one area.
    edges = np.floor(mel_edges(LOWEST, HIGHEST, BANDS) / spacing + 0.5) * spacing
    bands = triangles(edges) * (2 / (edges[2:] - edges[:-2]))
    spectra = np.empty((len(frames), BANDS))
    for start in range(0, len(frames), 1000):  # in blocks, to bound memory
        block = slice(start, start + 1000)
        spectra[block] = (np.abs(np.fft.rfft(frames[block] * window, FFT_POINTS)) ** 2) @ bands
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


def _quieted(spectra: Floats) -> Floats:
    """Subtract slowly varying noise from each band, tracked over frames."""
    quieted = np.empty_like(spectra)
    power = spectra[0].copy()
    # The start of a sound counts as 13 dB above its noise, until the envelopes have settled.
    noise = spectra[0] / 20
    floor = noise.copy()
    peak = np.zeros(BANDS)
    sums = np.arange(BANDS)
    first, last = np.maximum(sums - 4, 0), np.minimum(sums + 5, BANDS)
    for number, here in enumerate(spectra):
        power = 0.7 * power + 0.3 * here
        noise = _envelope(power, noise)
        signal = np.maximum(power - noise, 1.0)
        floor = _envelope(signal, floor)
        # Temporal masking: after a peak, a weaker sound is lowered to a share of the fading peak
        # (Kim and Stern 2016, power-normalized cepstra).
        peak = 0.85 * peak
        heard = signal
        signal = np.where(signal < 0.85 * peak, 0.2 * peak, signal)
        peak = np.maximum(peak, heard)
        signal = np.maximum(signal, floor)
        gain = np.clip(signal / np.maximum(power, 1e-300), 1 / 20, 20)
        # A moving mean over nine bands from differences of the running sum, which has a 0 in front.
        whole = np.concatenate([[0.0], np.cumsum(gain)])
        quieted[number] = here * (whole[last] - whole[first]) / (last - first)
    return quieted


def _envelope(values: Floats, below: Floats) -> Floats:
    """Track the lower envelope of values: slow rise, fast fall."""
    slow = np.where(values >= below, 0.995, 0.5)
    return slow * below + (1 - slow) * values
