"""Sound files that libsndfile does not read, or whose header states too little."""

import struct
from contextlib import suppress
from io import RawIOBase
from pathlib import Path

from lipsync_lang.base.files.quoting import shell_command

FOREIGN_MARKS = (
    (4, b"ftyp", "MPEG-4 sound or video (m4a, mp4, mov)"),
    (0, b"\x1aE\xdf\xa3", "Matroska or WebM"),
    (0, b"0&\xb2u\x8ef\xcf\x11", "Windows Media (wma)"),
    (0, b"\xff\xf1", "AAC"),
    (0, b"\xff\xf9", "AAC"),
    (0, b"#!AMR", "AMR"),
    (0, b".RMF", "RealMedia"),
    (0, b"MAC ", "Monkey's Audio (ape)"),
    (0, b"wvpk", "WavPack"),
)
"""Formats that other programs read: offset and bytes of their marks, and their names."""

SOUND_HEAD_BYTES = 512
MAX_CHUNKS = 1000
"""Chunks of a WAV file to skip."""

FORM_BYTES = 16
"""Minimum size of the chunk that states rate and channels."""

SURPLUS_SECONDS = 0.1
"""Tolerated sound after the stated end, where some programs write tags."""

AUDIO_SUFFIXES = (".wav", ".flac", ".ogg", ".mp3")
"""Suffixes of recordings, the most likely first."""

PLACEHOLDER_BYTES = 0x7FFF_0000
"""Minimum placeholder size, written by streaming programs in place of the unknown size."""


def unread(path: Path, reason: str) -> str:
    """Describe an unreadable file, and its remedy.

    Parameters
    ----------
    reason : libsndfile's own
    """
    with path.open("rb") as stream:
        head = stream.read(SOUND_HEAD_BYTES)
    title = next((one for at, sign, one in FOREIGN_MARKS if head[at:].startswith(sign)), None)
    if title is not None:
        stem = path.stem if path.suffix.lower() != ".wav" else f"{path.stem}-converted"
        command = shell_command(["ffmpeg", "-i", str(path), f"{stem}.wav"])
        return f"it is {title}); convert it: {command}"
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
