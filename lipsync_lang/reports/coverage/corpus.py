"""Counts of a corpus: phonemes and bigrams of many lines, in batches.

A bigram (a, b) of n phonemes is the code ``a * n + b``; silence is phoneme 0. A pair with a shade
counts as the pair whose curves it plays, as `units` tells. Memory use is low:
each line keeps the set of its bigrams, as small integers, and its text and place, which are moved
to disk if there are many.
"""

import json
from array import array
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice, pairwise
from tempfile import SpooledTemporaryFile
from typing import NamedTuple, Self

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Ints
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.speaker_faces import SpeakerFaces
from lipsync_lang.performing.gesturing import GestureScales, gesture_curves, scales_of
from lipsync_lang.performing.performer import Performer
from lipsync_lang.pipeline.track import trigrams_in
from lipsync_lang.reports.coverage.changes import ScriptDigests
from lipsync_lang.reports.coverage.reading_cache import reading_cache
from lipsync_lang.reports.coverage.report import UNSTATED, Corpus, GestureNeed
from lipsync_lang.reports.coverage.scripts import EntryWords, OtherScripts, TallyCounter
from lipsync_lang.resolver.compiled import CompiledPair
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.sound.speech.speaking.joining import estimate
from lipsync_lang.sound.speech.speaking.transcripts import Transcript
from lipsync_lang.text.lines import Line
from lipsync_lang.text.phonology.g2p.tokens import PAUSES, pieces

BATCH_LINES = 1000
"""Number of lines in a batch for a voice."""

MAX_PLACES = 3
"""Maximum number of places of a bigram."""

MAX_MEMORY_BYTES = 2**24
"""Maximum size of the text in memory; a larger text is moved to disk."""

UINT16_VALUES = 2**16
"""Number of codes that two bytes hold."""

MAX_EXAMPLE_CHARS = 40
"""Maximum length of an example word of a bigram."""

SILENT, BREAK = 0, -1
"""Ids of silence, and of a gap with an unknown sound."""

COUNTED_FPS = 30.0
"""Frames per second at which gestures are laid; a line has the same gestures at any rate."""


class GestureTally:
    """Gestures of the lines of a character, by their facts."""

    def __init__(self, performer: Performer, scales: list[float]) -> None:
        self._performer, self._scales = performer, scales
        self.seconds = 0.0
        """Length of the lines, with the movements before and after them."""
        self._counts: Counter[tuple[int, str]] = Counter()

    @classmethod
    def of(cls, performer: Performer, asked: GestureScales | None) -> Self | None:
        """Return a tally of the gestures asked for; None if the pose set has none of them."""
        scales = scales_of(performer.compiled, asked)
        return None if scales is None else cls(performer, scales)

    def add(self, schedule: Schedule) -> None:
        """Count the gestures of a line."""
        times = self._performer.performance(schedule, COUNTED_FPS).frames.times()
        _, laid = gesture_curves(self._performer, schedule, times, COUNTED_FPS, self._scales, {})
        self._counts.update((one.gesture.number, one.gesture.trigger) for one in laid)
        # With lead-in and tail, in which gestures of silence come too.
        self.seconds += float(times[-1] - times[0])

    def needs(self) -> tuple[GestureNeed, ...]:
        """Return the gestures that occur, in the order of the pose set."""
        found, counts = [], self._counts.most_common()
        for number, shape in enumerate(self._performer.gesture_set.shapes):
            by = {what or "by itself": times for (own, what), times in counts if own == number}
            count = sum(by.values())
            if count:
                rate = round(60 * count / self.seconds, 1)
                found.append(GestureNeed(gesture=shape.name, count=count, a_minute=rate, facts=by))
        return tuple(found)


class Pages:
    """Text and place of each line by number, on disk when they are many."""

    def __init__(self) -> None:
        self._file = SpooledTemporaryFile(MAX_MEMORY_BYTES)  # noqa: SIM115 closed by `close`
        self.close = self._file.close
        self._starts = array("Q", [0])

    def __len__(self) -> int:
        return len(self._starts) - 1

    def add(self, line: Line) -> None:
        """Append a line."""
        self._file.seek(self._starts[-1])
        self._file.write(json.dumps([line.place, line.text]).encode())
        self._starts.append(self._file.tell())

    def __getitem__(self, number: int) -> tuple[str, str]:
        start, stop = self._starts[number : number + 2]
        self._file.seek(start)
        place, text = json.loads(self._file.read(stop - start))
        return place, text


