"""Make the notations of a language: its own, and other spellings of its IPA.

The signs of notations such as X-SAMPA, and the invisible marks, come from the IPA pack:
`{"spelled": {notation: {sign: IPA}}, "unseen": {mark: letters on which it is visible}}`.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from lipsync_lang.phonology.labels import Notation, Value


@dataclass(frozen=True, eq=False)
class EncodedNotation(Notation):
    """A notation that spells the labels of its table in other signs, the longest sign first."""

    signs: Mapping[str, str] = field(default_factory=dict)

    def text(self, label: str) -> str | None:
        """Return a label in the table's spelling; None if it has an unknown sign."""
        longest = max(map(len, self.signs), default=0)
        text, rest = "", label.strip()
        while rest:
            sign = next((rest[:n] for n in range(longest, 0, -1) if rest[:n] in self.signs), "")
            if not sign:
                return None
            text, rest = text + self.signs[sign], rest[len(sign) :]
        return text

    def stress(self, label: str) -> int | None:
        """Return the stress that a label is marked with; None for a label without a mark."""
        text = self.text(label)
        return None if text is None else super().stress(text)

    def spells(self, label: str) -> bool:
        """Return True if the table has what a label spells."""
        text = self.text(label)
        return text is not None and super().spells(text)

    def likely(self, label: str) -> Value | None:
        """Return a value by likeness for a label missing from the table; None if unknown."""
        text = self.text(label)
        return None if text is None else super().likely(text)

    def suggest(self, label: str) -> str:
        """Return a hint for a label missing from the table."""
        text = self.text(label)
        return "a sign of it is unknown" if text is None else f"it is read as '{text}'"

    def _stated(self, label: str) -> Value | None:
        text = self.text(label)
        found = None if text is None else super()._stated(text)
        return self.silence if found is None and self.is_silence(label) else found


def ready(  # noqa: PLR0913, PLR0917 the tables of a language
    tables: Mapping[str, Mapping[str, Value]],
    silences: Collection[str],
    silence: Value,
    ipa: str,
    spelling: Mapping[str, Any],
    nearest: Callable[[str], Value | None] | None = None,
    stress_digits: Collection[str] = (),
) -> dict[str, Notation]:
    """Return tables as notations, followed by other spellings of the IPA, if any.

    Parameters
    ----------
    tables : by name; one named as a way to spell the IPA is taken instead of that
    silences, silence : spellings of silence, and what they stand for
    ipa : the name of the IPA's table
    spelling : how the IPA is spelled, and which of its marks are not seen
    nearest : answers for IPA that the table lacks
    stress_digits : names of the tables whose labels may end in a stress digit
    """
    made = {
        name: Notation(table, silences, silence, digits=name in stress_digits)
        for name, table in tables.items()
    }
    if ipa in tables:
        rest = (tables[ipa], silences, silence, nearest, spelling["unseen"])
        made[ipa] = Notation(*rest)
        for name, signs in spelling["spelled"].items():
            made.setdefault(name, EncodedNotation(*rest, signs=signs))
    return made
