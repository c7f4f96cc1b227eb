"""Text to phonemes with the voices of eSpeak NG, without sound.

It says a text clause by clause and tells its words apart, but not which of the user's they are:
"10,000" is several of them, "of the" is one. Where a clause has as many words as the user's have by
themselves, or as pairs that the voice joins, they are these; else the clause is one `SpokenWord` as
a whole.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from types import MappingProxyType

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.text.phonology.espeak.process import VOICE_PAUSE, label_of, stress_of
from lipsync_lang.text.phonology.g2p.g2p_engines import (
    G2P_ENGINES,
    RESPELLERS,
    G2PEngine,
    Settings,
    SpokenWord,
)
from lipsync_lang.text.phonology.g2p.ipa_text import segments
from lipsync_lang.text.phonology.g2p.rules import CACHED_WORDS
from lipsync_lang.text.phonology.g2p.tokens import TextPiece, counts, pieces
from lipsync_lang.text.phonology.labels import looser, normalise

LabelledWords = Sequence[tuple[str, ...]]

ESPEAK_TIMEOUT_SECONDS = 120.0
"""Maximum seconds of a batch; a busy computer may delay one of many batches."""


@G2P_ENGINES.register("espeak")
def engine(settings: Settings) -> G2PEngine:
    """Read text with a voice of eSpeak NG."""
    respell = RESPELLERS.find(settings.respell, SpeechError) if settings.respell else None

    def transcribe(texts: Sequence[str]) -> Iterable[Sequence[LabelledWords]]:
        from lipsync_lang.text.phonology.espeak.process import EspeakProcess

        reader = EspeakProcess(patience=ESPEAK_TIMEOUT_SECONDS)
        return reader.transcribe(texts, settings.voice or "")

    read_plain, apart = by_clauses(transcribe), label_splitter(settings.labels)

    def read(texts: Sequence[str]) -> Iterator[tuple[SpokenWord, ...]]:
        spelled = [(respell(text) if respell else [(text, text)]) for text in texts]
        plain = ["".join(spelling for _, spelling in parts) for parts in spelled]
        for parts, words in zip(spelled, read_plain(plain), strict=True):
            yield tuple(map(apart, as_written(words, parts) if respell else words))

    return read


def by_clauses(
    transcribe: Callable[[Sequence[str]], Iterable[Sequence[LabelledWords]]],
) -> Callable[[Sequence[str]], Iterator[Iterator[SpokenWord]]]:
    """Return a function from texts to their words; `transcribe` gives the clauses of each text."""
    lengths: dict[str, int] = {}

    def count(spoken: set[str]) -> None:
        unmet = sorted(spoken - lengths.keys())
        for one, found in zip(unmet, transcribe(unmet), strict=True):
            lengths[one] = sum(map(len, found))

    def read(texts: Sequence[str]) -> Iterator[Iterator[SpokenWord]]:
        said = (piece for text in texts for piece in pieces(text) if piece.kind != "pause")
        count({piece.text for piece in said if not _surely(piece)})
        clauses = list(transcribe(texts))
        for text, found in zip(texts, clauses, strict=True):
            count({pair for said in paired(text, found, lengths) for pair in _pairs(said.text)})
        for text, found in zip(texts, clauses, strict=True):
            yield paired(text, found, lengths)

    return read


def label_splitter(labels: Iterable[str]) -> Callable[[SpokenWord], SpokenWord]:
    """Return a function that takes the stress off labels, and splits those that were joined."""
    known = frozenset(map(normalise, labels))

    @lru_cache(CACHED_WORDS)
    def apart(said: SpokenWord) -> SpokenWord:
        split: list[str] = []
        stress: list[int | None] = []
        for one in said.labels:
            label = label_of(one)
            found = (label,) if not known or known_as(label, known) else parts(label, known)
            split += found
            stress += [stress_of(one), *(None,) * (len(found) - 1)]
        marks = tuple(stress) if any(stress) else ()
        return said._replace(labels=tuple(split), stress=marks)

    return apart


def as_written(
    words: Iterable[SpokenWord], parts: Sequence[tuple[str, str]]
) -> Iterator[SpokenWord]:
    """Yield words in the user's spelling; `parts` are (user's spelling, the one that was read)."""
    written = "".join(piece for piece, _ in parts)
    read = "".join(spelling for _, spelling in parts)
    at = 0
    places: list[int] = []  # in the user's text, of each character that was read
    for piece, spelling in parts:
        places += (at + min(n, len(piece)) for n in range(len(spelling)))
        at += len(piece)
    places.append(at)
    done = 0
    for word in words:
        start = read.find(word.text, done) if word.labels else -1
        if start < 0:
            yield word
            continue
        done = start + len(word.text)
        text = written[places[start] : places[done]]
        yield word if text == word.text else word._replace(text=text, respelled=word.text)


def known_as(label: str, known: Collection[str]) -> bool:
    """Return True if a label is known in one of its spellings."""
    return any(spelling in known for spelling in looser(normalise(label)))


def parts(label: str, known: Collection[str]) -> tuple[str, ...]:
    """Split a label into known labels; return it whole if that is impossible."""
    found = segments(label, known)
    return found if all(known_as(part, known) for part in found) else (label,)


def paired(
    text: str, clauses: Sequence[LabelledWords], lengths: Mapping[str, int] = MappingProxyType({})
) -> Iterator[SpokenWord]:
    """Yield the words of each clause in the user's spelling, with pauses between clauses.

    `lengths` gives the number of spoken words for numbers, compounds, pairs of words and the like.
    """
    written: list[list[TextPiece]] = [[]]
    for piece in pieces(text):
        if piece.kind == "pause":
            # the full stop in `a.m.` is no pause
            if not text[max(piece.start - 1, 0) : piece.start + 2].replace(".", "", 1).isalpha():
                written.append([])
        else:
            written[-1].append(piece)
    written = [clause for clause in written if clause]
    spoken = [words for words in clauses if words]
    whole = [word for words in spoken for word in words]
    tokens = [token for part in written for token in part]
    # The voice may cut clauses elsewhere, and still say the same words.
    if len(written) != len(spoken) and _matched(text, tokens, whole, lengths) is not None:
        spoken, written = [whole], [tokens]
    if len(written) != len(spoken):
        yield from _said(_between(text, tokens), whole)
        return
    for number, (words, part) in enumerate(zip(spoken, written, strict=True)):
        if number:
            yield SpokenWord(",", ())
        matched = _matched(text, part, words, lengths)
        yield from _said(_between(text, part), words) if matched is None else matched


def _matched(
    text: str, tokens: Sequence[TextPiece], words: LabelledWords, lengths: Mapping[str, int]
) -> list[SpokenWord] | None:
    """Assign spoken words to each token, or pair of tokens; None unless their counts agree."""
    alone = len(tokens) == len(words) == 1
    counted: list[tuple[list[TextPiece], int]] = []
    for token in tokens:
        if counted and lengths.get(_between(text, [counted[-1][0][-1], token])) == 1:
            counted[-1][0].append(token)
        else:
            sure = alone or _surely(token)
            counted.append(([token], 1 if sure else lengths.get(token.text, 0)))
    numbers = [number for _, number in counted]
    if sum(numbers) != len(words) or 0 in numbers:
        return None
    said: list[SpokenWord] = []
    at = 0
    for joined, number in counted:
        said += _said(_between(text, joined), words[at : at + number])
        at += number
    return said


def _said(text: str, words: LabelledWords) -> Iterator[SpokenWord]:
    """Yield the labels of spoken words as one word, and the pause behind them."""
    labels = [label for word in words for label in word]
    if labels:
        yield SpokenWord(text, tuple(label for label in labels if label != VOICE_PAUSE))
    if labels[-1:] == [VOICE_PAUSE]:
        yield SpokenWord(",", ())


def _pairs(text: str) -> Iterator[str]:
    """Yield each two neighbouring words of a text."""
    for pair in pairwise(piece for piece in pieces(text) if piece.kind == "word"):
        yield _between(text, pair)


def _surely(token: TextPiece) -> bool:
    """Return True if a token is one word: not a number, an abbreviation or a compound."""
    return (
        token.kind == "word"
        and all(counts(c) and not c.isdigit() for c in token.text)
        and (sum(map(str.isupper, token.text)) <= 1 or not token.text.isupper())
    )


def _between(text: str, tokens: Sequence[TextPiece]) -> str:
    if not tokens:
        return text.strip()
    return text[tokens[0].start : tokens[-1].start + len(tokens[-1].text)]
