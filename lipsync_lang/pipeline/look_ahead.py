"""Look-ahead: the part of the line that must be known before a frame is final.

Conventions: lengths are whole frames unless said otherwise. A frame at t is final as soon as a
common phoneme is known that starts later than t by what the stages look ahead: only then are the
end of every phoneme before it, and what follows each, known for sure. Of a silence it is enough to
know that it lasts `Motion.silence_reach` longer, for no bigram reaches farther into it.

The paper computes whole utterances.
"""

from dataclasses import dataclass
from math import ceil
from typing import Self

from lipsync_lang.pipeline.hold import MARGIN, SHORTEST
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.perform import frames_until
from lipsync_lang.pipeline.prepare import StageValues

CLEAR_SECONDS = 1e-6
"""Seconds by which a frame lies before a boundary, so that rounding never puts it behind."""

_WANTED = ("smooth", "anticipate", "ease")
_PROMISED = ("limit", "soften")


@dataclass(frozen=True)
class LookAhead:
    """Numbers of frames around a frame that the stages of a motion depend on."""

    motion: Motion
    fps: float
    wanted: int
    """Frames ahead on which the stages before the contacts depend."""
    promised: int
    """Frames ahead on which the stages after the contacts depend."""
    before: int
    """Frames back on which all stages depend."""
    ramp: int
    """Frames from either end of the animation that rest influences."""
    lead: int
    """Frames from rest to the first held frame of a contact."""
    stages: dict[str, float]
    """Seconds that each stage looks ahead; they add up to `seconds`."""

    @classmethod
    def of(cls, prepared: StageValues, motion: Motion, fps: float) -> Self:
        """Add up the dependencies of the stages.

        Raises OverflowError if a stage looks at any distance.
        """
        reach = prepared.reach
        ahead = {name: int(look.ahead) for name, look in reach.items()}
        wanted = sum(ahead.get(name, 0) for name in _WANTED)
        promised = sum(ahead.get(name, 0) for name in _PROMISED)
        back = sum(int(look.back) for name, look in reach.items() if name != "rest")
        ramp = prepared.ramps.shape[1]
        stages = {name: ahead[name] / fps for name in (*_WANTED, *_PROMISED) if ahead.get(name)}
        if motion.contacts == "hold":
            stages["hold"] = max(max(MARGIN, widened(fps)) - wanted / fps, 0.0)
        resting = (ramp + 1) / fps - motion.added_silence
        stages["rest"] = max(resting - max(wanted / fps, stages.get("hold", 0.0)), 0.0)
        shown = {name: seconds for name, seconds in stages.items() if seconds > 0}
        return cls(motion, fps, wanted, promised, back, ramp, prepared.lead, shown)

    @property
    def ahead(self) -> int:
        """Frames ahead on which all stages depend, except for contacts and the end."""
        return self.wanted + self.promised

    @property
    def seconds(self) -> float:
        """Seconds that all stages together look ahead."""
        return sum(self.stages.values())

    def lead_in(self, opening: float) -> int:
        """Return the frames before the start of a line with some seconds of initial silence."""
        return frames_until(0, -opening, self.motion.added_silence, self.lead, self.fps)

    def stop(self, length: float, closing: float) -> int:
        """Return the frames from the start to past the end of a line.

        Parameters
        ----------
        length : seconds of the line
        closing : seconds of silence at its end
        """
        reach = self.motion.added_silence
        return frames_until(length, length - closing, reach, self.lead, self.fps) + 1

    def settled(self, clear: float, held: float, least: int) -> int:
        """Return the number of final frames from the start of the line.

        Parameters
        ----------
        clear : seconds before which bigrams and dials are known
        held : seconds before which held contacts are known
        least : frames that the line has for sure
        """
        raised = self._frames(clear) - self.wanted
        return min(raised, self._frames(held), least - self.ramp) - self.promised

    def _frames(self, seconds: float) -> int:
        """Return the number of frames from the start of the line to a time."""
        return ceil((seconds - CLEAR_SECONDS) * self.fps)


def widened(fps: float) -> float:
    """Return the seconds before its start in which a short phoneme may hold its contact."""
    return max(SHORTEST, 1 / fps) / 2
