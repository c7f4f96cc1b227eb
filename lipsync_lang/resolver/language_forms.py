"""The written forms of a language, from its pack and the common pack."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

from lipsync_lang.packs.finding import IPA
from lipsync_lang.phonology.g2p.spoken_forms import Interjection, SpokenForms
from lipsync_lang.phonology.labels import looser, normalise

if TYPE_CHECKING:
    from lipsync_lang.packs import models


def forms_of(language: "models.Language", common: "models.Phonemes", notation: str) -> SpokenForms:
    """Return the written forms of a language.

    Shared interjections go to the nearest labels of the language, if its engine writes IPA.

    Parameters
    ----------
    notation : the notation that the language's engine writes
    """
    stated, shared = language.text, common.text
    known: dict[str, Interjection] = {}
    if shared is not None and notation == IPA:
        labels = frozenset(map(normalise, language.notations.get(IPA, ())))
        for spelling, sounds in shared.interjections.items():
            found = _nearest(sounds.to, labels, shared.nearby) if sounds is not None else ()
            if sounds is not None and found:
                known[spelling] = Interjection(found, sounds.say)
    vowels = shared.vowels if shared is not None else ""
    if stated is None:
        return SpokenForms(known, vowels=vowels)
    for spelling, own in stated.interjections.items():
        known.pop(spelling, None)
        if own is not None:
            known[spelling] = Interjection(own.to, own.say)
    numerals = stated.numerals
    return SpokenForms(
        interjections=known,
        abbreviations=dict(stated.abbreviations),
        counted=numerals.counted if numerals else (),
        named=numerals.named if numerals else (),
        ordinals=numerals.ordinals if numerals else (),
        doubled=stated.doubled,
        hyphenated=stated.hyphenated,
        vowels=vowels,
    )


def _nearest(
    sounds: Collection[str], labels: Collection[str], nearby: Mapping[str, Collection[str]]
) -> tuple[str, ...]:
    """Return labels of a language for sounds; a language without labels takes any."""
    if not labels:
        return tuple(sounds)
    tried = ((sound, *nearby.get(sound, ())) for sound in sounds)
    found = (next((one for one in choice if _known(one, labels)), "") for choice in tried)
    return tuple(one for one in found if one)


def _known(label: str, labels: Collection[str]) -> bool:
    return any(spelling in labels for spelling in looser(normalise(label)))
