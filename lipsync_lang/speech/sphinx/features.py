"""Acoustic features: cepstra of a sound and their time derivatives.

Processing steps and constants match the training of the CMU Sphinx models.
"""

import numpy as np
import numpy.typing as npt

RATE = 16_000
"""Sample rate of the model in hertz."""

STEP = 160
"""Frame step in samples."""

FRAME = STEP / RATE
"""Frame step in seconds."""

WINDOW = 410
"""Frame window in samples."""

SIZE = 512
"""Size of the Fourier transform."""

EMPHASIS = 0.97
"""Pre-emphasis coefficient."""

BANDS, LOWEST, HIGHEST = 25, 130.0, 6800.0
"""Number of mel bands, and their limits in hertz."""

CEPSTRA = 13
LIFTER = 22

Floats = npt.NDArray[np.float64]


def features(samples: Floats) -> Floats:
    """Return three streams of features for each frame of a sound.

    Parameters
    ----------
    samples : (N,) at `RATE`

    Returns
    -------
    (T, 3, 13): cepstra less their mean, first and second derivatives; T = N / `STEP`
    """
    cepstra = _cepstra(_quieted(_spectra(samples)))
    cepstra -= cepstra.mean(axis=0)
    wide = np.pad(cepstra, ((3, 3), (0, 0)), mode="edge")
    count = len(cepstra)

    def at(later: int) -> Floats:
        return wide[3 + later : 3 + later + count]

    change = at(2) - at(-2)
    turn = (at(3) - at(-1)) - (at(1) - at(-3))
    return np.stack([cepstra, change, turn], axis=1)


def _spectra(samples: Floats) -> Floats:
    """Return the power of each band in each frame: (T, `BANDS`)."""
    count = max(-(-len(samples) // STEP), 1)
    padded = np.pad(samples, (0, max(count * STEP + WINDOW - STEP - len(samples), 0)))
    padded[1:] -= EMPHASIS * padded[:-1]
    frames = np.lib.stride_tricks.sliding_window_view(padded, WINDOW)[: count * STEP : STEP]
    window = 0.54 - 0.46 * np.cos(2 * np.pi * np.arange(WINDOW) / (WINDOW - 1))
    bands = _bands()
    spectra = np.empty((len(frames), BANDS))
    for start in range(0, len(frames), 1000):  # in blocks, to bound memory
        block = slice(start, start + 1000)
        spectra[block] = (np.abs(np.fft.rfft(frames[block] * window, SIZE)) ** 2) @ bands
    return spectra


def _bands() -> Floats:
    """Return triangular filters of equal area, evenly spaced in mel: (257, `BANDS`)."""
    low, high = (2595 * np.log10(1 + hertz / 700) for hertz in (LOWEST, HIGHEST))
    edges = 700 * (10 ** (np.linspace(low, high, BANDS + 2) / 2595) - 1)
    spacing = RATE / SIZE
    edges = np.floor(edges / spacing + 0.5) * spacing
    hertz = np.arange(SIZE // 2 + 1)[:, None] * spacing
    left, middle, right = edges[:-2], edges[1:-1], edges[2:]
    rising = (hertz - left) / (middle - left)
    falling = (right - hertz) / (right - middle)
    height = 2 / (right - left)
    shape: Floats = np.clip(np.minimum(rising, falling), 0, None) * height
    return shape


def _quieted(spectra: Floats) -> Floats:
    """Subtract slowly varying noise from each band, tracked over frames."""
    quieted = np.empty_like(spectra)
    power = spectra[0].copy()
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
        peak = 0.85 * peak
        heard = signal
        signal = np.where(signal < 0.85 * peak, 0.2 * peak, signal)
        peak = np.maximum(peak, heard)
        signal = np.maximum(signal, floor)
        gain = np.clip(signal / np.maximum(power, 1e-300), 1 / 20, 20)
        whole = np.concatenate([[0.0], np.cumsum(gain)])
        quieted[number] = here * (whole[last] - whole[first]) / (last - first)
    return quieted


def _envelope(values: Floats, below: Floats) -> Floats:
    """Track the lower envelope of values: slow rise, fast fall."""
    slow = np.where(values >= below, 0.995, 0.5)
    return slow * below + (1 - slow) * values


def _cepstra(spectra: Floats) -> Floats:
    """Return the cepstra of spectra: (T, `CEPSTRA`)."""
    order = np.arange(CEPSTRA)[:, None]
    waves = np.cos(np.pi * order * (np.arange(BANDS) + 0.5) / BANDS) * np.sqrt(2 / BANDS)
    waves[0] = np.sqrt(1 / BANDS)
    lifter = 1 + LIFTER / 2 * np.sin(np.pi * np.arange(CEPSTRA) / LIFTER)
    cepstra: Floats = (np.log(spectra + 1e-4) @ waves.T) * lifter
    return cepstra
