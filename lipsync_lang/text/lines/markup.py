r"""Separate the spoken text of a line from its markup.

These are not spoken, and listed in the result:

- tags: ``<i>``, ``{i}``, ``{/color}``, ``{\an8}``, ``<#ff0000>``; the words between two tags stay.
  ``<break/>``, ``{w}`` and ``{p}`` are pauses, ``<emphasis>`` is emphasis,
- ruby, the small reading above a word: ``<rt>..</rt>``, ``{rt}..{/rt}``,
- placeholders whose value only the game knows: ``{name}``, ``[name]``, ``%s``, ``$name``; notes in
  square brackets, such as ``[sighs]``, look the same,
- codes of colours, sizes and waits: ``§a``, ``\C[4]``, ``|cFF0000``,
- asides: ``(laughs)``, ``*sighs*`` (see `is_aside`),
- addresses, hashtags, emoji, arrows, notes of music, and signs such as ``~``,
- signs in place of a curse, such as ``#@$%!``, which are a pause,
- passages that a project lists.

Placeholders with a value become that value, and choices one of their branches (see `choices`).
Doubled percent signs stand for one, entities are decoded (``&nbsp;``), and ``\n`` is a space.

A placeholder or a note in square brackets leaves a gap: speech that the file does not contain. A
tag leaves no gap. A word in braces is a tag if a closing tag follows, or if it has a value
(``{w=0.5}``); otherwise it is a placeholder.
"""

import re
from collections.abc import Iterator, Sequence
from functools import lru_cache
from html import unescape
from itertools import islice
from pathlib import Path
from typing import NamedTuple
from unicodedata import normalize

from lipsync_lang.text.lines.choices import chosen
from lipsync_lang.text.lines.cleaning import AS_WRITTEN, Cleaning
from lipsync_lang.text.phonology.g2p.tokens import PAUSES, UNSPACED, plain

UNUSUAL = re.compile(
    "(?:["
    "０-９Ａ-Ｚａ-ｚ＇－＋＝％＆＃＠＄＾＿｜￠-￦"  # full width
    "℃℉"
    "\uff66-\uffdc"  # half-width kana and hangul
    "\u2460-\u2473\u3380-\u33df\u203c\u2047-\u2049"  # numbers in circles, units, double marks
    "\u2160-\u216b"  # Roman numerals in one sign
    "\u01c4-\u01cc\u01f1-\u01f3\u0132\u0133\ufb00-\ufb4f"  # ligatures
    "\ufb50-\ufd3d\ufd50-\ufdfb\ufe70-\ufefc"  # shapes of Arabic letters
    "\U0001d400-\U0001d7ff"  # letters of formulas
    "]|(?<=[0-9０-９])[．：／](?=[0-9０-９])|(?<=[０-９])，(?=[０-９]))+"
)
"""Compatibility characters that are ordinary letters, digits and signs in another shape."""

NUMERAL_SIGNS = {0x2160 + number: str(number + 1) for number in range(12)}
"""Signs of whole Roman numerals, such as `Ⅷ`, as digits."""

UNSEEN = re.compile("[\u00ad\u034f\u061c\u200e\u200f\u202a-\u202e\u2060-\u2069\ufeff]+")
"""Soft hyphens, directions of writing, and spaces without width."""

APOSTROPHE = re.compile("(?<=[^\\W\\d_])[’‘ʼ´`′](?=[^\\W\\d_])")
"""An apostrophe within a word, in any of its spellings."""

PATTERN_PARTS = {"UNSPACED": UNSPACED}
"""Parts of patterns by name: those of `markup_forms.tsv`, and one that these need."""


def _stated_forms() -> Iterator[list[str]]:
    """Yield the rows of `markup_forms.tsv`: kind, example, pattern, and a proof for unsure ones."""
    text = Path(__file__).with_name("markup_forms.tsv").read_text("utf-8")
    for row in text.splitlines()[1:]:
        if not row.startswith("# "):
            whole = re.sub(r"@\{([A-Z_]+)\}", lambda found: PATTERN_PARTS[found[1]], row)
            kind, example, pattern, proof = [*whole.split("\t"), ""][:4]
            if kind == "part":
                PATTERN_PARTS[example] = pattern
            else:
                yield [kind, example, pattern, proof]


