"""Forms of a coverage: one file and one function ``(coverage, stream, asked) -> None`` each."""

from lipsync_lang.coverage.forms.report_forms import FORMS, Asked

__all__ = ["FORMS", "Asked"]
