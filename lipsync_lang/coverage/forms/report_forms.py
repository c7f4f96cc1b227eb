"""Forms of a coverage report and their options."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TextIO

from lipsync_lang.extensions import Extensions

if TYPE_CHECKING:
    from lipsync_lang.coverage.report import Coverage


@dataclass(frozen=True)
class Asked:
    """Options of a report's form.

    Parameters
    ----------
    everything : all rows, where a form would shorten its lists
    fail_under : percent that must be authored; None where nothing must
    """

    everything: bool = False
    fail_under: float | None = None


Write = Callable[["Coverage", TextIO, Asked], None]

FORMS: Extensions[Write] = Extensions(
    "coverage_forms",
    "coverage format",
    modules={name: f"{__package__}.{name}" for name in ("text", "json", "html", "csv", "junit")},
)
"""Functions that write a form, by its name."""

SUFFIXES = {".json": "json", ".html": "html", ".csv": "csv", ".xml": "junit"}
"""The form of a file that is named without one; all other files are text."""
