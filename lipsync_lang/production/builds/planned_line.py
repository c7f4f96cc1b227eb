"""Lines of a build, before and after they are made."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from lipsync_lang.schedules.schedule import DOUBTFUL

LIMIT_FACTOR, LIMIT_STEP = 1.001, 1e-9
"""Factor and step by which a value may pass its limit, since values are rounded."""

CONFIDENCE = "confidence"
"""Limit of a project that is a minimum: the confidence of an alignment."""

Outcome = Literal["built", "failed"]
"""`built`: its outputs are complete. `failed`: it has no outputs."""

Verdict = Literal["failed", "over", "doubted", "passed"]
"""`over` and `doubted`: built, but past a limit of the project, or of the face alone."""


@dataclass(slots=True, unsafe_hash=True)  # frozen, a million of them take 8 s more
class PlannedLine:
    """A line of the script in one language, on one character.

    Parameters
    ----------
    name : the line's id in its table
    text : the text as the table has it, with its marks of emphasis; empty for timings alone
    speaker : name of the speaker in the table; may be empty
    place : `file:line` of the text
    timings : path of its timed phonemes, or None
    audio : path of its recording, or None
    outputs : files to write, as (writer, path from the project's folder)
    """

    name: str
    language: str
    character: str
    text: str
    speaker: str
    place: str
    timings: str | None
    audio: str | None
    outputs: tuple[tuple[str, str], ...]

    @property
    def key(self) -> tuple[str, str, str]:
        """Language, character and name: no two lines of a build share them."""
        return self.language, self.character, self.name


class JudgedFigure(NamedTuple):
    """Figure of a built line, as the report shows it."""

    name: str
    value: float | None
    """Value; None if the line could not be judged."""
    unit: str
    limit: float | None
    at: Sequence[float] = ()
    """Times of its first findings in seconds."""
    words: str = ""
    """First finding in words, or the reason for a missing judgement."""
    binding: bool = True
    """True if the project states the limit; the limits of a face alone are advice."""

    @property
    def passed(self) -> bool:
        """False if the value exceeds its limit."""
        if self.value is None or self.limit is None:
            return True
        return self.value <= self.limit * LIMIT_FACTOR + LIMIT_STEP


@dataclass(frozen=True)
class BuiltLine:
    """Planned line with its outcome, and the figures of quality for the report."""

    line: PlannedLine
    outcome: Outcome
    message: str = ""
    """Why it failed, located and mendable; else remarks, may be empty."""
    seconds: float = 0.0
    """Length of the animation."""
    confidence: float | None = None
    """Fit of the timings to the recording, in [0, 1]; None if nothing was aligned."""
    figures: tuple[JudgedFigure, ...] = ()
    left_out: tuple[str, ...] = ()
    """Words of the text that the recording lacks."""

    @property
    def verdict(self) -> Verdict:
        """Category of the line in the counts of a build."""
        if self.outcome == "failed":
            return "failed"
        if self.failed:
            return "over"
        # only the face's own limits are left
        return "passed" if all(one.passed for one in self.figures) else "doubted"

    @property
    def unsure(self) -> bool:
        """True if the recording may not hold the text of the line."""
        return self.confidence is not None and self.confidence < DOUBTFUL

    @property
    def failed(self) -> tuple[JudgedFigure, ...]:
        """The figures that exceed limits of the project, which fails the build."""
        return tuple(one for one in self.figures if one.binding and not one.passed)


def recorded_path(folder: Path, path: str) -> str:
    """Return a file as records name it: from the project's folder, or in full outside of it.

    >>> recorded_path(Path("/game"), "/game/vo/l1.wav")
    'vo/l1.wav'
    """
    return path.removeprefix(f"{folder}{os.sep}")
