"""Tables and settings of a language pack for reading and speaking its text."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cache
from itertools import chain, islice
from string import ascii_uppercase
from unicodedata import normalize

from lipsync_lang.packs import models
from lipsync_lang.packs.finding import IPA, beside, model_beside
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models.text_models import LanguageText
from lipsync_lang.packs.pack import Pack
from lipsync_lang.text.phonology.g2p.drawn_out import spelled_out
from lipsync_lang.text.phonology.g2p.g2p_engines import TONED, Correction, Rule, Settings
from lipsync_lang.text.phonology.g2p.own_words import by_spelling, ipa_labels, stands_alone
from lipsync_lang.text.phonology.g2p.spoken_forms import OwnWord, SpokenForms
from lipsync_lang.text.phonology.g2p.tokens import plain
from lipsync_lang.text.phonology.labels import Notation, Value, looser, normalise, ready
from lipsync_lang.text.phonology.manner import Hearing, Manner


def manner_of(
    language: Pack[models.Language],
    common: models.Phonemes,
    character: models.Character | None = None,
) -> Manner:
    """Return the settings for reading and speaking text; a character may add its own words."""
    model, g2p = language.model, language.model.g2p
    own = character.pronunciations if character is not None else {}
    stated = {word: one.phonemes for word, one in model.words.items() if one.phonemes}
    words = {
        plain(word): tuple(sounds)
        for said in (stated, *(own.get(name, {}) for name in (*language.lineage[::-1],)))
        for word, sounds in said.items()
    }
    added = {name: phoneme for name, phoneme in model.adds.items() if phoneme is not None}
    phonemes: dict[str, models.SoundFields] = {**common.shades, **common.phonemes, **added}
    return Manner(
        language=model.name,
        engine=g2p.engine if g2p else None,
        settings=_settings(language, common),
        notation=model.g2p_notation,
        voice=(model.tts.engine, model.tts.voice or "") if model.tts else None,
        others=dict(model.tts.others) if model.tts else {},
        kinds={name: phoneme.sound or "" for name, phoneme in phonemes.items()},
        durations={str(k): v for k, v in {**common.durations, **model.durations}.items()},
        words=words,
        audio=_hearing(language),
        stress_digits=model.stress_digits,
        weak=model.weak or "",
        forms=forms_of(model, common, model.g2p_notation),
        asides=model.asides,
        letters={normalize("NFC", one): one for one in g2p.letters} if g2p else {},
    )


def _hearing(language: Pack[models.Language]) -> Hearing:
    model, stated = language.model, language.model.audio
    if stated is None:
        return Hearing(code=model.tag)
    return Hearing(
        tuple(_beside(language, "align", one) for one in stated.align) or Hearing.align,
        stated.recognise and _beside(language, "recognise", stated.recognise),
        stated.model and _beside(language, "model", f":{stated.model}").removeprefix(":"),
        stated.notation or "",
        dict(stated.phones),
        dict(stated.also),
        stated.code or model.tag,
    )


def _beside(language: Pack[models.Language], field: str, engine: str) -> str:
    """Return `NAME:FOLDER` with a folder that is relative to the pack that names it."""
    return model_beside(language.where(("audio", field)).file, engine)


def _settings(language: Pack[models.Language], common: models.Phonemes) -> Settings:
    model, g2p = language.model, language.model.g2p
    if g2p is None:
        return Settings(model.name)
    stated = language.where(("g2p", "file")).file
    return Settings(
        language=model.name,
        voice=g2p.voice or (model.tts.voice if model.tts else None),
        code=g2p.code,
        file=beside(stated, g2p.file) if g2p.file else None,
        backend=g2p.reading_backend,
        column=g2p.column,
        rules=tuple(Rule(r.spelling, r.to, r.before, r.after) for r in g2p.rules),
        readings=tuple(Rule(r.spelling, r.to, r.before, r.after) for r in g2p.readings),
        corrections=tuple(
            Correction(
                c.labels, c.to, c.before, c.after, c.spelled, c.timings, c.next_word, c.capital
            )
            for c in g2p.corrections
        ),
        labels=tuple(model.notations.get(model.g2p_notation, ())),
        respell=g2p.respell,
        otherwise=g2p.otherwise,
        foreign_voice=common.text.foreign_voice if common.text else "",
        foreign=tuple(_foreign(model, common)),
        vowels=common.text.vowels if common.text else "",
        native=g2p.native,
        whole=tuple(
            (word, one.say)
            for word, one in model.words.items()
            if not (one.dropped or stands_alone(word))
        ),
    )


def _foreign(model: models.Language, common: models.Phonemes) -> Iterator[Rule]:
    """Yield the rules for the sounds of foreign words: those of the pack, or the nearest labels."""
    if model.g2p is None or common.text is None:
        return
    yield from (Rule(r.spelling, r.to, r.before, r.after) for r in model.g2p.foreign)
    named = model.text and model.text.letters.keys() >= set(ascii_uppercase)
    if named and model.g2p.engine != "espeak" and model.g2p_notation == IPA:
        labels = frozenset(map(normalise, model.notations.get(IPA, ())))
        nearest = _nearest(labels, common.text.nearby)
        for sound in sorted(common.text.nearby, key=len, reverse=True):
            yield Rule(sound, nearest((sound,)))


def notations_of(library: Library, language: Pack[models.Language]) -> dict[str, Notation]:
    """Return the notations of a language and of mouth shapes, indexed for label lookup."""
    from lipsync_lang.resolver.nearest_phonemes import among, spelling

    common, model = library.common().model, language.model
    silences = (*common.rests, *model.silence, common.silence)
    silence: Value = ((common.silence, 1.0),)
    near = among(library, language).value if model.automatic else None
    tables = {**visemes_of(common), **tables_of(model)}
    digits = model.stress_digits
    return ready(tables, silences, silence, IPA, spelling(library), near, digits)


def visemes_of(common: models.Phonemes) -> dict[str, dict[str, Value]]:
    """Return the notations of mouth shapes as tables."""
    return {
        name: {label: sounds.value for label, sounds in notation.labels.items()}
        for name, notation in common.visemes.items()
    }


def tables_of(model: models.Language) -> dict[str, dict[str, Value]]:
    """Return the notations of a language as tables; an automatic language needs none for IPA."""
    tables = {
        name: {label: sounds.value for label, sounds in table.items()}
        for name, table in model.notations.items()
    }
    if model.automatic:
        tables.setdefault(IPA, {})
    return tables


def forms_of(language: models.Language, common: models.Phonemes, notation: str) -> SpokenForms:
    """Return the written forms of a language, whose engine writes a notation.

    Shared interjections go to the nearest labels of the language, if its engine writes IPA.
    """
    stated, shared = language.text, common.text
    known: dict[str, OwnWord] = {}
    words, phrases = _own_words(language, language.notations.get(notation, ()))
    if shared is not None and notation == IPA:
        labels = frozenset(map(normalise, language.notations.get(IPA, ())))
        nearest = _nearest(labels, shared.nearby)
        for spelling, sounds in shared.interjections.items():
            if sounds is not None and (found := nearest(sounds.to)):
                known[spelling] = OwnWord(found, sounds.say)
        taken = {plain(word) for word in (*words, *(stated.abbreviations if stated else ()))}
        tag = language.tag.partition("-")[0]
        names = [one for tags, one in shared.names.items() if tag not in tags.split()]
        for name, ipa in (pair for one in names for pair in one.items()):
            if plain(name) not in taken:
                words[name] = OwnWord(nearest(ipa.split()))
    for_all = ("vowels", "censored", "particles") if shared is not None else ()
    shared_forms = {name: getattr(shared, name) for name in for_all}
    if stated is None:
        return SpokenForms(known, phrases, words, **shared_forms)
    for spelling, own in stated.interjections.items():
        known.pop(spelling, None)
        if own is not None:
            known[spelling] = OwnWord(own.to, own.say)
    numerals, vowels = stated.numerals, shared.vowels if shared else ""
    alike = ("beginnings", "letters", "repeated", "joins", "doubled", "hyphenated", "curses")
    return SpokenForms(
        interjections=known,
        abbreviations=_listed(abbreviations_of(stated, vowels), stated.lists) | phrases,
        words=words,
        endings={last: dict(others) for last, others in stated.endings.items()},
        rank_cases=tuple((r.before, r.after, r.endings) for r in stated.rank_cases.values()),
        numbers={**stated.numbers, **stated.number_tables},
        numeral_words=numerals.words,
        numerals_like=numerals.like,
        **{name: getattr(numerals, name) for name in ("counted", "named", "ordinals")},
        **shared_forms,
        **{name: getattr(stated, name) for name in (*alike, "thousands", "decimal")},
    )


def abbreviations_of(text: LanguageText, vowels: str) -> dict[str, str]:
    """Return the abbreviations of a language with its ranks, which are titles."""
    said = dict(text.abbreviations)
    for rank, words in text.ranks.items():
        # `sgt.` is no word that ends a sentence; alphabets without small letters write few vowels
        sure = rank[3:].endswith(".") and rank.islower() and spelled_out(rank[:-1], vowels)
        # before a name with a capital the rank is said, otherwise what follows the bars
        said[rank] = f"{words}||{said.get(rank, words if sure else '')}"
    return said


def _nearest(
    labels: frozenset[str], nearby: Mapping[str, Sequence[str]]
) -> Callable[[Sequence[str]], tuple[str, ...]]:
    """Return a function from sounds to their nearest labels, exact ones first.

    In a language without labels it returns the sounds.
    """

    @cache  # a thousand names have a hundred sounds
    def found(sound: str) -> tuple[str, ...]:
        choice = (sound, *nearby.get(sound, ()))
        exact = (one for one in choice if normalise(one) in labels)
        alike = (one for one in choice if not labels.isdisjoint(looser(normalise(one))))
        return tuple(islice(chain(exact, alike), 1))

    return (lambda sounds: tuple(chain(*map(found, sounds)))) if labels else tuple


def _listed(
    abbreviations: Mapping[str, str], lists: Mapping[str, Mapping[str, str | None]]
) -> dict[str, str]:
    """Return abbreviations with each word of a list in the place of its name."""
    places = {f"{{{name}}}": words for name, words in lists.items()}
    listed: dict[str, str] = {}
    for spelling, reading in abbreviations.items():
        found, text = {spelling: reading}, f"{spelling} {reading}"
        for place, words in places.items():
            if place in text:
                found = {
                    key.replace(place, word): read.replace(place, word if said is None else said)
                    for key, read in found.items()
                    for word, said in (words.items() if place in key else (("", ""),))
                }
                text = " ".join(chain(*found.items()))
        listed |= found
    return listed


def _own_words(
    language: models.Language, labels: Collection[str]
) -> tuple[dict[str, OwnWord], dict[str, str]]:
    """Return the words that a pack reads its own way, and respelled ones without spaces around."""
    words: dict[str, OwnWord] = {}
    phrases: dict[str, str] = {}
    known = by_spelling(labels)
    for word, reading in language.words.items():
        if reading.say and not reading.ipa and not stands_alone(word):
            if not (language.g2p and language.g2p.readings and TONED.fullmatch(reading.say)):
                phrases[word] = reading.say
        elif reading.ipa or reading.say:
            own = OwnWord(ipa_labels(reading.ipa, known), reading.say)
            words |= {plain(word): own, word: own}
    return words, phrases
