"""Heard: the phonemes of a stream that coming frames can still depend on.

Times are seconds. Labels are numbered from the first one of the stream. Labels that no frame needs
any more are forgotten, so hours take no more memory than seconds.

If two trigrams share a bigram, the first one plays, so each trigram depends on those before it. No
two trigrams begin at neighbouring sounds. Therefore a window makes the same choice as the whole
line if no trigram begins one sound before the window.
"""

from bisect import bisect_right
from collections.abc import Collection
from copy import copy
from dataclasses import dataclass, field
from math import inf
from operator import attrgetter
from typing import NamedTuple, Self

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.performing.effort import RAMP_SECONDS, STRESS_REACH_SECONDS, StressMarks
from lipsync_lang.pipeline.overlay import Overlay
from lipsync_lang.pipeline.tables import Tables
from lipsync_lang.pipeline.track import trigrams_in
from lipsync_lang.schedules.schedule import SILENCE

UNSURE_SECONDS = 0.1
"""Assumed length of the last phoneme until its end is known; no final frame depends on it."""


class HeardLabel(NamedTuple):
    """A label in time, and the common phonemes that it stands for."""

    start: float
    end: float | None
    """End in seconds; None while the label lasts."""
    sounds: tuple[tuple[int, float], ...]
    """Numbers of common phonemes, each with its share of the time; empty for a mute label."""
    kind: str = ""
    """Sound class of the first; empty for silence."""
    mark: int | None = None
    """Marked stress."""
    marked: bool = False
    """True if any label that arrived with it has a mark of stress."""
    whole: float | None = None
    """Start of the word from which the label cannot be separated."""
    text: str = SILENCE
    """The label as it was fed."""


class FedWord(NamedTuple):
    """A word of the line, for its gestures."""

    number: int
    """Number of the first label of the word."""
    stop: int
    """Number of the label after it."""
    start: float
    text: str
    emphasised: bool


class HeardWord(NamedTuple):
    """Curves and emphasis of a word."""

    number: int
    """Number of the first label of the word."""
    ramp: tuple[float, float, float, float]
    high: float
    """Increase of the level of emphasis."""
    overlays: tuple[Overlay, ...]


class Vowel(NamedTuple):
    """The stress at the middle of a vowel."""

    number: int
    """Number of the label of the vowel."""
    middle: float
    stress: int
    marked: bool
    """True if marks of stress were heard by then."""


