"""Models of written forms that packs read themselves: interjections, abbreviations, numerals."""

import re
from collections.abc import Mapping
from typing import Annotated, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, ValidationInfo, model_validator
from pydantic_core import PydanticCustomError

from lipsync_lang.packs.models.fields import (
    Common,
    Label,
    OrNames,
    OrOne,
    Short,
    Strict,
    Text,
    labels_as_sounds,
    sound_forms,
)
from lipsync_lang.packs.yaml.source import BETWEEN_SPELLINGS, Data
from lipsync_lang.text.phonology.g2p.contexts import ContextError, compile_context


def _context(text: str, told: ValidationInfo) -> str:
    """Refuse a context that is not a regular expression, or too slow."""
    try:
        if text:
            compile_context(text, precedes=told.field_name in {"after", "repeated"})
    except ContextError as error:
        raise PydanticCustomError(
            "P118" if error.slow else "P117",
            "`{name}` {what}",
            {"what": error.what, "hint": error.cure, "name": told.field_name},
        ) from None
    return text


ContextText = Annotated[str, AfterValidator(_context)]
"""A regular expression for the text around a place."""


class InterjectionSounds(Strict):
    """The sounds of an interjection."""

    to: Annotated[tuple[Label, ...], OrOne] = Field(min_length=1)
    """Labels of the notation that `g2p` writes."""
    say: str = ""
    """A spelling for the voice; the interjection's own unless stated."""


ShortInterjection = Short(
    lambda value: None if value is None else labels_as_sounds(value), forms=sound_forms
)

InterjectionTable = dict[Text, Annotated[InterjectionSounds | None, ShortInterjection]]
"""The sounds of interjections by their shortest spelling; null for a word that is none."""


class WordReading(Strict):
    """The reading of a word: its common phonemes, IPA, or another spelling."""

    phonemes: tuple[Common, ...] = ()
    """Common phonemes, the mouths, whatever an engine or a voice says."""
    ipa: str = ""
    """Labels of the notation that `g2p` writes, such as `ʂ ɛ p a r t`."""
    say: str = ""
    """A spelling that is read in place of the word; beside another field, for the voice alone."""
    dropped: bool = False
    """True for an inherited word that the engine reads after all; `null` is short for it."""

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if self.dropped and not (self.phonemes or self.ipa or self.say):
            return self
        if bool(self.phonemes) == bool(self.ipa) and (self.phonemes or not self.say):
            what = "a word needs `phonemes`, `ipa` or `say`, and not both of the first two"
            raise PydanticCustomError("P115", what)
        return self


def _word(value: Data) -> Data:
    if value is None:
        return {"dropped": True}
    if isinstance(value, str):
        return {"say": value}
    return value if isinstance(value, (dict, Strict)) else {"phonemes": value}


ShortWord = Short(_word, forms=lambda full: [*sound_forms(full), {"type": "null"}])

WordTable = dict[Text, Annotated[WordReading, ShortWord]]
"""Readings of words: a list of common phonemes, another spelling, or a mapping."""

NumberRules = dict[Annotated[str, Field(pattern="^(0|[1-9][0-9]{0,11})$")], str]
"""The words of numbers, by the first number that each serves."""


class RulesLike(Strict):
    """Rules of numbers that differ from others by the ends of their words."""

    like: Text
    """The other rules, which are stated in full."""
    endings: dict[Text, str] = Field(min_length=1)
    """Ends of their words, or whole words, with their replacements; the longest end that fits wins.
    Brackets and signs behind a word stay."""

    def made_of(self, rules: Mapping[str, str]) -> dict[str, str]:
        """Return the rules in full, made of the others."""
        made = {}
        for start, words in rules.items():
            end, rest = self.ending(words)
            before = words.removesuffix(end + rest)
            made[start] = before + self.endings.get(end, end) + rest
        return made

    def ending(self, words: str) -> tuple[str, str]:
        """Return the ending of words that is replaced, maybe empty, and the signs behind it."""
        word = re.sub(r"(\[[^\]]*\]| ?>)$", "", words)
        ends = filter(word.endswith, self.endings)
        return max(ends, key=len, default=""), words[len(word) :]