@dataclass
class CorpusTotals:
    """Totals of a corpus, the same in every language."""

    files: dict[str, None] = field(default_factory=dict)
    lines: int = 0
    words: int = 0
    heard: int = 0
    dropped: TallyCounter = field(default_factory=TallyCounter)
    faces: SpeakerFaces | None = None
    """Characters of the speakers; None if every character speaks every line."""
    others: TallyCounter = field(default_factory=TallyCounter)
    digests: ScriptDigests = field(default_factory=ScriptDigests)

    def add(self, line: Line) -> None:
        """Count a line."""
        self.files.setdefault(line.file or line.place)
        self.lines += 1
        self.words += sum(piece.kind == "word" for piece in pieces(line.text))
        self.heard += line.schedule is not None and line.schedule.recognised
        self.digests.add(line)
        for what in line.dropped:
            self.dropped.add(what, line.place)
        if self.faces is not None and not self.faces.own(line.speaker):
            if not self.faces.of(line.speaker):
                raise LipsyncError(f"{line.place}: {self.faces.lacking(line.speaker)}")
            if line.speaker:
                self.others.add(line.speaker, line.place)

    def corpus(self, languages: Sequence[str]) -> Corpus:
        """Return the totals as the document holds them."""
        return Corpus(
            files=tuple(self.files),
            lines=self.lines,
            words=self.words,
            heard=self.heard,
            dropped=self.dropped.tallies(),
            other_speakers=self.others.tallies(),
            script=self.digests.lines(languages),
        )


Takes = Callable[[Line], bool]
"""Predicate for the lines that a character speaks."""


class Reading(NamedTuple):
    """A reading of lines: a language with its pronunciations."""

    performer: Performer
    """Reads the lines; its character contributes pronunciations and trigrams."""
    scripts: Iterable[str] = ()
    """Scripts of the language; empty if unknown."""
    takes: Takes | None = None
    """Predicate of the lines to count; None for all."""
    letters: Iterable[str] = ()
    """Letters of the language; empty if unknown."""
    tallies: Sequence[GestureTally] = ()
    """Counts of gestures, which the lines are added to."""


LinePhonemes = tuple[list[int], list[str]]
"""A spoken line: ids of common phonemes and breaks, and words."""


