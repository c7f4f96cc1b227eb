"""What judging an animation gives: figures, what was found where, and a verdict."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

from lipsync_lang.errors import LipsyncError, did_you_mean

ROUNDING = 1e-3
"""Share of a limit by which files that round their numbers may pass it."""

MANY = 5
"""As many findings of one figure as text lists."""


class Finding(NamedTuple):
    """One place that counts against a figure."""

    at: float
    """Seconds."""
    what: str


@dataclass(frozen=True)
class Figure:
    """What one measure came to.

    Parameters
    ----------
    name : the measure, and of what it is one of several
    value : None where it could not be judged
    unit : of value and limit
    limit : the most that is sound; None where nothing is asked
    parts : what the value is made of: by pose, pair or count
    findings : where, in order of time
    why : what kept it from being judged
    """

    name: str
    value: float | None
    unit: str
    limit: float | None = None
    parts: Mapping[str, float] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()
    why: str = ""

    @property
    def passed(self) -> bool:
        """Whether the value keeps to its limit; what is not judged does."""
        if self.value is None or self.limit is None:
            return True
        return self.value <= self.limit * (1 + ROUNDING) + 1e-9

    @property
    def verdict(self) -> str:
        """The same in a word: `ok`, `FAIL`, or `-` where nothing is asked."""
        if self.value is None or self.limit is None:
            return "-"
        return "ok" if self.passed else "FAIL"


@dataclass(frozen=True)
class Quality:
    """The figures of one animation.

    Parameters
    ----------
    subject : what was judged, in words
    figures : in the order in which measures are told
    remarks : what is worth knowing about how it was judged
    """

    subject: str
    figures: tuple[Figure, ...]
    remarks: tuple[str, ...] = ()

    @property
    def failed(self) -> tuple[Figure, ...]:
        """The figures past their limits."""
        return tuple(figure for figure in self.figures if not figure.passed)

    @property
    def passed(self) -> bool:
        """Whether no figure is past its limit."""
        return not self.failed

    def __getitem__(self, name: str) -> Figure:
        """Return the figure of a name."""
        known = {figure.name: figure for figure in self.figures}
        if name not in known:
            raise LipsyncError(f"no figure '{name}' here; {did_you_mean(name, known)}")
        return known[name]

    def __str__(self) -> str:
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        yield self.subject
        yield from (f"  {remark}" for remark in self.remarks)
        width = max((len(figure.name) for figure in self.figures), default=0)
        for figure in self.figures:
            yield f"  {figure.verdict:<6}{figure.name:<{width}}  {told(figure)}".rstrip()
            if not figure.passed:
                yield from (f"{' ' * 10}{f.at:.3f} s: {f.what}" for f in figure.findings[:MANY])
                if len(figure.findings) > MANY:
                    yield f"{' ' * 10}and {len(figure.findings) - MANY} more"
        judged = [figure for figure in self.figures if figure.limit is not None]
        yield f"{len(judged) - len(self.failed)} of {len(judged)} limits kept"

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as JSON holds them."""
        rows = [
            asdict(figure)
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


def told(figure: Figure) -> str:
    """Return a figure's value, limit and worst part in words."""
    if figure.value is None:
        return f"not judged: {figure.why}"
    words = f"{figure.value:.4g} {figure.unit}".rstrip()
    if figure.limit is not None:
        words += f", at most {figure.limit:g}"
    if figure.parts:
        worst = sorted(figure.parts.items(), key=lambda part: -abs(part[1]))[:3]
        words += f" ({', '.join(f'{name} {value:.3g}' for name, value in worst)})"
    return words
