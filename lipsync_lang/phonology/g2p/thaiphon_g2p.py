"""Text to IPA with thaiphon, for scripts without spaces between words.

PyThaiNLP cuts a run of letters into words; thaiphon finds the syllables of each, and with them the
vowels that are not written. Whole numbers are read as words; the sign of repetition says the word
before it again. Tones do not show, and are left out.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache

from lipsync_lang.errors import SpeechError
from lipsync_lang.extras import install_line
from lipsync_lang.phonology.g2p.epitran import segments
from lipsync_lang.phonology.g2p.g2p_engines import G2P_ENGINES, G2PEngine, Settings, SpokenWord
from lipsync_lang.phonology.g2p.rules import CACHED_WORDS, foreign_reader
from lipsync_lang.phonology.g2p.tokens import TextPiece, pieces
from lipsync_lang.phonology.labels import normalise

REPETITION_SIGN = "\u0e46"
"""The sign that repeats a word."""

_ALPHANUMERIC = re.compile(r"\w|[\u0e00-\u0e7f]")
_SCRIPT_LETTER = re.compile("[\u0e01-\u0e4e]")

MAX_READ_DIGITS = 15
"""Maximum digits of a number; a longer one is read digit by digit."""

_TONES = re.compile("[\u02e5-\u02e9/]")
_RUN = re.compile("[0-9\u0e50-\u0e59]+|[^0-9\u0e50-\u0e59]+")


@G2P_ENGINES.register("thaiphon")
def engine(settings: Settings) -> G2PEngine:
    """Read text with thaiphon."""
    try:
        from pythainlp.tokenize import word_tokenize
        from pythainlp.util import num_to_thaiword
        from thaiphon import transcribe
        from thaiphon.errors import ThaiphonError
    except ImportError:
        raise SpeechError(
            f"{settings.language} is read by thaiphon and PyThaiNLP, which are not both installed; "
            f"get them with: {install_line('thaiphon')}"
        ) from None
    known = frozenset(map(normalise, settings.labels))
    foreign = foreign_reader(settings)

    @lru_cache(CACHED_WORDS)
    def labels_of(word: str) -> tuple[str, ...]:
        try:
            ipa = _TONES.sub("", transcribe(word, "ipa"))
        except ThaiphonError:  # a misspelt word: a mark without its letter
            return ()
        return tuple(label for part in ipa.split(".") for label in segments(part, known))

    def number(digits: str) -> tuple[str, ...]:
        parts = [digits] if len(digits) <= MAX_READ_DIGITS else [*digits]
        return labels_of("".join(num_to_thaiword(int(part)) for part in parts))

    def words(run: str) -> Iterator[SpokenWord]:
        last: tuple[str, ...] = ()
        for word in filter(_ALPHANUMERIC.search, word_tokenize(run, keep_whitespace=False)):
            again = word == REPETITION_SIGN
            reader = labels_of if _SCRIPT_LETTER.search(word) else foreign
            last = last if again else reader(word)
            yield SpokenWord(word, last, unread="" if last else word)

    def read(texts: Sequence[str]) -> Iterator[tuple[SpokenWord, ...]]:
        for text in texts:
            yield tuple(said for piece in pieces(text) for said in _read(piece, words, number))

    return read


def _read(
    piece: TextPiece,
    words: Callable[[str], Iterator[SpokenWord]],
    number: Callable[[str], tuple[str, ...]],
) -> Iterator[SpokenWord]:
    """Yield the words of a piece; letters of scripts that no voice reads are left over."""
    if piece.kind != "word":
        yield SpokenWord(piece.text, (), unread=piece.text if piece.kind == "symbol" else "")
        return
    for found in _RUN.finditer(piece.text):
        run = found[0]
        if run.isdigit():
            yield SpokenWord(run, number(run))
        elif any(map(str.isalnum, run)):
            yield from words(run)
