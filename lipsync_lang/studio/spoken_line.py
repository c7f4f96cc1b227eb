"""Line of the studio: a corrected schedule, and its shown part.

Conventions: times are seconds; boundary b is the start of phoneme b, and the last one is the end.
Numbers of boundaries and words count from the start of the shown part.
"""

from dataclasses import replace

import numpy as np

from lipsync_lang.errors import LipsyncError
from lipsync_lang.schedules.schedule import MAX_EMPHASIS, SILENCE, Audio, Schedule

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
            self._part = line, first, stop, line if uncut else excerpt(line, first, stop)
        return self._part[3]

    def _span(self, seconds: float) -> tuple[int, int]:
        cuts, number = self.cuts(seconds), self.number(seconds)
        return cuts[number], cuts[number + 1]

    def move(self, boundary: int, to: float, seconds: float) -> None:
        """Move a boundary, which stays between its neighbours; refuse an unknown one."""
        first, stop = self._span(seconds)
        if not 0 <= boundary <= stop - first:
            raise LipsyncError(f"there is no boundary {boundary}; the last is {stop - first}")
        at, times = first + boundary, self.whole.times.copy()
        low = times[at - 1] + MIN_SPAN_SECONDS if at else min(0.0, times[0])
        audio = self.whole.audio
        if at + 1 < len(times):
            high = times[at + 1] - MIN_SPAN_SECONDS
        else:
            high = max(self.whole.end, float("inf") if audio is None else audio.seconds)
        if low <= high:  # phonemes below the minimum length keep it
            times[at] = min(max(to, low), high)
        cuts = self.cuts(seconds)
        self.whole = replace(self.whole, times=times)
        self._cut = self.whole, seconds, cuts  # an edit does not change the parts
        self.at = float(times[first])

    def restore(self) -> None:
        """Restore the times as opened."""
        self.retime(replace(self.whole, times=self.opened.times))

    def retime(self, whole: Schedule) -> None:
        """Take over other times or words of the same phonemes; the shown part stays."""
        number = int(self.whole.times.searchsorted(self.at, "right")) - 1
        self.whole = whole
        self.at = float(whole.times[max(0, number)])
        if self._cut is not None:
            self._cut = whole, *self._cut[1:]

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

    def hear(self, audio: Audio) -> None:
        """Add the sound."""
        self.whole, self.opened = (replace(one, audio=audio) for one in (self.whole, self.opened))


def excerpt(line: Schedule, first: int, stop: int) -> Schedule:
    """Return the phonemes from `first` until `stop` of a line, with their words."""
    words = tuple(
        replace(w, first=max(w.first, first) - first, stop=min(w.stop, stop) - first)
        for w in line.words
        if first <= w.first < stop
    )
    return replace(
        line, labels=line.labels[first:stop], times=line.times[first : stop + 1],
        words=words, stress=line.stress[first:stop], lines=line.lines[first:stop],
        likely=line.likely[first:stop],
    )  # fmt: skip


def _cuts(schedule: Schedule, seconds: float) -> list[int]:
    """Split a line into parts, in the longest pause near the end, or at a word or phoneme."""
    times, last = schedule.times, len(schedule)
    starts = np.zeros(last + 1, bool)
    starts[[word.first for word in schedule.words]] = True
    inside = np.zeros(last + 1, bool)
    for word in schedule.words:
        inside[word.first + 1 : word.stop] = True
    pauses = np.where([label == SILENCE for label in schedule.labels], np.diff(times), 0.0)
    found = [0]
    while times[-1] - times[found[-1]] > seconds:
        begin = found[-1]
        most = int(times.searchsorted(times[begin] + seconds, "right")) - 1
        least = int(times.searchsorted(times[begin] + (1 - PAUSE_SEARCH_SHARE) * seconds))
        places = np.arange(max(least, begin + 1), max(most, begin + 1) + 1)
        if not len(places):
            places = np.array([max(most, begin + 1)])
        worth = pauses[places - 1] + 1e-3 * starts[places] - 1e3 * inside[places] + 1e-6 * places
        found.append(int(places[worth.argmax()]))
    return [*found, last] if found[-1] < last else found
