"""Chinese text to pinyin, with pypinyin.

Labels are the initials and finals of Hanyu Pinyin, without tones. Finals are written in full
wherever they stand, so that there is no ``y`` and no ``w``: 我 is ``uo``, 月 ``üe``, 有 ``iou``,
会 ``h uei``, 雪 ``x üe``. An r after a final is ``r``: 花儿 is ``h ua r``.

Words are the phrases that pypinyin knows, else characters. It knows them in simplified
characters; OpenCC turns traditional ones into these, to be read, and only to be read.

What is not hanzi: Latin letters with tone marks or tone digits are pinyin; without tones they are
where nothing but numbers in hanzi stands beside them. Other Latin words are said as another voice
says them. Digits are read one by one, where the pack has no words for a number. What is none of
these is left over, and named.

`respelled` is pinyin with tone digits, ``v`` for ü and no spaces, as eSpeak NG's voice for pinyin
reads it: one word to the voice as well.
"""

import re
from collections.abc import Iterator, Sequence
from functools import cache, lru_cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple
from unicodedata import category, normalize

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.base.extras import install_line
from lipsync_lang.text.phonology.g2p.g2p_engines import (
    G2P_ENGINES,
    TONED,
    G2PEngine,
    Rule,
    Settings,
    SpokenWord,
)
from lipsync_lang.text.phonology.g2p.rules import (
    ForeignReader,
    StatedReading,
    compiled_readings,
    stated_syllables,
)
from lipsync_lang.text.phonology.g2p.tokens import PAUSES, unmarked

if TYPE_CHECKING:
    from opencc import OpenCC

HANZI = "〇\u3400-\u9fff\uf900-\ufaff\U00020000-\U0003ffff"
LATIN = "A-Za-zÀ-ÖØ-öø-\u024f\u1e00-\u1eff\u0300-\u036f"
LENGTHENING_SIGNS = "~～"
"""Characters that lengthen a word in writing and have no sound of their own."""

_FULL_WIDTH = {0xFEE0 + c: c for c in range(0x21, 0x7F)}
_TEXT_PART = re.compile(
    rf"""
      (?P<hanzi>[{HANZI}]+)
    | (?P<number>[0-9]+)
    | (?P<roman>[{LATIN}](?:[{LATIN}]
        |[0-5](?![0-9])|(?<=[nlNL][uU]):(?=[0-5eanEAN])|['’-](?=[{LATIN}]))*)
    | (?P<pause>[{re.escape("".join(sorted(PAUSES)))}]+)
    | (?P<symbol>\S)
    """,
    re.VERBOSE,
)
_NUMERALS = "零一二三四五六七八九十百千万亿点负两"
"""Signs of numbers in hanzi, the digits first."""


class _TextChunk(NamedTuple):
    """A part of a text of one kind: the user's spelling, and plain letters."""

    kind: str
    text: str
    plain: str


@G2P_ENGINES.register("pypinyin")
def engine(settings: Settings) -> G2PEngine:
    """Read Chinese text."""
    if not all(map(find_spec, ("pypinyin", "opencc"))):
        what = "reading Chinese needs pypinyin and OpenCC, which are not both installed"
        raise SpeechError(f"{what}; get them with: {install_line('mandarin')}")

    stated = [(_converter().convert(word), say) for word, say in settings.whole]
    own = (Rule(word, tuple(say.split())) for word, say in stated if TONED.fullmatch(say))
    readings = compiled_readings((*own, *settings.readings))
    foreign, whole = ForeignReader(settings), frozenset(word for word, _ in stated)

    def read(texts: Sequence[str]) -> Iterator[tuple[SpokenWord, ...]]:
        cut = [[*_text_parts(text)] for text in texts]
        foreign.ahead(one.plain for parts in cut for one in parts if one.kind == "foreign")
        for parts in cut:
            yield tuple(said for piece in parts for said in _read(piece, foreign, readings, whole))

    return read


