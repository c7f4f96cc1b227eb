"""Explanation of one frame: its phoneme, its bigrams, and the effect of each stage on each pose."""

from dataclasses import asdict, dataclass
from typing import Any

from lipsync_lang.base.presentation.text_templates import filled

BIGRAM_SIZE = 2
"""Phonemes of a bigram."""


@dataclass(frozen=True)
class BigramAt:
    """A bigram, or a trigram, that covers the frame."""

    pair: tuple[str, ...]
    """Its phonemes: two, or three of a trigram."""
    position: float
    """Normalised time within it."""
    layer: str
    status: str
    places: tuple[str, ...]
    """file:line:column of its data; both targets for a draft."""
    word: str | None
    styles: tuple["StyleAt", ...] = ()
    """Styles that change the bigram at this time."""
    drawn_as: tuple[str, ...] | None = None
    """The phonemes whose curves are played, if a bank draws those instead: the shades' parents."""

    @property
    def unit(self) -> str:
        """The kind of unit."""
        return "bigram" if len(self.pair) == BIGRAM_SIZE else "trigram"


@dataclass(frozen=True)
class StyleAt:
    """A style that changes a bigram, and the location of its data."""

    style: str
    share: float
    layer: str
    status: str
    places: tuple[str, ...]


@dataclass(frozen=True)
class StageAt:
    """Weight of a pose after one stage, and the reason for a change."""

    stage: str
    weight: float
    why: str


@dataclass(frozen=True)
class PoseAt:
    """Weights of a pose through all stages."""

    pose: str
    weight: float
    bigrams: tuple[float, ...]
    """Value of the pose in each bigram, in the order of the bigrams."""
    stages: tuple[StageAt, ...]


@dataclass(frozen=True)
class Explanation:
    """Explanation of one frame; `str` gives a readable report."""

    seconds: float
    frame: int
    phoneme: str
    """Schedule label; silence outside the schedule."""
    index: int | None
    """Index of the phoneme in the schedule."""
    common: str
    start: float
    end: float
    word: str | None
    bigrams: tuple[BigramAt, ...]
    poses: tuple[PoseAt, ...]
    shade_of: str | None = None
    """The parent of the common phoneme, if it is a shade."""
    likely: tuple[tuple[str, float], ...] = ()
    """The likeliest labels with their probability, where the sound alone was heard."""

    def to_dict(self) -> dict[str, Any]:
        """Return a plain dictionary, for JSON."""
        return asdict(self)

    def __str__(self) -> str:
        resting = [pose.pose for pose in self.poses if not any(one.why for one in pose.stages)]
        values = {**vars(self), "resting": resting}
        return filled(__package__, "explanation", values).removesuffix("\n")
