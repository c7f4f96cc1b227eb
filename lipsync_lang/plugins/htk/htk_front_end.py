"""Features of HTK: mel-frequency cepstra with regression derivatives (HTK Book, chapter 5).

Windows are 25 ms, and frames 10 ms apart. The energy of a frame (`_E`) is left out: a model of
diagonal Gaussians is as good a model of the other features.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Self

import numpy as np

from lipsync_lang import SpeechError
from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.sound.speech.hearing.sphinx.features import HOP_SAMPLES, FrontEnd, voice_mean
from lipsync_lang.sound.speech.hearing.sphinx.folder import refused, same_value
from lipsync_lang.sound.speech.sound import SPEECH_RATE

FRAME_SAMPLES = 400
"""Frame window in samples."""

FFT_POINTS = 512
"""Size of the Fourier transform: the next power of two."""

CONFIG = "config"
"""The file of HTK's settings beside a model."""

FIXED_SETTINGS: Mapping[str, tuple[str, ...]] = MappingProxyType({
    "SOURCERATE": ("625",), "TARGETRATE": ("100000",), "WINDOWSIZE": ("250000",),
    "USEHAMMING": ("T", "TRUE"), "DELTAWINDOW": ("2",), "ACCWINDOW": ("2",), "NUMCEPS": ("12",),
    "USESILDET": ("F", "FALSE"), "SIMPLEDIFFS": ("F", "FALSE"), "DOUBLEFFT": ("F", "FALSE"),
    "WARPFREQ": ("1",), "ADDDITHER": ("0",),
})  # fmt: skip
"""Settings that the features cannot follow, with the values that they have."""

FOLLOWED_SETTINGS = ("NUMCHANS", "CEPLIFTER", "PREEMCOEF", "LOFREQ", "HIFREQ", "USEPOWER",
                     "ZMEANSOURCE")  # fmt: skip

INERT_SETTINGS = frozenset({
    "TARGETKIND", "SOURCEKIND", "SOURCEFORMAT", "TARGETFORMAT", "SAVECOMPRESSED", "SAVEWITHCRC",
    "ENORMALISE", "ESCALE", "SILFLOOR", "BYTEORDER", "NATURALREADORDER", "NATURALWRITEORDER",
    "LPCORDER", "ALLOWCXTEXP", "FORCECXTEXP", "ALLOWXWRDEXP", "MAXTRYOPEN", "TRACE",
})  # fmt: skip
"""Settings that no kept feature depends on."""

CEPSTRA_OF_KIND = 12
"""Cepstra after the first one, `_0`."""

ENERGY = -1
"""Number in place of a feature, for the energy."""


