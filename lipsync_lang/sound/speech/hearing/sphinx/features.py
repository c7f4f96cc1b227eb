"""Acoustic features: cepstra of a sound and their time derivatives.

Processing steps and constants match the training of the CMU Sphinx models.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import chain, pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.schedules.schedule import Audio
from lipsync_lang.sound.speech.sound import SPEECH_RATE, resampled_blocks

PEAK_AMPLITUDE = 16_000.0
"""Peak amplitude after normalisation, for independence from loudness."""

HISS_DEVIATION = 3.0
"""Standard deviation of added noise, so that digital silence has the features of silence."""

HOP_SAMPLES = 160
"""Frame step in samples."""

FRAME_SECONDS = HOP_SAMPLES / SPEECH_RATE
"""Frame step in seconds."""

SECTION_FRAMES = 20_000
"""Frames of a long sound that are measured at once, to bound memory: 200 s."""

WINDOW_SAMPLES = 410
"""Frame window in samples."""

EVEN_STEPS = 1024
"""Steps of 1 to which features, log likelihoods and boundaries in frames are rounded.

Processors add in different orders. Their results differ far less, and are equal once rounded.
"""

FFT_POINTS = 512
"""Size of the Fourier transform."""

PRE_EMPHASIS = 0.97

CEPSTRA = 13

DELTA_FRAMES = 3
"""Frames on each side of a frame on which its derivatives depend."""

QUIET_PERCENT = 10
"""Percentage of the frames of a whole sound, the quietest ones, that are its steady noise."""

CLEAR_RATIO = 100.0
"""Power of a sound relative to that noise (20 dB) from which it stays as it is."""

NOTHING_ELSE_RATIO = 1.5
"""Power relative to that noise (2 dB) below which a sound is noise and nothing else."""

LEAST_BAND_GAIN = 0.25
"""Minimum gain of a band; noise is attenuated no further, because it may be a voice."""

PAUSE_RATIO = 1e-3
"""Power of a pause relative to the loudest frame (-30 dB), if the noise is no louder."""

PAUSE_SHARE = 0.3
"""Maximum share of pauses in the mean of a sound's cepstra.

With all of them, long pauses would make a voice far louder than those of the models' training.
"""

HELD_FRAMES = 3
"""Frames at each end of a held sound that count; those between them only repeat them."""

HELD_SHARE, HELD_RANGE = 0.4, 30.0
"""Greatest change in a held sound over 4 frames, relative to the mean deviation of the cepstra, and
its loudness (the first cepstrum) below that of the loudest frame.

