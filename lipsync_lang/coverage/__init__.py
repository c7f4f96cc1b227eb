"""Coverage: which bigrams a corpus needs, which a character has, and what to author next.

- `coverage` reads lines in one or several languages, for one or several characters.
- `Coverage.to_dict` is the document that all other forms are made of.

A bigram is *authored* where a bank has it edited or approved. A draft is not, and neither is what
an added phoneme borrows from the one it is like.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lipsync_lang.coverage.matrix import coverage
    from lipsync_lang.coverage.report import Coverage

__all__ = ["Coverage", "coverage"]


def __getattr__(name: str) -> object:
    """Import what is public when it is asked for."""
    if name == "coverage":
        from lipsync_lang.coverage.matrix import coverage

        return coverage
    if name == "Coverage":
        from lipsync_lang.coverage.report import Coverage

        return Coverage
    raise AttributeError(f"module 'lipsync_lang.coverage' has no attribute '{name}'")