def _text_parts(text: str) -> Iterator[_TextChunk]:
    """Cut a text into hanzi, numbers, pinyin, foreign words, pauses and symbols."""
    text = normalize("NFC", text)
    narrow = text.translate(_FULL_WIDTH)
    among_hanzi = re.search(f"(?![{_NUMERALS}])[{HANZI}]", narrow) is not None
    for found in _TEXT_PART.finditer(narrow):
        start, end = found.span()
        piece = _TextChunk(found.lastgroup or "", text[start:end], found[0])
        if piece.kind == "roman":
            letters = piece.plain.rstrip("012345")
            paper = among_hanzi and len(letters) == 1 and letters.isupper()  # A4纸
            if not paper and spelled(piece.plain, toneless=not among_hanzi):
                yield piece._replace(kind="spelled")
                continue
            for part in re.finditer(r"[0-9]+|[^0-9]+", piece.plain):
                kind = "number" if part[0].isdigit() else "foreign"
                # the voice would take marks on letters for tones
                bare = unmarked(normalize("NFD", part[0]))
                yield _TextChunk(kind, piece.text[slice(*part.span())], bare)
        elif piece.kind != "symbol" or (
            category(piece.plain)[0] in "LNS" and piece.plain not in LENGTHENING_SIGNS
        ):
            yield piece


def _read(
    piece: _TextChunk,
    foreign: ForeignReader,
    readings: Sequence[StatedReading],
    whole: frozenset[str],
) -> Iterator[SpokenWord]:
    match piece.kind:
        case "hanzi":
            yield from (said(*word) for word in words_of(piece.text, readings, whole))
        case "number":
            digits = "".join(_NUMERALS[int(digit)] for digit in piece.plain)
            yield said(piece.text, [s for _, word in words_of(digits) for s in word])
        case "spelled":
            yield said(piece.text, spelled(piece.plain, toneless=True))
        case "foreign" if labels := foreign(piece.plain):
            yield SpokenWord(piece.text, labels, piece.plain)
        case "pause":
            yield SpokenWord(piece.text, ())
        case _:
            yield said(piece.text, ())


def said(text: str, syllables: Sequence[str]) -> SpokenWord:
    """Return a word of syllables; without any, the word is unread and silent."""
    if not syllables:
        return SpokenWord(text, (), " ", text)
    labels = tuple(label for syllable in syllables for label in labels_of(syllable))
    respelled = ""
    for syllable in syllables:
        name, tone = syllable[:-1], syllable[-1]
        # eSpeak NG knows no such syllables, and other spellings of some.
        split = name in {"jiong", "qiong", "xiong"}
        respelled += f"{name[:2]}{tone}ong" if split else _UNKNOWN_TO_VOICE.get(name, name)
        respelled += tone
    return SpokenWord(text, labels, respelled)


@cache
def labels_of(syllable: str) -> tuple[str, ...]:
    """Return the initial and the final of a syllable with a tone digit, or ``r``."""
    from pypinyin.contrib.tone_convert import to_finals, to_initials

    name = syllable[:-1]
    initial, final = to_initials(name), to_finals(name, v_to_u=True)
    if name[0] == "y" and final == "o":
        initial = "i"
    elif name != "r" and not final:  # hm, hng; m, n, ng
        initial, final = ("h", name[1:]) if name[0] == "h" else ("", name)
    return tuple(label for label in (initial, final) if label)


_UNKNOWN_TO_VOICE = dict(
    name.split() for name in ("r er", "m mu", "hm heng", "hng heng", "ê ei", "wong weng")
)


ERHUA = re.compile(
    r"(?<=.)(?<![女妻孙侄孤婴幼胎少健男宠弃育托产生血能潮馨运])儿(?![子童女媳孙歌科戏]|时(?!间|候))"
)
"""儿 that is only an r after the syllable before: not in 女儿, 婴儿, 儿子."""


def words_of(
    hanzi: str, readings: Sequence[StatedReading] = (), whole: frozenset[str] = frozenset()
) -> Iterator[tuple[str, list[str]]]:
    """Yield words with their syllables and tone digits; unreadable words have no syllables.

    An r after a syllable is the syllable ``r5``. A stated reading counts where its letters are
    words of the text. Words of `whole` are cut out first.
    """
    from pypinyin import Style, lazy_pinyin

    simple = _converter().convert(hanzi)
    if len(simple) != len(hanzi):
        simple = hanzi  # places in it are places in the text
    erhua = {found.start() for found in ERHUA.finditer(simple)}
    phrases = list(_phrases(simple, whole))
    stated = stated_syllables(simple, phrases, readings)
    word: tuple[str, list[str]] = ("", [])
    start = 0
    for phrase in phrases:
        stop = start + len(phrase)
        syllables = lazy_pinyin(phrase, Style.TONE3, errors="ignore", neutral_tone_with_five=True)
        if start in stated:
            syllables = [stated[at] for at in range(start, stop)]
        if len(syllables) == len(phrase):
            syllables = ["r5" if start + i in erhua else s for i, s in enumerate(syllables)]
        if syllables[:1] == ["r5"] and word[1]:
            word = (word[0] + hanzi[start:stop], word[1] + syllables)
        else:
            if word[0]:
                yield word
            word = (hanzi[start:stop], syllables)
        start = stop
    yield word


