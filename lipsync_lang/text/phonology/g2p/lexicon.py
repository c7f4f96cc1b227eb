"""Look-up of words in a file of pronunciations.

One word a line, then its labels: ``word<TAB>w ɜ d``, as WikiPron has it, or ``WORD  W ER1 D`` as
CMUdict does. Of several lines for a word the first counts; ``WORD(2)`` is another. Lines that start
with ``;;;`` or ``#`` are comments. Words the file does not have are read by the pack's rules, if it
has some; else they are left over, and named.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.base.files.reading import MIB_BYTES, input_text
from lipsync_lang.text.phonology.g2p.g2p_engines import G2P_ENGINES, G2PEngine, Settings, SpokenWord
from lipsync_lang.text.phonology.g2p.rules import Rewriter
from lipsync_lang.text.phonology.g2p.tokens import plain, read_words

COMMENTS = (";;;", "#")

MAX_LEXICON_BYTES = 256 * MIB_BYTES
"""Maximum size of a lexicon in bytes; the largest of WikiPron has 30 million."""

_PRONUNCIATION_NUMBER = re.compile(r"\(\d+\)$")
_WORD_BREAK = re.compile(r"-|'")


@G2P_ENGINES.register("lexicon")
def engine(settings: Settings) -> G2PEngine:
    """Read text with a lexicon."""
    if settings.file is None:
        raise SpeechError(
            f"{settings.language} reads by a lexicon, but names none: "
            "state it as `g2p: {engine: lexicon, file: words.tsv}`"
        )
    words = read_lexicon(settings.file)
    rewriter = Rewriter(settings.rules, settings.labels) if settings.rules else None

    def look_up(word: str) -> SpokenWord:
        spelled = plain(word)
        if spelled in words:
            return SpokenWord(word, words[spelled])
        parts = [part for part in _WORD_BREAK.split(spelled) if part]
        if len(parts) > 1 and all(part in words for part in parts):
            return SpokenWord(word, tuple(label for part in parts for label in words[part]))
        return rewriter.read(word) if rewriter else SpokenWord(word, (), unread=word)

    def read(texts: Sequence[str]) -> Iterator[tuple[SpokenWord, ...]]:
        for text in texts:
            yield read_words(text, look_up)

    return read


def read_lexicon(path: Path) -> dict[str, tuple[str, ...]]:
    """Read a lexicon: words in plain spelling, and the labels of each."""
    text = input_text(
        path, MAX_LEXICON_BYTES, error=SpeechError, mend="keep the words that are said"
    )
    words: dict[str, tuple[str, ...]] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.startswith(COMMENTS):
            continue
        word, _, labels = line.partition("\t") if "\t" in line else line.strip().partition(" ")
        if not word.strip() or not labels.split():
            raise SpeechError(
                f"{path}:{number}: {line.strip()[:60]!r} is not a word and its labels; "
                "write the word, a tab, and the labels with spaces between them"
            )
        words.setdefault(plain(_PRONUNCIATION_NUMBER.sub("", word.strip())), tuple(labels.split()))
    if not words:
        raise SpeechError(f"{path}: has no words; write one a line, a tab, and its labels")
    return words
