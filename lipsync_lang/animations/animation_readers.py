"""Registry of animation readers, and the curves, times (seconds) and schedule of a file."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import AnimationError
from lipsync_lang.base.extensions import Format, Formats
from lipsync_lang.base.files import read_input
from lipsync_lang.schedules.schedule import Schedule

MAX_ANIMATION_BYTES = 2**30

LONGEST_SECONDS = 86_400.0
"""Maximum time in seconds; larger values indicate a different unit."""

MAX_VALUE = 1e9
"""Maximum size of a value; larger ones are damage, and their squares overflow."""

MIN_FRAMES = 2
"""Minimum number of frames; a single frame has no movement."""


@dataclass(frozen=True, eq=False)
class Recording:
    """Curves as stored in a file: (T, C) values at (T,) increasing seconds of the sound.

    The schedule has the spoken phonemes and words, if the file has them; remarks are warnings.
    """

    source: str
    times: Floats
    names: tuple[str, ...]
    values: Floats
    schedule: Schedule | None = None
    remarks: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        """Reject invalid times and values."""
        if len(self.times) < MIN_FRAMES:
            fail(self.source, f"has {len(self.times)} frames", "export the whole take")
        if not self.names:
            fail(self.source, "has no columns of curves", "export it with its blend shapes")
        twice = sorted({name for name in self.names if self.names.count(name) > 1})
        if twice:
            fail(self.source, f"has two columns called '{twice[0]}'", "give each its own name")
        _refuse(self.source, ~np.isfinite(self.times), "a time is not a number")
        bad = np.asarray(~np.isfinite(self.values).all(axis=1))
        _refuse(self.source, bad, "a value is not a number")
        bad = np.asarray((np.abs(self.values) > MAX_VALUE).any(axis=1))
        _refuse(self.source, bad, f"a value is beyond {MAX_VALUE:g}; export the take again")
        _refuse(self.source, np.abs(self.times) > LONGEST_SECONDS, "its time is later than one day")
        falls = np.append(False, np.diff(self.times) <= 0)
        _refuse(self.source, falls, "its time does not rise; put the frames in order")


def _refuse(source: str, bad: npt.NDArray[np.bool_], what: str) -> None:
    if bad.any():
        fail(source, f"frame {int(bad.argmax())}: {what}")


def fail(source: str | Path, what: str, mend: str = "") -> NoReturn:
    """Raise an error about an animation file, with a suggested fix."""
    raise AnimationError(f"{source}: {what}{'; ' if mend else ''}{mend}")


ReadAnimation = Callable[[Path, bytes], Recording]
Guess = Callable[[bytes], bool]


@dataclass(frozen=True)
class AnimationReader(Format):
    """A format: its read function, and a test to tell it from others with the same suffix."""

    read: ReadAnimation
    fits: Guess | None


ANIMATION_READERS: Formats[AnimationReader] = Formats(
    "animation_readers", "format", package="lipsync_lang.animations.readers"
)


def reader(
    name: str, *, suffix: str, fits: Guess | None = None
) -> Callable[[ReadAnimation], ReadAnimation]:
    """Register ``(path, content) -> Recording`` as the reader of a format.

    Among formats with the same suffix, the first with a positive `fits` test reads the file. A
    format without `fits` is the fallback.
    """
    return ANIMATION_READERS.adding(
        lambda title, read: AnimationReader(name, (suffix,), title, read, fits)
    )


def read_animation(path: str | Path) -> Recording:
    """Read the curves of an animation file; its suffix selects the format."""
    path = Path(path)
    # Formats that know their files by content come before the fallback.
    chosen = sorted(ANIMATION_READERS.ending(path), key=lambda one: one.fits is None)
    if not chosen:
        what = f"no reader for '{path.suffix}'" if path.suffix else "has no suffix"
        fail(path, what, f"known: {', '.join(ANIMATION_READERS.suffixes())}")
    mend = "check that it is an animation"
    content = read_input(path, MAX_ANIMATION_BYTES, error=AnimationError, mend=mend)
    fits = [one for one in chosen if one.fits is None or one.fits(content)]
    if not fits:
        what = f"is no {' or '.join(one.name for one in chosen)}"
        fail(path, what, "check the program that wrote it")
    return fits[0].read(path, content)