The change of speech is 0.6 to 1.2 in the median, that of held notes 0.2.
"""

GAIN_FRAMES = 2
"""Frames on each side of a frame on whose mean power its gain depends."""

STEADY_FRAMES, STEADY_DEVIATION = 50, 0.45
"""Frames over which the logarithms of the bands hardly change in a steady noise, and their greatest
mean standard deviation. White noise and hum have 0.36 at most, voices and music 0.6 or more."""

MIN_NOISE_FRAMES = 100
"""Fewest frames of a loud steady noise beside a voice."""


@dataclass(frozen=True)
class PreparedSound:
    """A sound as models hear it: `SPEECH_RATE`, normalised peak, added noise.

    It makes its samples in blocks each time that it is read: those of an hour take 460 MB.

    Parameters
    ----------
    gain : factor of its samples
    first, stop : the samples that count, at `SPEECH_RATE`
    """

    audio: Audio
    gain: float
    first: int
    stop: int

    @classmethod
    def of(cls, audio: Audio) -> "PreparedSound":
        """Prepare a sound."""
        blocks = resampled_blocks(audio, SPEECH_RATE)
        peak = max(max(int(one.max(initial=0)), -int(one.min(initial=0))) for one in blocks)
        count = -(-len(audio.samples) * SPEECH_RATE // audio.rate)
        return cls(audio, PEAK_AMPLITUDE / peak if peak else 1.0, 0, count)

    def part(self, first: int, stop: int) -> "PreparedSound":
        """Return some of its frames."""
        first, stop = (self.first + one * HOP_SAMPLES for one in (first, stop))
        return replace(self, first=first, stop=min(stop, self.stop))

    def __len__(self) -> int:
        return self.stop - self.first

    def __iter__(self) -> Iterator[Floats]:
        """Yield its samples in blocks."""
        # A fixed seed: the same sound must always give the same schedule.
        hiss, at = np.random.default_rng(0), 0
        for block in resampled_blocks(self.audio, SPEECH_RATE):
            made = block.astype(np.float64) * self.gain
            made += hiss.normal(0.0, HISS_DEVIATION, len(block))
            yield made[max(self.first - at, 0) : max(self.stop - at, 0)]
            at += len(block)

    def samples(self) -> Floats:
        """Return all its samples."""
        found, at = np.empty(len(self)), 0
        for block in self:
            found[at : (at := at + len(block))] = block
        return found


@dataclass(frozen=True, eq=False)
class HeardFrames:
    """Features of the frames of a sound, of which some are derived at a time.

    Parameters
    ----------
    wide : of each frame, in streams; cepstra alone with those `beside` a frame on each side
    starts : frames of the sound at which each begins, and its end; None for every frame
    words_alone : True if no other sound stands beside or between the words
    """

    wide: Floats
    beside: int = 0
    starts: Ints | None = None
    words_alone: bool = False

    def __len__(self) -> int:
        return len(self.wide) - 2 * self.beside

    def __getitem__(self, span: slice) -> Floats:
        first, stop, _ = span.indices(len(self))
        found = self.wide[first : max(first, stop) + 2 * self.beside]
        return derived(found[:, 0]) if self.beside else found

    def changing(self) -> "HeardFrames":
        """Return the frames without the middles of held sounds."""
        kept = np.flatnonzero(changing(self.first_stream()))
        end = len(self) + self.beside
        if len(kept) == len(self):
            return self
        rows = [*range(self.beside), *(kept + self.beside), *range(end, len(self.wide))]
        return replace(self, wide=self.wide[rows], starts=np.append(kept, len(self)))

    def first_stream(self) -> Floats:
        """Return the first stream, (T, values): in that of a frame, the loudness comes first."""
        return self.wide[self.beside : self.beside + len(self), 0]


class FrontEnd(ABC):
    """Extraction of a model's features from samples at `SPEECH_RATE`."""

    @abstractmethod
    def __call__(self, samples: Floats) -> Floats:
        """Return the features of each frame of a sound: (T, streams, values) or another shape."""

    def hearings(self, sound: Iterable[Floats]) -> Iterator[HeardFrames]:
        """Yield the features of a sound in blocks, and others that may fit better."""
        yield HeardFrames(self(np.concatenate([*sound])))


@dataclass(frozen=True)
class SphinxFrontEnd(FrontEnd):
    """Settings of features; the defaults serve a model that states none.

    Parameters
    ----------
    bands, lowest, highest : number of mel bands, and their limits in hertz
    transform : of the bands' logarithms to cepstra: `legacy`, `dct` or `htk`
    lifter : weight of high cepstra, 0 for none
    quieted : True for the subtraction of noise from each band
    """

    bands: int = 40
    lowest: float = 133.33334
    highest: float = 6855.4976
    transform: str = "legacy"
    lifter: int = 0
    quieted: bool = False

    def __call__(self, samples: Floats) -> Floats:
        """Return cepstra less their mean, and two derivatives: (N / `HOP_SAMPLES`, 3, 13)."""
        return next(self.hearings([samples]))[:]

    def hearings(self, sound: Iterable[Floats]) -> Iterator[HeardFrames]:
        """Yield the features of a sound, and those with less noise if it has a steady one.

        Less noise keeps words of a foreign language in their place; where music stops and starts,
        it costs more of the voice than of the music. The alignment tells what fits better.
        """
        spectra = CepstralFrames(self).last(sound)
        loud = spectra.sum(axis=1)
        noise = spectra[loud <= np.percentile(loud, QUIET_PERCENT)].mean(axis=0)
        noisy = NOTHING_ELSE_RATIO <= loud.mean() / max(noise.sum(), 1e-9) <= CLEAR_RATIO
        found = [self._normalised(spectra, less) for less in (None, noise)[: 1 + noisy]]
        del spectra  # an hour of them takes 72 MB
        yield from found

    def _normalised(self, spectra: Floats, noise: Floats | None) -> HeardFrames:
        """Return the features of a whole sound from the power of its bands, less a steady noise."""
        frames, found = CepstralFrames(self), []
        for start in range(0, len(spectra), SECTION_FRAMES):
            here = spectra[start : start + SECTION_FRAMES]
            if noise is not None:
                # A Wiener filter, of the whole sound: `_BandNoise` follows one that is not over.
                early = min(start, GAIN_FRAMES)
                around = _smoothed(spectra[start - early : start + len(here) + GAIN_FRAMES])
                gain = 1 - noise / np.maximum(around[early : early + len(here)], 1e-9)
                here = here * np.maximum(gain, LEAST_BAND_GAIN) ** 2
            found.append((frames.cepstra(here), here.sum(axis=1)))
        cepstra, power = (np.concatenate(parts) for parts in zip(*found, strict=True))
        cepstra -= voice_mean(cepstra, power)
        wide = np.pad(cepstra, ((DELTA_FRAMES, DELTA_FRAMES), (0, 0)), mode="edge")
        return HeardFrames(wide[:, None], DELTA_FRAMES)


