"""Look-up of words in a file of pronunciations.

One word a line, then its labels: ``word<TAB>w ɜ d``, as WikiPron has it, or ``WORD  W ER1 D`` as
CMUdict does. Probabilities may stand before the labels, as in dictionaries of the Montreal Forced
Aligner and of Kaldi. An entry of noise, ``<unk>  spn``, is no word. Of several lines for a word the
likeliest counts, or the first; ``WORD(2)`` is another. Lines that start with ``;;;`` or ``#`` are
comments. Words the file does not have are read by the pack's rules, if it has some; else they are
left over, and named.
"""

import re
from itertools import dropwhile
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
_NO_WORD = re.compile(r"<[^>]*>|\[[^]]*]|\{[^}]*}|\+\+.*\+\+|!\w+")
"""Names of noise and of silence in the place of a word."""

_BEFORE_LABELS = re.compile(r"\d+\.\d*(?:[eE][-+]?\d+)?")
"""A number with a point, which no label is; a digit alone may be one, as in X-SAMPA."""

_WORD_BREAK = re.compile(r"-|'")


@G2P_ENGINES.register("lexicon")
def engine(settings: Settings) -> G2PEngine:
    """Read text with a lexicon."""
    if settings.file is None:
        hint = "state it as `g2p: {engine: lexicon, file: words.tsv}`"
        raise SpeechError(f"{settings.language} reads by a lexicon, but names none: {hint}")
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

    return lambda texts: (read_words(text, look_up) for text in texts)


def read_lexicon(path: Path) -> dict[str, tuple[str, ...]]:
    """Read a lexicon: words in plain spelling, and the labels of each."""
    mend = "keep the words that are said"
    text = input_text(path, MAX_LEXICON_BYTES, error=SpeechError, mend=mend)
    words: dict[str, tuple[str, ...]] = {}
    likeliest: dict[str, float] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.startswith(COMMENTS):
            continue
        word, _, rest = line.partition("\t") if "\t" in line else line.strip().partition(" ")
        cells = rest.split()
        labels = tuple(dropwhile(_BEFORE_LABELS.fullmatch, cells))
        if not word.strip() or not labels:
            raise SpeechError(
                f"{path}:{number}: {line.strip()[:60]!r} is not a word and its labels; "
                "write the word, a tab, and the labels with spaces between them"
            )
        if _NO_WORD.fullmatch(word.strip()):
            continue
        # the first number is the probability of these labels, others are those of pauses around
        likely = float(cells[0]) if len(cells) > len(labels) else 1.0
        spelled = plain(_PRONUNCIATION_NUMBER.sub("", word.strip()))
        if likely > likeliest.get(spelled, -1.0):
            words[spelled], likeliest[spelled] = labels, likely
    if not words:
        raise SpeechError(f"{path}: has no words; write one a line, a tab, and its labels")
    return words
