"""Coverage: bigrams that a corpus needs, bigrams that a character has, and bigrams to draw next.

- `coverage` reads lines in one or several languages, for one or several characters.
- `Coverage.to_dict` returns the document from which all other forms are made.

A bigram is *authored* if a bank has it edited or approved. Drafts are not authored, and neither are
bigrams fitted to captures, nor curves that an added phoneme borrows from a similar one.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lipsync_lang.reports.coverage.matrix import coverage
    from lipsync_lang.reports.coverage.report import Coverage

__all__ = ["Coverage", "coverage"]


def __getattr__(name: str) -> object:
    """Import a public name at its first use."""
    homes = {"coverage": "matrix", "Coverage": "report"}
    if name in homes:
        return getattr(import_module(f"{__name__}.{homes[name]}"), name)
    raise AttributeError(f"module 'lipsync_lang.reports.coverage' has no attribute '{name}'")
