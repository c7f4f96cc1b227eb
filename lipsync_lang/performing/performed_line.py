"""The performer behind an animation, with its settings for the line."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.animations.explanation import Explanation
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.pipeline.perform import Performance


@dataclass(frozen=True)
class PerformedLine:
    """Source of an animation that a performer made: it can be repeated, and explained.

    Parameters
    ----------
    performer : the performer that made the animation
    settings : options of `Performer.perform`: line name, styles, dials, intensity and gestures
    """

    performer: "Performer"
    settings: Mapping[str, Any]

    @classmethod
    def of(cls, animation: "Animation") -> Self | None:
        """Return the performed line of an animation; None for curves of another program."""
        return animation.source if isinstance(animation.source, cls) else None

    def performance(self, animation: "Animation") -> "Performance":
        """Repeat the performance of an animation, with access to each stage."""
        beside = {"gestures", "placed", "whole"}
        spoken = {name: value for name, value in self.settings.items() if name not in beside}
        return self.performer.performance(animation.schedule, animation.fps, **spoken)

    def explain(self, animation: "Animation", seconds: float) -> "Explanation":
        """Explain the weight of each pose at a time."""
        from lipsync_lang.performing.trace import explain

        return explain(self, animation, seconds)


def performer_of(animation: "Animation") -> "Performer | None":
    """Return the performer that made an animation; None for curves of another program."""
    line = PerformedLine.of(animation)
    return line.performer if line else None
