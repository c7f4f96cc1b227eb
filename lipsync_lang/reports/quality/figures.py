"""Results of the judgement of an animation: figures with findings, and a verdict."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

from lipsync_lang.base.errors import LipsyncError, did_you_mean

LIMIT_TOLERANCE = 1e-3
"""Maximum relative excess over a limit by rounding in files."""

MAX_FINDINGS = 5
"""Maximum number of findings of a figure in text."""


class Finding(NamedTuple):
    """A place in the animation that increases a figure."""

    at: float
    """Seconds."""
    what: str


class Figure(NamedTuple):
    """The value of one measure.

    Parameters
    ----------
    name : the measure, with its contact or rule if it has several figures
    value : None if it could not be judged
    unit : of value and limit
    limit : the highest acceptable value; None for no limit
    parts : components of the value, by pose, pair or count
    findings : places that increase the figure, in order of time; remarks if the figure is 0
    why : reason why it could not be judged; otherwise empty
    """

    name: str
    value: float | None
    unit: str = ""
    limit: float | None = None
    parts: Mapping[str, float] = MappingProxyType({})
    findings: tuple[Finding, ...] = ()
    why: str = ""

    @property
    def passed(self) -> bool:
        """False if the value exceeds its limit."""
        if self.value is None or self.limit is None:
            return True
        # The last term is for limits of 0.
        return self.value <= self.limit * (1 + LIMIT_TOLERANCE) + 1e-9

    @property
    def verdict(self) -> str:
        """`ok`, `FAIL`, or `-` without value or limit."""
        if self.value is None or self.limit is None:
            return "-"
        return "ok" if self.passed else "FAIL"


@dataclass(frozen=True)
class Quality:
    """The figures of one animation.

    Parameters
    ----------
    subject : language, character, frame rate and text
    figures : in the order of the measures
    remarks : notes of the reader
    """

    subject: str
    figures: tuple[Figure, ...]
    remarks: tuple[str, ...] = ()

    @property
    def failed(self) -> tuple[Figure, ...]:
        """The figures that exceed their limits."""
        return tuple(figure for figure in self.figures if not figure.passed)

    @property
    def passed(self) -> bool:
        """True if no figure exceeds its limit."""
        return not self.failed

    @property
    def summary(self) -> str:
        """Counts of the limits that are met, and of the figures that could not be judged."""
        limited = [figure for figure in self.figures if figure.verdict != "-"]
        met = f"{len(limited) - len(self.failed)} of {len(limited)} limits met"
        blank = sum(figure.value is None for figure in self.figures)
        return f"{met}, {blank} not judged" if blank else met

    def __getitem__(self, name: str) -> Figure:
        """Return a figure by name.

        Raises
        ------
        LipsyncError
            There is no such figure.
        """
        known = {figure.name: figure for figure in self.figures}
        if name not in known:
            raise LipsyncError(f"unknown figure '{name}'; {did_you_mean(name, known)}")
        return known[name]

    def __str__(self) -> str:
        lines = [self.subject, *(f"  {remark}" for remark in self.remarks)]
        width = max((len(figure.name) for figure in self.figures), default=0)
        for figure in self.figures:
            told = f"  {figure.verdict:<6}{figure.name:<{width}}  {describe(figure)}"
            lines.append(told.rstrip())
            shown = () if figure.passed and figure.value else figure.findings[:MAX_FINDINGS]
            lines += [f"{' ' * 10}{one.at:.3f} s: {one.what}" for one in shown]
            if shown and len(figure.findings) > MAX_FINDINGS:
                lines.append(f"{' ' * 10}and {len(figure.findings) - MAX_FINDINGS} more")
        return "\n".join([*lines, self.summary])

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain JSON data."""
        rows = [
            figure._asdict()
            | {
                "parts": dict(figure.parts),
                "findings": [finding._asdict() for finding in figure.findings],
                "passed": figure.passed,
            }
            for figure in self.figures
        ]
        return {
            "subject": self.subject,
            "passed": self.passed,
            "remarks": list(self.remarks),
            "figures": rows,
        }


def describe(figure: Figure) -> str:
    """Return a figure's value, limit and largest parts in words."""
    if figure.value is None:
        return f"not judged: {figure.why}"
    most = figure.limit if figure.passed and figure.limit else figure.value  # not past by rounding
    words = f"{min(figure.value, most):.4g} {figure.unit}".rstrip()
    if figure.limit is not None:
        words += f", at most {figure.limit:g}"
    if figure.parts:
        worst = sorted(figure.parts.items(), key=lambda part: -abs(part[1]))[:3]
        words += f" ({', '.join(f'{name} {value:.3g}' for name, value in worst)})"
    return words
