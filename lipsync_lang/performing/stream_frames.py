"""Stream frames: the final frames of a stream, their weights, and their gestures.

Times are seconds; frames are counted from the first of the stream. The stages run on a window
around the frames, within their look-back and look-ahead.
"""

from collections import Counter
from collections.abc import Sequence
from math import floor, inf, isinf
from typing import NamedTuple, Self

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing import gesturing
from lipsync_lang.performing.effort import PRIMARY, VOWEL, StressMarks, ramped_level, vowel_level
from lipsync_lang.performing.heard import HeardLabels, begun_trigrams, open_trigram
from lipsync_lang.performing.played_pair import PlayedPair
from lipsync_lang.pipeline.gestures.laying import GestureSet
from lipsync_lang.pipeline.gestures.placing import (
    DRAWING_SECONDS,
    OPENING_SECONDS,
    LineFact,
    LineFacts,
    PlacedGesture,
    placing,
)
from lipsync_lang.pipeline.hold import MARGIN
from lipsync_lang.pipeline.levels import Blend, Dial
from lipsync_lang.pipeline.look_ahead import LookAhead, widened
from lipsync_lang.pipeline.perform import Frames, perform
from lipsync_lang.pipeline.prepare import prepare
from lipsync_lang.pipeline.track import lay_track

ENDLESS = {
    "smooth": ("smooth", "smooth=none"),
    "switch": ("hold", "hold=0"),
    "rest": ("ends", "ends=rest"),
    "stitch": ("silence_reach", "silence_reach=0.25"),
}
"""The setting of each stage with an unlimited look-ahead, and the value that limits it."""

NO_END = 2**60
"""Number of frames of a line whose end is unknown, beyond any stream."""

ROUNDING_FRAMES = 3
"""Frames by which times of gestures and of the line are rounded."""

CLEAR_SECONDS = 1e-6
"""Time by which a fact lies before the time until which everything is known."""


