"""Which forms of a coverage there are, and what may be asked of them."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, TextIO, cast

if TYPE_CHECKING:
    from lipsync_lang.coverage.report import Coverage


@dataclass(frozen=True)
class Asked:
    """How a form is wanted.

    Parameters
    ----------
    everything : all rows, where a form would shorten its lists
    fail_under : percent that must be authored; None where nothing must
    """

    everything: bool = False
    fail_under: float | None = None


Write = Callable[["Coverage", TextIO, Asked], None]

FORMS: dict[str, str] = {
    "text": "lipsync_lang.coverage.forms.text:write",
    "json": "lipsync_lang.coverage.forms.json:write",
    "html": "lipsync_lang.coverage.forms.html:write",
    "csv": "lipsync_lang.coverage.forms.csv:write",
    "junit": "lipsync_lang.coverage.forms.junit:write",
}
"""Forms by name: where the function is that writes one."""

SUFFIXES = {".json": "json", ".html": "html", ".csv": "csv", ".xml": "junit"}
"""The form of a file that is named without one; all other files are text."""


def find_form(name: str) -> Write:
    """Return what writes a form."""
    module, _, function = FORMS[name].partition(":")
    return cast("Write", getattr(import_module(module), function))
