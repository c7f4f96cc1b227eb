"""Clips of a study: rendered in parallel, and cached by the digest of their contents.

An existing clip is never rendered again, so a new run continues an interrupted one.
"""

import os
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property, partial
from hashlib import blake2b
from io import BytesIO
from pathlib import Path

from lipsync_lang import Animation, OutputError
from lipsync_lang.base.files import atomic
from lipsync_lang.production.builds.workers import LostBatch, run_batches

CLIP_SIDE = 480
"""Side of a clip in pixels."""

CLIP_CODEC = (
    *("-c:v", "libx264", "-profile:v", "baseline", "-level", "3.1", "-preset", "veryfast"),
    *("-crf", "22", "-c:a", "aac", "-b:a", "64k", "-ac", "1", "-movflags", "+faststart"),
)
"""H.264 baseline with AAC, which every phone plays."""

CLIP_DIGEST_BYTES = 16

FREE_BOX_BYTES = 8
"""Length of the header of an MP4 box in bytes: its size and its kind."""

CLIP_FORM = "clip 1"
"""Version of the drawing; with a new version, all clips are rendered again."""


@dataclass(frozen=True, eq=False)
class Clip:
    """A clip to render."""

    animation: Animation
    framing: Animation
    """Animation for camera and light; the same for both clips of a pair."""

    @cached_property
    def digest(self) -> str:
        """Digest of all contents of the clip."""
        whole = blake2b(digest_size=CLIP_DIGEST_BYTES)
        model = self.animation.model
        content = model and blake2b(model.read_bytes(), digest_size=CLIP_DIGEST_BYTES).hexdigest()
        for part in (CLIP_FORM, CLIP_SIDE, CLIP_CODEC, content):
            whole.update(repr(part).encode())
        for one in (self.animation, self.framing):
            whole.update(repr((one.fps, one.columns)).encode())
            whole.update(one.times.tobytes() + one.weights.tobytes())
        audio = self.animation.schedule.audio
        if audio is not None:
            whole.update(repr(audio.rate).encode() + audio.samples.tobytes())
        return whole.hexdigest()

    @property
    def seconds(self) -> float:
        """Length of the clip: the longer one of its motion and its sound."""
        times, audio = self.animation.times, self.animation.schedule.audio
        sound = audio.seconds - float(times[0]) if audio is not None else 0.0
        # The last frame is shown for a frame as well.
        return max(float(times[-1] - times[0]), sound) + 1 / self.animation.fps

    def path(self, folder: Path) -> Path:
        """Return the file of the clip in a folder."""
        return folder / f"{self.digest}.mp4"


def render_clips(
    clips: Sequence[Clip],
    folder: Path,
    *,
    workers: int | None = None,
    told: Callable[[int, int], None] = lambda _done, _all: None,
) -> int:
    """Render the clips that are missing from a folder, and return their number.

    By default, there is one worker process per core. `told` receives the number of rendered clips
    and the total. Raises OutputError if ffmpeg or a library is missing, a file cannot be written,
    or a process died, and ModelError if a model cannot be drawn.
    """
    folder.mkdir(parents=True, exist_ok=True)
    wanted = {clip.path(folder): clip for clip in clips}
    missing = {path: clip for path, clip in wanted.items() if not path.is_file()}
    # A container may give this process fewer cores than the machine has.
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    count = max(1, min(len(missing), workers or usable or 1))
    told(0, len(missing))
    rendering = run_batches(partial(_render, folder), missing.values(), workers=count)
    with closing(rendering):
        for number, found in enumerate(rendering, 1):
            if isinstance(found, LostBatch):
                raise OutputError(
                    "a process that rendered clips died (out of memory?); start again, with one "
                    "worker (`workers=1`), and it goes on with the clips that are left"
                )
            told(number, len(missing))
    return len(missing)


def _render(folder: Path, clip: Clip) -> None:
    from lipsync_lang.render.video import film

    content = BytesIO()
    film(clip.animation, content, "mp4", size=CLIP_SIDE, codec=CLIP_CODEC, framing=clip.framing)
    with atomic(clip.path(folder)) as stream:
        stream.write(content.getvalue())


def of_one_size(contents: Sequence[bytes]) -> list[bytes]:
    """Return MP4 files of one size, each with a free box at its end.

    With equal sizes, the clips of a pair do not reveal their methods.
    """
    size = max(map(len, contents)) + FREE_BOX_BYTES
    return [
        content + room.to_bytes(4, "big") + b"free" + bytes(room - FREE_BOX_BYTES)
        for content, room in ((content, size - len(content)) for content in contents)
    ]