def _phrases(simple: str, whole: frozenset[str]) -> Iterator[str]:
    """Cut hanzi into the words of `whole`, the longest first, and those that pypinyin knows."""
    from pypinyin.seg.mmseg import seg

    if not whole:
        return seg.cut(simple)
    parts = _whole_words(whole).split(simple)
    return (one for part in parts for one in ((part,) if part in whole else seg.cut(part)) if one)


@lru_cache(8)
def _whole_words(whole: frozenset[str]) -> re.Pattern[str]:
    return re.compile(f"({'|'.join(map(re.escape, sorted(whole, key=len, reverse=True)))})")


@cache
def _converter() -> "OpenCC":
    from opencc import OpenCC

    return OpenCC("t2s")


TONE_MARKS = {"\u0304": "1", "\u0301": "2", "\u030c": "3", "\u0300": "4"}
MAX_PINYIN_CHARS = 60
"""Maximum number of letters of a word of pinyin."""

_SYLLABLE_END = re.compile(r"(r(?![aeiouv]))?([0-5]?)(r(?![aeiouv]))?'?")


@cache
def _known() -> frozenset[str]:
    """Return all syllables that have a vowel, without tones."""
    from pypinyin.constants import PINYIN_DICT

    written = {s for readings in PINYIN_DICT.values() for s in readings.split(",")}
    bare = {normalize("NFD", s).replace("u\u0308", "v") for s in written}
    return frozenset(s for s in map(unmarked, bare) if set(s) & set("aeiouv"))


def spelled(word: str, *, toneless: bool) -> tuple[str, ...]:
    """Return the syllables of a word of pinyin, with tone digits; none if it is not pinyin.

    Tones are marks or digits. A `toneless` word may be without any, and is read in the first tone.
    """
    letters, marks = _unmarked(word)
    cut = len(word) <= MAX_PINYIN_CHARS and (_cut(letters, 0) or _cut(letters, 0, loose=True))
    tones = bool(marks) or any(map(str.isdigit, letters))
    if not cut or not (tones or toneless):
        return ()
    out: list[str] = []
    for start, end, stop in cut:
        digit = re.sub("[^1-5]", "", letters[end:stop])
        mark = next((marks[i] for i in range(start, end) if i in marks), "5" if tones else "1")
        out.append(letters[start:end] + (digit or mark))
        if "r" in letters[end:stop]:
            out.append("r5")
    return tuple(out) if tones or "r5" not in out else ()


def _unmarked(word: str) -> tuple[str, dict[int, str]]:
    """Return the letters of a word, v for ü, and the tones marked on them by their places."""
    letters: list[str] = []
    marks: dict[int, str] = {}
    for character in normalize("NFD", word.lower()):
        if character in TONE_MARKS:
            marks[len(letters) - 1] = TONE_MARKS[character]
        elif character in ":\u0308" and letters[-1:] == ["u"]:
            letters[-1] = "v"
        elif character != "\u0302":  # ê
            letters.append("'" if character in "’-" else character)
    return re.sub("(?<=[jqxy])v", "u", "".join(letters)), marks


# The cache also keeps a word from being cut in exponentially many ways.
@lru_cache(10_000)
def _cut(letters: str, start: int, *, loose: bool = False) -> tuple[tuple[int, int, int], ...]:
    """Cut letters into syllables: where each starts, its own letters end, and the next may start.

    The longest come first. A syllable that starts with a vowel needs a tone digit or an
    apostrophe before it, unless `loose`.
    """
    for end in range(min(start + 6, len(letters)), start, -1):
        tail = _SYLLABLE_END.match(letters, end)
        if letters[start:end] not in _known() or tail is None:
            continue
        here, stop = (start, end, tail.end()), tail.end()
        if stop == len(letters):
            return (here,)
        if (loose or stop > end or letters[stop] not in "aeo") and (
            rest := _cut(letters, stop, loose=loose)
        ):
            return (here, *rest)
    return ()