class Count:
    """Phonemes and bigrams of lines in one language."""

    def __init__(self, reading: Reading) -> None:
        performer, scripts, takes, letters, self._tallies = reading
        self._takes: Takes = takes or (lambda _: True)
        # An unknown label must not end the count of a whole script.
        self._performer = replace(performer, unknown="rest")
        self._speaker = self._performer.speaker
        self._speaker.read = reading_cache(self._performer)
        self._numbers = self._performer.labels.numbers
        self.units, self._parents = units(performer), parents(performer.compiled)
        self.size = len(self._parents)
        self.lines = self.words = 0
        self.phonemes = np.zeros(self.size, np.int64)
        self.bigrams = np.zeros(self.size**2, np.int64)
        self.first: list[list[int]] = [[] for _ in range(self.size**2)]
        self.trigrams: defaultdict[str, Counter[int]] = defaultdict(Counter)
        """By trigram, the occurrences of bigrams that it plays: two of each of its own."""
        self.first_trigrams: defaultdict[str, list[int]] = defaultdict(list)
        self.unread, self.unmapped = TallyCounter(), TallyCounter()
        self.dropped = TallyCounter()
        self.others = OtherScripts(self._speaker, scripts)
        self.entries = EntryWords(self._speaker, letters)
        self._words: dict[str, None] = {}
        # A million lines have some 30 bigrams each: two bytes instead of a Python integer of 28.
        self._sets = array("H" if self.size**2 <= UINT16_VALUES else "I")
        self._starts = array("Q", [0])

    def sets(self) -> tuple[Ints, Ints]:
        """Return the codes of all lines, without silence, and the start index of each line."""
        kind = np.uint16 if self._sets.typecode == "H" else np.uint32
        return np.frombuffer(self._sets, kind), np.frombuffer(self._starts, np.uint64)

    def add(self, start: int, lines: Sequence[Line]) -> None:
        """Count lines with numbers from `start` on."""
        own = {n: line for n, line in enumerate(lines, start) if self._takes(line)}
        written = [line for line in own.values() if line.schedule is None]
        spelled = self.others.spelled(written)
        self.entries.add(written)
        cut: list[list[str]] = []
        for one, spans in zip(written, spelled, strict=True):
            # Gaps and spelled words have unknown sounds; the line is cut at them.
            parts, at = [], 0
            for first, last in sorted([*spans, *((gap, gap) for gap in one.gaps)]):
                parts.append(one.text[at:first].strip())
                at = max(at, last)
            cut.append([*parts, one.text[at:].strip()])
        # All parts of a batch go to the voice at once, since an engine is slow to start.
        texts = [text for parts in cut for text in parts if text]
        heard = self._speaker.transcribe(texts) if texts else iter(())
        left = iter(cut)
        for number in range(start, start + len(lines)):
            line = own.get(number)
            if line is None:  # a set of its own keeps the number of the next line
                self._starts.append(len(self._sets))
                continue
            if line.schedule is not None:
                self._count(number, *self._scheduled(line))
                continue
            ids, words = self._joined(next(left), heard, line.place)
            if self._count(number, ids, words):
                self._words |= dict.fromkeys(w for w in words if len(w) <= MAX_EXAMPLE_CHARS)

    def _count(self, number: int, said: Sequence[int], words: Sequence[str]) -> bool:
        """Count a line; return True if any of its bigrams is new."""
        ids = np.array(said, np.int64)
        codes = self.units[ids[:-1], ids[1:]]
        codes = codes[(ids[:-1] != BREAK) & (ids[1:] != BREAK)]
        codes = codes[codes > 0]  # silence beside silence is no bigram
        self.lines += 1
        self.words += len(words)
        # Plain indexing would count an index that occurs twice only once.
        np.add.at(self.phonemes, self._parents[ids[ids != BREAK]], 1)
        np.add.at(self.bigrams, codes, 1)
        kinds = np.unique(codes)
        is_first = False
        for code in kinds.tolist():
            is_first |= not self.first[code]
            if len(self.first[code]) < MAX_PLACES:
                self.first[code].append(number)
        compiled, tables = self._performer.compiled, self._performer.compiled.tables
        for part in np.split(ids, np.flatnonzero(ids == BREAK)) if len(tables.trigrams) else ():
            run = part[part != BREAK]
            for at in trigrams_in(run, tables).tolist():
                first, second, third = run[at : at + 3].tolist()
                code = (first * self.size + second) * self.size + third
                row = tables.trigram_rows[tables.trigrams.searchsorted(code), 0]
                name = compiled.origins[row].name
                self.trigrams[name].update(
                    self.units[run[at : at + 2], run[at + 1 : at + 3]].tolist()
                )
                places = self.first_trigrams[name]
                if len(places) < MAX_PLACES and number not in places:
                    places.append(number)
        spoken = kinds[self.sounding(kinds)]
        self._sets.extend(spoken.tolist())
        self._starts.append(len(self._sets))
        return is_first

    def sounding(self, codes: Ints) -> npt.NDArray[np.bool_]:
        """Return True for codes without silence, in the shape of `codes`."""
        return (codes >= self.size) & (codes % self.size > 0)

    def _joined(
        self, parts: Sequence[str], heard: Iterator[Transcript], place: str
    ) -> LinePhonemes:
        """Join the parts of a line with breaks between them."""
        ids: list[int] = [SILENT]
        words: list[str] = []
        for number, part in enumerate(parts):
            if number:
                # A pause beside a gap is silence for certain, whatever the gap holds.
                ids += [BREAK, SILENT] if part[:1] in PAUSES else [BREAK]
            if part:
                own, spoken = self._transcribed(next(heard), place)
                ids += own
                words += spoken
            if number + 1 < len(parts) and part[-1:] in PAUSES:
                ids.append(SILENT)
        return [*ids, SILENT], words

    def _transcribed(self, transcript: Transcript, place: str) -> LinePhonemes:
        words = [word for word in transcript.words if word.labels]
        for what in transcript.dropped:
            self.dropped.add(what, place)
        for word in transcript.words if transcript.unread else ():
            if word.unread:
                whole = len(word.text.split()) == 1 and len(word.text) <= MAX_EXAMPLE_CHARS
                self.unread.add(word.text if whole else word.unread, place)
        if transcript.unmapped:
            missing = set(transcript.unmapped)
            for label in (label for word in words for label in word.labels):
                if label in missing:
                    self.unmapped.add(label, place)
        if self._tallies and words:
            manner, notations = self._speaker.manner, self._speaker.notations
            schedule = estimate(transcript, manner, notations[manner.notation])
            for tally in self._tallies:
                tally.add(schedule)
        return self._ids(transcript), [text for word in words for text in word.text.split()]

    def _ids(self, transcript: Transcript) -> list[int]:
        ids = [self._numbers[name] for name in transcript.phonemes]
        for gap in reversed(transcript.gaps):
            ids.insert(gap, BREAK)
        return ids

    def _scheduled(self, line: Line) -> LinePhonemes:
        schedule = line.schedule
        assert schedule is not None  # noqa: S101 only lines with one come here
        notation = self._performer.notation(schedule)
        missing = {n for n, label in enumerate(schedule.labels) if notation.find(label) is None}
        for number in sorted(missing):
            self.unmapped.add(schedule.labels[number], line.place)
        for tally in self._tallies:
            tally.add(schedule)
        ids, _, source = self._performer.common_phonemes(schedule)
        said = [
            BREAK if number == SILENT and label in missing else number
            for number, label in zip(ids.tolist(), source.tolist(), strict=True)
        ]
        return [SILENT, *said, SILENT], [word.text for word in schedule.words]

    def examples(self) -> dict[int, str]:
        """Return an example word by code, for bigrams within a word."""
        examples: dict[int, str] = {}
        for transcript in self._speaker.transcribe(self._words) if self._words else ():
            for first, second in pairwise(self._ids(transcript)):
                if BREAK not in (first, second):
                    examples.setdefault(int(self.units[first, second]), transcript.text)
        return examples


