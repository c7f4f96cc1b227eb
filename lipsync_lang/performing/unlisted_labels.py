"""Labels that a language does not list: the common phonemes nearest to them."""

import re
from typing import TYPE_CHECKING

from lipsync_lang.phonology.labels import MAX_TONE_SIGNS, TONE, Notation, Value
from lipsync_lang.phonology.one_sound import is_one_sound

if TYPE_CHECKING:
    from lipsync_lang.phonology.nearest import NearestPhonemes

_CAPITAL = re.compile("[A-Z]")
"""Letters that are absent from the IPA, but present in most other notations."""


def nearest_value(near: "NearestPhonemes", notation: Notation, label: str) -> Value | None:
    """Return the common phonemes nearest to an IPA label; None if it is not a single sound."""
    text = notation.text(label)
    if text is None or not any(map(str.isalpha, text)) or _CAPITAL.search(text):
        return None  # signs alone, such as ??, or another notation
    if sum(sign in TONE for sign in label) > MAX_TONE_SIGNS:
        return None  # a number
    return near.value(text) if is_one_sound(near.read(text).sounds) else None
