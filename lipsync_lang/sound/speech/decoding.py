"""Sound that ffmpeg decodes: recordings of phones, films, and what else libsndfile cannot read."""

import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.base.extras import install_line

SOUND_HEAD_BYTES = 512

MAX_DECODED_SECONDS = 7_201
"""Longest decoded sound: a second more than the longest recording, which is refused by its own."""

MAX_DECODED_BYTES = 1 << 31
"""Largest decoded file: two hours at 48,000 samples a second on three channels."""

DECODING_SECONDS = 600
"""Time in which ffmpeg decodes a recording of two hours; damaged ones may take forever."""


class Compression(NamedTuple):
    """A format that ffmpeg decodes, and its mark at the start of a file."""

    at: int
    mark: bytes
    title: str
    demuxer: str
    """ffmpeg's name. A demuxer that is found by content may be a playlist, which opens others."""


COMPRESSIONS = (
    *(
        Compression(4, atom, "MPEG-4 or QuickTime (m4a, mp4, mov)", "mov")
        for atom in (b"ftyp", b"wide", b"free", b"skip", b"mdat", b"moov")
    ),
    Compression(0, b"\x1aE\xdf\xa3", "Matroska or WebM", "matroska"),
    Compression(0, b"0&\xb2u\x8ef\xcf\x11", "Windows Media (wma)", "asf"),
    *(Compression(0, bytes([0xFF, one]), "AAC", "aac") for one in (0xF0, 0xF1, 0xF8, 0xF9)),
    Compression(0, b"#!AMR", "AMR", "amr"),
    Compression(0, b".RMF", "RealMedia", "rm"),
    Compression(0, b"MAC ", "Monkey's Audio (ape)", "ape"),
    Compression(0, b"wvpk", "WavPack", "wv"),
)


def tag_bytes(head: bytes) -> int:
    """Return the length of the ID3 tag at the start of a file; its size has seven bits a byte."""
    size = sum(byte << shift for byte, shift in zip(head[6:10], (21, 14, 7, 0), strict=False))
    return size + 10 if head.startswith(b"ID3") else 0


def compression(path: Path) -> Compression | None:
    """Return the format of a file, if it is one that ffmpeg decodes; an ID3 tag is passed over."""
    with path.open("rb") as stream:
        head = stream.read(SOUND_HEAD_BYTES)
        if stream.seek(tag_bytes(head)):
            head = stream.read(SOUND_HEAD_BYTES)
    return next((one for one in COMPRESSIONS if head[one.at :].startswith(one.mark)), None)


def find_ffmpeg() -> str | None:
    """Return the path of ffmpeg: that of imageio-ffmpeg, or a program on the search path."""
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        return shutil.which("ffmpeg")


@contextmanager
def decoded(path: Path, found: Compression) -> Iterator[Path]:
    """Yield a temporary WAV file of the first sound in a file, in its own rate and channels.

    Raises SpeechError if ffmpeg is not installed, finds no sound, or takes too long; or the sound
    is too long.
    """
    program = find_ffmpeg()
    if program is None:
        what = f"{path}: it is {found.title}, which ffmpeg reads, and that is not installed"
        raise SpeechError(f"{what}; get it with: {install_line('video')}")
    with TemporaryDirectory(prefix="lipsync-lang-") as folder:
        wav = Path(folder, "sound.wav")
        # A film of a stranger may name other files and addresses; only this file is opened.
        source = ("-protocol_whitelist", "file", "-f", found.demuxer)
        limits = ("-t", str(MAX_DECODED_SECONDS), "-fs", str(MAX_DECODED_BYTES))
        command = [program, "-nostdin", "-v", "error", *source, "-i", f"file:{path.absolute()}"]
        command += ["-map", "0:a:0", *limits, str(wav)]
        try:
            ended = subprocess.run(  # noqa: S603 no shell reads it
                command, stdin=subprocess.DEVNULL, capture_output=True, check=False,
                timeout=DECODING_SECONDS,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            told = f"ffmpeg has not decoded it in {DECODING_SECONDS // 60} minutes"
            raise SpeechError(f"{path}: {told}; convert it to WAV with another program") from None
        except OSError as error:
            raise SpeechError(f"{path}: {program} does not run ({error})") from None
        if ended.returncode:
            lines = ended.stderr.decode("utf-8", "replace").split("\n")
            why = next((line.strip() for line in lines if line.strip()), f"code {ended.returncode}")
            what = f"{path}: it is {found.title}, and ffmpeg finds no sound in it"
            raise SpeechError(f"{what}: {why.rstrip('.')}; check that it plays, with sound")
        if wav.stat().st_size >= MAX_DECODED_BYTES:
            most = MAX_DECODED_BYTES >> 30
            raise SpeechError(f"{path}: is larger than {most} GB when decoded; cut it into lines")
        yield wav
