"""Corrections of an engine's labels for a word, which a language pack states.

An engine of many languages has habits that the spelling of one contradicts: it may write one label
for two sounds, or say a vowel that nobody says. At each label of a word the corrections are tried
in order, and the first that fits takes its labels; every other label stays as it is.

A context is a regular expression (see `contexts`) over the labels of the word, joined without
spaces, in any spelling of them: ``^`` in `after` is the start of the word, ``$`` in `before` its
end. `spelled` must be found in the word as it is written, or respelled, composed and in small
letters; with `capital`, that word must begin with a capital, such as a name. `next_word` is for the
first label of the next word; none follows before a pause. All contexts see the labels as the engine
gave them.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import accumulate, starmap, zip_longest
from typing import NamedTuple

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.text.phonology.g2p.contexts import Context, Surroundings
from lipsync_lang.text.phonology.g2p.g2p_engines import (
    G2P_ENGINES,
    Correction,
    G2PEngine,
    MissingReaderError,
    Settings,
    SpokenWord,
)
from lipsync_lang.text.phonology.g2p.rules import CACHED_WORDS
from lipsync_lang.text.phonology.g2p.tokens import plain
from lipsync_lang.text.phonology.labels import SAME, normalise

MAX_WRITTEN_CHARS = 50
"""Maximum length of a word's spelling for `spelled`."""


class _CompiledCorrection(NamedTuple):
    """A correction with compiled contexts."""

    labels: tuple[str, ...]
    to: tuple[str, ...]
    around: Surroundings
    spelled: Context | None
    next_word: Context | None
    capital: bool

    def fits(self, sounds: str, start: int, stop: int, written: str, following: str) -> bool:
        """Return True if the labels between two positions of a word's sounds are corrected."""
        return (
            self.around.fit(sounds, start, stop)
            and (self.spelled is None or bool(self.spelled.pattern.search(written)))
            and (self.next_word is None or self.next_word.fits(following, 0))
        )


def engine(name: str, settings: Settings) -> G2PEngine:
    """Make the engine of a language, whose labels are corrected as its pack states.

    Raise `SpeechError` for an engine that is unknown, not installed, or lacks the language.
    """
    try:
        read = G2P_ENGINES.find(name, SpeechError)(settings)
    except MissingReaderError:
        if settings.otherwise is None:
            raise
        read = G2P_ENGINES.find(settings.otherwise, SpeechError)(settings)
    if not settings.corrections:
        return read
    mend = corrector(settings.corrections)

    def corrected(texts: Sequence[str]) -> Iterator[tuple[SpokenWord, ...]]:
        for words in read(texts):
            firsts = (word.labels[:1] for word in words[1:])
            yield tuple(starmap(mend, zip_longest(words, firsts, fillvalue=())))

    return corrected


def corrector(corrections: Iterable[Correction]) -> Callable[..., SpokenWord]:
    """Compile corrections into a function of a word, and of the labels that begin the next one.

    Raise `SpeechError` for an unusable context.

    >>> mend = corrector([Correction(("a",), ("ə",), before="$")])
    >>> mend(SpokenWord("mage", ("m", "a", "ɡ", "a"))).labels
    ('m', 'a', 'ɡ', 'ə')
    """
    first: dict[str, list[_CompiledCorrection]] = {}
    for number, one in enumerate(corrections, start=1):
        where = f"correction {number} ('{one.labels[0]}'):"
        around = Surroundings.compiled(one.before.translate(SAME), one.after.translate(SAME), where)
        spelled, _ = Surroundings.compiled(one.spelled, "", where)
        next_word, _ = Surroundings.compiled(one.next_word.translate(SAME), "", where)
        labels = tuple(map(normalise, one.labels))
        compiled = _CompiledCorrection(labels, one.to, around, spelled, next_word, one.capital)
        first.setdefault(labels[0], []).append(compiled)

    @lru_cache(CACHED_WORDS)
    def corrected(said: SpokenWord, following: tuple[str, ...] = ()) -> SpokenWord:
        # Most words have no label that is ever corrected.
        if not first.keys() & set(map(normalise, said.labels)):
            return said
        marks = said.stress or (None,) * len(said.labels)
        pairs = list(_corrected(said, marks, first, plain(normalise("".join(following)))))
        stress = tuple(mark for _, mark in pairs)
        labels = tuple(label for label, _ in pairs)
        return said._replace(labels=labels, stress=stress if any(stress) else ())

    return corrected


def _corrected(
    said: SpokenWord,
    marks: Sequence[int | None],
    first: dict[str, list[_CompiledCorrection]],
    following: str,
) -> Iterator[tuple[str, int | None]]:
    """Yield the labels of a word after correction, each with its stress."""
    labels = tuple(map(normalise, said.labels))
    folded = [plain(label) for label in labels]
    starts = [0, *accumulate(map(len, folded))]
    sounds, written = "".join(folded), plain(said.respelled or said.text)[:MAX_WRITTEN_CHARS]
    at, capital = 0, said.text[:2].istitle()
    while at < len(labels):
        for one in first.get(labels[at], ()):
            stop = at + len(one.labels)
            if (
                one.capital <= capital
                and labels[at:stop] == one.labels
                and one.fits(sounds, starts[at], starts[stop], written, following)
            ):
                mark = next((mark for mark in marks[at:stop] if mark is not None), None)
                yield from ((label, None if n else mark) for n, label in enumerate(one.to))
                at = stop
                break
        else:
            yield said.labels[at], marks[at]
            at += 1