_FORM_ROWS = list(_stated_forms())
FORMS = {
    kind: {
        example: pattern for of, example, pattern, proof in _FORM_ROWS if of == kind and not proof
    }
    for kind, *_ in _FORM_ROWS
}
"""Kinds of markup: examples, and the pattern that finds them; the first that fits counts."""
UNSURE_FORMS = {example: (kind, *rest) for kind, example, *rest in _FORM_ROWS if rest[-1]}
"""Examples of markup that may be text: its kind, its pattern, and its proof elsewhere in a line."""
PROOFS = {kind: re.compile(proof) for kind, (_, _, proof) in UNSURE_FORMS.items()}
SILENT_KINDS = frozenset({"bleep", "code", "tag", "sign", "wave", "face"})
SUSPECT = re.compile(
    rf"[][<>{{}}%$§£\\(（【〔［＜〈*~〜～#&@×/={PATTERN_PARTS['SYMBOL'][1:-1]}]|[:;](?:-?[DPpOo3]|(?<=:)[A-Za-z_])"
    r"|[-+](?<![\s\S][-+])|www\.|[xX]D|[Tt]\.[Tt]|o\.o"
)
"""A trace of markup; text without one is spoken as it is.

Each way begins with a set of characters, which makes the search twice as fast.
"""
ADDRESS_SIGN = re.compile(r"@|(?i:https?:|www\.)")
DOUBLED = {"{{": "", "}}": "", "[[": "", "]]": "", "%%": "%"}
CLOSING = re.compile(r"([{\[])/(\w+)[}\]]")
SOUNDLESS = re.compile(r"\[/|\{(?:[/\\]|rt\}|\w+=)")
"""Pattern of the start of tags in brackets, which leave no gap."""
PAUSING = re.compile(r"<break\b|\{[wp](?:=[\d.]*)?\}", re.IGNORECASE)
BREAKING = re.compile(r"</?(?:br|div|h[1-6]|li|p|s|t[dr])\b|\{br\}", re.IGNORECASE)
"""Tags that separate words."""
EMPHASIS_TAG = re.compile(r"</?emphasis\b", re.IGNORECASE)
ENTITY = re.compile(r"&(?:amp;)*(#?\w{1,32};)")
STRAY = re.compile(r"[{}\[\]]|</?(?!\s*\d)|>(?!\s*\d)")
TAG_VALUES = re.compile(r"[ =].*", re.DOTALL)
"""Pattern of the values of a tag, after its name."""
PLACEHOLDER_NAME = re.compile(r"[\w.-]+")
LEFT_LETTER = re.compile(r"['’]?[b-df-hj-np-tv-xz](?![^\W_]|[-…]|\.\.)")
"""A consonant of a placeholder's word, as in `{name}'s`, which alone would be spelled."""
RUN_ON = re.compile(r"\.(?<=[^\W\dA-Z_]{2}\.)(?=[A-ZÀ-ÞČĆĐĞİŁŘŚŠŞŻŽΑ-ΩЁІЇЄА-Я](?![A-Z.]))")
"""A full stop between two words that ends a sentence, as in `Wait.Go!`."""
LOOSE_PUNCTUATION = re.compile(r" ([,.])(?!\S)")
PAUSE_MARK = "\0"
"""Placeholder for a pause, until the text around it is known."""
PAUSED = re.compile(rf"(?P<before>[^\s{PAUSE_MARK}]?)\s*(?:{PAUSE_MARK}\s*)+(?P<after>\S?)")
TAGS_BEFORE = re.compile(r"(?: |\{[^{}]*\}|<[^<>]*>)+$")
TAGS_AFTER = re.compile(r"^(?: |\{[^{}]*\}|<[^<>]*>)+")
SEEN_CHARS = 200
"""Number of characters examined on each side of an aside."""
MAX_MOVED_GAPS = 100
"""Maximum number of gaps in a text with stray marks that is cleaned again; each reads the text."""
MAX_UNSPOKEN_CHARS = 500
"""Longest passage between the two ends of an `unspoken` entry."""


