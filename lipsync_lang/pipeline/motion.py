"""Settings of motion: every setting, its default, and the paper's own values."""

from dataclasses import dataclass
from math import inf
from typing import Literal

LEAST_SPEED = 1.0
"""Weight per second; a slower mouth would start more than 1 s before the first sound."""

SLOW_SPEED = 4.0
"""Slowest weight per second of drafts and fits: a mouth starts 0.3 s before the first sound."""

ADDED_SILENCE_SECONDS = 0.25
"""Most silence that is added to either end: a reach of 10 s is of pauses that are there."""


@dataclass(frozen=True)
class Motion:
    """Settings of the runtime stages; a pose set, a character and a call may each change some."""

    stitch: Literal["max", "crossfade"] = "max"
    """Join of overlapping bigrams: the larger (paper 3.2.1), or a fade from one to the next."""

    warp: Literal["anchored", "linear"] = "anchored"
    """Pin each bigram's own phoneme boundary to the spoken one, or stretch it evenly (paper)."""

    smooth: Literal["closing", "chord", "none"] = "none"
    """Fill valleys by morphological closing, by the paper's chord between maxima, or not at all."""

    window: float = 0.13
    """Seconds; valleys narrower than this are filled."""

    anticipate: float = 1.0
    """Factor of how early poses begin that look ahead; 0 lets none."""

    speed_limit: float = 15.0
    """Weight per second that no pose exceeds (paper 3.2.3)."""

    silence_reach: float = 0.25
    """Seconds of silence that a bigram may use on its silent side."""

    ends: Literal["rest", "cut"] = "rest"
    """Rest in silence put before the first sound and after the last, or the phonemes as they are:
    the paper's curves begin and end with them."""

    sound_reach: float = 0.3
    """Seconds of a sound in which its bigrams move; the middle of a longer sound is held."""

    contacts: Literal["hold", "free"] = "hold"
    """Contacts are sure to be reached, or left to the curves."""

    limit: Literal["before", "after"] = "before"
    """Speed is limited before the constraints, or after them (paper).

    After them it can only lower curves, contacts included.
    """

    thresholds: Literal["own", "paper"] = "own"
    """Constraints at the pose set's own thresholds, or at those it states as the paper's."""

    softness: float = 1.0
    """Factor of the half-widths over which poses are rounded off; 0 leaves their corners."""

    stress: float = 1.0
    """Factor of how far stress opens vowels, and its lack closes them; 0 has none."""

    loudness: float = 1.0
    """Factor of how far loudness moves the mouth, where there is sound; 0 has none."""

    reference_level: float = -26.0
    """Level of ordinary speech in a recording, in dBFS over its sounds.

    The level to which speech is usually normalised (ITU-T P.56, G.191).
    """

    hold: float = 0.0
    """Seconds; poses are shown one at a time, each at least as long. At 0 they blend."""

    @property
    def added_silence(self) -> float:
        """Seconds of silence at least at both ends, for the mouth to begin and end at rest."""
        return min(self.silence_reach, ADDED_SILENCE_SECONDS) if self.ends == "rest" else 0.0


PRESETS = {
    "default": Motion(),
    "paper": Motion(
        warp="linear",
        silence_reach=inf,
        ends="cut",
        sound_reach=inf,
        smooth="chord",
        window=0.18,
        anticipate=0,
        contacts="free",
        limit="after",
        thresholds="paper",
        softness=0,
        stress=0,
        loudness=0,
    ),
}
"""Named settings: `paper` is as sections 3.2.1 to 3.2.3 have it."""
