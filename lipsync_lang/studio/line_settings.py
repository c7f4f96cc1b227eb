"""Settings of a line: in seconds while it is open, and in words in the character's file."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from lipsync_lang.performing.delivery import in_seconds, in_words
from lipsync_lang.schedules.schedule import Schedule


@dataclass
class LineSettings:
    """Settings of the performed line; the fields are those of `Performer.perform`."""

    fps: float = 60.0
    line: str | None = None
    styles: dict[str, Any] = field(default_factory=dict)
    dials: dict[str, Any] = field(default_factory=dict)
    intensity: float | None = None
    bends: dict[str, list[list[float]]] = field(default_factory=dict)
    placed: list[dict[str, Any]] = field(default_factory=list)

    @classmethod
    def of(cls, stated: Mapping[str, Any], whole: Schedule, fps: float, line: str | None) -> Self:
        """Return the settings that a character's file states for a whole line."""

        def timed(name: str, points: Any) -> list[list[float]]:
            return [[round(in_seconds(name, at, whole), 5), level] for at, level in points]

        styles, dials = (
            {
                name: points[0][1] if len(points) == 1 else timed(name, points)
                for name, points in stated.get(kind, {}).items()
            }
            for kind in ("styles", "dials")
        )
        bends = {pose: timed(pose, keys) for pose, keys in stated.get("bends", {}).items()}
        placed = [dict(one) for one in stated.get("placed", ())]
        return cls(fps, line, styles, dials, stated.get("intensity"), bends, placed)

    def stated(self, whole: Schedule) -> dict[str, Any]:
        """Return what a character's file states for a whole line."""
        styles, dials, bends = (
            {
                name: [[in_words(at, whole), value] for at, value in level]
                if isinstance(level, list)
                else level
                for name, level in table.items()
            }
            for table in (self.styles, self.dials, self.bends)
        )
        return {
            "styles": brief(styles),
            "dials": brief(dials),
            "bends": bends,
            "intensity": self.intensity,
            "placed": self.placed,
        }


def brief(value: Any) -> Any:
    """Return levels with a number for a single point; other values stay."""
    if not isinstance(value, dict):
        return value
    # A pack writes a constant as a number, and a list of one point would read like a change.
    single = {name: level for name, level in value.items() if np.shape(level) == (1, 2)}
    return value | {name: level[0][1] for name, level in single.items()}
