"""Mapping of labels by features: the phonemes of packs, and mappings that disagree."""

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakKeyDictionary

from lipsync_lang.base.errors import PackError, SpeechError, did_you_mean, shortlist
from lipsync_lang.packs.checking.ipa_checks import check_ipa
from lipsync_lang.packs.finding import IPA, Paths
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.building import read_yaml
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.text.phonology.ipa import Features, by_ear, key
from lipsync_lang.text.phonology.labels import Value
from lipsync_lang.text.phonology.nearest import NearestPhonemes

if TYPE_CHECKING:
    from lipsync_lang.packs import models
    from lipsync_lang.packs.pack import Pack
    from lipsync_lang.packs.yaml.source import YamlSource


class Disagreement(NamedTuple):
    """A label with different mappings by its pack and by its features."""

    label: str
    common: Value
    """Mapping of the pack."""
    automatic: Value
    """Mapping by features."""
    reason: str
    """The reason, as `reason_for` gives it."""


def plain_among(library: Library, language: "Pack[models.Language]") -> dict[str, Any]:
    """Return the features and candidates of a language's nearest-phoneme search, as JSON."""
    return _plain_search(library, candidates(language.model, library.common().model))


def _plain_search(library: Library, known: dict[str, list[str]]) -> dict[str, Any]:
    """Return a search among phonemes, each with its IPA equivalents, as JSON.

    Of each of their shades it has the parent and the IPA equivalents. An unsound pack of the IPA
    raises `PackFaults`.
    """
    shades = {
        name: [shade.like, list(shade.ipa)]
        for name, shade in library.common().model.shades.items()
        if shade.like in known
    }
    return {"features": _features(library), "candidates": known, "shades": shades}


def spelling(library: Library) -> dict[str, dict[str, Any]]:
    """Return spellings of the IPA in other signs, and the letters with a visible mark, as JSON.

    Where the pack of the IPA is unsound or missing, nothing is known of either: the languages that
    need no more of it are performed all the same.
    """
    try:
        ipa, common = library.ipa(), library.common()
        known = _SPELLINGS.setdefault(ipa.source, WeakKeyDictionary())
        if common.source not in known:
            data = _features(library)
            spelled = {
                name: {sign: key(meant) for sign, meant in signs.items()}
                for name, signs in data["notations"].items()
            }
            unseen = Features(data).unseen()
            known[common.source] = {"spelled": spelled, "unseen": unseen}
        return known[common.source]
    except PackError:
        return {"spelled": {}, "unseen": {}}


_SPELLINGS: "WeakKeyDictionary[YamlSource, WeakKeyDictionary[YamlSource, dict[str, Any]]]"
_SPELLINGS = WeakKeyDictionary()
"""Spellings by the files of the IPA and of the common phonemes, as long as a library has these."""


def _features(library: Library) -> dict[str, Any]:
    ipa = library.ipa()
    faults = sorted(set(check_ipa(ipa, library.common().model)))
    if faults:
        raise PackFaults(faults)
    return ipa.model.model_dump(mode="json", by_alias=True)


def among(library: Library, language: "Pack[models.Language]") -> NearestPhonemes:
    """Return a nearest-phoneme search among the phonemes of a language."""
    return NearestPhonemes.from_plain(plain_among(library, language))


def among_shared(names: Sequence[str], paths: Paths = ()) -> NearestPhonemes | None:
    """Return a nearest-phoneme search among some common phonemes of the packs found.

    For labels that a pack does not list: where those packs are unsound or missing, there is none.
    """
    library = Library(paths)
    try:
        common = library.common().model
        known = {n: list(common.phonemes[n].ipa) for n in names if n in common.phonemes}
        return NearestPhonemes.from_plain(_plain_search(library, known))
    except PackError:
        return None


def among_all(library: Library) -> NearestPhonemes:
    """Return a nearest-phoneme search among all common phonemes."""
    common = library.common().model
    # before the base, so that of equals the more special one is the nearest
    added = [name for name in common.phonemes if name not in (*common.base, common.silence)]
    known = {name: list(common.phonemes[name].ipa) for name in (*added, *common.base)}
    return NearestPhonemes.from_plain(_plain_search(library, known))


class ModelPhones(NamedTuple):
    """An acoustic model with a search for its phones that sound most like a label."""

    model: str
    nearest: NearestPhonemes
    neighbours: tuple[tuple[str, ...], ...]
    """Groups of phones that change the sound of those beside them alike."""
    looks: NearestPhonemes
    """The same phones, compared by what is seen of them."""
    between: NearestPhonemes
    """The search for the phones of a label between two vowels."""

    @property
    def vowels(self) -> frozenset[str]:
        """The phones that are vowels throughout."""
        read = self.nearest.read
        return frozenset(
            name
            for name, labels in self.nearest.candidates.items()
            if labels and all(sound.is_vowel for sound in read(labels[0]).sounds)
        )


PHONES_FILE = "phones.yaml"
"""The file beside an acoustic model with the letters that each of its phones sounds like."""


@cache
def model_phones() -> ModelPhones | None:
    """Return the search for phones of the acoustic model for all languages.

    None where the pack of the IPA names no such model; raise `PackError` where it is unsound.
    """
    data = _features(Library())
    hearing = data["hearing"]
    if hearing is None:
        return None
    neighbours = tuple(tuple(group.split()) for group in hearing["neighbours"])
    return _searched(
        data, hearing["model"], hearing["phones"], neighbours, hearing["between_vowels"]
    )


