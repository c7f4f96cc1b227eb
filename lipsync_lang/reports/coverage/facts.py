"""Base of the document's models, and the common figures of reports and the total."""

from pydantic import BaseModel, ConfigDict

AUTHORED = frozenset(("edited", "approved"))
BORROWED_LAYER = "like"


class Fact(BaseModel):
    """A part of the document."""

    model_config = ConfigDict(frozen=True, use_attribute_docstrings=True)


class AuthoredShare(Fact):
    """The needed bigrams that are authored."""

    bigrams: int
    percent: float


class WorkLeft(Fact):
    """The needed bigrams that are left to author."""

    bigrams: int
    hours: float


class NextHour(Fact):
    """The bigrams to author in the next hour."""

    bigrams: tuple[str, ...]
    percent: float


def authored(layer: str, status: str) -> bool:
    """Return True if a person drew a bigram; drafts and borrowed curves do not count."""
    return status in AUTHORED and layer != BORROWED_LAYER