# Asides are notes between the spoken words: ``(laughs)`` and ``*sighs*`` are notes to an actor,
# ``(my brother)`` and ``*never*`` are words of the line. A language lists the words of its asides.
# With capitals the form tells, too: few words, from a small letter, where a sentence begins.
MAX_ASIDE_WORDS = 5
"""Maximum number of words of an aside that is recognised by its form."""

MAX_CHARS, MAX_UNCASED_CHARS = 40, 12
"""Maximum length of an aside known by its words, in scripts with and without capitals."""

OPEN_END = "..."
"""Mark at the end of a listed word, for all words with this start."""

SENTENCE_ENDS = frozenset(".!?…。！？")

QUOTE_SIGNS = frozenset("\"'»«“”„‘’—–-[](){}")


def is_aside(
    said: str, before: str, after: str, listed: Sequence[str], *, starred: bool = False
) -> bool:
    """Return True if a passage in brackets or asterisks is an aside.

    `before` and `after` are the text around it; `listed` are the language's words of asides;
    `starred` is True if the passage is in asterisks, which emphasise other words.

    >>> is_aside("sighs deeply", "", " I know.", ["sigh..."])
    True
    >>> is_aside("never", "I ", " said so.", [], starred=True)
    False
    """
    last, first = before.rstrip()[-1:], after.lstrip()[:1]
    begins = not last or last in PAUSES or last in QUOTE_SIGNS
    ends = not first or not first.islower()
    if starred and not (begins and ends):
        return False
    longest = MAX_CHARS if _has_case(said) else MAX_UNCASED_CHARS
    if listed and len(said) <= longest and _pattern(tuple(listed)).search(plain(said)):
        return True
    known_by_form = begins and ends and _has_case(said) and not re.search(r"\d", said)
    if not (known_by_form and 0 < len(said.split()) <= MAX_ASIDE_WORDS):
        return False
    if starred:
        apart = (not last or last in SENTENCE_ENDS) and (not first or first.isupper())
        return said[0].islower() and apart and bool(last + first)
    closed = said.rstrip()[-1] in PAUSES
    return not closed and (said[0].islower() or (said.isupper() and not after.strip()))


def _has_case(text: str) -> bool:
    return text.lower() != text.upper()


@lru_cache(256)
def _pattern(listed: tuple[str, ...]) -> re.Pattern[str]:
    """Return the pattern of listed words; without capitals, words may have no edges."""
    ways = []
    for one in listed:
        word = re.escape(plain(one.removesuffix(OPEN_END)))
        if _has_case(word):
            word = rf"(?<!\w){word}" + ("" if one.endswith(OPEN_END) else r"(?!\w)")
        ways.append(word)
    return re.compile("|".join(ways))


class SpokenText(NamedTuple):
    """The spoken text, the markup dropped, in order, and the offsets of gaps in the text.

    `remarks` tell of marks without a partner.
    """

    text: str
    dropped: tuple[str, ...] = ()
    gaps: tuple[int, ...] = ()
    remarks: tuple[str, ...] = ()


def spoken(text: str, cleaning: Cleaning = AS_WRITTEN) -> SpokenText:
    """Return the spoken part of a text.

    >>> spoken("Hello, {i}dear{/i} [name]!").text
    'Hello, dear !'
    >>> spoken("*sighs* Hello, [name]!", Cleaning({"name": "Ada"}))[:2]
    ('Hello, Ada!', ('*sighs*',))
    """
    text = ordinary(text)
    if not cleaning.unspoken and not SUSPECT.search(text):
        return SpokenText(RUN_ON.sub(". ", " ".join(text.split())))
    text = " ".join(text.replace(PAUSE_MARK, " ").split())
    text = ENTITY.sub(lambda found: unescape(f"&{found[1]}"), text)
    found = TextCleaner(chosen(text, cleaning.values), cleaning).spoken()
    # The signs beside a stray mark may be markup without it, such as an emoticon.
    twice = found.remarks and len(found.gaps) <= MAX_MOVED_GAPS
    again = spoken(found.text, cleaning) if twice else found
    if again.text == found.text:
        return found
    # A gap moves with the text before it, which is cleaned alone for its length.
    gaps = {len(spoken(found.text[:gap], cleaning).text) for gap in found.gaps} | {*again.gaps}
    return SpokenText(again.text, found.dropped + again.dropped, tuple(sorted(gaps)), found.remarks)


