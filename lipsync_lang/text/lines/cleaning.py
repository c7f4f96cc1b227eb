"""Settings of the cleaning of a script, apart from the patterns of `markup`, which load slowly."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Cleaning:
    """Settings of the cleaning of a script's text.

    Parameters
    ----------
    values : values of placeholders, by name
    unspoken : passages to leave out: their text, or their two ends with ``...`` between them
    asides : the language's words of asides
    """

    values: Mapping[str, str] = field(default_factory=dict)
    unspoken: tuple[str, ...] = ()
    asides: tuple[str, ...] = ()


AS_WRITTEN = Cleaning()