@dataclass
class HeardLabels:
    """Labels that a stream received, and their common phonemes, stress and words.

    Parameters
    ----------
    silence : number of the common phoneme for silence
    levels : level of a vowel for each stress; None for no effect
    marked : True if stress counts; while False, it begins with the first mark
    """

    silence: int
    levels: dict[int, float] | None = None
    marked: bool = False
    plain_until: float = -inf
    """Time until which vowels in returned frames had the level 1, since no mark was heard."""
    start: float = 0.0
    """Start of the first label."""
    until: float = 0.0
    """Time until which everything is known; the label at that time may last longer."""
    first: int = 0
    """Number of the first label that is kept."""
    labels: list[HeardLabel] = field(default_factory=list)
    sounds: list[int] = field(default_factory=list)
    """Common phonemes; silences in a row are one."""
    starts: list[float] = field(default_factory=list)
    sources: list[int] = field(default_factory=list)
    """Number of the label of each common phoneme."""
    words: list[HeardWord] = field(default_factory=list)
    spoken: list[FedWord] = field(default_factory=list)
    """All words."""
    vowels: list[Vowel] = field(default_factory=list)
    befores: list[tuple[int | None, bool]] = field(default_factory=list)
    """State of stress before each label."""
    opening: float | None = None
    """Seconds of silence before the first sound; None until the first sound is known."""
    forgotten: bool = False
    """True if some received labels are forgotten."""
    stress: tuple[int | None, bool] = (None, False)

    def __post_init__(self) -> None:
        self.stress = (None, self.marked)

    def apart(self) -> Self:
        """Return an independent copy."""
        other = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, list):
                setattr(other, name, value[:])
        return other

    @property
    def number(self) -> int:
        """Number of the next label."""
        return self.first + len(self.labels)

    @property
    def silent(self) -> bool:
        """True if the last common phoneme is silence."""
        return bool(self.sounds) and self.sounds[-1] == self.silence

    def add(self, label: HeardLabel) -> None:
        """Add a label, which starts at the end of the last one."""
        if not self.labels:
            self.start = label.start
        elif self.labels[-1].end is None:
            self.end(label.start)
        self._lay(label)

    def lasts(self, seconds: float) -> None:
        """Extend the last label until a time, or add silence after it."""
        last = self.labels[-1]
        quiet = ((self.silence, 1.0),)
        if last.end is not None and last.sounds == quiet:
            self.labels[-1] = last._replace(end=seconds)
        elif last.end is not None:
            self._lay(HeardLabel(self.until, seconds, quiet))
        self.until = seconds

    def end(self, seconds: float) -> None:
        """Close the last label."""
        label = self._drop()
        self._lay(label._replace(end=seconds))

    def _drop(self) -> HeardLabel:
        """Remove the last label."""
        label, number = self.labels.pop(), self.number
        self.stress = self.befores.pop()
        while self.sources and self.sources[-1] == number:
            self.sounds.pop()
            self.starts.pop()
            self.sources.pop()
        while self.vowels and self.vowels[-1].number == number:
            self.vowels.pop()
        for words in (self.words, self.spoken):
            while words and words[-1].number >= number:
                words.pop()
        self.until = label.start
        if not self.forgotten and all(sound == self.silence for sound in self.sounds):
            self.opening = None
        return label

    def _lay(self, label: HeardLabel) -> None:
        number, at = self.number, label.start
        length = None if label.end is None else label.end - label.start
        self.labels.append(label)
        self.befores.append(self.stress)
        # the boundaries within a label are unknown until its end is, but its first sound is known
        for sound, share in label.sounds if length is not None else label.sounds[:1]:
            if not self.silent or sound != self.silence:
                self.starts.append(at if self.sounds else self.start)
                self.sounds.append(sound)
                self.sources.append(number)
                if self.opening is None and sound != self.silence:
                    self.opening = self.starts[-1] - self.start
            at += share * (length or 0.0)
        self.until = label.start if label.end is None else label.end
        before, marked = self.stress
        reading = StressMarks(before)
        stress = reading.of(label.mark, label.kind)
        marked = marked or label.marked
        self.stress = reading.before, marked
        if stress is not None and label.end is not None and self.levels is not None:
            self.vowels.append(Vowel(number, (label.start + label.end) / 2, stress, marked))

    def freeze_levels(self, seconds: float) -> None:
        """Keep the levels of vowels until a time, since returned frames depend on them."""
        if self.stress[1]:
            self.marked = True
        else:
            self.plain_until = seconds + 2 * STRESS_REACH_SECONDS

    def stressed(self) -> tuple[Floats, Floats]:
        """Return the middle and the level of each vowel, (V,) seconds and (V,).

        As in a whole line, one mark makes all vowels without a mark unstressed.
        """
        levels, marks = self.levels or {}, self.stress[1] or self.marked
        found = [
            levels[one.stress] if one.marked or (marks and one.middle > self.plain_until) else 1.0
            for one in self.vowels
        ]
        return np.array([vowel.middle for vowel in self.vowels]), np.array(found)

    def take_back(self, seconds: float) -> None:
        """Remove all labels from a time on, and cut the label that lasts at that time."""
        while self.labels and (self.labels[-1].start >= seconds or self.until > seconds):
            label = self._drop()
            if label.start < seconds:
                self._lay(label._replace(end=seconds))
        self.until = min(self.until, seconds) if self.labels else self.until

    def parted(self, seconds: float) -> float | None:
        """Return the start of the word that a cut at a time divides; None if it divides none."""
        inside = [
            label.whole
            for label in self.labels
            if label.whole is not None and label.whole < seconds
            and (label.end is None or label.end > seconds)
        ]  # fmt: skip
        return inside[0] if inside else None

    def forget(self, seconds: float, begun: Collection[int] = ()) -> None:
        """Forget the labels on which no frame from a time on depends.

        Parameters
        ----------
        begun : sounds that begin a trigram, by index
        """
        kept = self._first(seconds, begun)
        if kept:
            del self.sounds[:kept], self.starts[:kept], self.sources[:kept]
            self.forgotten = True
        # the label at that time stays, since it may still be cut or lengthened
        gone = max(bisect_right(self.labels, seconds, key=attrgetter("start")) - 1, 0)
        del self.labels[:gone], self.befores[:gone]
        self.first += gone
        while len(self.vowels) > 1 and self.vowels[1].middle <= seconds:
            del self.vowels[0]
        while self.words and self.words[0].ramp[-1] < seconds:
            del self.words[0]
        while self.spoken and self.spoken[0].stop <= self.first:
            del self.spoken[0]

    def clear(self, silence_reach: float, *, linear: bool, emphasis: bool) -> float:
        """Return the time before which bigrams and dials are known.

        Parameters
        ----------
        silence_reach : seconds of a silence that a bigram uses
        linear : True if bigrams are stretched evenly, so that the length of the next sound counts
        emphasis : True if later words may have emphasis
        """
        time = self._bigrams(silence_reach, linear=linear)
        if self.levels is not None:
            # until then no vowel to come changes the level of stress
            last = self.labels[-1]
            unknown = self.until if last.end is not None else last.start
            sure = unknown - STRESS_REACH_SECONDS
            if self.vowels and unknown < self.vowels[-1].middle + 2 * STRESS_REACH_SECONDS:
                sure = self.vowels[-1].middle
            time = min(time, sure)
        return min(time, self.until - RAMP_SECONDS) if emphasis else time

    def _bigrams(self, silence_reach: float, *, linear: bool) -> float:
        start, count = self.starts[-1], len(self.starts)
        if self.silent:
            far = self.until - silence_reach
            if far >= start or not linear or count == 1:
                return max(start, far)
        if not linear:
            return start
        early = start - silence_reach
        if count == 1:
            return early  # the silence before a line is as long as a bigram needs
        if self.sounds[-2] != self.silence:
            return self.starts[-2]
        first = count == len(("silence", "sound")) and not self.forgotten
        return early if first else max(self.starts[-2], early)

    def held(self, margin: float, widened: float) -> float:
        """Return the time before which held contacts are known.

        Parameters
        ----------
        margin : seconds at each side of a phoneme in which a contact may still open
        widened : seconds before its start in which a short phoneme may hold its contact
        """
        if self.silent:
            return self.until - widened
        return self.starts[-1] - max(margin, widened)

    def closing(self, added_silence: float) -> float:
        """Return the seconds of silence at the end, as for a line that ends here."""
        if not self.silent:
            return 0.0
        # a line of silence alone has no last sound from which to count
        alone = len(self.starts) == 1 and self.opening is None
        far = max(added_silence, 1e-9)
        return max(self.until - self.starts[-1], far) if alone else self.until - self.starts[-1]

    def between(
        self, begin: float, end: float, begun: Collection[int] = ()
    ) -> tuple[Ints, Floats, bool]:
        """Return the common phonemes around a span of time, and their (m + 1,) boundaries.

        The third value is True if no phoneme was heard before these.

        Parameters
        ----------
        begun : sounds that begin a trigram, by index
        """
        first = self._first(begin, begun)
        stop = min(bisect_right(self.starts, end) + 2, len(self.starts))
        last = self.starts[-1]
        until = self.until if self.until > last else last + UNSURE_SECONDS
        edge = self.starts[stop : stop + 1] or [until]
        bounds = np.array(self.starts[first:stop] + edge)
        return np.array(self.sounds[first:stop]), bounds, first == 0 and not self.forgotten

    def _first(self, seconds: float, begun: Collection[int]) -> int:
        """Return the index of the first sound on which frames from a time on depend."""
        # the sound at that time, and two before: a bigram reaches over both of its sounds
        first = max(bisect_right(self.starts, seconds) - 3, 0)
        return first - (first > 0 and first - 1 in begun)


