"""Output forms of a coverage document.

Each form is a module with a function ``write(coverage, stream, asked) -> None``.
"""

from lipsync_lang.coverage.forms.report_forms import FORMS, Asked

__all__ = ["FORMS", "Asked"]
