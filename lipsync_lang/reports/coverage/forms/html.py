"""HTML: one page with its style and script inside."""

from typing import TYPE_CHECKING, TextIO

from lipsync_lang.reports.coverage.forms import FORMS, FormOptions

if TYPE_CHECKING:
    from lipsync_lang.reports.coverage.report import Coverage


@FORMS.register("html")
def write(coverage: "Coverage", out: TextIO, options: FormOptions) -> None:
    """Write the page."""
    from lipsync_lang.reports.coverage.page import page

    del options  # it is always whole
    out.write(page(coverage.to_dict()))