def _rules_form(value: Data) -> str:
    """Return the tag of the form in which rules are stated."""
    like = isinstance(value, RulesLike) or (isinstance(value, dict) and "like" in value)
    return "<like>" if like else "<rules>"


StatedRules = Annotated[
    Annotated[NumberRules, Tag("<rules>")] | Annotated[RulesLike, Tag("<like>")],
    Discriminator(_rules_form),
]

NumeralShape = Annotated[str, Field(pattern=r"^(?:\w+ )?~\.?$")]
"""A Roman numeral, perhaps behind a word or with a full stop."""


def _each_spelling(value: Data) -> Data:
    """Give each of the spellings that share a key an entry of its own."""
    if not isinstance(value, Mapping):
        return value
    found: dict[str, Data] = {}
    for key, words in value.items():
        for spelling in key.split(BETWEEN_SPELLINGS):
            if spelling in found:
                what = "'{spelling}' is written for other words above"
                hint = "leave it out here, or there"
                context = {"spelling": spelling, "hint": hint, "at": key}
                raise PydanticCustomError("P119", what, context)
            found[spelling] = words
    return found


class Numerals(Strict):
    """Roman numerals, and the words before them."""

    counted: tuple[Text, ...] = ()
    """Words before a cardinal number, such as `chapter`."""
    named: tuple[Text, ...] = ()
    """Words before an ordinal number: names of rulers. `king *` is `king` with any name."""
    ordinals: tuple[Text, ...] = ()
    """Ordinal numbers from 1; later ones are read as cardinal numbers."""
    like: Annotated[
        dict[NumeralShape, Annotated[str, Field(pattern="#")]], Short(_each_spelling)
    ] = Field(default={})
    """The digits whose reading a numeral of two letters or more has before a word: with
    `"~.": "#."`, `im II. Stock` is read like `im 2. Stock`, and with `"la ~ | una ~": "#ª"`,
    `la III edición` like `la 3ª edición`."""
    words: Annotated[dict[Text, tuple[Text, ...] | None], OrNames] = Field(default={})
    """Numerals that are words too, such as the English `I`: no numeral before a small letter,
    except before the words stated, as in `I: [of]`. `^lost` is one behind a name that starts a
    sentence: `Charles I lost`. `*` is any letters, and `[!e]` one other than `e`: `^*[!e]ed`."""


def parts_of(spelling: str) -> tuple[list[str], list[str]]:
    """Return the numbers of the places in the spelling of an abbreviation, and its lists of words.

    >>> parts_of("# {month} ####")
    (['1', '2'], ['month'])
    """
    places = [str(1 + n) for n, _ in enumerate(re.findall("#+|[~*]", spelling))]
    return places, re.findall(r"\{(\w+)\}", spelling)


def _read_alike(spellings: tuple[str, ...]) -> tuple[str, ...]:
    """Refuse spellings that the words of the first do not fit."""
    for number, spelling in enumerate(spellings):
        if parts_of(spelling) != parts_of(spellings[0]):
            what = "'{spelling}' has other numbers or lists than '{first}'"
            told = {"spelling": spelling, "first": spellings[0], "at": number}
            raise PydanticCustomError("P119", what, told)
    return spellings


class RankCase(Strict):
    """A case of ranks: where they have it, and their endings."""

    before: ContextText = ""
    """Expression for what follows the rank: a name in its case, `\\w+ovi(?!\\w)`, or none, `$`, so
    that the rank needs no name."""
    after: ContextText = ""
    """Expression for what precedes the rank, such as a preposition with its space."""
    endings: dict[Text, str] = Field(default={})
    """Ends of the words of ranks, or whole words, with those of the case; the longest that fits a
    word wins."""