features = SphinxFrontEnd(25, 130.0, 6800.0, "dct", 22, quieted=True)
"""The front end of the model that hears every language."""


def _smoothed(values: Floats) -> Floats:
    """Return the moving mean of the values of frames, (T, V)."""
    wide = np.pad(values, ((GAIN_FRAMES, GAIN_FRAMES), (0, 0)), mode="edge")
    return sliding_window_view(wide, 2 * GAIN_FRAMES + 1, axis=0).mean(axis=-1)


def voice_span(sound: Iterable[Floats], count: int) -> tuple[int, int]:
    """Return the first of a sound's frames and the end, less steady noise before and after a voice.

    Such a noise is no voice, though words of a language that the model hears badly fit it well.
    """
    if count < MIN_NOISE_FRAMES:
        return 0, count
    frames, kept, at = CepstralFrames(SphinxFrontEnd()), np.zeros((0, SphinxFrontEnd.bands)), 0
    power, steady = np.zeros(count), np.zeros(count, bool)
    for spectra, later in pairwise(chain(map(frames.spectra, sound), [kept])):
        # The first frame is smoothed with those before it, and the last span with those after it.
        around = np.concatenate([kept, spectra, later[: STEADY_FRAMES + GAIN_FRAMES]])
        logs = _smoothed(np.log(around + 1e-4))[len(kept) :]
        sums = np.cumsum(np.pad([logs, logs**2], ((0, 0), (1, 0), (0, 0))), axis=1)
        mean, square = (sums[:, STEADY_FRAMES:] - sums[:, :-STEADY_FRAMES]) / STEADY_FRAMES
        calm = np.sqrt(np.maximum(square - mean**2, 0)).mean(axis=1) < STEADY_DEVIATION
        for first in at + np.flatnonzero(calm[: len(spectra)]):
            steady[first : first + STEADY_FRAMES] = True
        power[at : at + len(spectra)] = spectra.sum(axis=1)
        kept, at = spectra[-GAIN_FRAMES:], at + len(spectra)
    # The last frame that `last` fills up with zeros is no steady noise.
    power, steady = power[:at], steady[:at]
    changing = np.flatnonzero(~steady)
    if not len(changing):
        return 0, count
    noise = steady & (power > PAUSE_RATIO * power.max())
    before, after = (int(one) for one in (changing[0], changing[-1] + 1))
    return (
        before if noise[:before].sum() >= MIN_NOISE_FRAMES else 0,
        after if noise[after:].sum() >= MIN_NOISE_FRAMES else count,
    )


def voice_mean(cepstra: Floats, power: Floats) -> Floats:
    """Return the mean of cepstra, (T, V), in which pauses have a limited share: (V,).

    A microphone adds a constant to the logarithm of each band, which the mean takes away
    (cepstral mean normalisation). The power of each frame, (T,), tells pauses from the voice.
    """
    own = changing(cepstra)
    noise = np.percentile(power[own], QUIET_PERCENT)
    quiet = own & (power < max(NOTHING_ELSE_RATIO * noise, PAUSE_RATIO * power.max()))
    # A steady sound, such as a held vowel, is all as loud as its noise: no part of it is a pause.
    voiced = int((own & ~quiet).sum()) or len(quiet)
    most = PAUSE_SHARE / (1 - PAUSE_SHARE) * voiced / max(int(quiet.sum()), 1)
    weights = own * np.where(quiet, min(most, 1.0), 1.0)
    return np.average(cepstra, axis=0, weights=weights)


