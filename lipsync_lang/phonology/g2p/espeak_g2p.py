"""Text to phonemes by eSpeak NG, as its voices say it, without sound.

It says a text clause by clause and tells its words apart, but not which of the user's they are:
"10,000" is several of them, "of the" is one. Where a clause has as many words as the user's have by
themselves, they are these; else the clause is one `Said` as a whole.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import lru_cache
from types import MappingProxyType

from lipsync_lang.phonology.g2p.epitran import segments
from lipsync_lang.phonology.g2p.g2p_engines import (
    ENGINES,
    Engine,
    Respeller,
    Said,
    Settings,
    respeller,
)
from lipsync_lang.phonology.g2p.rules import CACHED_WORDS
from lipsync_lang.phonology.g2p.tokens import TextPiece, counts, pieces
from lipsync_lang.phonology.labels import looser, normalise

Words = Sequence[tuple[str, ...]]

PATIENCE_SECONDS = 120.0
"""Seconds; many texts are read in many turns, and a busy computer may let one of them wait."""


@ENGINES.register("espeak")
def engine(settings: Settings) -> Engine:
    """Read text with a voice of eSpeak NG."""
    respell = respeller(settings.respell) if settings.respell else None

    def read(texts: Sequence[str]) -> Iterator[tuple[Said, ...]]:
        from lipsync_lang.phonology.espeak.process import EspeakProcess

        spelled = [_spelled(text, respell) for text in texts]
        plain = ["".join(spelling for _, spelling in parts) for parts in spelled]
        voice, reader = settings.voice or "", EspeakProcess(patience=PATIENCE_SECONDS)
        odd = {
            p.text for text in plain for p in pieces(text) if p.kind != "pause" and not _surely(p)
        }
        unmet = sorted(odd - lengths.keys())
        for token, found in zip(unmet, reader.transcribe(unmet, voice), strict=True):
            lengths[token] = sum(map(len, found))
        clauses = reader.transcribe(plain, voice)
        for text, found in zip(plain, clauses, strict=True):
            yield tuple(
                said._replace(labels=apart(said.labels)) for said in paired(text, found, lengths)
            )

    lengths: dict[str, int] = {}
    known = frozenset(map(normalise, settings.labels))

    @lru_cache(CACHED_WORDS)
    def apart(labels: tuple[str, ...]) -> tuple[str, ...]:
        """Take apart what the engine ran together where words meet: no label that there is."""
        return tuple(
            part
            for label in labels
            for part in ((label,) if not known or known_as(label, known) else parts(label, known))
        )

    return read


def known_as(label: str, known: Collection[str]) -> bool:
    """Tell whether a label is known in one of its spellings."""
    return any(spelling in known for spelling in looser(normalise(label)))


def parts(label: str, known: Collection[str]) -> tuple[str, ...]:
    """Return the known labels that a label is made of; itself where it is of none."""
    found = segments(label, known)
    return found if all(known_as(part, known) for part in found) else (label,)


def _spelled(text: str, respell: Respeller | None) -> list[tuple[str, str]]:
    return respell(text) if respell else [(text, text)]


def paired(
    text: str, clauses: Sequence[Words], lengths: Mapping[str, int] = MappingProxyType({})
) -> Iterator[Said]:
    """Give the words of each clause the user's spelling, and pauses between the clauses.

    `lengths` are the words that numbers, compounds and the like are by themselves.
    """
    written = _clauses(text)
    spoken = [words for words in clauses if words]
    whole = [word for words in spoken for word in words]
    tokens = [token for part in written for token in part]
    if len(written) != len(spoken) and _matched(tokens, whole, lengths) is not None:
        spoken, written = [whole], [tokens]
    if len(written) != len(spoken):
        written = [tokens] if tokens else []
        labels = tuple(label for word in whole for label in word)
        if labels:
            yield Said(_between(text, tokens), labels)
        return
    for number, (words, part) in enumerate(zip(spoken, written, strict=True)):
        if number:
            yield Said(",", ())
        matched = _matched(part, words, lengths)
        if matched is not None:
            yield from matched
        else:
            yield Said(_between(text, part), tuple(label for word in words for label in word))


def _clauses(text: str) -> list[list[TextPiece]]:
    """Return the words of each clause of a text."""
    clauses: list[list[TextPiece]] = [[]]
    for piece in pieces(text):
        if piece.kind == "pause":
            clauses.append([])
        else:
            clauses[-1].append(piece)
    return [clause for clause in clauses if clause]


def _matched(
    tokens: Sequence[TextPiece], words: Words, lengths: Mapping[str, int]
) -> list[Said] | None:
    """Give each token its words where it is sure which they are.

    It is where there are as many as the tokens are by themselves: words that are run together are
    fewer.
    """
    alone = len(tokens) == len(words) == 1
    counted = [1 if alone or _surely(t) else lengths.get(t.text, 0) for t in tokens]
    if sum(counted) != len(words) or 0 in counted:
        return None
    said: list[Said] = []
    at = 0
    for token, count in zip(tokens, counted, strict=True):
        labels = tuple(label for word in words[at : at + count] for label in word)
        said.append(Said(token.text, labels))
        at += count
    return said


def _surely(token: TextPiece) -> bool:
    """Tell whether a token is one word: no number, no abbreviation, no compound."""
    return (
        token.kind == "word"
        and all(counts(c) and not c.isdigit() for c in token.text)
        and (sum(map(str.isupper, token.text)) <= 1 or not token.text.isupper())
    )


def _between(text: str, tokens: Sequence[TextPiece]) -> str:
    if not tokens:
        return text.strip()
    return text[tokens[0].start : tokens[-1].start + len(tokens[-1].text)]