class LanguageText(Strict):
    """Written forms of a language that its engine would misread."""

    sources: dict[Text, Text] = Field(default={})
    """Sources of the written forms, such as `CLDR`, a language authority or one person's knowledge,
    each with what it states."""
    interjections: InterjectionTable = Field(default={})
    """The sounds of interjections by their shortest spelling. A letter may be repeated more often,
    and a spelling that is one part twice, such as `haha`, as a whole. Null removes a shared one."""
    abbreviations: Annotated[dict[Text, str], Short(_each_spelling)] = Field(default={})
    """The words for abbreviations and signs. Spellings with ` | ` between them are read alike, and
    those that the common pack lists under `alike` are too, where a pack states the first of them.
    `#` in a spelling is a number, `##` a number of two
    digits, `~` a Roman numeral, and `*` two or more letters of a word: `"1 *a": "una {1}a"`. `{1}`
    in the words is the first of them, and `{1:ordinal}` its word in a list of `numbers`. A number
    and a full stop, `#.`, stand before a small letter. Words with a full stop at their end end a
    sentence where a capital follows. Other spellings with a capital and a full stop are titles, and
    stand before a name. `Saint|Street` has after `|` what is read without one. `…str.` is the end
    of a word, and `…th…` stands within words, too. `{month}` in both is each word of the list
    `month`. `№ #` also serves `#1`, `≈ #` serves `~30`, and `50/50` other shares of 100, such as
    `60/40`. A spelling that holds more of the text precedes others. If `#` itself is a spelling,
    all numbers in words are read as it says, and `-#` names the minus of each."""
    ranks: Annotated[
        dict[Text, Annotated[str, Field(pattern=r"^[^{}|]+$")]], Short(_each_spelling)
    ] = Field(default={})
    """The words for ranks, such as `por.: porucznik`, before a name with a capital, another rank, a
    mark (`por.!`) or a small letter (`por. idzie`). Those with three letters or more and no vowel
    (`sgt.`) are read anywhere. The same spelling in `abbreviations` says what is read elsewhere."""
    rank_cases: dict[Text, RankCase] = Field(default={})
    """Cases of the ranks, in languages that inflect them before a name, by name. The first whose
    expressions fit wins."""
    letters: dict[Annotated[str, Field(pattern="^[A-Z]$")], Text] = Field(default={})
    """Names of Latin letters, for an engine that knows none. Capitals in a row are spelled if all
    have names: a language in Latin letters names its consonants, and reads `NATO` as a word.
    Others read as words four letters or more that could be syllables, and in a sentence that is all
    capitals those with any vowel."""
    lists: dict[Text, Annotated[dict[Text, str | None], Short(_each_spelling), OrNames]] = Field(
        default={}
    )
    """Words that `abbreviations` treat alike, by name: `"# {month}": "{1:genitive} {month}"`. A
    mapping tells what is said for each: with `unit: {km: kilometres}`, `"# {unit}": "{1} {unit}"`
    reads `5 km`."""
    numbers: dict[Text, tuple[str, ...]] = Field(default={})
    """Lists of words for the numbers from 1, by name: ordinals, months, numbers of another kind. A
    number beyond its list is read as the engine reads it."""
    number_rules: dict[Text, StatedRules] = Field(default={})
    """Rules that put the words of numbers together, by name, used as a list of `numbers` is.
    `20: "vinte[ e >]"` serves 20 and those after it, up to the next rule. `>` is the rest, `<` how
    many tens, hundreds, thousands or millions, and brackets hold what is said with a rest alone.
    `>{joined}` and `<{joined}` go by the rules `joined`; `<<` and `>>` count in the number of the
    rule itself, such as 100000. From an empty rule on, numbers are read as the engine does. Rules
    for 0 to 9 alone name each digit, as in telephone numbers. Words without signs serve all numbers
    up to the next rule, so rules also choose the form of a noun: `"# ч": "{1} {1:час}"` goes by
    `час: {1: час, 2: часа, 5: часов, 21: ">"}`. Rules that differ in endings alone name others:
    `feminine: {like: ordinal, endings: {o: a}}`."""
    joins: tuple[Text, ...] = ()
    """Words between numbers that have the form of the last: with `und`, each of
    `am 3., 5. und 9. Mai` has that of `am 9. Mai`."""
    repeated: dict[Text, ContextText] = Field(default={})
    """Signs that say the word before them again, as the Lao `ໆ`, each with an expression for it."""
    thousands: str = Field(default="", max_length=1)
    """The sign between the thousands of a number, where the engine misreads it: `.` of 25.000."""
    decimal: str = ""
    """The word of the decimal sign in the numbers of `abbreviations`."""
    numerals: Numerals = Numerals()
    """Roman numerals, and the words before them."""
    beginnings: dict[Text, Text] = Field(default={})
    """Prefixes that respelled words of `words` with three letters or more take, each with its
    spelling, as `ה: הַ` for the article of Hebrew."""
    endings: dict[str, dict[Text, Annotated[tuple[Label, ...], OrOne]]] = Field(default={})
    """Endings that words of `words` take, each with its labels: by the end of the word that they
    replace, one sound for each letter, or by an empty text."""
    doubled: tuple[Text, ...] = ()
    """Words whose double letter stays if the word is drawn out: `goood` is `good`."""
    hyphenated: tuple[Text, ...] = ()
    """Words with a hyphen that look like stutters, such as `D-Day`."""
    curses: tuple[Text, ...] = ()
    """Words that scripts censor, in small letters: with `damn`, `d*mned` has its letters."""

    @property
    def number_tables(self) -> dict[str, dict[str, str]]:
        """The rules of numbers in full."""
        stated = self.number_rules.items()
        full = {name: rules for name, rules in stated if not isinstance(rules, RulesLike)}
        made = {
            # rules like others that are `like` themselves have none: a check reports the chain
            name: rules.made_of(full.get(rules.like, {}))
            for name, rules in stated
            if isinstance(rules, RulesLike)
        }
        return full | made


