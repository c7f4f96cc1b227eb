"""Explanation of one frame: its phoneme, its bigrams, and the effect of each stage on each pose."""

from dataclasses import asdict, dataclass
from typing import Any

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
        where = f", in '{self.word}'" if self.word else ""
        common = f"{self.common} (a shade of {self.shade_of})" if self.shade_of else self.common
        sound = f"{self.phoneme} as {common}, {self.start:.3f} to {self.end:.3f} s{where}"
        lines = [f"{self.seconds:.3f} s (frame {self.frame}): {sound}"]
        if self.likely:
            told = ", ".join(f"{label} {chance:.2f}" for label, chance in self.likely)
            lines.append(f"  likeliest by sound: {told}")
        for bigram in self.bigrams:
            example = f", as in {bigram.word}" if bigram.word else ""
            drawn = f", drawn as {'-'.join(bigram.drawn_as)}" if bigram.drawn_as else ""
            lines.append(
                f"  {bigram.unit} {'-'.join(bigram.pair)} at {bigram.position:.2f}{example}: "
                f"{bigram.layer}, {bigram.status or 'none'}{drawn}"
            )
            lines.extend(f"    {place}" for place in bigram.places)
            for one in bigram.styles:
                told = f"{one.layer}, {one.status}"
                lines.append(f"    style {one.style} {one.share:.2f}: {told}")
                lines.extend(f"      {place}" for place in one.places)
        resting = []
        for pose in self.poses:
            steps = [f"    {s.stage:<9} {s.weight:.3f}  {s.why}" for s in pose.stages if s.why]
            if steps:
                lines += [f"  {pose.pose} = {pose.weight:.3f}", *steps]
            else:
                resting.append(pose.pose)
        return "\n".join([*lines, f"  at rest: {', '.join(resting)}"] if resting else lines)