def changing(cepstra: Floats) -> Bools:
    """Return False for the frames in the middles of held vowels and tones: (T,).

    These repeat one piece of evidence. A vowel that a model hears badly would be unlikelier with
    each of them, until a pause or other sound took its place.
    """
    change, deviation = np.zeros(len(cepstra)), 0.0
    for one in cepstra.T:  # one by one, to bound memory
        wide = np.pad(one, 2, mode="edge")
        change += np.abs(wide[4:] - wide[:-4])
        deviation += np.abs(one - one.mean()).mean()
    held = change < HELD_SHARE * deviation
    held &= cepstra[:, 0] > cepstra[:, 0].max() - HELD_RANGE
    around = sliding_window_view(np.pad(held, HELD_FRAMES), 2 * HELD_FRAMES + 1)
    return np.asarray(~around.all(axis=1))


def derived(wide: Floats) -> Floats:
    """Return cepstra, (T + 2 `DELTA_FRAMES`, 13), with their derivatives: (T, 3, 13)."""
    count = len(wide) - 2 * DELTA_FRAMES

    def at(later: int) -> Floats:
        return wide[DELTA_FRAMES + later : DELTA_FRAMES + later + count]

    # The decoder of the models takes these differences over 4 and 6 frames, without the usual
    # weights: other derivatives fit none of their Gaussians.
    change, turn = at(2) - at(-2), (at(3) - at(-1)) - (at(1) - at(-3))
    return np.stack([at(0), change, turn], axis=1)


