"""A picture of a line: what was spoken, and each pose's way through the stages (figures 6 to 10).

Along the time axis the sound, the words and the phonemes; below them a row for every pose that
moves. A row shows the bigrams, the stitched curve and the final one, and shades what each stage
between them changed: what it added lies under the final curve, what it took away above.

Units: x is seconds; y is inches from the top of a strip, so that every size below is a real one.
"""

import math
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise
from textwrap import shorten
from typing import TYPE_CHECKING, Any, BinaryIO
from unicodedata import combining, east_asian_width

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.errors import OutputError
from lipsync_lang.pipeline.arrays import Bools, Floats
from lipsync_lang.pipeline.motion import PRESETS, Motion
from lipsync_lang.pipeline.perform import Performance, Stage

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lipsync_lang.performer import Performer

FORMATS: dict[str, dict[str, Any] | None] = {
    "png": None,
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
    "jpg": None,
    "webp": None,
}
"""Formats that can be drawn, and what keeps the clock out of the file."""

RC = {
    "font.size": 9,
    "text.parse_math": False,  # a word may hold a dollar sign
    "svg.fonttype": "none",
    "svg.hashsalt": "lipsync-lang",
    "pdf.fonttype": 42,
    "legend.handlelength": 1.5,
    "legend.columnspacing": 1.6,
}
"""What differs from matplotlib's own defaults; the user's are left out."""

STRIP, SHOWN = 6.5, 60.0
"""Seconds: a longer line is wrapped into several strips, and the picture ends after `SHOWN`."""

WIDTH, DPI = 15.0, 100
HEAD, AXIS, RIGHT = 0.95, 0.55, 0.15
SOUND, LANE, GAP = 0.45, 0.19, 0.14
TALLEST_ROW, LOWEST_ROW, ALL_ROWS = 0.8, 0.32, 80.0
"""Inches: the page, its margins, the bands and the rows; all rows together keep to `ALL_ROWS`."""

LANES = 3
"""Lines of text over which crowded labels of a band are spread."""

VISIBLE = 5e-3
"""Weight below which a pose rests, and a stage has changed nothing to be seen."""

THINNED = 4
"""Of a bigram's tabulated steps every fourth is drawn."""

TITLE = 130
"""Characters of a line that fit its title."""

BIGRAMS = (("#cfe5f5", "#86b8dc"), ("#f1e4bf", "#cdb56b"))
"""Fill and edge of every other bigram."""

STAGES = {
    "stitch": ("stitched", "#444444"),
    "smooth": ("smoothed", "#009e73"),
    "hold": ("contacts held", "#cc79a7"),
    "limit": ("speed limited", "#0072b2"),
    "constrain": ("constrained", "#d55e00"),
}
"""What a stage did, and its colour (Okabe and Ito's, safe for the colour-blind)."""

FINAL, INK, RULE, SILENT, OUTSIDE = "black", "#333333", "#c4c4c4", "#f6f6f6", "#e9e9e9"


def plot(animation: Animation, stream: BinaryIO, format: str = "png") -> None:  # noqa: A002
    """Draw an animation and how it came about.

    Parameters
    ----------
    stream : open for bytes
    format : a key of `FORMATS`, in any case

    Raises
    ------
    OutputError
        The format is unknown, matplotlib is missing, or nobody knows who performed this.
    """
    name = format.lower()
    if name not in FORMATS:
        raise OutputError(f"no picture in '{format}'; known: {', '.join(FORMATS)}")
    if animation.performer is None:
        raise OutputError("this animation was not performed here; its stages cannot be drawn")
    try:
        import matplotlib as mpl
        from matplotlib import style
    except ImportError:
        raise OutputError(
            'a picture needs matplotlib: pip install "lipsync-lang[plot]"'
        ) from None
    with warnings.catch_warnings(), style.context(RC, after_reset=True):
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        warnings.filterwarnings("ignore", message="Matplotlib currently does not support")
        figure = _page(View(animation))
        figure.savefig(stream, format=name, dpi=DPI, metadata=FORMATS[name])


@dataclass(frozen=True)
class Band:
    """Labels along the time axis."""

    name: str
    texts: Sequence[str]
    starts: Floats
    ends: Floats
    size: float
    lanes: Sequence[int]

    @property
    def height(self) -> float:
        return LANE * (max(self.lanes, default=0) + 1)


class View:
    """The numbers of a picture, before any drawing."""

    def __init__(self, animation: Animation) -> None:
        self.animation = animation
        self.performer: Performer = animation.performer
        self.performance: Performance = self.performer.performance(
            animation.schedule, animation.fps
        )
        self.begin = float(animation.times[0])
        self.end = min(float(animation.times[-1]), self.begin + SHOWN)
        self.strips = math.ceil((self.end - self.begin) / STRIP - 1e-9) or 1
        self.seconds = max(self.end - self.begin, 1 / animation.fps) / self.strips
        names = [_width(pose, 10) for pose in animation.poses]
        self.left = 0.45 + max(*names, _width("phonemes", 9))
        self.scale = (WIDTH - self.left - RIGHT) / self.seconds

    @cached_property
    def times(self) -> Floats:
        """Return seconds of the frames whose stages are shown."""
        times = self.performance.frames.times()
        return times[times <= self.end + 1 / self.animation.fps]

    @cached_property
    def stages(self) -> list[Stage]:
        performance = self.performance
        stop = min(performance.frames.count, len(self.times) + performance.halo())
        if performance.motion.smooth == "chord":  # its tops may be as long as the whole
            stop = performance.frames.count
        made = performance.stages(0, stop)
        return [Stage(name, curves[:, : len(self.times)]) for name, curves in made]

    @cached_property
    def moving(self) -> Bools:
        """Return (P,) True for the poses that move in any stage."""
        return np.max([stage.curves.max(axis=1) for stage in self.stages], axis=0) > VISIBLE

    @cached_property
    def row(self) -> float:
        """Return the height of a pose's row."""
        rows = max(1, int(self.moving.sum())) * self.strips
        return min(TALLEST_ROW, max(LOWEST_ROW, ALL_ROWS / rows - GAP))