class StreamFrames:
    """The frames of one stream.

    Parameters
    ----------
    blends, dials : styles and dials of the whole stream
    emphasis : True if words with emphasis are expected
    """

    def __init__(
        self,
        performer: PlayedPair,
        fps: float,
        blends: tuple[Blend, ...],
        dials: tuple[Dial, ...],
        *,
        emphasis: bool,
    ) -> None:
        self.performer, self.fps = performer, fps
        self.motion = performer.styled_motion(blends)
        self.blends, self.dials, self.emphasis = blends, dials, emphasis
        self.tables = performer.tables(blends)
        shown = self.tables.papers if self.motion.thresholds == "paper" else self.tables
        prepared = prepare(shown, self.motion, fps)
        for stage, look in prepared.reach.items():
            if isinf(look.ahead):
                setting, cure = ENDLESS[stage]
                raise LipsyncError(
                    f"the motion's `{setting}` needs the whole line, so no frame of a stream is "
                    f"ever final; perform whole lines, or set motion.{cure}"
                )
        self.ahead = LookAhead.of(prepared, self.motion, fps)
        self.lead: int | None = None
        """Number of frames before the schedule starts; None until it is known."""
        self.count: int | None = None
        """Number of frames of the whole stream; None until its end is known."""

    def settled(self, heard: HeardLabels) -> int:
        """Return the number of frames that are final with the labels so far."""
        if self.count is not None:
            return self.count
        if not heard.sounds:
            return 0
        if self.lead is None:
            lead = self._lead_in(heard)
            if lead and heard.opening is None:
                return 0
            self.lead = lead
        reach, linear = self.motion.silence_reach, self.motion.warp == "linear"
        clear = held = heard.clear(reach, linear=linear, emphasis=self.emphasis)
        if self.motion.contacts == "hold":
            held = heard.held(MARGIN, widened(self.fps))
        unsure = open_trigram(heard, self.tables, reach)
        if unsure is not None:
            clear = min(clear, unsure)
            held = min(held, unsure - max(MARGIN, widened(self.fps)))
        least = self.ahead.stop(heard.until - heard.start, heard.closing(reach))
        final = self.ahead.settled(clear - heard.start, held - heard.start, least)
        return max(final + self.lead, 0)

    def finish(self, heard: HeardLabels) -> None:
        """Count all frames of a stream that ends with the labels so far."""
        if self.lead is None:
            self.lead = self._lead_in(heard)
        self.count = self.counted(heard)

    def counted(self, heard: HeardLabels, end: float | None = None) -> int:
        """Count the frames of a stream that ends with the labels so far, or in silence at `end`."""
        reach = self.motion.added_silence
        until, closing = (heard.until, heard.closing(reach)) if end is None else (end, reach)
        return (self.lead or 0) + self.ahead.stop(until - heard.start, closing)

    def _lead_in(self, heard: HeardLabels) -> int:
        opening = heard.opening
        return self.ahead.lead_in(heard.until - heard.start if opening is None else opening)

    def needed(self, begin: int) -> int:
        """Return the first frame of the window for frames from `begin` on."""
        low = begin - self.ahead.before
        # near the start the ramp from rest still counts, so the window begins with the line
        return low if low >= self.ahead.ramp else 0

    def weights(self, heard: HeardLabels, begin: int, stop: int) -> Floats:
        """Return the weights of some final frames: (k, P)."""
        low, high = self.needed(begin), stop + self.ahead.ahead
        if self.count is not None:
            high = min(high, self.count)
        # more frames if the line goes on, since the stages bring the mouth to rest at both ends
        more = self.ahead.ramp if low else 0
        beyond = self.ahead.ramp if high != self.count else 0
        frames = self.laid(heard, low - more, high + beyond)
        times = self.seconds(heard, low), self.seconds(heard, high)
        ids, bounds, opening = heard.between(*times, begun_trigrams(heard, self.tables))
        # no label numbers: the track reads only whether a sound was scheduled
        source = np.arange(len(ids))
        tables, motion, blends = self.tables, self.motion, self.blends
        track = lay_track(ids, bounds, source, tables, motion, blends, opening=opening)
        dials = (*self.dials, *self._effort(heard))
        edits = tuple(one for word in heard.words for one in word.overlays)
        said = tables, track, motion, self.fps
        performance = perform(*said, overlays=edits, blends=blends, dials=dials, frames=frames)
        first = begin - low + more
        return performance.weights()[first : first + stop - begin]

    def _effort(self, heard: HeardLabels) -> tuple[Dial, ...]:
        """Return the dials of stress and emphasis around a window."""
        out = []
        poses = self.performer.opening_poses
        if heard.vowels:
            out.append(Dial(poses, vowel_level(*heard.stressed()), "stress"))
        words = [word for word in heard.words if word.high]
        if words:
            level = ramped_level([word.ramp for word in words], [word.high for word in words])
            out.append(Dial(poses, level, "emphasis"))
        return tuple(out)

    def forget(self, heard: HeardLabels, given: int) -> None:
        """Forget the labels on which no frame after the returned ones depends."""
        since = self.seconds(heard, self.needed(given))
        heard.forget(since, begun_trigrams(heard, self.tables))

    def laid(self, heard: HeardLabels, begin: int, stop: int) -> Frames:
        """Return frames `begin` to `stop`."""
        return Frames(heard.start, begin - (self.lead or 0), stop - begin, self.fps)

    def seconds(self, heard: HeardLabels, frame: int) -> float:
        """Return the time of a frame."""
        return heard.start + (frame - (self.lead or 0)) / self.fps


class GestureReach(NamedTuple):
    """Parts of a line on which the gestures in a frame depend."""

    ahead: float
    """Seconds after the frame in which phonemes must be known."""
    ending: float
    """Seconds after the frame that the line must last at least."""
    guard: int
    """Frames on either side whose sums of gestures keep to a speed together."""

    @classmethod
    def of(cls, own: GestureSet, scales: Sequence[float], fps: float) -> Self:
        """Add up the reach of the gestures whose factor is above 0."""
        used = [(n, own.shapes[n], by) for n, by in enumerate(scales) if by]
        most = np.zeros(len(own.poses))
        for number, _, by in used:
            most += by * np.abs(own.laid(number, fps).block).max(axis=0)
        most = np.minimum(most, own.high - own.low)
        guard = int(np.ceil((most / own.speed)[shared(own, scales)] * fps).max(initial=0))
        rounded = (guard + ROUNDING_FRAMES) / fps
        drawn = DRAWING_SECONDS * any(shape.at for _, shape, _ in used)
        lead = max(shape.lead for _, shape, _ in used)
        ahead = max(DRAWING_SECONDS + drawn + max(lead, 0.0), OPENING_SECONDS)
        longest = max(shape.seconds for _, shape, _ in used)
        return cls(ahead + rounded, longest + rounded, guard)


