"""Stream frames: the final frames of a stream, and their weights.

Times are seconds; frames are counted from the first of the stream. The stages run on a window
around the frames, within their look-back and look-ahead.
"""

from math import isinf
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.heard import HeardLabels, begun_trigrams, open_trigram
from lipsync_lang.performing.stress import ramped_level, vowel_level
from lipsync_lang.pipeline.hold import MARGIN
from lipsync_lang.pipeline.levels import Blend, Dial
from lipsync_lang.pipeline.look_ahead import LookAhead, widened
from lipsync_lang.pipeline.perform import Frames, perform
from lipsync_lang.pipeline.prepare import prepare
from lipsync_lang.pipeline.track import lay_track

if TYPE_CHECKING:
    from lipsync_lang.performing.played_pair import PlayedPair

ENDLESS = {
    "smooth": ("smooth", "smooth=none"),
    "switch": ("hold", "hold=0"),
    "rest": ("ends", "ends=rest"),
    "stitch": ("silence_reach", "silence_reach=0.25"),
}
"""The setting of each stage with an unlimited look-ahead, and the value that limits it."""


class StreamFrames:
    """The frames of one stream.

    Parameters
    ----------
    blends, dials : styles and dials of the whole stream
    emphasis : True if words with emphasis are expected
    """

    def __init__(
        self,
        performer: "PlayedPair",
        fps: float,
        blends: tuple[Blend, ...],
        dials: tuple[Dial, ...],
        *,
        emphasis: bool,
    ) -> None:
        self.performer, self.fps = performer, fps
        self.motion = performer.styled_motion(blends)
        self.blends, self.dials, self.emphasis = blends, dials, emphasis
        self.tables = performer.tables(blends)
        shown = self.tables.papers if self.motion.thresholds == "paper" else self.tables
        prepared = prepare(shown, self.motion, fps)
        for stage, look in prepared.reach.items():
            if isinf(look.ahead):
                setting, cure = ENDLESS[stage]
                raise LipsyncError(
                    f"the motion's `{setting}` needs the whole line, so no frame of a stream is "
                    f"ever final; perform whole lines, or set motion.{cure}"
                )
        self.ahead = LookAhead.of(prepared, self.motion, fps)
        self.lead: int | None = None
        """Number of frames before the schedule starts; None until it is known."""
        self.count: int | None = None
        """Number of frames of the whole stream; None until its end is known."""

    def settled(self, heard: HeardLabels) -> int:
        """Return the number of frames that are final with the labels so far."""
        if self.count is not None:
            return self.count
        if not heard.sounds:
            return 0
        if self.lead is None:
            lead = self._lead_in(heard)
            if lead and heard.opening is None:
                return 0
            self.lead = lead
        reach, linear = self.motion.silence_reach, self.motion.warp == "linear"
        clear = held = heard.clear(reach, linear=linear, emphasis=self.emphasis)
        if self.motion.contacts == "hold":
            held = heard.held(MARGIN, widened(self.fps))
        unsure = open_trigram(heard, self.tables, reach)
        if unsure is not None:
            clear = min(clear, unsure)
            held = min(held, unsure - max(MARGIN, widened(self.fps)))
        least = self.ahead.stop(heard.until - heard.start, heard.closing(reach))
        final = self.ahead.settled(clear - heard.start, held - heard.start, least)
        return max(final + self.lead, 0)

    def finish(self, heard: HeardLabels) -> None:
        """Count all frames of a stream that ends with the labels so far."""
        if self.lead is None:
            self.lead = self._lead_in(heard)
        self.count = self.counted(heard)

    def counted(self, heard: HeardLabels, end: float | None = None) -> int:
        """Count the frames of a stream that ends with the labels so far, or in silence at `end`."""
        reach = self.motion.added_silence
        until, closing = (heard.until, heard.closing(reach)) if end is None else (end, reach)
        return (self.lead or 0) + self.ahead.stop(until - heard.start, closing)

    def _lead_in(self, heard: HeardLabels) -> int:
        opening = heard.opening
        return self.ahead.lead_in(heard.until - heard.start if opening is None else opening)

    def needed(self, begin: int) -> int:
        """Return the first frame of the window for frames from `begin` on."""
        low = begin - self.ahead.before
        # near the start the ramp from rest still counts, so the window begins with the line
        return low if low >= self.ahead.ramp else 0

    def weights(self, heard: HeardLabels, begin: int, stop: int) -> Floats:
        """Return the weights of some final frames: (k, P)."""
        low, high = self.needed(begin), stop + self.ahead.ahead
        if self.count is not None:
            high = min(high, self.count)
        # more frames if the line goes on, since the stages bring the mouth to rest at both ends
        more = self.ahead.ramp if low else 0
        beyond = self.ahead.ramp if high != self.count else 0
        frames = self.laid(heard, low - more, high + beyond)
        times = self.seconds(heard, low), self.seconds(heard, high)
        ids, bounds, opening = heard.between(*times, begun_trigrams(heard, self.tables))
        # no label numbers: the track reads only whether a sound was scheduled
        source = np.arange(len(ids))
        track = lay_track(
            ids, bounds, source, self.tables, self.motion, self.blends, opening=opening
        )
        performance = perform(
            self.tables,
            track,
            self.motion,
            self.fps,
            overlays=heard.overlays(),
            blends=self.blends,
            dials=(*self.dials, *self._effort(heard)),
            frames=frames,
        )
        first = begin - low + more
        return performance.weights()[first : first + stop - begin]

    def _effort(self, heard: HeardLabels) -> tuple[Dial, ...]:
        """Return the dials of stress and emphasis around a window."""
        out = []
        poses = self.performer.opening_poses
        if heard.vowels:
            out.append(Dial(poses, vowel_level(*heard.stressed()), "stress"))
        words = [word for word in heard.words if word.high]
        if words:
            level = ramped_level([word.ramp for word in words], [word.high for word in words])
            out.append(Dial(poses, level, "emphasis"))
        return tuple(out)

    def forget(self, heard: HeardLabels, given: int) -> None:
        """Forget the labels on which no frame after the returned ones depends."""
        since = self.seconds(heard, self.needed(given))
        heard.forget(since, begun_trigrams(heard, self.tables))

    def laid(self, heard: HeardLabels, begin: int, stop: int) -> Frames:
        """Return frames `begin` to `stop`."""
        return Frames(heard.start, begin - (self.lead or 0), stop - begin, self.fps)

    def seconds(self, heard: HeardLabels, frame: int) -> float:
        """Return the time of a frame."""
        return heard.start + (frame - (self.lead or 0)) / self.fps
