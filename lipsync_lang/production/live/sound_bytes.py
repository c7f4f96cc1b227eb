"""Sound as a stream of bytes: raw samples, or WAV files one after the other.

Bytes are heard as they arrive. A stream whose header contradicts its sound is heard all the same,
and the contradiction is told. Samples are floats from -1 to 1, little-endian in the stream.
"""

import struct
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Singles
from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.sound.speech.decoding import COMPRESSIONS
from lipsync_lang.sound.speech.sound import (
    FASTEST,
    FORM_BYTES,
    MAX_CHANNELS,
    PLACEHOLDER_BYTES,
    SLOWEST,
    SPEECH_RATE,
    is_name,
)
from lipsync_lang.text.lines.line_readers import Remark

PCM_FORMATS = {
    "u8": (1, 1), "s16": (1, 2), "s24": (1, 3), "s32": (1, 4), "f32": (3, 4), "f64": (3, 8),
}  # fmt: skip
"""Formats of samples: their number in WAV (1 whole, 3 float), and bytes per sample."""

EXTENSIBLE = 0xFFFE
"""Number in WAV of a format that is stated later in its chunk."""

RIFF, RF64 = b"RIFF", b"RF64"

COMPRESSED = (
    *((one.at, one.mark, one.title) for one in COMPRESSIONS),
    *((0, b"fLaC", "FLAC"), (0, b"OggS", "Ogg"), (0, b"ID3", "MP3"), (0, b"FORM", "AIFF")),
)
"""Other formats of sound: offset and bytes of their marks, and their names."""

SNIFFED_BYTES = 12

DOUBTED_BYTES = 4096
"""Raw samples by which a wrong format is noticed."""

USUAL = (1e-6, 1.5)
"""Magnitudes of nearly all samples that are floats."""

READ_SECONDS = 0.25
"""Most sound that is read at once."""

CONVERTED = "pipe it through ffmpeg: ffmpeg -loglevel error -i FILE -f wav -"

Pcm = tuple[int, Singles]
"""Samples per second, and (n,) samples from -1 to 1."""


