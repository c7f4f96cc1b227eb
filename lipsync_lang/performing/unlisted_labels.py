"""Labels that a language does not list: the common phonemes nearest to them, and what is said."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lipsync_lang.phonology.labels import MAX_TONE_SIGNS, TONE, Notation, Value
from lipsync_lang.phonology.one_sound import is_one_sound

if TYPE_CHECKING:
    from lipsync_lang.phonology.nearest import NearestPhonemes

MAX_REMARKS = 8
"""Labels that are named one by one; more than a screenful is not read."""


def nearest_value(near: "NearestPhonemes", notation: Notation, label: str) -> Value | None:
    """Return the common phonemes nearest to a label in IPA; None if it is not one sound of it."""
    text = notation.text(label)
    if text is None or not any(map(str.isalpha, text)):
        return None  # signs alone, such as ??
    if sum(sign in TONE for sign in label) > MAX_TONE_SIGNS:
        return None  # a number
    return near.value(text) if is_one_sound(near.read(text).sounds) else None


def remarks_on(
    found: Mapping[str, Value], labels: Sequence[str], name: str, language: str
) -> tuple[str, ...]:
    """Return a remark for each label that is performed by its features.

    Parameters
    ----------
    found : values of labels that a notation does not list
    labels : all labels of the schedule
    name, language : the notation and its language
    """
    told = []
    for label, value in [*found.items()][:MAX_REMARKS]:
        times, shown = labels.count(label), " ".join(name for name, _ in value) or "nothing"
        often = f" ({times} times)" if times > 1 else ""
        told.append(
            f"{label!r}{often} is not in the {name} of {language}; it is performed as {shown}, "
            "the nearest by its features"
        )
    more = len(found) - len(told)
    return (*told, *([f"{more} more labels are performed by their features"] if more else []))
