"""Text that is IPA, and IPA cut into segments."""

import re
from collections.abc import Collection
from unicodedata import category

from lipsync_lang.text.phonology.g2p.g2p_engines import G2P_ENGINES, G2PEngine, Settings, SpokenWord
from lipsync_lang.text.phonology.labels import LENGTH_MARKS, STRESS, TONE, normalise

_STRESS_SIGN = re.compile(f"[{STRESS}]")
_IPA_WORDS = re.compile(r"(?:[^\s.,;!?…]|\.(?=\w))+|[.,;!?…]+")
_JOINED = {"Mn", "Lm", "Sk"}
"""Unicode categories of diacritics and modifier letters, which belong to the letter before."""


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