def begun_trigrams(heard: HeardLabels, tables: Tables) -> frozenset[int]:
    """Return the sounds that begin a trigram, by index; -1 is the silence before the first."""
    if not len(tables.trigrams) or not heard.sounds:
        return frozenset()
    before = not heard.forgotten and heard.sounds[0] != heard.silence
    ids = np.array([heard.silence] * before + heard.sounds)
    return frozenset(at - before for at in trigrams_in(ids, tables).tolist())


def open_trigram(heard: HeardLabels, tables: Tables, silence_reach: float) -> float | None:
    """Return the time from which bigrams depend on the sound after the last one, if they do.

    Parameters
    ----------
    silence_reach : seconds of a silence that a bigram uses
    """
    if not len(tables.trigrams) or not heard.sounds:
        return None
    only = len(heard.sounds) == 1
    before = heard.silence if only else heard.sounds[-2]
    if only and (heard.forgotten or heard.silent):
        return None
    size = len(tables.pairs)
    # codes of three sounds rise with the third, so all with these first two are a range
    code = (before * size + heard.sounds[-1]) * size
    at = int(tables.trigrams.searchsorted(code))
    if at == len(tables.trigrams) or int(tables.trigrams[at]) >= code + size:
        return None
    if len(heard.sounds) - len(("one", "two", "three")) in begun_trigrams(heard, tables):
        return None
    if before != heard.silence:
        return heard.starts[-2]
    early = heard.starts[-1] - silence_reach
    first = only or (len(heard.sounds) == len(("silence", "sound")) and not heard.forgotten)
    return early if first else max(heard.starts[-2], early)
