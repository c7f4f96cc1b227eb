"""Line of the studio: a corrected schedule, and its shown part.

Conventions: times are seconds; boundary b is the start of phoneme b, and the last one is the end.
Numbers of boundaries and words count from the start of the shown part.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.schedules import phoneme_changes
from lipsync_lang.schedules.schedule import MAX_EMPHASIS, SILENCE, Audio, Schedule, Word
from lipsync_lang.text.phonology.emphasis import with_mark

MIN_SPAN_SECONDS = 0.005
"""Minimum length of a phoneme beside a moved boundary."""

MAX_PART_FRAMES = 7200
"""Maximum number of frames in the shown part: 2 minutes at 60 per second."""

PAUSE_SEARCH_SHARE = 0.25
"""Share at the end of a part in which a pause may end it."""


class SpokenLine:
    """A schedule as read from a file or spoken, corrected by hand."""

    def __init__(self, schedule: Schedule) -> None:
        self.whole = self.opened = schedule
        self.changes: Sequence[phoneme_changes.PhonemeChange] = ()
        """Changed phonemes of the opened schedule."""
        self.at = schedule.start
        """A time within the shown part, in seconds."""
        self._cut: tuple[Schedule, float, list[int]] | None = None
        self._part: tuple[Schedule, int, int, Schedule] | None = None

    def cuts(self, seconds: float) -> list[int]:
        """Return the boundaries of parts of at most some seconds."""
        if self._cut is None or self._cut[0] is not self.whole or self._cut[1] != seconds:
            self._cut = self.whole, seconds, list(_cuts(self.whole, seconds))
        return self._cut[2]

    def number(self, seconds: float) -> int:
        """Return the number of the shown part among those of at most some seconds."""
        starts = self.whole.times[self.cuts(seconds)[:-1]]
        return max(0, int(starts.searchsorted(self.at + MIN_SPAN_SECONDS / 2, "right")) - 1)

    def show(self, number: int, seconds: float) -> None:
        """Show another part."""
        cuts = self.cuts(seconds)
        if not 0 <= number < len(cuts) - 1:
            raise LipsyncError(f"the line has {len(cuts) - 1} parts; there is no part {number + 1}")
        self.at = float(self.whole.times[cuts[number]])

    def part(self, seconds: float) -> Schedule:
        """Return the shown part of at most some seconds, or a shorter line as a whole."""
        first, stop = self._span(seconds)
        if self._part is None or self._part[:3] != (self.whole, first, stop):
            line = self.whole
            uncut = (first, stop) == (0, len(line))
            part = line if uncut else phoneme_changes.excerpt(line, first, stop)
            self._part = line, first, stop, part
        return self._part[3]

    def _span(self, seconds: float) -> tuple[int, int]:
        cuts, number = self.cuts(seconds), self.number(seconds)
        return cuts[number], cuts[number + 1]

    @property
    def unmoved(self) -> Schedule:
        """The schedule as opened, with the changed phonemes."""
        return phoneme_changes.with_changes(self.opened, self.changes)

    def move(self, boundary: int, to: float, seconds: float, through: int | None = None) -> None:
        """Move a boundary, and those after it up to `through`, as far as both neighbours allow."""
        first, stop = self._span(seconds)
        last = boundary if through is None else through
        for number in (boundary, last):
            if not 0 <= number <= stop - first:
                raise LipsyncError(f"there is no boundary {number}; the last is {stop - first}")
        at, until, times = first + boundary, first + max(boundary, last), self.whole.times.copy()
        low = times[at - 1] + MIN_SPAN_SECONDS if at else min(0.0, times[0])
        audio = self.whole.audio
        if until + 1 < len(times):
            high = times[until + 1] - MIN_SPAN_SECONDS
        else:
            high = max(self.whole.end, float("inf") if audio is None else audio.seconds)
        # The boundaries up to `through` move together, so the last of them meets the limit first.
        high -= times[until] - times[at]
        if low <= high:  # phonemes below the minimum length keep it
            times[at : until + 1] += min(max(to, low), high) - times[at]
        self.retime(replace(self.whole, times=times))

    def relabel(self, span: tuple[int, int], labels: Sequence[str], seconds: float) -> None:
        """Replace the phonemes of a span by others, which share its time."""
        first, stop = self._span(seconds)
        low, high = first + span[0], first + span[1]
        if not first <= low < high <= stop:
            raise LipsyncError(
                f"there are no phonemes {span[0]} to {span[1] - 1}; the last is {stop - first - 1}"
            )
        changes = phoneme_changes.composed(self.opened, self.changes, (low, high), labels)
        made = phoneme_changes.with_changes(self.opened, changes)  # refuses a word without phonemes
        times = phoneme_changes.spread(self.whole.times, low, high, len(labels))
        self.changes = changes
        self.retime(replace(made, times=times, words=self._emphasised(made)))

    def align(
        self, span: tuple[int, int], seconds: float, aligner: Callable[[Audio, str], Schedule]
    ) -> None:
        """Find the times of the words of a span in the sound of that span alone.

        The phonemes stay. Pauses beside the span are heard too, and give or take time; boundaries
        with sounds of other words stay. Raises LipsyncError if the line has no sound, the span has
        no words, or the aligner finds other words.
        """
        first, stop = self._span(seconds)
        line = self.whole
        low, high = first + span[0], min(first + span[1], stop)
        words = [one for one in line.words if one.first < high and low < one.stop]
        if line.audio is None:
            raise LipsyncError("the line has no recording to align with; open its recording first")
        if not words:
            raise LipsyncError("no word is chosen; choose phonemes of at least one word")
        inside = {at for one in line.words for at in range(one.first, one.stop)}
        low, high = words[0].first, words[-1].stop
        low -= low > first and low - 1 not in inside
        high += high < stop and high not in inside
        start, end = line.times[low], line.times[high]
        heard = line.audio.samples[
            slice(*(int(max(at, 0) * line.audio.rate) for at in (start, end)))
        ]
        found = aligner(replace(line.audio, samples=heard), " ".join(one.text for one in words))
        if len(found.words) != len(words):
            raise LipsyncError(
                f"the aligner finds {len(found.words)} words here instead of {len(words)}; "
                "choose a longer range, or move the boundaries by hand"
            )
        times = line.times.copy()
        times[low : high + 1] = _realigned(line, words, found, low, high)
        self.retime(replace(line, times=times))

    def _emphasised(self, schedule: Schedule) -> tuple[Word, ...]:
        """Return the words of a schedule with the present emphasis."""
        pairs = zip(schedule.words, self.whole.words, strict=True)
        return tuple(replace(word, emphasis=now.emphasis) for word, now in pairs)

    def restore(self) -> None:
        """Restore the phonemes and their times as opened."""
        self.changes = ()
        self.retime(replace(self.opened, words=self._emphasised(self.opened)))

    def retime(self, whole: Schedule) -> None:
        """Take over other times, words or phonemes; the shown part stays."""
        number = int(self.whole.times.searchsorted(self.at, "right")) - 1
        alike = len(whole) == len(self.whole)
        self.whole = whole
        if alike:
            self.at = float(whole.times[max(0, number)])
        if self._cut is not None:
            self._cut = (whole, *self._cut[1:]) if alike else None

    def emphasise(self, word: int, level: float, seconds: float) -> None:
        """Set the emphasis of a word; refuse an unknown word, and a level out of range."""
        first, stop = self._span(seconds)
        words = [n for n, one in enumerate(self.whole.words) if first <= one.first < stop]
        if not 0 <= word < len(words):
            raise LipsyncError(f"there is no word {word}; the line shows {len(words)} words")
        if not 0 <= level <= MAX_EMPHASIS:
            raise LipsyncError(f"emphasis must be a number from 0 to {MAX_EMPHASIS:g}")
        changed = list(self.whole.words)
        changed[words[word]] = replace(changed[words[word]], emphasis=level)
        self.retime(replace(self.whole, words=tuple(changed)))

    def text_with(self, number: int, text: str) -> str:
        """Return the text of the line with a mark on one of the words that are left out."""
        lacking = self.whole.left_out
        if not 0 <= number < len(lacking):
            raise LipsyncError(f"there is no word {number}; the line leaves out {len(lacking)}")
        marked = with_mark(text, [one.text for one in self.whole.words], lacking, number)
        if marked is None:
            what = f"'{lacking[number]}' is written in another way in the text"
            raise LipsyncError(f"{what}; put its word in asterisks there, and open the sound again")
        return marked

    def emphasise_as(self, other: Schedule) -> None:
        """Take over the emphasis of a schedule that has some of the words."""
        left = deque(other.words)
        words = (
            replace(one, emphasis=left.popleft().emphasis)
            if left and left[0].text == one.text
            else one
            for one in self.whole.words
        )
        self.retime(replace(self.whole, words=tuple(words)))

    def hear(self, audio: Audio) -> None:
        """Add the sound."""
        self.whole, self.opened = (replace(one, audio=audio) for one in (self.whole, self.opened))


def _realigned(
    line: Schedule, words: Sequence[Word], found: Schedule, low: int, high: int
) -> Floats:
    """Return the boundaries from `low` to `high` with the words as found; both ends stay."""
    start, end = line.times[low], line.times[high]
    known: dict[int, list[float]] = {}
    for word, other in zip(words, found.words, strict=True):
        own = np.linspace(other.first, other.stop, word.stop - word.first + 1)
        at = start + np.interp(own, np.arange(len(found.times)), found.times)
        for boundary, time in enumerate(at.tolist(), word.first):
            known.setdefault(boundary, []).append(time)  # words that meet share a pause
    known |= {low: [start], high: [end]}
    count = np.arange(low, high + 1)
    places = sorted(known)
    times: Floats = np.interp(count, places, [np.mean(known[place]) for place in places])
    least = np.minimum(MIN_SPAN_SECONDS, (end - start) / len(count)) * (count - low)
    # Each phoneme keeps a minimum length: first from the left, then from the right end.
    times = np.maximum.accumulate(times - least) + least
    times = np.minimum(times, end - least[::-1])
    times[[0, -1]] = start, end
    return times


def _cuts(schedule: Schedule, seconds: float) -> list[int]:
    """Split a line into parts, in the longest pause near the end, or at a word or phoneme."""
    times, last = schedule.times, len(schedule)
    starts, inside = np.zeros((2, last + 1), bool)
    for word in schedule.words:
        starts[word.first] = True
        inside[word.first + 1 : word.stop] = True
    pauses = np.where([label == SILENCE for label in schedule.labels], np.diff(times), 0.0)
    found = [0]
    while times[-1] - times[found[-1]] > seconds:
        begin = found[-1]
        most = max(int(times.searchsorted(times[begin] + seconds, "right")) - 1, begin + 1)
        least = int(times.searchsorted(times[begin] + (1 - PAUSE_SEARCH_SHARE) * seconds))
        places = np.arange(min(max(least, begin + 1), most), most + 1)
        # In order of weight: never within a word, in the longest pause, at a word, and late.
        worth = pauses[places - 1] + 1e-3 * starts[places] - 1e3 * inside[places] + 1e-6 * places
        found.append(int(places[worth.argmax()]))
    return [*found, last] if found[-1] < last else found