class SampleForm(NamedTuple):
    """The form of raw samples."""

    rate: int = SPEECH_RATE
    """Samples per second."""
    format: str = "s16"
    """A name of `PCM_FORMATS`."""
    channels: int = 1

    @property
    def frame_bytes(self) -> int:
        """Bytes of a sample of all channels."""
        return PCM_FORMATS[self.format][1] * self.channels

    def seconds(self, count: int) -> float:
        """Duration of so many bytes."""
        return count / self.frame_bytes / self.rate

    def samples(self, raw: bytes) -> Singles:
        """Decode whole samples, and mix their channels: (n,) from -1 to 1."""
        whole, size = PCM_FORMATS[self.format][0] == 1, PCM_FORMATS[self.format][1]
        if size == 3:  # noqa: PLR2004 no type of NumPy has three bytes
            wide = np.zeros((len(raw) // 3, 4), np.uint8)
            wide[:, 1:] = np.frombuffer(raw, np.uint8).reshape(-1, 3)
            # At the upper end of four bytes, three keep their sign, and the range is that of four.
            raw, size = wide.tobytes(), 4
        found = np.frombuffer(raw, f"<{'i' if whole else 'f'}{size}" if size > 1 else np.uint8)
        # Damaged floats may be no numbers, or too large for the next type.
        values = found if whole else np.clip(np.nan_to_num(found, nan=0.0), -1.0, 1.0)
        mixed: Singles = values.astype(np.float32).reshape(-1, self.channels).mean(axis=1)
        if whole:
            mixed = (mixed - 128.0 * (size == 1)) / np.float32(2.0 ** (8 * size - 1))
        return mixed


def checked_form(rate: object = None, format_: object = None) -> SampleForm:
    """Return the form of raw samples of one channel; None stands for the usual value.

    A `LipsyncError` names a rate or a format that cannot be heard.
    """
    usual = SampleForm()
    rate = usual.rate if rate is None else rate
    if isinstance(rate, bool) or not isinstance(rate, int) or not SLOWEST <= rate <= FASTEST:
        what = f"give the samples per second of the sound, from {SLOWEST} to {FASTEST}"
        raise LipsyncError(f"`rate={rate}`: {what}, such as 16000")
    format_ = usual.format if format_ is None else format_
    if not isinstance(format_, str) or format_ not in PCM_FORMATS:
        hint = did_you_mean(str(format_), PCM_FORMATS)
        raise LipsyncError(f"'{format_}' is not a format of samples; {hint}")
    return SampleForm(rate, format_)


class ByteStream:
    """Bytes of a stream, some of which are read again; `read` returns b"" at the end only."""

    def __init__(self, read: Callable[[int], bytes]) -> None:
        self.read, self.kept = read, b""

    def some(self, most: int) -> bytes:
        """Return the bytes that are there, at least one; none at the end."""
        raw = self.kept or self.read(most)
        self.kept = raw[most:]
        return raw[:most]

    def exactly(self, count: int) -> bytes:
        """Return so many bytes, or fewer at the end."""
        found = b""
        while len(found) < count and (more := self.some(count - len(found))):
            found += more
        return found

    def peek(self, count: int) -> bytes:
        """Return bytes that will be read again."""
        found = self.exactly(count)
        self.kept = found + self.kept
        return found


def sounds(read: Callable[[int], bytes], stated: SampleForm, tell: Remark) -> Iterator[Pcm]:
    """Yield the sound of a stream as it arrives, until its end.

    Raises LipsyncError if the sound is compressed, or the WAV header states no samples.

    Parameters
    ----------
    read : returns at most so many bytes, at least one, or none at the end
    stated : the form of the samples, if the stream has no WAV header
    """
    stream = ByteStream(read)
    form, left, heard = stated, None, 0
    # fewer than four bytes after the samples of a WAV file are no sound
    while len(head := stream.peek(4)) == 4 or (head and not heard):  # noqa: PLR2004
        if head in (RIFF, RF64):
            form, left = _wav_form(stream, stated, tell)
            heard = 0
        elif heard and left == 0 and is_name(head):
            _skip(stream, int.from_bytes(stream.exactly(8)[4:], "little"))
            continue
        elif heard and left == 0:
            lasted = form.seconds(heard)
            tell(f"the sound goes on after the {lasted:.2f} s that its WAV header states")
            left = None
        else:
            head = stream.peek(SNIFFED_BYTES)
            if compressed := [name for at, mark, name in COMPRESSED if head[at:].startswith(mark)]:
                what = f"the sound is {compressed[0]}, neither samples nor WAV; {CONVERTED}"
                raise LipsyncError(what)
            _doubt(stream.peek(DOUBTED_BYTES), form, tell)
        for raw in _whole_samples(stream, form, left, tell):
            heard += len(raw)
            yield form.rate, form.samples(raw)
        if left is not None and heard < left:
            lasted, whole = form.seconds(heard), form.seconds(left)
            tell(f"the sound ends after {lasted:.2f} s; its WAV header states {whole:.2f} s")
        if left is not None:
            stream.exactly(left % 2)
            left = 0


def _whole_samples(
    stream: ByteStream, form: SampleForm, left: int | None, tell: Remark
) -> Iterator[bytes]:
    """Yield bytes of whole samples, at most `left`, until the end."""
    size, rest = form.frame_bytes, b""
    most = max(int(READ_SECONDS * form.rate), 1) * size
    while left is None or left > 0:
        raw = stream.some(most if left is None else min(most, left))
        if not raw:
            break
        left = None if left is None else left - len(raw)
        rest += raw
        whole = len(rest) - len(rest) % size
        if whole:
            yield rest[:whole]
            rest = rest[whole:]
    if rest:
        tell(f"the sound ends within a sample: {len(rest)} of {size} bytes are left out")


def _wav_form(
    stream: ByteStream, stated: SampleForm, tell: Remark
) -> tuple[SampleForm, int | None]:
    """Read a WAV header; return the form of its samples and their bytes, None if unknown."""
    stream.exactly(SNIFFED_BYTES)
    form: SampleForm | None = None
    while len(head := stream.exactly(8)) == 8:  # noqa: PLR2004 a name and a size
        name, size = head[:4], int.from_bytes(head[4:], "little")
        if name == b"data" and form is not None:
            return form, None if size == 0 or size >= PLACEHOLDER_BYTES else size
        if name == b"fmt " and size >= FORM_BYTES:
            chunk = stream.exactly(size + size % 2)
            if len(chunk) < FORM_BYTES:
                break
            form = _stated_form(chunk, stated, tell)
        elif not is_name(name):
            break
        else:
            _skip(stream, size)
    raise LipsyncError(f"the WAV header has no samples; {CONVERTED}")


def _stated_form(chunk: bytes, stated: SampleForm, tell: Remark) -> SampleForm:
    """Return the form that a WAV header states; where it contradicts itself, tell which part."""
    kind, channels, rate, _, block, bits = struct.unpack("<HHIIHH", chunk[:FORM_BYTES])
    if kind == EXTENSIBLE and len(chunk) > 25:  # noqa: PLR2004 the place of the number
        kind = int.from_bytes(chunk[24:26], "little")
    names = {form: name for name, form in PCM_FORMATS.items()}
    name = names.get((kind, bits // 8))
    if name is None or bits % 8 or not 1 <= channels <= MAX_CHANNELS:
        raise LipsyncError(
            f"the WAV header states format {kind} with {bits} bits on {channels} channels, which "
            f"cannot be heard live; {CONVERTED}"
        )
    if not SLOWEST <= rate <= FASTEST:
        tell(f"the WAV header states {rate} samples per second; it is heard at {stated.rate}")
        rate = stated.rate
    form = SampleForm(rate, name, channels)
    if block != form.frame_bytes:
        tell(
            f"the WAV header states {block} bytes per sample, but {channels} channels of {bits} "
            f"bits have {form.frame_bytes}, which are heard"
        )
    return form


def _skip(stream: ByteStream, size: int) -> None:
    """Skip a chunk of other data."""
    left = size + size % 2
    while left > 0 and (raw := stream.some(min(left, 1 << 16))):
        left -= len(raw)


def _doubt(raw: bytes, form: SampleForm, tell: Remark) -> None:
    """Tell if raw samples are floats, but stated as whole numbers, or the other way round."""
    values = np.abs(np.frombuffer(raw[: len(raw) - len(raw) % 4], "<f4"))
    values = values[values != 0]
    floats = float(np.mean((values > USUAL[0]) & (values < USUAL[1]))) if len(values) else 0.8
    if form.format == "s16" and floats > 0.9:  # noqa: PLR2004
        tell("the samples look like floats; if the mouth moves oddly, give --format f32")
    if form.format == "f32" and floats < 0.7:  # noqa: PLR2004
        tell("the samples look like whole numbers; if the mouth moves oddly, give --format s16")