class TextCleaner:
    """State of the cleaning of a text."""

    def __init__(self, text: str, cleaning: Cleaning) -> None:
        self.text, self.cleaning = text, cleaning
        self._closed = {f"{mark}{name}" for mark, name in CLOSING.findall(text)}
        self._left: list[str] = []
        self._dropped: list[str] = []
        self._gaps: list[int] = []
        self._remarks: list[str] = []
        self._solid = 0

    def spoken(self) -> SpokenText:
        """Return the spoken text."""
        proven = (kind for kind, proof in PROOFS.items() if proof.search(self.text))
        addressed = ADDRESS_SIGN.search(self.text) is not None
        pattern = _markup(self.cleaning.unspoken, tuple(proven), addressed)
        done = at = 0
        while found := pattern.search(self.text, at):
            start = found.start()
            if (instead := self._instead(found)) is None:
                at = start + 1
                continue
            self._say(self._sound(done, start) + instead)
            whole = found[0]
            done = at = found.end()
            silent = found.lastgroup in SILENT_KINDS or SOUNDLESS.match(whole)
            if not (instead or silent or whole in DOUBLED or self._is_tag(whole)):
                self._gaps.append(self._solid)
                if ending := LEFT_LETTER.match(self.text, at):
                    done = at = ending.end()
                # The words on both sides of a placeholder are not one word.
                beside = self.text[max(start - 1, 0) : start], self.text[at : at + 1]
                self._left.append(" " if all(map(str.isalnum, beside)) else "")
        self._say(self._sound(done, len(self.text)))
        tidy = RUN_ON.sub(". ", " ".join("".join(self._left).split()))
        if PAUSE_MARK in tidy:
            tidy = " ".join(PAUSED.sub(_paused, tidy).split())
        said = LOOSE_PUNCTUATION.sub(r"\1", tidy).replace(f" {PAUSE_MARK}", PAUSE_MARK)
        # Gaps are counted without spaces, because dropping markup changes the spaces around it.
        solid = (at for at, one in enumerate(said, 1) if not one.isspace() and one != PAUSE_MARK)
        ends = [0, *islice(solid, max(self._gaps, default=0))]
        gaps = tuple(ends[count] for count in self._gaps)
        said = said.replace(PAUSE_MARK, ",")
        return SpokenText(said, tuple(self._dropped), gaps, tuple(self._remarks))

    def _say(self, text: str) -> None:
        self._left.append(text)
        # The characters that are neither spaces nor pauses.
        self._solid += len("".join(text.replace(PAUSE_MARK, " ").split()))

    def _sound(self, start: int, stop: int) -> str:
        """Return a part of the text without stray marks, and remark on them."""
        part = self.text[start:stop]
        for found in STRAY.finditer(part):
            column = start + found.start() + 1
            self._remarks.append(
                f"column {column}: '{found[0]}' has no partner, so the text next to it is spoken"
            )
            self._dropped.append(found[0])
        return STRAY.sub("", part)

    def _instead(self, found: re.Match[str]) -> str | None:
        """Return the replacement of markup; None for text that is not markup."""
        whole, aside = found[0], found["round"] or found["doublewidth"] or found["star"]
        if aside:
            start, stop = found.span()
            before = TAGS_BEFORE.sub("", self.text[max(start - SEEN_CHARS, 0) : start])
            after = TAGS_AFTER.sub("", self.text[stop : stop + SEEN_CHARS])
            starred = found["star"] is not None
            if not is_aside(aside, before, after, self.cleaning.asides, starred=starred):
                return None
        elif (instead := self._meant(found)) is not None:
            return instead
        self._dropped.append(whole)
        if aside or found.lastgroup == "bleep" or PAUSING.match(whole):
            return PAUSE_MARK
        before = self.text[max(found.start() - 1, 0) : found.start()]
        after = self.text[found.end() : found.end() + 1]
        # A sign between two words, as in "one->two", stands for the space that it lacks.
        parts = found.lastgroup == "sign" and before.isalnum() and after.isalnum()
        return " " if parts or BREAKING.match(whole) else ""

    def _meant(self, found: re.Match[str]) -> str | None:
        """Return the text that a mark stands for; None if it is not spoken."""
        whole = found[0]
        if found.lastgroup == "escape":
            return found["kept"] or " "
        if EMPHASIS_TAG.match(whole):
            return "*"
        if found["alias"] is not None or whole in DOUBLED:
            return found["alias"] or DOUBLED.get(whole, "")
        values = self.cleaning.values
        if self._is_tag(whole) or not values or whole[0] not in "{[%$<\\":
            return None
        name = PLACEHOLDER_NAME.search(whole)
        known = values.get(whole, values.get(name[0]) if name else None)
        return None if known is None else ordinary(known)

    def _is_tag(self, whole: str) -> bool:
        """Return True for a word in brackets with a later closing one."""
        return TAG_VALUES.sub("", whole[:-1]) in self._closed


