"""Output forms of a coverage document.

Each form is a function ``(coverage, stream, options) -> None``.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TextIO

from lipsync_lang.base.extensions import Extensions

if TYPE_CHECKING:
    from lipsync_lang.reports.coverage.report import Coverage


@dataclass(frozen=True)
class FormOptions:
    """Options of a report's form."""

    everything: bool = False
    """True for all rows, instead of shortened lists."""
    fail_under: float | None = None
    """Percentage that must be authored; None for no minimum."""


Write = Callable[["Coverage", TextIO, FormOptions], None]

FORMS: Extensions[Write] = Extensions(
    "coverage_forms",
    "coverage format",
    modules={
        "text": f"{__package__}.text",
        **dict.fromkeys(("json", "html", "csv", "junit"), f"{__package__}.whole"),
    },
)
"""Writer functions by the name of the form."""

SUFFIXES = {".json": "json", ".html": "html", ".csv": "csv", ".xml": "junit"}
"""Forms by the suffix of the file; all other files are text."""
