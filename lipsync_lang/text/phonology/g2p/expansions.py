"""Abbreviations, signs, Roman numerals, spelled capitals and ruby, replaced by spoken words."""

import re
from collections.abc import Iterator
from functools import cached_property

from lipsync_lang.text.phonology.g2p.abbreviation_keys import (
    AbbreviationKeys,
    Replacement,
    is_spaced,
    roman,
)
from lipsync_lang.text.phonology.g2p.contexts import SEEN_LETTERS, compile_context
from lipsync_lang.text.phonology.g2p.spoken_forms import SpokenForms

MAX_ROMAN_CHARS = 12
"""Maximum number of letters of a Roman numeral."""

_DOT = r"(?P<dot>\.(?= +[^\W\d_A-ZÀ-Þ]))?"
"""The full stop of an ordinal number, as in `Karl V. war`."""

_LATIN_LETTERS = "A-Za-zÀ-ɏḀ-ỿ"
_AFTER_NAME = re.compile(
    rf"(?<![^\W\d_])[^\W\d_]+[ \u00a0]+(?P<numeral>[IVX]{{2,7}})(?![{_LATIN_LETTERS}\d])" + _DOT
)
_NUMERAL_LETTERS = re.compile(r"[IVXLCDM]+(?![a-z])")
_IN_SENTENCE = re.compile(r"\s+(?!of\b)[a-z]")
"""The rest of a sentence behind a pronoun; "of" stands behind a numeral."""

_CAPITALS = re.compile(
    rf"(?<![{_LATIN_LETTERS}])(?![A-Z]+([A-Z])\1|[AEIOU]{{2}})[A-Z]{{1,5}}(?![{_LATIN_LETTERS}'’])"
)
"""Capitals of an abbreviation; sounds are none, such as `PSST`, `AAH` and `OI`."""

_VOWEL_CAPITAL = re.compile("[AEIOUY]")
_SYLLABLES = re.compile("(?=....)[^AEIOUY]?(?:[AEIOUY]{1,2}[^AEIOUY])+[AEIOUY]{,2}")
"""Four letters or more with a vowel beside each consonant, as in `SALE` and `TIDAK`."""

_RUBY_TEXT = re.compile(
    "(?:[｜|](?P<marked>[^｜|《》\n]{1,40})|(?P<hanzi>[\u3400-\u9fff々〆ヶ]{1,40}))"
    "《(?P<reading>[ぁ-ゖァ-ヺー・]{1,60})》"
)
"""A word with its reading in kana, as in 漢字《かんじ》; of several hanzi, all in a row."""

_KATAKANA = {code: code + 0x60 for code in range(0x3041, 0x3097)}
"""Katakana cannot be mistaken for a particle, as は and へ can."""


class Expansions:
    """A finder of abbreviations, signs, Roman numerals and ruby of a language."""

    def __init__(self, forms: SpokenForms) -> None:
        self._forms = forms

    def find(self, text: str) -> list[Replacement]:
        """Return what to replace in a text, in order and apart from each other."""
        found: list[Replacement] = []
        ruby = (
            Replacement(*one.span(), one["reading"].translate(_KATAKANA))
            for one in (_RUBY_TEXT.finditer(text) if "《" in text else ())
        )
        keys = self._keys.find(text)
        replaced = (*ruby, *self._again(text), *keys, *self._roman(text), *self._spelled(text))
        for one in sorted(replaced, key=lambda one: (one.start, -one.stop)):
            if not found or one.start >= found[-1].stop:
                found.append(one)
        return found

    @cached_property
    def _keys(self) -> AbbreviationKeys:
        return AbbreviationKeys(self._forms)

    def _spelled(self, text: str) -> Iterator[Replacement]:
        """Yield capitals in a row as the names of their letters; `PSST` and `GRRR` are none.

        Those that could be syllables are words, and in a sentence that is all capitals, those with
        any vowel: `AYO KITA PERGI!`.
        """
        names = self._forms.letters
        for sentence in re.finditer("[^.!?…\n]+", text) if names else ():
            shouted = all(map(str.isupper, filter(str.isalpha, sentence[0])))
            for one in _CAPITALS.finditer(text, *sentence.span()):
                known = one[0].lower() in self._forms.interjections or one[0] in self._forms.words
                word = known or (_VOWEL_CAPITAL.search if shouted else _SYLLABLES.fullmatch)(one[0])
                if not word and names.keys() >= set(one[0]):
                    yield Replacement(*one.span(), " ".join(names[letter] for letter in one[0]))

    def _again(self, text: str) -> Iterator[Replacement]:
        """Yield the word before each sign of repetition in place of the sign."""
        for sign, repeated in self._forms.repeated.items():
            before = compile_context(repeated, precedes=True).pattern
            for one in re.finditer(rf"{re.escape(sign)}(?!\d)", text):
                said = before.search(text, max(0, one.start() - SEEN_LETTERS), one.start())
                if said:
                    yield Replacement(*one.span(), f" {said[0]} ")

    def _roman(self, text: str) -> Iterator[Replacement]:
        if not _NUMERAL_LETTERS.search(text):
            return
        found: dict[tuple[int, int], str] = {}
        for pattern, ordinals in self._numerals:
            bare = pattern is _AFTER_NAME
            for one in pattern.finditer(text):
                beside = text[max(one.start() - 1, 0) : one.start()], text[one.end("numeral") :][:1]
                if not bare and any(map(is_spaced, beside)):
                    continue
                number = roman(one["numeral"])
                ordinal = 0 < number <= len(ordinals)
                read = ordinals[number - 1] if ordinal else self._keys.respelled(str(number))
                named = not bare or not one[0][0].islower()
                word = one["numeral"] in self._forms.numeral_words and _IN_SENTENCE.match(
                    text, one.end("numeral")
                )
                if number and named and not word:
                    found.setdefault((one.start("numeral"), one.end()), read)
        yield from (Replacement(*span, read) for span, read in found.items())

    @cached_property
    def _numerals(self) -> list[tuple[re.Pattern[str], tuple[str, ...]]]:
        """Expressions for Roman numerals, and the ordinal numbers that replace them."""
        forms = self._forms
        numeral = rf"(?P<numeral>[IVXLCDM]{{1,{MAX_ROMAN_CHARS}}})(?![A-Za-z'’])"
        found: list[tuple[re.Pattern[str], tuple[str, ...]]] = []
        for words, ordinals in ((forms.named, forms.ordinals), (forms.counted, ())):
            if words:
                listed = "|".join(re.escape(word) for word in sorted(words, key=len, reverse=True))
                before = rf"(?<![A-Za-z])(?i:{listed})[ \u00a0]*"
                found.append((re.compile(f"{before}{numeral}{_DOT}"), ordinals))
        return [*found, (_AFTER_NAME, ())] if found else []
