"""Check a language pack against itself: labels, rules, inventory and tests.

These checks need the pack alone. `authoring.trial` runs the tests with their engine.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from unicodedata import category, combining

from lipsync_lang.base.errors import SpeechError, did_you_mean
from lipsync_lang.packs import models
from lipsync_lang.packs.extending import test_fault
from lipsync_lang.packs.finding import IPA, beside
from lipsync_lang.packs.models.text_models import LanguageText, RulesLike, parts_of
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.packs.yaml.source import Loc
from lipsync_lang.text.phonology.g2p.g2p_engines import Rule
from lipsync_lang.text.phonology.g2p.number_words import named_rules
from lipsync_lang.text.phonology.g2p.orthography_profile import BY_PROFILE, profile_rows
from lipsync_lang.text.phonology.g2p.own_words import by_spelling, ipa_labels, stands_alone
from lipsync_lang.text.phonology.g2p.rules import QUICKER, SLOW, never_fire, too_slow
from lipsync_lang.text.phonology.labels import Notation, normalise


def check_labels(language: Pack[models.Language]) -> Iterator[Fault]:
    """Check that labels are distinct, and that rules use known labels and can fire."""
    yield from _twice(language)
    yield from _unmet(language)
    yield from _rules(language)
    model = language.model
    notation = notation_of(model, model.g2p_notation)
    for loc, labels in _own_labels(model) if not model.automatic else ():
        for label in labels:
            if notation.find(label) is None:
                what = f"'{label}' is not in the notation '{model.g2p_notation}'"
                yield language.fault(loc, "P218", what, notation.suggest(label))
    yield from _profile(language, notation)
    yield from _written_forms(language)
    for word, reading in model.words.items():
        if reading.ipa and not stands_alone(word):
            what = f"'{word}' has IPA, which serves single words with spaces around them"
            hint = "write another spelling: `say`"
            yield language.fault(("words", word), "P115", what, hint, key=True)


def _profile(language: Pack[models.Language], notation: Notation) -> Iterator[Fault]:
    """Check each line of an orthography profile."""
    g2p, at = language.model.g2p, ("g2p", "file")
    if g2p is None or g2p.reading_backend != BY_PROFILE:
        return
    if g2p.file is None:
        what, hint = "the pack names no orthography profile", "state it as `file: profile.tsv`"
        yield language.fault(("g2p", "engine"), "P237", what, hint)
        return
    path = beside(language.where(at).file, g2p.file)
    if path is None:
        return  # the check of files tells it
    try:
        rows = list(profile_rows(path, g2p.column))
    except SpeechError as error:
        yield language.fault(at, "P237", str(error))
        return
    for row in rows:
        if row.wrong:
            yield Fault(shown(path), row.line, 1, "P237", row.wrong, row.mend)
        for sound in row.sounds if not language.model.automatic else ():
            if notation.find(sound) is None:
                what = f"'{sound}' is not in the notation '{language.model.g2p_notation}'"
                yield Fault(shown(path), row.line, 1, "P218", what, notation.suggest(sound))


def _written_forms(language: Pack[models.Language]) -> Iterator[Fault]:
    """Check that tables and lists have the names by which others use them, and numbers a place."""
    text = language.model.text
    if text is None:
        return
    tables = text.number_tables
    for table, rules in text.number_rules.items():
        if isinstance(rules, RulesLike):
            yield from _endings(language, table, rules, text)
    for table, full in tables.items():
        for number, words in full.items():
            # In any order: faults are sorted at the end.
            for name in set(named_rules(words)) - tables.keys():
                at = ("text", "number_rules", table, number)
                yield language.unknown(at, "P236", "rules of numbers", name, tables)
    for spelling, words in text.abbreviations.items():
        loc = ("text", "abbreviations", spelling)
        for fault in _abbreviation(language, loc, spelling, words, text):
            if language.states(loc):  # others have the words and faults of the first of their list
                yield fault


def _endings(
    language: Pack[models.Language], table: str, rules: RulesLike, text: LanguageText
) -> Iterator[Fault]:
    """Check that rules name others that are stated in full, and change endings that these have."""
    loc = ("text", "number_rules", table)
    others = {n: full for n, full in text.number_rules.items() if not isinstance(full, RulesLike)}
    if rules.like in text.number_rules.keys() - others.keys():
        what = f"'{rules.like}' is like other rules itself"
        hint = f"state '{rules.like}' in full, or name rules that are"
        yield language.fault((*loc, "like"), "P236", what, hint)
        return
    if rules.like not in others:
        yield language.unknown((*loc, "like"), "P236", "rules of numbers", rules.like, others)
        return
    ends = {rules.ending(words)[0] for words in others[rules.like].values()}
    for end in rules.endings.keys() - ends:
        what = f"no word of '{rules.like}' ends in '{end}'"
        hint = "correct it, or delete it"
        yield language.warning((*loc, "endings", end), "W308", what, hint, key=True)


def _abbreviation(
    language: Pack[models.Language], loc: Loc, spelling: str, words: str, text: LanguageText
) -> Iterator[Fault]:
    """Check that an abbreviation names lists and tables of the language, and its own numbers."""
    places, named = parts_of(spelling)
    for name in set(named) - text.lists.keys():
        yield language.unknown(loc, "P236", "list of words", name, text.lists, key=True)
    known = text.number_rules.keys() | text.numbers.keys()
    for number, table in re.findall(r"\{(\d)(?::([\w-]+))?\}", words):
        if number not in places:
            yield language.unknown(loc, "P236", "place of the spelling", number, places)
        if table and table not in known:
            yield language.unknown(loc, "P236", "list of numbers", table, known)


def _own_labels(model: models.Language) -> Iterator[tuple[Loc, Sequence[str]]]:
    """Yield the place and the labels of each interjection, word in IPA, and ending."""
    known = by_spelling(model.notations.get(model.g2p_notation, ()))
    for word, reading in model.words.items():
        yield ("words", word, "ipa"), ipa_labels(reading.ipa, known)
    if model.text is None:
        return
    for spelling, sounds in model.text.interjections.items():
        yield ("text", "interjections", spelling), sounds.to if sounds else ()
    for last, endings in model.text.endings.items():
        for ending, labels in endings.items():
            yield ("text", "endings", last, ending), labels


def check_claims(
    language: Pack[models.Language], common: models.Phonemes | None
) -> Iterator[Fault]:
    """Check the inventory, the tests, and the labels of examples and reasons.

    These faults concern claims about the language; a pack with them can still be performed.
    """
    yield from _inventory(language)
    yield from _tests(language, common.shades if common is not None else {})
    yield from _annotated_labels(language)


def notation_of(model: models.Language, name: str) -> Notation:
    """Return a notation of a language for look-ups of labels; silence is not included."""
    return Notation(
        {label: sounds.value for label, sounds in model.notations.get(name, {}).items()}
    )


def _twice(language: Pack[models.Language]) -> Iterator[Fault]:
    for name, table in language.model.notations.items():
        first: dict[str, str] = {}
        for label, sounds in table.items():
            # YAML refuses equal keys, but Unicode spells one label in several ways
            earlier = first.setdefault(normalise(label), label)
            if earlier == label:
                continue
            loc: Loc = ("notations", name, label)
            line = language.where(("notations", name, earlier), key=True).line
            if table[earlier] != sounds:
                what = f"'{label}' and '{earlier}' (line {line}) are one label with two mappings"
                yield language.fault(loc, "P219", what, "keep one of the two", key=True)
            else:
                what = f"'{label}' is '{earlier}' (line {line}) in another spelling"
                yield language.warning(loc, "W308", what, "keep one of the two", key=True)


LIKE_LATIN = str.maketrans("асеһіјорѕхуԁԛԝ", "acehijopsxydqw")
"""Cyrillic letters with the look of Latin ones."""


def _unmet(language: Pack[models.Language]) -> Iterator[Fault]:
    """Warn of labels that no text has, because of a character that cannot be seen in them."""
    for name, table in language.model.notations.items():
        latin = any("a" <= sign <= "z" for label in table for sign in label.casefold())
        for label in table:
            seen = normalise(label)
            alike = seen.translate(LIKE_LATIN) if latin else seen
            hidden = next((sign for sign in seen if category(sign) == "Cf"), "")
            if alike != seen:
                odd = next(sign for sign in seen if ord(sign) in LIKE_LATIN)
                what = f"'{label}' has the Cyrillic letter U+{ord(odd):04X}"
                hint = f"write '{alike}' with Latin letters"
            elif hidden:
                what = f"'{label}' has the invisible character U+{ord(hidden):04X}"
                hint = f"write '{seen.replace(hidden, '')}'"
            elif combining(seen[:1] or " "):
                what, hint = f"'{label}' begins with a mark", "write the mark after its letter"
            elif seen[:1] in ("ˈ", "ˌ") and seen[1:]:
                what, hint = f"'{label}' begins with a mark of stress", f"write '{seen[1:]}'"
            else:
                continue
            yield language.warning(("notations", name, label), "W308", what, hint, key=True)
    for number, line in enumerate(language.source.text.splitlines(), 1):
        if found := re.match(r"\s+(#[^\s:]?): \S", line):
            what = f"this line is a comment, so '{found[1]}' is no label"
            hint = f"write it in quotes: `'{found[1]}': ...`"
            place = (shown(language.path), number, found.start(1) + 1)
            yield Fault(*place, "W308", what, hint, "warning")


def _rules(language: Pack[models.Language]) -> Iterator[Fault]:
    g2p = language.model.g2p
    if g2p is None:
        return
    rules = [Rule(r.spelling, r.to, r.before, r.after) for r in g2p.rules]
    labels = language.model.notations.get(language.model.g2p_notation, {})
    known = {normalise(label) for label in labels}
    made = [("rules", n, one.to) for n, one in enumerate(g2p.rules)]
    made += [("corrections", n, one.to) for n, one in enumerate(g2p.corrections)]
    unknown = [(f, n, one) for f, n, to in made for one in to if normalise(one) not in known]
    # a language that is mapped by features has no labels of its own
    for field, number, label in unknown if labels else ():
        what = f"'{label}' is not in the notation '{language.model.g2p_notation}'"
        hint = did_you_mean(label, labels)
        yield language.fault(("g2p", field, number, "to"), "P218", what, hint)
    for number, rule in enumerate(rules):
        if signs := re.search(r"[\[\](){}|^$+*\\]", rule.spelling):
            what = f"`from` is letters, and no pattern with '{signs[0]}'"
            hint = "write the letters alone; `before` and `after` are patterns"
            yield language.warning(("g2p", "rules", number, "from"), "W308", what, hint)
    for number in too_slow(rules):
        what = f"the rule for '{rules[number].spelling}' {SLOW}"
        yield language.fault(("g2p", "rules", number), "P118", what, QUICKER)
    for number, earlier in never_fire(rules):
        line = language.where(("g2p", "rules", earlier)).line
        what = f"the rule for '{rules[number].spelling}' never applies"
        hint = f"the rule of line {line} takes its letters first; put it before that one"
        yield language.warning(("g2p", "rules", number), "W307", what, hint)


def _inventory(language: Pack[models.Language]) -> Iterator[Fault]:
    inventory = language.model.inventory
    if inventory is None:
        return
    notation = notation_of(language.model, IPA)
    for number, segment in enumerate(inventory.segments):
        mapped, absent = notation.find(segment) is not None, segment in inventory.absent
        loc: Loc = ("inventory", "segments", number)
        if not mapped and not absent and not language.model.automatic:
            what = f"'{segment}' is in the inventory, but '{IPA}' does not map it"
            hint = "map it, or give a reason under `inventory: absent`"
            yield language.fault(loc, "P220", what, hint)
        elif mapped and absent:
            what = f"'{segment}' is listed as absent, but mapped"
            yield language.warning(("inventory", "absent", segment), "W308", what, key=True)
    for name in ("spelled", "absent"):
        for segment in getattr(inventory, name):
            if segment not in inventory.segments:
                hint = did_you_mean(segment, inventory.segments)
                what = f"'{segment}' is not in the inventory"
                yield language.warning(("inventory", name, segment), "W308", what, hint, key=True)


def _tests(language: Pack[models.Language], shades: Mapping[str, models.Shade]) -> Iterator[Fault]:
    """Check that the `ipa` of each test maps to the phonemes of the test."""
    notation = notation_of(language.model, IPA)
    for index, test in enumerate(language.model.tests):
        loc: Loc = ("tests", index, IPA)
        unknown = [label for label in test.ipa.split() if notation.find(label) is None]
        for label in unknown if not language.model.automatic else ():
            what = f"'{label}' is not in the notation '{IPA}'"
            yield language.fault(loc, "P218", what, notation.suggest(label))
        heard = [n for label in test.ipa.split() for n, _ in notation.find(label) or ()]
        if test.ipa and not unknown and not test.accepts(heard, shades):
            becomes = f"/{test.ipa}/ becomes {' '.join(heard)}, not {' '.join(test.phonemes)}"
            what = f"{becomes}, in the test of '{test.text}'"
            yield test_fault(language, index, what, "correct the map or the test", IPA)


def _annotated_labels(language: Pack[models.Language]) -> Iterator[Fault]:
    """Check that the labels of examples and reasons exist."""
    model = language.model
    notations = {name: notation_of(model, name) for name in model.notations}
    first = {name: notations[name] for name in [*model.notations][:1]}
    for name, known in (("examples", first), ("reasons", notations)):
        for label in getattr(model, name):
            if not any(notation.find(label) is not None for notation in known.values()):
                where = "in no notation" if len(known) > 1 else "not in the first notation"
                what = f"'{label}' is {where}"
                hint = did_you_mean(label, [one for n in known.values() for one in n.table])
                yield language.warning((name, label), "W308", what, hint, key=True)