class SharedText(Strict):
    """Written forms that many languages share."""

    vowels: str = ""
    """Letters of vowels, small and without accents, in all alphabets."""
    censored: dict[Text, tuple[Text, ...]] = Field(default={})
    """For each alphabet, the letter that is read for a sign of a censored word, as in `sh!t`. Those
    of `*` serve all other signs."""
    particles: tuple[Text, ...] = ()
    """Small words of a name, such as `van`, which may stand between a rank and a capital."""
    interjections: InterjectionTable = Field(default={})
    """The sounds of interjections in IPA, for every language whose `g2p` writes IPA."""
    nearby: dict[Label, tuple[Label, ...]] = Field(default={})
    """For a label that a language lacks, others in order; a sound without any is left out."""
    alike: tuple[Annotated[tuple[Text, ...], AfterValidator(_read_alike)], ...] = ()
    """Spellings of one abbreviation. A language that states the first has the others, too, unless
    it states them itself."""
    foreign_voice: str = ""
    """The voice of eSpeak NG for words in Latin letters, in languages in which `letters` names each
    of these, and whose engine is no voice itself. Its sounds go to the nearest labels."""
    names: dict[Text, dict[Text, str]] = Field(default={})
    """Names in IPA, such as `dʒ o n`, by the tags of the languages that read them their own way,
    such as `en` or `de en`. Every other language whose `g2p` writes IPA reads them so, except packs
    that state the name themselves. A name with a capital needs one in texts."""

    @model_validator(mode="after")
    def _alike_once(self) -> Self:
        known: set[str] = set()
        for number, spellings in enumerate(self.alike):
            for spelling in spellings:
                if spelling in known:
                    at = {"spelling": spelling, "field": "alike", "at": number}
                    raise PydanticCustomError("P119", "'{spelling}' is listed twice", at)
                known.add(spelling)
        return self
