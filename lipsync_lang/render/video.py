"""Video of a speaking model with sound; ffmpeg encodes the frames drawn here."""

import math
import os
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from shutil import copyfileobj
from tempfile import TemporaryDirectory
from typing import BinaryIO

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.writers.wav import write_samples
from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.extras import install_line
from lipsync_lang.base.terminal import progress, wipe
from lipsync_lang.render.model.picture import Artist, Pixels
from lipsync_lang.render.model.scene import pillow
from lipsync_lang.render.staging import staged, sweep
from lipsync_lang.sound.speech.decoding import find_ffmpeg

FRAME_PIXELS = 720
"""Side of a frame in pixels."""

CODECS = {
    kind: tuple(options.split())
    for kind, options in {
        "mp4": "-c:v libx264 -preset veryfast -crf 18 -c:a aac -b:a 160k -movflags +faststart",
        "webm": "-c:v libvpx-vp9 -deadline realtime -cpu-used 6 -crf 24 -b:v 0 "
        "-c:a libopus -b:a 96k",
    }.items()
}
"""Encoder options of each file kind."""

COLOURS = (
    *("-vf", "scale=out_color_matrix=bt709:out_range=tv", "-pix_fmt", "yuv420p"),
    *("-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"),
)

REPRODUCIBLE_FLAGS = ("-fflags", "+bitexact", "-flags:v", "+bitexact", "-flags:a", "+bitexact")
"""Options that keep dates and machine details out of the file, for reproducible output."""

PROGRESS_SECONDS = 2.0
"""Seconds before a terminal shows progress."""

MOST_AT_ONCE, AHEAD = 8, 4
"""Maximum number of frames that are drawn at once, which takes up to 70 MB each, and the number of
frames that are kept for each of them."""


def film(  # noqa: PLR0913 the animation, and settings of the film
    animation: Animation,
    out: BinaryIO,
    kind: str,
    *,
    size: int | None = None,
    codec: Sequence[str] = (),
    framing: Animation | None = None,
) -> None:
    """Draw every frame of an animation and write a video of a kind in `CODECS` with its sound.

    The duration is the longer of animation and sound; the size is the side of a frame in pixels.
    Camera and light are those of `framing`, an animation of the same model. Raises OutputError if a
    library is missing, there is nothing to draw, or ffmpeg fails, and ModelError if the model
    cannot be drawn.
    """
    ffmpeg, size = find_ffmpeg(), size or FRAME_PIXELS
    if ffmpeg is None:
        mend = "or set the environment variable IMAGEIO_FFMPEG_EXE to its path"
        raise OutputError(f"video needs ffmpeg: {install_line('video')}, {mend}")
    pillow()
    scene = staged(animation)
    audio = animation.schedule.audio
    seconds = max(scene.seconds, scene.sound + (audio.seconds if audio else 0.0))
    # A product such as 2.9999 counts as 3.
    count = math.floor(seconds * animation.fps + 1e-3) + 1
    widest = staged(sweep(framing)) if framing is not None else None
    artist = Artist(scene, size, widest=widest)
    with TemporaryDirectory(prefix="lipsync-lang-") as folder:
        path, sound = Path(folder) / f"film.{kind}", Path(folder) / "sound.wav"
        rate = Fraction(animation.fps).limit_denominator(1001)
        inputs = f"-f rawvideo -pix_fmt rgb24 -s {size}x{size} -r {rate} -i -".split()
        if audio is not None:
            # Silence before the sound, and after it up to the end of the video.
            before = round(scene.sound * audio.rate)
            whole = math.ceil(count / animation.fps * audio.rate)
            after = max(0, whole - before - len(audio.samples))
            with sound.open("wb") as stream:
                write_samples(np.pad(audio.samples, (before, after)), audio.rate, stream)
            inputs += ["-i", str(sound)]
        output = [*COLOURS, *(codec or CODECS[kind]), *REPRODUCIBLE_FLAGS, str(path)]
        times = np.arange(count) / animation.fps
        command = [ffmpeg, "-loglevel", "error", "-nostdin", "-y", *inputs, *output]
        _encode(command, artist, times.tolist(), Path(folder) / "log")
        with path.open("rb") as stream:
            copyfileobj(stream, out)


def _encode(command: Sequence[str], artist: Artist, times: Sequence[float], log: Path) -> None:
    """Draw frames and send them to ffmpeg, with progress on a terminal after a while."""
    began = time.monotonic()
    # A file instead of a pipe: a full pipe of messages would stop ffmpeg while we write frames.
    with log.open("wb") as errors:
        process = subprocess.Popen(  # noqa: S603 no shell reads it
            command, stdin=subprocess.PIPE, stdout=errors, stderr=errors
        )
    assert process.stdin is not None  # noqa: S101 asked for above
    try:
        with suppress(OSError), process.stdin as pipe:  # ffmpeg ended; its error is read below
            for number, pixels in enumerate(drawn(artist.draw, times)):
                if time.monotonic() - began > PROGRESS_SECONDS:
                    progress(f"frame {number} of {len(times)} ...")
                pipe.write(pixels.data)
        failed = process.wait()
    except BaseException:
        process.kill()
        process.wait()
        raise
    finally:
        wipe()
    if failed:
        lines = log.read_text("utf-8", "replace").split("\n")
        last = next((line for line in reversed(lines) if line.strip()), f"code {failed}")
        raise OutputError(f"ffmpeg could not make the video: {last.strip()}")


def drawn(draw: Callable[[float], Pixels], times: Sequence[float]) -> Iterator[Pixels]:
    """Yield the frames at some times, in their order; every processor draws.

    Threads suffice: nearly all of a frame is work on arrays, in which Python lets others run.
    """
    most = min(os.cpu_count() or 1, MOST_AT_ONCE)
    with ThreadPoolExecutor(most) as threads:
        for at in range(0, len(times), AHEAD * most):
            yield from threads.map(draw, times[at : at + AHEAD * most])
