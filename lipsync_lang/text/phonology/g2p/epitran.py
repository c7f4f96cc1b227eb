"""Text to IPA with Epitran, for languages with a regular spelling; and text that is IPA."""

import re
from collections.abc import Collection, Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from unicodedata import category

from lipsync_lang.base.errors import SpeechError, did_you_mean
from lipsync_lang.base.extras import install_line
from lipsync_lang.text.phonology.g2p.g2p_engines import G2P_ENGINES, G2PEngine, Settings, SpokenWord
from lipsync_lang.text.phonology.g2p.rules import CACHED_WORDS
from lipsync_lang.text.phonology.g2p.tokens import plain, read_words
from lipsync_lang.text.phonology.labels import LENGTH_MARKS, STRESS, TONE, normalise

_STRESS_SIGN = re.compile(f"[{STRESS}]")
_IPA_WORDS = re.compile(r"(?:[^\s.,;!?…]|\.(?=\w))+|[.,;!?…]+")
_JOINED = {"Mn", "Lm", "Sk"}
"""Unicode categories of diacritics and modifier letters, which belong to the letter before."""


@G2P_ENGINES.register("epitran")
def engine(settings: Settings) -> G2PEngine:
    """Read text with Epitran's code of the language."""
    code = settings.code or ""
    try:
        import epitran
        from epitran.exceptions import DatafileError
    except ImportError:
        raise SpeechError(
            f"{settings.language} is read by Epitran, which is not installed; "
            f"get it with: {install_line('epitran')}"
        ) from None
    try:
        transliterate = epitran.Epitran(code).transliterate
    except (DatafileError, OSError, KeyError, ValueError):
        maps = Path(epitran.__file__).parent / "data" / "map"
        hint = did_you_mean(code, {path.stem for path in maps.glob("*.csv")})
        raise SpeechError(f"Epitran has no language '{code}'; {hint}") from None
    known = frozenset(map(normalise, settings.labels))

    @lru_cache(CACHED_WORDS)
    def read_word(word: str) -> SpokenWord:
        labels = segments(transliterate(plain(word)), known)
        read = tuple(label for label in labels if not label.isdigit())
        unread = "".join(label for label in labels if label.isdigit())
        return SpokenWord(word, read, unread=unread)

    def read(texts: Sequence[str]) -> Iterator[tuple[SpokenWord, ...]]:
        for text in texts:
            yield read_words(text, read_word)

    return read


@G2P_ENGINES.register("ipa")
def engine_of_ipa(settings: Settings) -> G2PEngine:
    """Read text that is IPA: words with spaces between them."""
    known = frozenset(map(normalise, settings.labels))

    def word(written: str) -> SpokenWord:
        return SpokenWord(written, segments(_STRESS_SIGN.sub("", written), known))

    return lambda texts: (tuple(map(word, _IPA_WORDS.findall(text))) for text in texts)


def segments(ipa: str, known: Collection[str] = ()) -> tuple[str, ...]:
    """Cut IPA into segments: the longest known ones, otherwise a letter with its marks."""
    text = normalise(ipa)
    longest = max(map(len, known), default=1)
    found: list[str] = []
    at = 0
    while at < len(text):
        stop = _after_marks(text, at + 1)
        for end in range(min(len(text), at + longest), stop, -1):
            whole = _after_marks(text, end)
            if text[at:end] in known and not text[end:whole].strip(TONE):
                stop = whole
                break
        segment = text[at:stop]
        if segment.strip() and (segment[0].isalnum() or category(segment[0])[0] in "LMN"):
            found.append(segment)
        at = stop
    return tuple(found)


def _after_marks(text: str, at: int) -> int:
    """Return the first place from `at` on that is no mark of the letter before."""
    while at < len(text) and (category(text[at]) in _JOINED or text[at] in LENGTH_MARKS):
        at += 1
    return at
