"""An explanation of one frame: its phoneme, its bigrams, and what each stage did to each pose."""

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class BigramAt:
    """A bigram that covers the frame."""

    pair: tuple[str, str]
    position: float
    """Normalised time in the bigram."""
    layer: str
    status: str
    places: tuple[str, ...]
    """file:line:column of its data; of both targets where it was drafted."""
    word: str | None
    styles: tuple["StyleAt", ...] = ()
    """What of it is heard in another manner."""


@dataclass(frozen=True)
class StyleAt:
    """A style that changes a bigram, and where that is written."""

    style: str
    share: float
    layer: str
    status: str
    places: tuple[str, ...]


@dataclass(frozen=True)
class StageAt:
    """What a stage made of a pose, and why, where it changed it."""

    stage: str
    weight: float
    why: str


@dataclass(frozen=True)
class PoseAt:
    """A pose's way through the stages."""

    pose: str
    weight: float
    bigrams: tuple[float, ...]
    """The value each of the bigrams gives it, in their order."""
    stages: tuple[StageAt, ...]


@dataclass(frozen=True)
class Explanation:
    """One frame, explained; prints itself."""

    seconds: float
    frame: int
    phoneme: str
    """The scheduled label; silence outside the schedule."""
    index: int | None
    """Its place in the schedule."""
    common: str
    start: float
    end: float
    word: str | None
    bigrams: tuple[BigramAt, ...]
    poses: tuple[PoseAt, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, for JSON."""
        return asdict(self)

    def __str__(self) -> str:
        where = f", in '{self.word}'" if self.word else ""
        sound = f"{self.phoneme} as {self.common}, {self.start:.3f} to {self.end:.3f} s{where}"
        lines = [f"{self.seconds:.3f} s (frame {self.frame}): {sound}"]
        for bigram in self.bigrams:
            example = f", as in {bigram.word}" if bigram.word else ""
            lines.append(
                f"  bigram {'-'.join(bigram.pair)} at {bigram.position:.2f}{example}: "
                f"{bigram.layer}, {bigram.status or 'none'}"
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