def shared(own: GestureSet, scales: Sequence[float]) -> list[int]:
    """Return the poses whose gestures may add up, or are scaled up."""
    moved = [(pose, by) for n, by in enumerate(scales) if by for pose, _ in own.shapes[n].poses]
    times = Counter(pose for pose, _ in moved)
    return sorted({pose for pose, by in moved if by > 1 or times[pose] > 1})


class StreamGestures:
    """The gestures of one stream, placed as its phonemes become known.

    They are those of the whole line. For a frame at t, `GestureReach.ahead` tells how far phonemes
    must be known, and `GestureReach.ending` how much longer the line must last while its end is
    unknown: a gesture is placed only where it fits.

    Parameters
    ----------
    scales : factor of each gesture of the set; some are above 0
    """

    def __init__(self, own: GestureSet, scales: Sequence[float], fps: float) -> None:
        self.own, self.fps = own, fps
        self.reach = GestureReach.of(own, scales, fps)
        self._guarded = shared(own, scales)
        names = ("pause", "phrase_end", "stress", "emphasis", *own.triggers)
        facts: dict[str, list[LineFact]] = {name: [] for name in names}
        seeds = [gesturing.seed_after(0, "")]
        self._line = LineFacts(0.0, inf, [], facts, [], seeds, until=-inf)
        self._kinds = [
            placing(number, shape, by, self._line)
            for number, (shape, by) in enumerate(zip(own.shapes, scales, strict=True))
            if by
        ]
        self._placed: list[PlacedGesture] = []
        self._known = -inf
        """Time of the last facts."""
        self._by_words: bool | None = None
        """True if words draw gestures, and not labels; None until the first frame."""
        self._vowels: list[tuple[float, float, bool]] = []
        """Begin, prominence, and True for primary stress."""
        self._marked = False
        """True if any label had a mark of stress."""

    @property
    def held(self) -> int:
        """Number of facts and gestures in memory."""
        line = self._line
        facts = sum(map(len, line.facts.values()))
        return len(line.starts) + len(line.phrases) + facts + len(self._placed) + len(self._vowels)

    def settled(self, heard: HeardLabels, start: float, *, ending: bool) -> int:
        """Return the number of frames whose gestures are final.

        Parameters
        ----------
        start : time of the first frame
        ending : True if the end of the line is known
        """
        last = _sure(heard) - self.reach.ahead - CLEAR_SECONDS
        if not ending:
            last = min(last, heard.until - self.reach.ending)
        return max(floor((last - start) * self.fps) + 1, 0)

    def curves(  # noqa: PLR0913 the labels, the frames, and what is known of the end
        self,
        heard: HeardLabels,
        start: float,
        begin: int,
        stop: int,
        count: int | None,
        *,
        ended: bool,
    ) -> Floats:
        """Return the amounts in some final frames, (k, G), from the last given one on.

        Parameters
        ----------
        count : number of frames of the whole stream; None while it is unknown
        ended : True if all labels are known
        """
        guard, own = self.reach.guard, self.own
        if stop == begin:
            return np.zeros((0, len(own.poses)))
        frames = NO_END if count is None else count
        if self._by_words is None:
            self._by_words, self._line.start = bool(heard.spoken), start
        if count is not None:
            self._line.end = start + (count - 1) / self.fps
        last = start + (stop - 1) / self.fps
        self._know(heard, inf if ended else last + self.reach.ahead, ended=ended)
        low, high = max(begin - guard, 0), min(stop + guard, frames)
        out = np.zeros((high - low, len(own.poses)))
        going = []
        for gesture in self._placed:
            found = own.fitted(gesture, start, frames, self.fps)
            if found is None:
                continue
            first, past = found
            if past + guard > begin:
                going.append(gesture)
            here, there = max(first, low), min(past, high)
            if here < there:
                block = own.laid(gesture.number, self.fps).block[here - first : there - first]
                out[here - low : there - low] += gesture.height * block
        self._placed = going
        if self._guarded:
            own.guard(out, self._guarded, self.fps, (low, frames - high))
        return out[begin - low : stop - low]

    def _know(self, heard: HeardLabels, until: float, *, ended: bool) -> None:
        """Take in the facts up to a time, and place the gestures that depend on no others."""
        if until <= self._known:
            return
        self._take_words(heard, until)
        self._take_pauses(heard, until, ended=ended)
        placed = until - DRAWING_SECONDS
        self._take_vowels(heard, until, placed)
        self._known, self._line.until = until, placed
        for kind in self._kinds:
            for one in kind:
                if one is None:
                    break
                self._placed.append(one)
        self._forget(placed - DRAWING_SECONDS)

    def _take_words(self, heard: HeardLabels, until: float) -> None:
        line = self._line
        for word in heard.spoken:
            if self._known < word.start <= until:
                for trigger in gesturing.word_facts(self.own, word.text):
                    line.facts.setdefault(trigger, []).append(LineFact(word.start))
        for one in heard.spoken if self._by_words else heard.labels:
            if self._known < one.start <= until:
                line.starts.append(one.start)
                line.seeds.append(gesturing.seed_after(line.seeds[-1], one.text))

    def _take_pauses(self, heard: HeardLabels, until: float, *, ended: bool) -> None:
        """Take in the pauses that begin by a time, and the phrases around them."""
        phrases, facts = self._line.phrases, self._line.facts
        ends = (*heard.starts[1:], heard.until)
        for sound, begin, end in zip(heard.sounds, heard.starts, ends, strict=True):
            if not self._known < begin <= until:
                continue
            speaking = bool(phrases) and phrases[-1][1] == inf
            if sound == heard.silence and end - begin >= gesturing.PAUSE_SECONDS:
                if speaking:
                    phrases[-1] = (phrases[-1][0], begin)
                    facts["phrase_end"].append(LineFact(begin))
                facts["pause"].append(LineFact(gesturing.pause_fact(begin, end)))
            elif not speaking:
                phrases.append((begin, inf))
        if ended and phrases and phrases[-1][1] == inf:
            phrases[-1] = (phrases[-1][0], heard.until)
            facts["phrase_end"].append(LineFact(heard.until))

    def _take_vowels(self, heard: HeardLabels, until: float, placed: float) -> None:
        """Take in the vowels that begin by a time, and those before `placed` that stand out."""
        facts = self._line.facts
        self._marked = self._marked or heard.stress[1]
        for number, (label, before) in enumerate(
            zip(heard.labels, heard.befores, strict=True), heard.first
        ):
            if label.kind != VOWEL or not self._known < label.start <= until:
                continue
            stress = StressMarks(before[0]).of(label.mark, label.kind)
            length = (heard.until if label.end is None else label.end) - label.start
            raised = any(one.number <= number < one.stop for one in heard.spoken if one.emphasised)
            prominence = length + gesturing.MARKED_PROMINENCE * raised
            self._vowels.append((label.start, prominence, stress == PRIMARY))
            if stress == PRIMARY and self._marked:
                facts["stress"].append(LineFact(label.start))
        # without marks, any vowel may stand out
        vowels = [one for one in self._vowels if one[2] or not self._marked]
        begins = [begin for begin, _, _ in vowels]
        for number in gesturing.stand_out(begins, [prominence for _, prominence, _ in vowels]):
            if self._line.until < begins[number] <= placed:
                facts["emphasis"].append(LineFact(begins[number]))

    def _forget(self, seconds: float) -> None:
        """Forget the facts before a time."""
        line = self._line
        for facts in line.facts.values():
            while facts and facts[0].seconds < seconds:
                del facts[0]
        while len(line.starts) > 1 and line.starts[1] < seconds:
            del line.starts[0], line.seeds[0]
        while line.phrases and line.phrases[0][1] < seconds:
            del line.phrases[0]
        while self._vowels and self._vowels[0][0] < seconds:
            del self._vowels[0]


def _sure(heard: HeardLabels) -> float:
    """Return the time before which words, vowels and pauses are known."""
    if not heard.labels:
        return -inf
    if not heard.silent:
        return heard.labels[-1].start
    quiet = heard.starts[-1]
    return heard.until if heard.until - quiet >= 2 * gesturing.PAUSE_SETTLED_SECONDS else quiet
