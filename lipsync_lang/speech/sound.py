"""Recordings: read from files of any usual form, and brought to another rate."""

from math import gcd
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lipsync_lang.errors import SpeechError
from lipsync_lang.schedules.schedule import Audio

if TYPE_CHECKING:
    from types import ModuleType

SLOWEST, FASTEST = 8_000, 192_000
"""Samples per second; speech needs the one, and nothing records with more than the other."""

LONGEST = 7_200.0
"""Seconds: two hours."""

MAX_SAMPLES = 7_200 * 48_000
"""Samples of a channel; a small file of silence may unpack to any number."""

FLAC_SAMPLES_PER_BYTE = 8_192
"""Samples that a byte may hold: FLAC, which packs silence best, needs 11 bytes for 65,535."""

SAMPLES_PER_BYTE = {"MP3": 64}
"""The same of other formats: the slowest MP3 has 24; damaged ones state any length."""

MAX_CHANNELS = 64
"""Channels of a recording; no microphone for faces has as many."""

BLOCK = 1 << 20
"""Samples of all channels that are read at a time."""

LOUDEST = 2.0**16
"""Of a sample; damaged files hold floats whose sum is infinite."""

OPEN = 0x7FFF_0000
"""Bytes; a size from here on is what programs state that do not know it yet."""

FULL = 32_768
"""The int16 beyond full scale."""


def read_audio(path: str | Path) -> Audio:
    """Read a recording: WAV, FLAC, OGG, MP3 and what else libsndfile knows, mixed down to mono.

    Raises
    ------
    SpeechError
        It is missing, no sound, cut short, empty, too long or of an odd rate; or soundfile is
        missing.
    """
    soundfile = _soundfile()
    try:
        # libsndfile seeks in the file itself: through a Python stream, a header that points before
        # the start of the file prints a traceback.
        with Path(path).open("rb") as stream:
            if not stream.seekable():
                raise SpeechError(f"{path}: is a pipe; put the recording into a file first")
            with soundfile.SoundFile(stream.fileno(), closefd=False) as sound:
                return _read(path, sound)
    except OSError as error:
        raise SpeechError(
            f"{path}: cannot be read: {error.strerror or error}; check the path"
        ) from None
    except soundfile.LibsndfileError as error:
        raise SpeechError(
            f"{path}: no sound that can be read ({error.error_string}); "
            "save it as WAV, FLAC, OGG or MP3"
        ) from None


def _read(path: str | Path, sound: Any) -> Audio:
    rate = sound.samplerate
    if not SLOWEST <= rate <= FASTEST:
        raise SpeechError(
            f"{path}: {rate} samples per second; speech needs {SLOWEST} to {FASTEST}: resample it"
        )
    if sound.frames > LONGEST * rate:
        raise SpeechError(
            f"{path}: lasts {sound.frames / rate / 60:.0f} minutes, and {LONGEST / 60:.0f} are the "
            "most; cut it into lines"
        )
    stated, size = sound.frames, Path(path).stat().st_size
    if stated > SAMPLES_PER_BYTE.get(sound.format, FLAC_SAMPLES_PER_BYTE) * size:
        raise SpeechError(f"{path}: states {stated:,} samples in {size:,} bytes; save it anew")
    if sound.frames > MAX_SAMPLES or sound.channels > MAX_CHANNELS:
        raise SpeechError(
            f"{path}: has {sound.frames:,} samples on {sound.channels} channels, and "
            f"{MAX_SAMPLES:,} on {MAX_CHANNELS} are the most; resample it to 48000 Hz, mono"
        )
    blocks = [
        _mono(block)
        for block in sound.blocks(BLOCK // sound.channels, dtype="float32", always_2d=True)
        if len(block)
    ]
    count = sum(map(len, blocks))
    if count == 0:
        raise SpeechError(f"{path}: holds no sound; record it anew")
    if count < sound.frames or _cut_short(sound):
        raise SpeechError(
            f"{path}: ends after {count / rate:.2f} s, before its own header says it does; "
            "copy or save it anew"
        )
    return Audio(np.concatenate(blocks), rate)


def _mono(block: npt.NDArray[np.float32]) -> npt.NDArray[np.int16]:
    """Mix channels (N, C) from -1 to 1 down to int16."""
    sound = np.clip(np.nan_to_num(block), -LOUDEST, LOUDEST)
    return _whole(sound.mean(axis=1) * FULL)


def _whole(samples: npt.NDArray[np.float32]) -> npt.NDArray[np.int16]:
    """Return the nearest int16; what is louder than any is cut off."""
    whole: npt.NDArray[np.int16] = np.clip(np.rint(samples), -FULL, FULL - 1).astype(np.int16)
    return whole


def _cut_short(sound: Any) -> bool:
    """Tell whether a file lacks sound that its header states; a header that states all is open.

    libsndfile believes the file rather than the header, and says so in its log only.
    """
    for line in sound.extra_info.splitlines():
        chunk, _, sizes = line.partition(":")
        stated, corrected, there = sizes.partition("(should be")
        if chunk.strip() in ("data", "SSND") and corrected:
            return int(there.strip(" )")) < int(stated) < OPEN
    return False


def resampled(audio: Audio, rate: int) -> Audio:
    """Return a sound at another rate, as long as it was to one sample.

    Raises
    ------
    SpeechError
        scipy is missing.
    """
    if audio.rate == rate:
        return audio
    try:
        from scipy.signal import resample_poly
    except ImportError:
        raise SpeechError(_missing("scipy")) from None
    common = gcd(audio.rate, rate)
    samples = resample_poly(audio.samples.astype(np.float32), rate // common, audio.rate // common)
    return Audio(_whole(samples), rate)


def _soundfile() -> "ModuleType":
    try:
        import soundfile
    except (ImportError, OSError):  # without its library it is not to be imported either
        raise SpeechError(_missing("soundfile")) from None
    module: ModuleType = soundfile
    return module


def _missing(name: str) -> str:
    return (
        f"recordings need {name}, which is not installed; "
        'get it with: pip install "lipsync-lang[audio]"'
    )
