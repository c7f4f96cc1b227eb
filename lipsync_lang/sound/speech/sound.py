"""Audio input: decoding of common file formats, and resampling."""

import os
import re
import shutil
import struct
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from io import RawIOBase
from math import gcd
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.base.extras import install_line
from lipsync_lang.schedules.schedule import Audio, Schedule
from lipsync_lang.sound.speech.decoding import SOUND_HEAD_BYTES, compression, decoded, tag_bytes

MAX_CHUNKS = 1000
"""Chunks of a WAV file to skip."""

FORM_BYTES = 16
"""Minimum size of the chunk that states rate and channels."""

SURPLUS_SECONDS = 0.1
"""Tolerated sound after the stated end, where some programs write tags."""

AUDIO_SUFFIXES = (
    *(".wav", ".flac", ".ogg", ".opus", ".mp3"),
    *(".m4a", ".aac", ".mp4", ".mov", ".webm"),  # ffmpeg decodes them
)
"""Suffixes of recordings, the most likely first."""

PLACEHOLDER_BYTES = 0x7FFF_0000
"""Minimum placeholder size, written by streaming programs in place of the unknown size."""

SPEECH_RATE = 16_000
"""Samples per second at which models and aligners hear speech."""

SLOWEST, FASTEST = 8_000, 192_000
"""Permitted sample rates in hertz, lowest and highest."""

MAX_SOUND_SECONDS = 7_200.0
"""Maximum duration in seconds: two hours."""

MAX_SAMPLES = 7_200 * 48_000
"""Maximum samples per channel; small files of silence can expand enormously."""

FLAC_SAMPLES_PER_BYTE = 8_192
"""Maximum samples per byte in FLAC, the densest for silence: 65,535 samples take 11 bytes."""

SAMPLES_PER_BYTE = {"MP3": 64}
"""Maximum samples per byte in other formats; MP3 has up to 24, damaged headers claim more."""

MAX_CHANNELS = 64
"""Maximum number of channels."""

MP3, MP3_SLACK = "MP3", 2 * 1152
"""Format whose header may count the padding of its frames as samples."""

BLOCK_SAMPLES = 1 << 20
"""Block size of reading, in samples over all channels."""

MIN_MIX_POWER = 0.05
"""Minimum power of a mix, as a share of that of its channels; reversed channels cancel out."""

MAX_AMPLITUDE = 2.0**16
"""Amplitude limit of a sample; damaged files hold floats with infinite sums."""

INT16_FULL_SCALE = 32_768
"""Magnitude of int16 full scale."""

_CORRECTED_SIZE = re.compile(
    r"^\s*(?:data|SSND)\s*:\s*(\d+)\s*\(should be\s*(\d+)\s*\)", re.MULTILINE
)

LATE_SECONDS = 0.1
"""Tolerated excess of a schedule over its sound, without a remark."""


SoundSource = str | Path | Audio
"""A sound, or a file of it."""


def unread(path: Path, reason: str) -> str:
    """Describe an unreadable file, and its remedy.

    Parameters
    ----------
    reason : libsndfile's own
    """
    with path.open("rb") as stream:
        head = stream.read(SOUND_HEAD_BYTES)
    if not head:
        return "the file is empty); copy or record it again"
    with suppress(UnicodeDecodeError):
        text = head[: SOUND_HEAD_BYTES - 4].decode(
            "utf-8", "strict" if len(head) < SOUND_HEAD_BYTES else "ignore"
        )
        if "\ufffd" not in text and all(c.isprintable() or c in "\t\r\n\ufeff" for c in text):
            return "the file contains text); give the recording itself"
    return f"{reason}); save it as WAV, FLAC, OGG or MP3"