@dataclass(frozen=True)
class HtkFrontEnd(FrontEnd):
    """Settings of features.

    Parameters
    ----------
    kept : numbers of the kept features among cepstra 1 to 12 and 0, then their first and second
        derivatives in the same order
    bands, lowest, highest : number of mel bands, and their limits in hertz
    """

    kept: tuple[int, ...]
    bands: int
    lowest: float = 0.0
    highest: float = SPEECH_RATE / 2
    lifter: int = 22
    emphasis: float = 0.97
    power: bool = False
    centred: bool = False

    @classmethod
    def of(cls, kept: tuple[int, ...], path: Path) -> Self:
        """Read the settings beside a model; one that cannot be followed is a `SpeechError`."""
        try:
            text = path.read_text("utf-8")
        except OSError:
            raise SpeechError(
                f"{path}: is missing: HTK keeps the settings of features there; ask the model's "
                "authors for theirs, such as NUMCHANS = 26 and CEPLIFTER = 22, one a line"
            ) from None
        lines = (line.partition("#")[0].partition("=") for line in text.splitlines())
        stated = {k.rpartition(":")[2].strip().upper(): v.strip() for k, sign, v in lines if sign}
        for name, value in stated.items():
            fixed = FIXED_SETTINGS.get(name)
            if fixed is not None and not same_value(value.upper(), fixed):
                raise refused(path, f"{name} = {value}", f"the features have {fixed[0]}")
            if fixed is None and name not in {*FOLLOWED_SETTINGS, *INERT_SETTINGS}:
                raise refused(path, name, "this setting is unknown")
        power, centred = (
            stated.get(name, "F")[:1].upper() == "T" for name in ("USEPOWER", "ZMEANSOURCE")
        )
        try:
            low, high = (float(stated.get(name, -1)) for name in ("LOFREQ", "HIFREQ"))
            return cls(
                kept, int(stated.get("NUMCHANS", 20)), max(low, 0.0),
                high if high > 0 else cls.highest, int(stated.get("CEPLIFTER", 22)),
                float(stated.get("PREEMCOEF", 0.97)), power, centred,
            )  # fmt: skip
        except ValueError as error:
            raise SpeechError(f"{path}: {error}; mend the number") from None

    def __call__(self, samples: Floats) -> Floats:
        """Return the features of each frame of a sound at `SPEECH_RATE`: (T, 1, kept)."""
        count = max(-(-len(samples) // HOP_SAMPLES), 1)
        whole = np.pad(samples, (0, max(FRAME_SAMPLES - len(samples), 0)))
        starts = np.arange((len(whole) - FRAME_SAMPLES) // HOP_SAMPLES + 1) * HOP_SAMPLES
        blocks = [starts[at : at + 1000] for at in range(0, len(starts), 1000)]
        cepstra = np.concatenate([self.cepstra_at(whole, block) for block in blocks])
        energy = np.cumsum(np.pad(whole**2, (1, 0)))
        cepstra -= voice_mean(cepstra, energy[starts + FRAME_SAMPLES] - energy[starts])
        # a window that the end of the sound cuts off has no features: those of the last stand in
        cepstra = np.pad(cepstra, ((0, count - len(cepstra)), (0, 0)), mode="edge")
        change = regression(cepstra)
        found = np.hstack([cepstra, change, regression(change)])
        return found[:, None, list(self.kept)]

    def cepstra_at(self, sound: Floats, starts: Ints) -> Floats:
        """Return cepstra 1 to 12 and 0 of the frames that start at some samples: (k, 13)."""
        frames = sound[starts[:, None] + np.arange(FRAME_SAMPLES)]
        if self.centred:
            frames = frames - frames.mean(axis=1, keepdims=True)
        # HTK emphasises each window apart, and its first sample against itself.
        before = np.hstack([frames[:, :1], frames[:, :-1]])
        window = np.hamming(FRAME_SAMPLES)
        spectrum = np.abs(np.fft.rfft((frames - self.emphasis * before) * window, FFT_POINTS))
        bands = (spectrum**2 if self.power else spectrum) @ mel_filters(self)
        order = np.array([*range(1, CEPSTRA_OF_KIND + 1), 0])
        waves = np.cos(np.pi * np.outer(np.arange(self.bands) + 0.5, order) / self.bands)
        lifted = 1 + (self.lifter / 2 * np.sin(np.pi * order / self.lifter) if self.lifter else 0)
        # HTK's own floor of a band; samples count to 32,768.
        found: Floats = np.log(np.maximum(bands, 1)) @ waves * np.sqrt(2 / self.bands) * lifted
        return found


@cache
def mel_filters(settings: HtkFrontEnd) -> Floats:
    """Return filters that are triangles in mel, not in hertz: (257, bands)."""
    mel = 1127 * np.log(1 + np.arange(FFT_POINTS // 2 + 1) * SPEECH_RATE / FFT_POINTS / 700)
    low, high = (1127 * np.log(1 + hz / 700) for hz in (settings.lowest, settings.highest))
    edges = np.linspace(low, high, settings.bands + 2)
    rising, falling = (mel[:, None] - edges[:-2]), (edges[2:] - mel[:, None])
    found: Floats = np.maximum(0, np.minimum(rising, falling)) / (edges[1] - edges[0])
    return found


def regression(values: Floats) -> Floats:
    """Return derivatives over two frames on each side: (T, V).

    As HTK has them::

        d[t] = sum of n (c[t + n] - c[t - n]) / 10   for n in 1, 2
    """
    wide = np.pad(values, ((2, 2), (0, 0)), mode="edge")
    found: Floats = (wide[3:-1] - wide[1:-3] + 2 * (wide[4:] - wide[:-4])) / 10
    return found


def kept_features(kind: str, size: int, path: Path) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return which numbers of a vector are kept, and which features of `HtkFrontEnd` they are.

    A target kind that is not computed here is a `SpeechError`.
    """
    base, *marks = re.sub(r"[<>]", "", kind).upper().split("_")
    # These two say how a file of features is packed.
    own = {*marks} - {"C", "K"}
    if base != "MFCC" or own - {*"0EDANZ"}:
        raise refused(path, f"<{kind}>", "the features are MFCC with _0 _E _D _A _N _Z")
    if "Z" not in own:
        raise refused(path, f"<{kind}>", "without _Z a model knows one microphone alone")
    cepstra = [*range(CEPSTRA_OF_KIND)] + ([CEPSTRA_OF_KIND] if "0" in own else [])
    part = [*cepstra, *([ENERGY] if "E" in own else [])]
    # `_N` leaves out energy and c0 themselves, but keeps their derivatives.
    rows = [*part] if "N" not in own else [*range(CEPSTRA_OF_KIND)]
    for order in range(1, 1 + ("D" in own) + ("A" in own)):
        rows += [one + 13 * order if one != ENERGY else one for one in part]
    if len(rows) != size:
        raise refused(path, f"<VECSIZE> {size}", f"<{kind}> has {len(rows)} numbers")
    kept = [number for number, one in enumerate(rows) if one != ENERGY]
    return tuple(kept), tuple(rows[number] for number in kept)