class CepstralFrames:
    """Cepstra of a sound that arrives in parts, before any mean is taken away."""

    def __init__(self, settings: SphinxFrontEnd = features) -> None:
        self._settings = settings
        self._sound = np.zeros(0)
        self._before = 0.0
        self._noise: _BandNoise | None = None

    def push(self, samples: Floats) -> Floats:
        """Return the cepstra of the frames that are complete with these samples: (k, 13)."""
        return self.cepstra(self.spectra(samples))

    def spectra(self, samples: Floats) -> Floats:
        """Return the power of each band in those frames: (k, bands)."""
        # Pre-emphasis, across the parts.
        earlier = np.concatenate([[self._before], samples])
        self._before = float(earlier[-1])
        sound = np.concatenate([self._sound, samples - PRE_EMPHASIS * earlier[:-1]])
        count = max((len(sound) - WINDOW_SAMPLES) // HOP_SAMPLES + 1, 0)
        self._sound = sound[count * HOP_SAMPLES :].copy()
        return _spectra(sound, count, self._settings)

    def cepstra(self, spectra: Floats) -> Floats:
        """Return the cepstra of the next frames, (k, 13), from the power of their bands."""
        if not len(spectra):
            return np.zeros((0, CEPSTRA))
        if self._settings.quieted:
            if self._noise is None:
                self._noise = _BandNoise(spectra[0])
            spectra = self._noise.quieted(spectra)
        return np.log(spectra + 1e-4) @ _cosines(self._settings).T

    def last(self, sound: Iterable[Floats]) -> Floats:
        """Return the power of the last frames: blocks of samples, filled up with zeros."""
        found = [self.spectra(block) for block in sound]
        # Ceiling division: the last frame may hold less sound than a hop.
        count = max(-(-len(self._sound) // HOP_SAMPLES), 1)
        missing = (count - 1) * HOP_SAMPLES + WINDOW_SAMPLES - len(self._sound)
        return np.concatenate([*found, self.spectra(np.zeros(missing))[:count]])


@cache
def _cosines(settings: SphinxFrontEnd) -> Floats:
    """Return the transform of bands to liftered cepstra: (`CEPSTRA`, bands)."""
    bands, lifter = settings.bands, settings.lifter
    order = np.arange(CEPSTRA)[:, None]
    waves = np.cos(np.pi * order * (np.arange(bands) + 0.5) / bands)
    if settings.transform == "legacy":
        waves /= bands
        waves[:, 0] /= 2  # the first band counts half
    else:
        waves *= np.sqrt(2 / bands)
        if settings.transform == "dct":  # unitary: the constant has another factor
            waves[0] = np.sqrt(1 / bands)
    if lifter:
        waves *= 1 + lifter / 2 * np.sin(np.pi * order / lifter)
    return waves


@cache
def _filters(settings: SphinxFrontEnd) -> tuple[Floats, Floats]:
    """Return the Hamming window of a frame, and the filter of each band."""
    window = 0.54 - 0.46 * np.cos(2 * np.pi * np.arange(WINDOW_SAMPLES) / (WINDOW_SAMPLES - 1))
    # the trainer gives all filters one area
    edges = band_edges(settings)
    return window, triangles(edges) * (2 / (edges[2:] - edges[:-2]))


def _spectra(sound: Floats, count: int, settings: SphinxFrontEnd) -> Floats:
    """Return the power of each band in some frames: (`count`, bands)."""
    window, bands = _filters(settings)
    starts, within = np.arange(count)[:, None] * HOP_SAMPLES, np.arange(WINDOW_SAMPLES)
    spectra = np.empty((count, settings.bands))
    for start in range(0, count, 1000):  # in blocks, to bound memory
        block = slice(start, start + 1000)
        frames = sound[starts[block] + within]
        spectra[block] = (np.abs(np.fft.rfft(frames * window, FFT_POINTS)) ** 2) @ bands
    return spectra


def band_edges(settings: SphinxFrontEnd) -> Floats:
    """Return the corners of bands in hertz, which the trainer rounds to bins of the spectrum."""
    spacing = SPEECH_RATE / FFT_POINTS
    corners = mel_edges(settings.lowest, settings.highest, settings.bands)
    return np.floor(corners / spacing + 0.5) * spacing


def mel_edges(lowest: float, highest: float, bands: int) -> Floats:
    """Return the corners of bands that are evenly spaced in mel, in hertz: (bands + 2,)."""
    low, high = (2595 * np.log10(1 + hertz / 700) for hertz in (lowest, highest))
    return 700 * (10 ** (np.linspace(low, high, bands + 2) / 2595) - 1)


def triangles(edges: Floats) -> Floats:
    """Return triangular filters between corners in hertz: (257, bands)."""
    hertz = np.arange(FFT_POINTS // 2 + 1)[:, None] * SPEECH_RATE / FFT_POINTS
    left, middle, right = edges[:-2], edges[1:-1], edges[2:]
    rising, falling = (hertz - left) / (middle - left), (right - hertz) / (right - middle)
    return np.maximum(0, np.minimum(rising, falling))


class _BandNoise:
    """Slowly varying noise in each band, tracked over frames."""

    def __init__(self, first: Floats) -> None:
        # The start of a sound counts as 13 dB above its noise, until the envelopes have settled.
        self._tracks = first, first / 20, first / 20, np.zeros(len(first))

    def quieted(self, spectra: Floats) -> Floats:
        """Subtract the noise from the next frames: (k, bands)."""
        powers, signals = np.empty_like(spectra), np.empty_like(spectra)
        power, noise, floor, peak = self._tracks
        for number, here in enumerate(spectra):
            powers[number] = power = 0.7 * power + 0.3 * here
            noise = _envelope(power, noise)
            signal = np.maximum(power - noise, 1.0)
            floor = _envelope(signal, floor)
            # Temporal masking: after a peak, a weaker sound is lowered to a share of the fading
            # peak (Kim and Stern 2016, power-normalized cepstra).
            peak = 0.85 * peak
            masked = np.where(signal < 0.85 * peak, 0.2 * peak, signal)
            peak = np.maximum(peak, signal)
            np.maximum(masked, floor, out=signals[number])
        self._tracks = power, noise, floor, peak
        gain = np.clip(signals / np.maximum(powers, 1e-300), 1 / 20, 20)
        # A moving mean over nine bands from differences of the running sum, which has a 0 in front.
        bands = np.arange(len(power))
        first, last = np.maximum(bands - 4, 0), np.minimum(bands + 5, len(power))
        whole = np.cumsum(np.pad(gain, ((0, 0), (1, 0))), axis=1)
        return spectra * (whole[:, last] - whole[:, first]) / (last - first)


def _envelope(values: Floats, below: Floats) -> Floats:
    """Track the lower envelope of values: slow rise, fast fall."""
    slow = np.where(values >= below, 0.995, 0.5)
    return slow * below + (1 - slow) * values