@lru_cache(64)
def _markup(
    unspoken: tuple[str, ...],
    proven: tuple[str, ...],
    addressed: bool,  # noqa: FBT001 for the cache
) -> re.Pattern[str]:
    """Return the pattern of markup, with the passages of a project and the forms with a proof.

    Addresses are a part of it only where the text has the sign of one, as their search is slow.
    """
    ways = []
    for one in unspoken:
        opening, _, closing = map(re.escape, ordinary(one).partition("..."))
        inner = rf".{{0,{MAX_UNSPOKEN_CHARS}}}?" + (closing or "$")
        ways.append(opening + (inner if "..." in one else ""))
    listed = f"(?P<listed>{'|'.join(ways)})|" if ways else ""
    sections = []
    for kind, forms in FORMS.items():
        unsure = [pattern for of, pattern, _ in map(UNSURE_FORMS.__getitem__, proven) if of == kind]
        sections.append(f"(?P<{kind}>{'|'.join([*forms.values(), *unsure])})")
    # Nearly all markup begins with a character that is neither a letter nor a pause.
    signs = rf"(?![^\W_]|[\s.,!?'\"])(?:{'|'.join(sections)})"
    address = f"(?P<address>{PATTERN_PARTS['ADDRESS']})|" if addressed else ""
    return re.compile(f"{listed}{signs}|{address}(?P<face>{PATTERN_PARTS['EMOTICONS']})", re.DOTALL)


def _paused(found: re.Match[str]) -> str:
    """Return a pause with the characters around it; adjacent pauses are merged."""
    before, after = found["before"], found["after"]
    needless = not before or not after or before in PAUSES or after in PAUSES
    return f"{before} {after}" if needless else f"{before}{PAUSE_MARK} {after}"


def ordinary(text: str) -> str:
    """Return a text in ordinary letters.

    Unicode writes one letter in several ways. Engines, lexicons and rules know one of them, and
    misread the others without a word: a decomposed ``ü`` becomes an ``u``, a full-width ``５`` is
    lost.

    Letters are composed (NFC); letters and digits of full width, half width or another shape become
    their ordinary selves; an apostrophe within a word is ``'``. Characters without a shape of their
    own, such as marks of direction, are left out.

    >>> ordinary("u\u0308ber ５０ lʼami")
    "über 50 l'ami"
    """
    if text.isascii():
        return APOSTROPHE.sub("'", text) if "`" in text else text
    text = UNUSUAL.sub(
        lambda found: normalize("NFKC", found[0].translate(NUMERAL_SIGNS)), UNSEEN.sub("", text)
    )
    return APOSTROPHE.sub("'", normalize("NFC", text))
