"""Text to IPA with thaiphon, for scripts without spaces between words.

PyThaiNLP cuts a run of letters into words; thaiphon finds the syllables of each, and with them the
vowels that are not written. The sign of repetition says the word before it again: PyThaiNLP alone
knows where that begins. Tones do not show, and are left out.
"""

import re
from collections.abc import Iterator, Sequence
from functools import lru_cache

from lipsync_lang import SpeechError
from lipsync_lang.base.extras import install_line
from lipsync_lang.text.phonology.g2p.g2p_engines import G2P_ENGINES, G2PEngine, Settings, SpokenWord
from lipsync_lang.text.phonology.g2p.ipa_text import segments
from lipsync_lang.text.phonology.g2p.rules import CACHED_WORDS, ForeignReader
from lipsync_lang.text.phonology.g2p.tokens import TextPiece, pieces
from lipsync_lang.text.phonology.labels import normalise

REPETITION_SIGN = "\u0e46"
"""The sign that repeats a word."""

_ALPHANUMERIC = re.compile(r"\w|[\u0e00-\u0e7f]")
_SCRIPT_LETTER = re.compile("[\u0e01-\u0e4e]")

_TONES = re.compile("[\u02e5-\u02e9/]")


@G2P_ENGINES.register("thaiphon")
def engine(settings: Settings) -> G2PEngine:
    """Read text with thaiphon."""
    try:
        from pythainlp.tokenize import word_tokenize
        from thaiphon import transcribe
        from thaiphon.errors import ThaiphonError
    except ImportError:
        raise SpeechError(
            f"{settings.language} is read by thaiphon and PyThaiNLP, which are not both installed; "
            f"get them with: {install_line('thaiphon')}"
        ) from None
    known = frozenset(map(normalise, settings.labels))
    foreign = ForeignReader(settings)

    @lru_cache(CACHED_WORDS)
    def labels_of(word: str) -> tuple[str, ...]:
        try:
            ipa = _TONES.sub("", transcribe(word, "ipa"))
        except ThaiphonError:  # a misspelt word: a mark without its letter
            return ()
        return tuple(label for part in ipa.split(".") for label in segments(part, known))

    def words(run: str) -> Iterator[SpokenWord]:
        last: tuple[str, ...] = ()
        for word in filter(_ALPHANUMERIC.search, word_tokenize(run, keep_whitespace=False)):
            again = word == REPETITION_SIGN
            reader = labels_of if _SCRIPT_LETTER.search(word) else foreign
            # a sign of repetition is a word of its own, said as the one before
            last = last if again else reader(word)
            yield SpokenWord(word, last, unread="" if last else word)

    def _read(piece: TextPiece) -> Iterator[SpokenWord]:
        if piece.kind == "word":
            yield from words(piece.text)
        else:
            yield SpokenWord(piece.text, (), unread=piece.text if piece.kind == "symbol" else "")

    def read(texts: Sequence[str]) -> Iterator[tuple[SpokenWord, ...]]:
        foreign.ahead(piece.text for text in texts for piece in pieces(text))
        for text in texts:
            yield tuple(said for piece in pieces(text) for said in _read(piece))

    return read