def surplus_seconds(stream: RawIOBase) -> float:
    """Return the length of the sound in a WAV file after the end that its header states.

    A recorder that crashed leaves such a header. Chunks of other programs may follow the sound.
    """
    head = _bytes(stream, 0, 12)
    if head[:4] != b"RIFF" or head[8:] != b"WAVE":
        return 0.0
    size = stream.seek(0, 2)
    at, bytes_per_second, sounding = 12, 0, False
    for _ in range(MAX_CHUNKS):
        name, length = _chunk(stream, at)
        inside = at + 8 + length <= size
        if sounding and not (inside and is_name(name)):
            rest = (size - at) / bytes_per_second if bytes_per_second else 0.0
            return rest if at < size and rest > SURPLUS_SECONDS else 0.0
        if not inside or (name == b"data" and length >= PLACEHOLDER_BYTES):
            return 0.0
        if name == b"fmt " and length >= FORM_BYTES:
            bytes_per_second = struct.unpack("<I", _bytes(stream, at + 16, 4))[0]
        sounding = sounding or name == b"data"
        at += 8 + length
        if length % 2 and not is_name(_chunk(stream, at)[0]):
            at += 1  # some programs leave the padding out
    return 0.0


def _bytes(stream: RawIOBase, at: int, count: int) -> bytes:
    stream.seek(at)
    return (stream.read(count) or b"").ljust(count, b"\0")


def _chunk(stream: RawIOBase, at: int) -> tuple[bytes, int]:
    name, length = struct.unpack("<4sI", _bytes(stream, at, 8))
    return name, length


def is_name(name: bytes) -> bool:
    """Return True if bytes can be the name of a chunk."""
    return all(0x20 <= code < 0x7F for code in name)  # noqa: PLR2004 printable ASCII


def sound_of(source: SoundSource) -> Audio:
    """Return a sound; read it, if it is a file. One without samples is an error."""
    if isinstance(source, Audio) and not len(source.samples):
        raise SpeechError("the recording has no sound; record it again")
    return source if isinstance(source, Audio) else read_audio(source)


def read_audio(path: str | Path, channel: int | None = None) -> Audio:
    """Read a recording in a format of libsndfile (WAV, FLAC, OGG, Opus, MP3) or of ffmpeg.

    ffmpeg, where it is installed, decodes the first sound of MPEG-4, WebM and the like (.m4a, .aac,
    .mp4, .mov, .webm), in a process of its own.

    Parameters
    ----------
    channel : the channel to take, counted from 1; None to mix all down to mono. Channels that
        cancel each other out are not mixed: then the loudest is taken

    Raises
    ------
    SpeechError
        The file is missing, not audio, truncated, empty, too long or of an unsupported rate; it
        lacks the channel; or soundfile, or the ffmpeg that a file needs, is missing.

    Examples
    --------
    >>> _ = ll.resolve("english", "facefx").perform(ll.speak("map", "english")).save("map.wav")
    >>> ll.read_audio("map.wav").rate
    22050
    """
    try:
        import soundfile
    except (ImportError, OSError):  # OSError: the shared library of the package is missing
        what = "recordings need soundfile, which is not installed"
        raise SpeechError(f"{what}; get it with: {install_line('audio')}") from None
    path = Path(path)
    try:
        found = compression(path) if path.is_file() else None
        if found is None:
            return _read_file(path, channel)
        with decoded(path, found) as wav:
            try:
                return _read_file(wav, channel)
            except SpeechError as error:
                raise SpeechError(str(error).replace(str(wav), str(path))) from None
    except OSError as error:
        why = error.strerror or error
        raise SpeechError(f"{path}: cannot be read: {why}; check the path") from None
    except soundfile.LibsndfileError as error:
        told = unread(path, error.error_string)
        raise SpeechError(f"{path}: not a readable recording ({told}") from None


def _read_file(path: Path, channel: int | None) -> Audio:
    """Read a file of libsndfile; raise its own error, OSError or SpeechError."""
    import soundfile

    # libsndfile seeks in the file itself, without a buffer of ours: through a Python stream, a
    # header that points before the start of the file prints a traceback.
    with path.open("rb", buffering=0) as stream:
        if not stream.seekable():
            raise SpeechError(f"{path}: is a pipe; write the recording to a file first")
        surplus = surplus_seconds(stream)
        stream.seek(0)
        with soundfile.SoundFile(stream.fileno(), closefd=False) as sound:
            _refuse_odd(path, sound, surplus)
            return _read(path, sound, channel)


