"""Output forms of a coverage document.

Each form is a module with a function ``write(coverage, stream, options) -> None``.
"""

from lipsync_lang.coverage.forms.report_forms import FORMS, FormOptions

__all__ = ["FORMS", "FormOptions"]