def units(performer: Performer) -> Ints:
    """Return the code of the bigram that counts for each pair: (n, n), as the pair is played.

    It is the drawn bigram that the pair plays. Without one, it is the pair of the parents, which
    serves all their shades once it is drawn.
    """
    compiled, own = performer.compiled, parents(performer.compiled)
    found = own[:, None] * len(own) + own
    for row, origin in enumerate(compiled.origins) if performer.labels.shades else ():
        if origin.layer not in UNSTATED and origin.triple is None:
            first, second = map(compiled.phonemes.index, origin.pair)
            found[compiled.tables.pairs == row] = first * len(own) + second
    return found


def parents(compiled: CompiledPair) -> Ints:
    """Return the number of each phoneme's parent, or its own: (n,)."""
    numbers = compiled.numbers(shades=False)
    return np.array([numbers[name] for name in compiled.phonemes])


def count(
    lines: Iterable[Line],
    readings: Sequence[Reading],
    pages: Pages,
    faces: SpeakerFaces | None = None,
) -> tuple[Corpus, list[Count]]:
    """Count lines in several languages at once; `pages` receive text and place of each line."""
    totals = CorpusTotals(faces=faces)
    counts = [Count(reading) for reading in readings]
    for one in counts[:1]:
        one.dropped = totals.dropped  # an aside is one, however many languages read it
    # Not a list: a corpus may be larger than memory, and comes from a generator.
    left = iter(lines)
    while batch := list(islice(left, BATCH_LINES)):
        start = len(pages)
        for line in batch:
            totals.add(line)
            pages.add(line)
        for one in counts:
            one.add(start, batch)
    languages = dict.fromkeys(reading.performer.language for reading in readings)
    return totals.corpus(tuple(languages)), counts
