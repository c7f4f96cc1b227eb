"""Check that the words, features, letters and marks used in the IPA pack are defined there."""

from collections.abc import Collection, Iterable, Iterator
from unicodedata import normalize

from lipsync_lang.packs.models.ipa_models import Ipa
from lipsync_lang.packs.models.language_models import Phonemes
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.packs.yaml.source import Loc

CARRIER = "\u25cc"
"""The dotted circle, which carries a combining mark in text."""


def check_ipa(ipa: Pack[Ipa], common: Phonemes) -> Iterator[Fault]:
    """Yield a fault for each undefined name that the IPA pack uses."""
    model = ipa.model
    for term, features in model.terms.items():
        yield from _features(ipa, ("terms", term), features)
    for letter, words in model.letters.items():
        yield from _words(ipa, ("letters", letter), words)
    for index, join in enumerate(model.joins):
        for side, phrases in (("first", join.first), ("second", join.second)):
            for number, phrase in enumerate(phrases):
                yield from _words(ipa, ("joins", index, side, number), phrase)
    for mark, cases in model.marks.items():
        for index, case in enumerate(cases):
            loc: Loc = ("marks", mark, index)
            for number, phrase in enumerate(case.on):
                yield from _words(ipa, (*loc, "on", number), phrase)
            yield from _features(ipa, (*loc, "set"), case.set)
            yield from _features(ipa, (*loc, "add"), case.add)
    yield from _letters(ipa)
    if model.hearing is not None:
        yield from _features(ipa, ("hearing", "weights"), model.hearing.weights)
    yield from _phonemes(ipa, common)


def _phonemes(ipa: Pack[Ipa], common: Phonemes) -> Iterator[Fault]:
    """Check that every common phoneme and shade exists."""
    model, known = ipa.model, (*common.phonemes, *common.shades)
    named: list[tuple[Loc, str, Collection[str]]] = [
        *((("aside", phoneme), phoneme, common.phonemes) for phoneme in model.aside),
        *(
            (("decided", index, "to", number), phoneme, known)
            for index, decision in enumerate(model.decided)
            for number, phoneme in enumerate(decision.to)
        ),
    ]
    for loc, phoneme, declared in named:
        if phoneme not in declared:
            yield ipa.unknown(loc, "P202", "phoneme", phoneme, declared, key=loc[-1] == phoneme)


def _letters(ipa: Pack[Ipa]) -> Iterator[Fault]:
    """Check that every letter and mark named by another entry is defined."""
    model = ipa.model
    letters = {_plain(letter) for letter in model.letters}
    marks = {_plain(mark) for mark in model.marks}
    named: list[tuple[Loc, str]] = [
        *((("prefer", letter, "as"), p.letter) for letter, p in model.prefer.items()),
        *((("alone", mark), letter) for mark, letter in model.alone.items()),
        *(
            (("marks", mark, index, "then"), case.then)
            for mark, cases in model.marks.items()
            for index, case in enumerate(cases)
            if case.then is not None
        ),
        *(
            (("hearing", "voiceless"), letter)
            for letter in (model.hearing.voiceless.split() if model.hearing else [])
        ),
        *(
            (("hearing", "heard"), model.alone.get(mark, mark))
            for mark in (model.hearing.heard.split() if model.hearing else [])
        ),
    ]
    for loc, letter in named:
        if _plain(letter) not in letters:
            what, hint = f"unknown letter '{letter}'", "put it under `letters`"
            yield ipa.fault(loc, "P223", what, hint, key=loc[-1] == letter)
    for mark in model.alone:
        if _plain(mark) not in marks:
            what = f"unknown mark '{mark}'"
            yield ipa.fault(("alone", mark), "P223", what, "put it under `marks`", key=True)
    yield from _spelled(ipa, letters | marks)


def _spelled(ipa: Pack[Ipa], known: Collection[str]) -> Iterator[Fault]:
    """Check that every spelling means known letters and marks."""
    model = ipa.model
    spelled: list[tuple[Loc, str]] = [
        *((("spellings", text), meant) for text, meant in model.spellings.items()),
        *(
            (("notations", name, sign), meant)
            for name, signs in model.notations.items()
            for sign, meant in signs.items()
        ),
        *(
            (("hearing", "phones", phone), label)
            for phone, labels in (model.hearing.phones.items() if model.hearing else ())
            for label in labels
        ),
    ]
    for loc, meant in spelled:
        rest, length = _plain(meant), 1
        while rest and length:  # the longest known letter or mark, again and again
            length = next((n for n in range(len(rest), 0, -1) if rest[:n] in known), 0)
            rest = rest[length:]
        if rest:
            what = f"'{rest[0]}' is neither a letter nor a mark"
            yield ipa.fault(loc, "P223", what, "put it under `letters` or `marks`")


def _words(ipa: Pack[Ipa], loc: Loc, phrase: str) -> Iterator[Fault]:
    for word in phrase.split():
        if word not in ipa.model.terms:
            yield ipa.unknown(loc, "P222", "word", word, ipa.model.terms)


def _features(ipa: Pack[Ipa], loc: Loc, named: Iterable[str]) -> Iterator[Fault]:
    for name in named:
        if name not in ipa.model.features:
            yield ipa.unknown((*loc, name), "P222", "feature", name, ipa.model.features, key=True)


def _plain(text: str) -> str:
    return normalize("NFD", text.replace(CARRIER, ""))
