"""The description of a fault code: its meaning, its usual cause and its cure."""

from dataclasses import dataclass


@dataclass(frozen=True)
class FaultCode:
    """A kind of fault in packs, as the reference describes it."""

    meaning: str
    """The mistake, as a sentence."""

    cause: str
    """The usual reasons for the mistake."""

    cure: str
    """The way to mend it; may link to pages beside the reference of faults."""
