"""Counting a corpus: phonemes and bigrams of many lines, a batch at a time.

A bigram (a, b) of n phonemes is the number ``a * n + b``; silence is phoneme 0. Of each line no
more is kept than the set of its bigrams, as small integers, and its text and place, on disk once
they are many.
"""

import json
from array import array
from dataclasses import dataclass, field, replace
from itertools import islice, pairwise
from tempfile import SpooledTemporaryFile
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from lipsync_lang.coverage.kinds import Kinds
from lipsync_lang.coverage.report import Corpus
from lipsync_lang.coverage.scripts import OtherScripts
from lipsync_lang.phonology.g2p.tokens import PAUSES, pieces

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence
    from types import TracebackType

    import numpy.typing as npt

    from lipsync_lang.coverage.plan import Ints
    from lipsync_lang.coverage.scripts import Spans
    from lipsync_lang.lines import Line
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.speech.speaking import Transcript

BATCH = 1000
"""Lines that are read at a time."""

PLACES = 3
"""Lines that are kept of each bigram."""

IN_MEMORY = 2**24
"""Bytes of text that are kept in memory."""

SMALL = 2**16
"""Numbers that two bytes hold."""

WORD = 40
"""Characters; a longer word is no example."""

SILENT, BREAK = 0, -1
"""Silence, and what stands between phonemes where it is not known what does."""


class Pages:
    """Text and place of lines by number, on disk once they are many."""

    def __init__(self) -> None:
        self._file = SpooledTemporaryFile(IN_MEMORY)  # noqa: SIM115 closed by `close`
        self._starts = array("Q", [0])

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: "type[BaseException] | None",
        error: "BaseException | None",
        trace: "TracebackType | None",
    ) -> None:
        self._file.close()

    def __len__(self) -> int:
        return len(self._starts) - 1

    def add(self, line: "Line") -> None:
        """Keep one more line."""
        self._file.seek(self._starts[-1])
        self._file.write(json.dumps([line.place, line.text]).encode())
        self._starts.append(self._file.tell())

    def __getitem__(self, number: int) -> tuple[str, str]:
        start, stop = self._starts[number : number + 2]
        self._file.seek(start)
        place, text = json.loads(self._file.read(stop - start))
        return place, text


@dataclass
class Facts:
    """What is said of a corpus in any language."""

    files: dict[str, None] = field(default_factory=dict)
    lines: int = 0
    words: int = 0
    dropped: Kinds = field(default_factory=Kinds)

    def add(self, line: "Line") -> None:
        """Take one more line into account."""
        self.files.setdefault(line.file or line.place)
        self.lines += 1
        self.words += sum(piece.kind == "word" for piece in pieces(line.text))
        for what in line.dropped:
            self.dropped.add(what, line.place)

    def corpus(self) -> Corpus:
        """Return them as a document holds them."""
        return Corpus(
            files=tuple(self.files),
            lines=self.lines,
            words=self.words,
            dropped=self.dropped.tallies(),
        )


class SaidLine(NamedTuple):
    """What a language makes of a line: numbers of common phonemes and breaks, and words."""

    ids: list[int]
    words: list[str]


