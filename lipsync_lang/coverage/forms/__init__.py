"""Forms of a coverage: one file and one function ``(coverage, stream, asked) -> None`` each."""

from lipsync_lang.coverage.forms.registry import FORMS, Asked, find_form

__all__ = ["FORMS", "Asked", "find_form"]