def _refuse_odd(path: str | Path, sound: Any, surplus: float) -> None:
    """Refuse a file by what its header states."""
    rate, stated = sound.samplerate, _stated(path, sound)
    if not SLOWEST <= rate <= FASTEST:
        raise SpeechError(
            f"{path}: {rate} samples per second; speech needs {SLOWEST} to {FASTEST}: resample it"
        )
    if stated > MAX_SOUND_SECONDS * rate:
        raise SpeechError(
            f"{path}: lasts {stated / rate / 60:.0f} minutes, more than the maximum of "
            f"{MAX_SOUND_SECONDS / 60:.0f}; cut it into lines"
        )
    size = Path(path).stat().st_size
    if stated > SAMPLES_PER_BYTE.get(sound.format, FLAC_SAMPLES_PER_BYTE) * size:
        raise SpeechError(f"{path}: states {stated:,} samples in {size:,} bytes; save it again")
    if stated > MAX_SAMPLES or sound.channels > MAX_CHANNELS:
        raise SpeechError(
            f"{path}: has {stated:,} samples on {sound.channels} channels, more than "
            f"{MAX_SAMPLES:,} samples or {MAX_CHANNELS} channels; resample it to 48000 Hz, mono"
        )
    if surplus:
        raise SpeechError(
            f"{path}: goes on for {surplus:.2f} s after the {stated / rate:.2f} s that its header "
            "states; open the file as raw sound in an editor, and save it again"
        )


def _read(path: str | Path, sound: Any, channel: int | None) -> Audio:
    rate, stated = sound.samplerate, _stated(path, sound)
    if channel is not None and not 1 <= channel <= sound.channels:
        raise SpeechError(
            f"{path}: has no channel {channel}; its channels are numbered 1 to {sound.channels}"
        )
    found = bytearray()  # which grows in place, where an array of blocks takes twice its memory
    if channel is None:
        powers, left = np.zeros(sound.channels), 0.0
        for block in _blocks(path, sound):
            mean = block.mean(axis=1)
            # In float64: the sum of an hour of squares has more digits than a float32 keeps.
            powers += np.square(block, dtype=np.float64).sum(axis=0)
            left += float(np.square(mean, dtype=np.float64).sum())
            found += _whole(mean * INT16_FULL_SCALE).tobytes()
        if left < MIN_MIX_POWER * powers.mean():  # the channels cancel each other out
            channel = int(powers.argmax()) + 1
    if channel is not None:
        found.clear()
        for block in _blocks(path, sound):
            found += _whole(block[:, channel - 1] * INT16_FULL_SCALE).tobytes()
    count = len(found) // 2
    if count == 0:
        raise SpeechError(f"{path}: has no sound; record it again")
    slack = MP3_SLACK if sound.format == MP3 else 0
    # libsndfile corrects the length silently and reports the mismatch in its log only. Placeholders
    # in place of a size are not an error.
    corrected = _CORRECTED_SIZE.search(sound.extra_info)
    size, there = map(int, corrected.groups()) if corrected else (0, 0)
    if count < stated - slack or there < size < PLACEHOLDER_BYTES:
        raise SpeechError(
            f"{path}: ends after {count / rate:.2f} s, before the end that its header states; "
            "copy or save it again"
        )
    return Audio(np.frombuffer(found, np.int16), rate)


def _stated(path: str | Path, sound: Any) -> int:
    """Return the length that a file states, in samples; 0 for an MP3 that states none.

    libsndfile then estimates one from the first frame, and reads no sample beyond it.
    """
    frames: int = sound.frames
    return frames if sound.format != MP3 or _mp3_frames(path)[1] else 0


