"""A text cut into words, pauses and symbols, and read word by word."""

import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import TYPE_CHECKING, NamedTuple
from unicodedata import category, normalize

if TYPE_CHECKING:
    from lipsync_lang.text.phonology.g2p.g2p_engines import SpokenWord

INNER = frozenset("'’‘-·־\u00ad")
"""Within a word, and nothing by themselves."""

UNSPACED = "\u0e00-\u109f\u1780-\u17ff\u3000-\u9fff\uf900-\ufaff"
"""Characters of scripts without spaces between words: Thai to Burmese, Khmer, kana and hanzi."""

PAUSES = frozenset(".!?…,;:—–、。，！？；：।॥؟،؛።፣፤၊။")
"""Marks at which the voice rests."""

SENTENCE_SIGNS = frozenset("၌၍၎၏")
"""Punctuation to Unicode, and words to their readers."""

APOSTROPHES = str.maketrans("’‘", "''")

JOINERS = frozenset("\u200c\u200d")

_WORD_SHAPE = re.compile(
    r"(?P<word>[wn]+(?:(?:i|(?<=n)p(?=n))[wn]+)*)|(?P<pause>p+|(?<= )i+(?= )|\n{2,})|s+"
)
"""Over the classes of characters: `w` letter, `n` digit, `i` inner, `p` pause, `s` symbol."""


@cache
def _class(character: str) -> str:
    kind = category(character)
    if character in PAUSES or character == "\n":
        return "p" if character in PAUSES else "\n"
    if character in INNER:
        return "i"
    if kind == "Nd":
        return "n"
    if kind[0] in "LMN" or character in JOINERS or character in SENTENCE_SIGNS:
        return "w"
    return "s" if kind[0] == "S" else " "


def counts(character: str) -> bool:
    """Test a character for a letter, a digit, or a mark on one."""
    return _class(character) in "wn"


class Replacement(NamedTuple):
    """A part of a text, and the text to read in its place."""

    start: int
    stop: int
    read: str


def respelled(text: str, replacements: Iterable[Replacement]) -> str:
    """Return a text with replacements, which are in order."""
    read, at = "", 0
    for one in replacements:
        read += text[at : one.start] + one.read
        at = one.stop
    return read + text[at:]


class TextPiece(NamedTuple):
    """A part of a text: a `word`, a `pause`, or a `symbol`."""

    text: str
    kind: str
    start: int


def pieces(text: str) -> Iterator[TextPiece]:
    """Yield the words, pauses and symbols of a text in order; spaces and brackets are none."""
    # Each class is one character, so places in the shape are places in the text.
    shape = "".join(map(_class, text))
    for found in _WORD_SHAPE.finditer(shape):
        start, end = found.span()
        yield TextPiece(text[start:end], found.lastgroup or "symbol", start)


def plain(word: str) -> str:
    """Return a word as rules and lexicons spell it: composed, in small letters."""
    return normalize("NFC", normalize("NFC", word).casefold()).translate(APOSTROPHES)


def unmarked(text: str) -> str:
    """Return a text without the marks on its letters."""
    return "".join(sign for sign in text if category(sign) != "Mn")


def read_words(text: str, read: "Callable[[str], SpokenWord]") -> "tuple[SpokenWord, ...]":
    """Read a text word by word; unread characters are kept for a remark."""
    from lipsync_lang.text.phonology.g2p.g2p_engines import SpokenWord

    out: list[SpokenWord] = []
    for piece in pieces(text):
        unread = piece.text if piece.kind == "symbol" else ""
        word = piece.kind == "word"
        out.append(read(piece.text) if word else SpokenWord(piece.text, (), unread=unread))
    while out and not out[-1].labels and not out[-1].unread:
        out.pop()
    return tuple(out)