def phones_beside(folder: Path, names: Sequence[str]) -> ModelPhones | None:
    """Return the search for phones of a model, by the file beside it; None without one.

    Raises SpeechError if a phone has no letters, or the file has another phone, or a letter that is
    no IPA.

    Parameters
    ----------
    names : phones of speech in the model
    """
    path = folder / PHONES_FILE
    if not path.is_file():
        return None
    source, data = read_yaml(path), _features(Library())
    stated = source.data if isinstance(source.data, dict) else {}
    letters = {
        name: [told] if isinstance(told, str) else list(told or ()) for name, told in stated.items()
    }
    known = _searched(data, folder.name, letters, (), {})
    wrong = {
        name: f"'{name}' is no phone of the model; {did_you_mean(name, names)}"
        for name in letters
        if name not in names
    } | {
        name: f"'{label}' is not IPA; write the letters that '{name}' sounds like"
        for name, labels in letters.items()
        for label in labels
        if known.nearest.features.read(str(label)).unknown
    }
    faults = [
        "{}:{}:{}: {}".format(path, *source.where([n], key=True), e) for n, e in wrong.items()
    ]
    if missing := [name for name in names if name not in letters]:
        told = f"no letters for {shortlist(missing)}: write `PHONE: LETTERS` for each"
        faults.append(f"{path}:1:1: {told}, or `PHONE: []` for noise")
    if faults:
        raise SpeechError("\n".join(faults))
    return known


def _searched(
    data: dict[str, Any],
    model: str,
    phones: Mapping[str, Sequence[str]],
    neighbours: tuple[tuple[str, ...], ...],
    between_vowels: Mapping[str, Sequence[str]],
) -> ModelPhones:
    moved = {label for labels in between_vowels.values() for label in labels}
    between = {
        name: [label for label in labels if label not in moved] + [*between_vowels.get(name, ())]
        for name, labels in phones.items()
    }
    heard, seen, inside = (
        NearestPhonemes.from_plain({"features": features, "candidates": some})
        for features, some in ((by_ear(data), phones), (data, phones), (by_ear(data), between))
    )
    return ModelPhones(model, heard, neighbours, seen, inside)


def candidates(language: "models.Language", common: "models.Phonemes") -> dict[str, list[str]]:
    """Return the common phonemes of a language, each with its IPA equivalents.

    Those that it adds come first, so that of equals they are the nearest.
    """
    names = dict.fromkeys((*language.adds, *common.base))
    stated = {name: language.adds.get(name) or common.phonemes.get(name) for name in names}
    return {name: list(phoneme.ipa) for name, phoneme in stated.items() if phoneme is not None}


def disagreements(
    language: "models.Language", near: NearestPhonemes, decided: "Sequence[models.Decision]" = ()
) -> list[Disagreement]:
    """List the IPA labels of a language whose mapping differs from that of their features.

    A shade and its parent do not differ. `decided` are the decisions of the IPA pack.
    """
    table = language.notations.get(IPA, {})
    rows = [(label, sounds.value, near.value(label) or ()) for label, sounds in table.items()]
    differ = (row for row in rows if not _agrees(near, *row[:2]))
    return [Disagreement(*row, reason_for(language, near, row[0], decided)) for row in differ]


def reason_for(
    language: "models.Language",
    near: NearestPhonemes,
    label: str,
    decided: "Sequence[models.Decision]" = (),
) -> str:
    """Return the reason for a language's mapping of an IPA label; empty if none is stated.

    The pack's own reason comes first, then the decision that languages share, the features of the
    label, and a shorter label of the same mapping.
    """
    table = language.notations.get(IPA, {})
    sounds = table[label]
    if label in language.reasons:
        return language.reasons[label]
    for one in decided:
        if label in one.labels and one.to == sounds.to:
            return one.why
    if _agrees(near, label, sounds.value):
        losses = near.nearest(label).losses
        return "by its features" + (f"; not shown: {', '.join(losses)}" if losses else "")
    # the longest first: a length mark is dropped before a letter is
    shorter = (label[:end] for end in range(len(label) - 1, 0, -1))
    return next((f"as {one}" for one in shorter if one in table and table[one] == sounds), "")


def _agrees(near: NearestPhonemes, label: str, stated: Value) -> bool:
    found = near.value(label)
    parents = {name: told.parent for name, told in near.shades.items()}
    return found is not None and _shown(found, parents) == _shown(stated, parents)


def fights(language: "models.Language", near: NearestPhonemes) -> list[tuple[str, list[str]]]:
    """List the IPA labels mapped against their features without a stated reason."""
    table = language.notations.get(IPA, {}).items()
    rows = [
        (one, near.fights(one, sounds.to)) for one, sounds in table if one not in language.reasons
    ]
    return [(label, against) for label, against in rows if against]


def _shown(value: Value, parents: Mapping[str, str]) -> list[str]:
    """Return the phonemes of a value, shades as their parents.

    A repeated one is shown once, as one long sound.
    """
    return [name for name, _ in groupby(parents.get(name, name) for name, _ in value)]