def _mp3_frames(path: str | Path) -> tuple[int, bool]:
    """Return the byte where the frames of an MP3 start, and whether the first states a length."""
    with Path(path).open("rb") as file:
        start = file.seek(tag_bytes(file.read(SOUND_HEAD_BYTES)))
        frame = file.read(2048)
    return start, any(mark in frame for mark in (b"Xing", b"Info", b"VBRI"))


@contextmanager
def _from_start(path: str | Path, sound: Any) -> Iterator[Any]:
    """Yield the sound of a file at its start, such that all of it can be read."""
    if _stated(path, sound) or sound.format != MP3:
        sound.seek(0)
        yield sound
        return
    # Of a pipe, libsndfile estimates no length. It reads no tag there.
    reading, writing = os.pipe()

    def feed() -> None:
        # The reader may end before the file does, as at a limit.
        with Path(path).open("rb") as file, suppress(OSError), os.fdopen(writing, "wb") as pipe:
            file.seek(_mp3_frames(path)[0])
            shutil.copyfileobj(file, pipe)

    feeder = Thread(target=feed)
    feeder.start()
    try:
        with type(sound)(reading, closefd=False) as whole:
            yield whole
    finally:
        os.close(reading)
        feeder.join()


def _blocks(path: str | Path, sound: Any) -> Iterator[npt.NDArray[np.float32]]:
    """Yield the samples in the file, (N, C), whatever its header states."""
    count, most = 0, min(MAX_SAMPLES, round(MAX_SOUND_SECONDS * sound.samplerate))
    with _from_start(path, sound) as source:
        while len(
            block := source.read(BLOCK_SAMPLES // sound.channels, dtype="float32", always_2d=True)
        ):
            count += len(block)
            if count > most:
                raise SpeechError(f"{path}: has more than {most:,} samples; cut it into lines")
            yield np.clip(np.nan_to_num(block), -MAX_AMPLITUDE, MAX_AMPLITUDE)


def _whole(samples: npt.NDArray[np.float32]) -> npt.NDArray[np.int16]:
    """Round to int16, clipped at full scale."""
    return np.clip(np.rint(samples), -INT16_FULL_SCALE, INT16_FULL_SCALE - 1).astype(np.int16)


def resampled(audio: Audio, rate: int) -> Audio:
    """Resample a sound; its duration is preserved to within one sample."""
    if audio.rate == rate:
        return audio
    return Audio(np.concatenate([*resampled_blocks(audio, rate)]), rate)


def resampled_blocks(audio: Audio, rate: int) -> Iterator[npt.NDArray[np.int16]]:
    """Yield a sound at another rate in blocks: an hour at once would take gigabytes."""
    common = gcd(audio.rate, rate)
    up, down = rate // common, audio.rate // common
    # Around each block is more sound than the filter reaches.
    block, around = BLOCK_SAMPLES // down * down, 16 * down
    for start in range(0, max(len(audio.samples), 1), block):
        if up == down:
            yield audio.samples[start : start + block]
            continue
        from scipy.signal import resample_poly

        first = max(start - around, 0)
        part = audio.samples[first : start + block + around].astype(np.float32)
        at = (start - first) // down * up
        yield _whole(resample_poly(part, up, down)[at : at + block // down * up])


def with_sound(
    schedule: Schedule, recording: str | Path | Audio, channel: int | None = None
) -> Schedule:
    """Attach a recording, or a channel of its file, to a schedule; remark if it is too short.

    A recording that cannot be read is a `SpeechError`.
    """
    audio = recording if isinstance(recording, Audio) else read_audio(recording, channel)
    file = "the recording" if isinstance(recording, Audio) else recording
    remarks = schedule.remarks
    if schedule.end > audio.seconds + LATE_SECONDS:
        told = f"{file}: ends at {audio.seconds:.2f} s, and the schedule at {schedule.end:.2f} s"
        remarks = (*remarks, f"{told}; check that they belong together")
    return replace(schedule, audio=audio, remarks=remarks)
