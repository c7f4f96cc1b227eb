"""Text to IPA with Epitran, for languages with a regular spelling."""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path

from lipsync_lang import SpeechError
from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.base.extras import install_line
from lipsync_lang.text.phonology.g2p.g2p_engines import G2P_ENGINES, G2PEngine, Settings, SpokenWord
from lipsync_lang.text.phonology.g2p.ipa_text import segments
from lipsync_lang.text.phonology.g2p.rules import CACHED_WORDS
from lipsync_lang.text.phonology.g2p.tokens import plain, read_words
from lipsync_lang.text.phonology.labels import normalise


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
        # Epitran leaves digits as they are
        read = tuple(label for label in labels if not label.isdigit())
        unread = "".join(label for label in labels if label.isdigit())
        return SpokenWord(word, read, unread=unread)

    def read(texts: Sequence[str]) -> Iterator[tuple[SpokenWord, ...]]:
        for text in texts:
            yield read_words(text, read_word)

    return read