class Count:
    """What lines need of a language, counted as they come.

    Parameters
    ----------
    performer : who reads them; of its character, only the words of its own matter
    scripts : those that its language is written in, where they are known
    """

    def __init__(self, performer: "Performer", scripts: "Iterable[str]" = ()) -> None:
        self._performer = replace(performer, unknown="rest")
        self._speaker = performer.speaker
        self._numbers = {name: n for n, name in enumerate(performer.compiled.phonemes)}
        self.size = len(self._numbers)
        self.lines = self.words = 0
        self.phonemes = np.zeros(self.size, np.int64)
        self.bigrams = np.zeros(self.size**2, np.int64)
        self.first: list[list[int]] = [[] for _ in range(self.size**2)]
        self.unread, self.unmapped = Kinds(), Kinds()
        self.others = OtherScripts(self._speaker, scripts)
        self._words: dict[str, None] = {}
        self._sets = array("H" if self.size**2 <= SMALL else "I")
        self._starts = array("Q", [0])

    def sets(self) -> "tuple[Ints, Ints]":
        """Return the bigrams without silence of all lines, and where each line's start."""
        kind = np.uint16 if self._sets.typecode == "H" else np.uint32
        return np.frombuffer(self._sets, kind), np.frombuffer(self._starts, np.uint64)

    def add(self, start: int, lines: "Sequence[Line]") -> None:
        """Count lines, the first of which has number `start`."""
        written = [line for line in lines if line.schedule is None]
        spelled = self.others.spelled(written)
        cut = [_parts(line, spans) for line, spans in zip(written, spelled, strict=True)]
        texts = [text for parts in cut for text in parts if text]
        heard = self._speaker.transcribe(texts) if texts else iter(())
        left = iter(cut)
        for number, line in enumerate(lines, start):
            if line.schedule is not None:
                said = self._scheduled(line)
            else:
                said = self._joined(next(left), heard, line.place)
            is_first = self._count(number, said)
            if is_first and line.schedule is None:
                self._words.update(dict.fromkeys(w for w in said.words if len(w) <= WORD))

    def _count(self, number: int, said: SaidLine) -> bool:
        """Count a line, and tell whether it is the first for any bigram."""
        ids = np.array(said.ids, np.int64)
        codes = ids[:-1] * self.size + ids[1:]
        codes = codes[(ids[:-1] != BREAK) & (ids[1:] != BREAK)]
        codes = codes[codes > 0]  # silence beside silence is no bigram
        self.lines += 1
        self.words += len(said.words)
        np.add.at(self.phonemes, ids[ids != BREAK], 1)
        np.add.at(self.bigrams, codes, 1)
        kinds = np.unique(codes)
        is_first = False
        for code in kinds.tolist():
            is_first |= not self.first[code]
            if len(self.first[code]) < PLACES:
                self.first[code].append(number)
        spoken = kinds[self.sounding(kinds)]
        self._sets.extend(spoken.tolist())
        self._starts.append(len(self._sets))
        return is_first

    def sounding(self, codes: "Ints") -> "npt.NDArray[np.bool_]":
        """Tell which bigrams are without silence."""
        return (codes >= self.size) & (codes % self.size > 0)

    def _joined(
        self, parts: "Sequence[str]", heard: "Iterator[Transcript]", place: str
    ) -> SaidLine:
        """Take the parts of a line together, with breaks between them."""
        ids: list[int] = [SILENT]
        words: list[str] = []
        for number, part in enumerate(parts):
            if number:
                ids += [BREAK, SILENT] if part[:1] in PAUSES else [BREAK]
            if part:
                said = self._transcribed(next(heard), place)
                ids += said.ids
                words += said.words
            if number + 1 < len(parts) and part[-1:] in PAUSES:
                ids.append(SILENT)
        return SaidLine([*ids, SILENT], words)

    def _transcribed(self, transcript: "Transcript", place: str) -> SaidLine:
        words = [word for word in transcript.words if word.labels]
        for word in transcript.words if transcript.unread else ():
            if word.unread:
                whole = len(word.text.split()) == 1 and len(word.text) <= WORD
                self.unread.add(word.text if whole else word.unread, place)
        if transcript.unmapped:
            missing = set(transcript.unmapped)
            for label in (label for word in words for label in word.labels):
                if label in missing:
                    self.unmapped.add(label, place)
        return SaidLine(
            self._ids(transcript), [text for word in words for text in word.text.split()]
        )

    def _ids(self, transcript: "Transcript") -> list[int]:
        ids = [self._numbers[name] for name in transcript.phonemes]
        for gap in reversed(transcript.gaps):
            ids.insert(gap, BREAK)
        return ids

    def _scheduled(self, line: "Line") -> SaidLine:
        schedule = line.schedule
        assert schedule is not None  # noqa: S101 only lines with one come here
        notation = self._performer.notation(schedule)
        missing = {n for n, label in enumerate(schedule.labels) if notation.find(label) is None}
        for number in sorted(missing):
            self.unmapped.add(schedule.labels[number], line.place)
        ids, _, source = self._performer.common_phonemes(schedule)
        said = [
            BREAK if number == SILENT and label in missing else number
            for number, label in zip(ids.tolist(), source.tolist(), strict=True)
        ]
        return SaidLine([SILENT, *said, SILENT], [word.text for word in schedule.words])

    def examples(self) -> dict[int, str]:
        """Return, for bigrams that lie within a word of the first lines, such a word."""
        examples: dict[int, str] = {}
        for transcript in self._speaker.transcribe(self._words) if self._words else ():
            for first, second in pairwise(self._ids(transcript)):
                if BREAK not in (first, second):
                    examples.setdefault(first * self.size + second, transcript.text)
        return examples


def _parts(line: "Line", spelled: "Spans") -> list[str]:
    """Cut a line where something stands of which it is not known how it sounds."""
    parts, at = [], 0
    for start, stop in sorted([*spelled, *((gap, gap) for gap in line.gaps)]):
        parts.append(line.text[at:start].strip())
        at = max(at, stop)
    return [*parts, line.text[at:].strip()]


def count(
    lines: "Iterable[Line]",
    performers: "Sequence[Performer]",
    scripts: "Sequence[Iterable[str]]",
    pages: Pages,
) -> tuple[Corpus, list[Count]]:
    """Count lines in several languages at once; texts and places go to `pages`.

    Each performer has the scripts that its language is written in.
    """
    facts, counts = Facts(), [Count(*each) for each in zip(performers, scripts, strict=True)]
    for batch in _batches(lines):
        start = len(pages)
        for line in batch:
            facts.add(line)
            pages.add(line)
        for one in counts:
            one.add(start, batch)
    return facts.corpus(), counts


def _batches(lines: "Iterable[Line]") -> "Iterator[list[Line]]":
    left = iter(lines)
    while batch := list(islice(left, BATCH)):
        yield batch
