"""Stream: renders the frames of a performance while its phonemes become known.

Times are seconds. The frames equal those of the whole schedule, whatever its parts; see
`pipeline.look_ahead` for the time at which a frame is final.

Order
    Phonemes arrive in the order of time. A gap between two phonemes is silence.
Late
    A phoneme that starts before the time until which everything is known is late. It is refused,
    or, with `late="shorten"`, begins at that time. A phoneme that is over by then is dropped.
Revised
    `revise` removes the phonemes from a time on. Returned frames do not change: `revise` refuses
    to remove the phonemes on which they depend.
"""

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from math import floor, isfinite, nan
from typing import Any, Literal

import numpy as np

from lipsync_lang.base.errors import LipsyncError, ScheduleError, did_you_mean, refuse_other
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.packs.finding import IPA
from lipsync_lang.performing.delivery import DialLevels, delivery, overlays
from lipsync_lang.performing.effort import RAMP_SECONDS, STRESS_REACH_SECONDS, stress_levels
from lipsync_lang.performing.gesturing import GestureScales, scales_of
from lipsync_lang.performing.heard import FedWord, HeardLabel, HeardLabels, HeardWord
from lipsync_lang.performing.played_pair import PlayedPair
from lipsync_lang.performing.stream_frames import StreamFrames, StreamGestures
from lipsync_lang.pipeline.perform import BLOCK, FinalFrames
from lipsync_lang.schedules.schedule import SILENCE, SNAP_SECONDS, Schedule, Word
from lipsync_lang.text.phonology.g2p.tokens import plain
from lipsync_lang.text.phonology.labels import Value

Late = Literal["refuse", "shorten"]
"""Treatments of a phoneme that starts before the time until which everything is known."""

MAX_FRAMES = 2.0**60
"""Upper limit of frame numbers, beyond any stream."""

ROUNDED_FRAMES = 1e-6
"""Tolerance of a frame's time, as a share of a frame."""

MAX_STEP_SECONDS = 3600.0
"""Longest phoneme or gap between phonemes; a longer one must be in another unit."""

MAX_LABELS = 4096
"""Maximum number of labels in memory, since a client may send any number of them."""


class Intake:
    """Reads the labels of one stream.

    Parameters
    ----------
    notation : notation of single labels; None for the notation of the language's texts
    emphasis : True if words with emphasis are expected
    """

    def __init__(self, performer: PlayedPair, notation: str | None, *, emphasis: bool) -> None:
        self.performer, self.emphasis = performer, emphasis
        known = performer.labels.notations
        name = notation or performer.compiled.manner["notation"] or IPA
        if name not in known:
            raise ScheduleError(
                f"{performer.language} has no notation '{name}'; {did_you_mean(name, known)}"
            )
        self.notation: str = name
        self.known: dict[str, tuple[Value, int | None]] = {}

    def label(self, label: object, start: float, end: float | None) -> HeardLabel:
        """Read a label in the stream's notation."""
        if not isinstance(label, str):
            raise ScheduleError(f"{label!r} is not a label; use text")
        if label not in self.known:
            if len(self.known) >= MAX_LABELS:
                self.known.clear()
            place = f"stream at {start:g} s"
            one = Schedule((label,), np.array([0.0, 1.0]), notation=self.notation, source=place)
            reader = self.performer.labels
            mark = reader.notation(one).stress(label)
            self.known[label] = reader.values(one)[0], mark
        value, mark = self.known[label]
        return self._heard(label, start, end, value, mark)._replace(marked=mark is not None)

    def part(
        self, part: Schedule, moved: float
    ) -> tuple[list[HeardLabel], list[HeardWord], list[FedWord]]:
        """Read a part of a schedule; its words count the labels of the part."""
        reader, compiled = self.performer.labels, self.performer.compiled
        named = part if part.notation is not None else replace(part, notation=self.notation)
        values = reader.values(named)
        marks = part.stress or tuple(map(reader.notation(named).stress, part.labels))
        marked = any(mark is not None for mark in marks)
        times = (part.times + moved).tolist()
        labels = [
            self._heard(text, start, end, value, mark)._replace(marked=marked)
            for text, (start, end), value, mark in zip(
                part.labels, pairwise(times), values, marks, strict=True
            )
        ]
        silent = [not label.kind for label in labels]
        words = []
        for word in part.words:
            found = self._word(part, word, silent, moved)
            own = part.language == compiled.language and plain(word.text) in compiled.words
            if found is not None or own:
                for index in range(word.first, word.stop):
                    labels[index] = labels[index]._replace(whole=times[word.first])
            words += [] if found is None else [found]
        spoken = [
            FedWord(word.first, word.stop, times[word.first], word.text, bool(word.emphasis))
            for word in part.words
        ]
        return labels, words, spoken

    def _heard(
        self, text: str, start: float, end: float | None, value: Value, mark: int | None
    ) -> HeardLabel:
        reader = self.performer.labels
        sounds = tuple((reader.numbers[name], share) for name, share in value)
        kind = reader.kinds[sounds[0][0]] if sounds else ""
        return HeardLabel(start, end, sounds, kind, mark, text=text)

    def _word(
        self, part: Schedule, word: Word, silent: list[bool], moved: float
    ) -> HeardWord | None:
        """Return the curves and the emphasis of a word; None if it has neither."""
        compiled = self.performer.compiled
        stated = compiled.intensity
        if word.emphasis and stated is not None and not self.emphasis:
            raise LipsyncError(
                f"word {word.text!r} has emphasis; open the stream with `emphasis=True`"
            )
        alone = replace(part, words=(word,))
        laid = overlays(compiled, alone, silent, None) if compiled.word_edits else ()
        high = word.emphasis * (stated["emphasised"] - 1) if stated is not None else 0.0
        if not laid and not word.emphasis:
            return None
        start, end = (float(part.times[index]) + moved for index in (word.first, word.stop))
        ramp = (start - RAMP_SECONDS, start, end, end + RAMP_SECONDS)
        later = tuple(one._replace(start=one.start + moved, end=one.end + moved) for one in laid)
        return HeardWord(word.first, ramp, high, later)


def checked_time(here: str, value: object) -> float:
    """Return a time as a float; other values are errors."""
    is_number = isinstance(value, (int, float, np.integer, np.floating))
    try:
        number = float(value) if is_number and not isinstance(value, bool) else nan  # type: ignore[arg-type]  # a number
    except OverflowError:
        number = nan
    if not isfinite(number):
        raise ScheduleError(f"{here}: {value!r} is not a time; times are finite numbers of seconds")
    return number


def refuse_jump(here: str, start: float, end: float) -> None:
    """Refuse a step that is longer than any phoneme or pause."""
    if end - start > MAX_STEP_SECONDS:
        raise ScheduleError(
            f"{here}: {start:g} to {end:g} s is longer than {MAX_STEP_SECONDS:g} s; if the times "
            "are in milliseconds, convert them to seconds"
        )


class Stream:
    """A performance of phonemes that arrive one by one; see `Performer.stream`.

    Examples
    --------
    >>> stream = ll.resolve("english", "facefx").stream(fps=60, notation="arpabet")
    >>> for label, start, end in [("HH", 0, 0.1), ("AY", 0.1, 0.6), ("_", 0.6, 1.5)]:
    ...     stream.feed(label, start, end)
    >>> stream.frames().weights.shape
    (63, 9)
    >>> stream.finish()
    >>> len(stream.frames().times)
    28
    """

    def __init__(  # noqa: PLR0913 as `Performer.perform`
        self,
        performer: PlayedPair,
        fps: float,
        *,
        notation: str | None = None,
        styles: DialLevels | None = None,
        dials: DialLevels | None = None,
        stress: bool | None = None,
        emphasis: bool = False,
        late: Late = "refuse",
        gestures: GestureScales | None = None,
    ) -> None:
        refuse_other("late", late, Late)
        self.performer, self.fps, self.late = performer, fps, late
        compiled, motion = performer.compiled, performer.motion
        self._intake = Intake(performer, notation, emphasis=emphasis)
        _refuse_words(compiled.delivery)
        nothing = Schedule((SILENCE,), np.array([0.0, 1.0]))
        blends, scaled = delivery(compiled, nothing, None, styles, dials)
        self._frames = StreamFrames(performer, fps, blends, scaled, emphasis=emphasis)
        levels = None
        if compiled.intensity is not None and motion.stress and stress is not False:
            levels = stress_levels(compiled.intensity, motion.stress)
        self._heard = HeardLabels(compiled.tables.silence, levels, bool(stress))
        scales = scales_of(compiled, gestures)
        self._gestures = scales and StreamGestures(performer.gesture_set, scales, fps)
        self._end: float | None = None
        """End of the line, as stated."""
        self._given = 0
        self._made = np.zeros((0, len(performer.shown_channels(self._frames.tables))))

    @property
    def poses(self) -> tuple[str, ...]:
        """Pose names, in column order of the weights: those of `perform` with the same styles."""
        return tuple(channel.name for channel in self.channels)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Channel of each pose on a model."""
        spoken = self.performer.shown_channels(self._frames.tables)
        return spoken + (self.performer.gesture_channels if self._gestures else ())

    @property
    def delays(self) -> dict[str, float]:
        """Look-ahead of each stage in seconds, by name; stages without one are left out."""
        found = {}
        if self._heard.levels is not None:
            found["stress"] = 2 * STRESS_REACH_SECONDS
        elif self._intake.emphasis:
            found["emphasis"] = RAMP_SECONDS
        found |= self._frames.ahead.stages
        if self._gestures:
            reach = self._gestures.reach
            needed = reach.ahead
            if self._end is None:
                needed = max(needed, reach.ending)
            found["gestures"] = max(needed - sum(found.values()), 0.0)
        return found

    @property
    def delay(self) -> float:
        """Maximum look-ahead of all stages together, in seconds.

        A frame is final as soon as a phoneme is known that starts later by this delay, or a silence
        that lasts longer than the delay by `motion.silence_reach`. If that phoneme may be the
        second of a trigram, the next one must be known as well.
        """
        return sum(self.delays.values())

    @property
    def start(self) -> float | None:
        """Time of the first frame, before the first sound; None while it is unknown."""
        return self._frames.seconds(self._heard, 0) if self.final else None

    @property
    def given(self) -> int:
        """Number of returned frames."""
        return self._given

    @property
    def final_until(self) -> float | None:
        """Time of the last final frame; None before the first one."""
        final = self.final
        return self._frames.seconds(self._heard, final - 1) if final else None

    @property
    def known(self) -> float | None:
        """Time until which everything is known; None before the first phoneme."""
        return self._heard.until if self._heard.labels else None

    @property
    def finished(self) -> bool:
        """True after `finish`."""
        return self._frames.count is not None

    @property
    def held(self) -> int:
        """Number of labels, sounds, levels and frames in memory; it stays small for hours."""
        heard, made = self._heard, self._made
        kept = len(heard.labels) + len(heard.sounds) + len(heard.words) + len(heard.vowels)
        kept += len(heard.spoken) + (self._gestures.held if self._gestures else 0)
        return kept + len(self._intake.known) + len(made)

    def feed(
        self, phoneme: str | Schedule, start: float | None = None, end: float | None = None
    ) -> None:
        """Add the next phoneme, or a schedule of phonemes with their words.

        Parameters
        ----------
        phoneme : a label in the stream's notation, or a schedule in any notation
        start : start of the label in seconds, or seconds to add to the times of the schedule
        end : end of the label in seconds; None while it is unknown: the label lasts until the
            next one

        Raises
        ------
        ScheduleError
            A label is unknown, a time is not a finite number, or the phoneme is late.
        LipsyncError
            The stream is finished.
        """
        self._refuse_finished()
        if isinstance(phoneme, Schedule):
            self._feed_part(phoneme, checked_time("the schedule", 0.0 if start is None else start))
            return
        here = f"phoneme {phoneme!r}"
        at = checked_time(here, start)
        stop = None if end is None else checked_time(here, end)
        if stop is not None and stop <= at:
            raise ScheduleError(
                f"{here} from {at:g} s ends at {stop:g} s, before it starts; check both times"
            )
        refuse_jump(here, at, at if stop is None else stop)
        label = self._intake.label(phoneme, at, stop)
        begun = self._begin(here, at, stop)
        if begun is not None:
            self._heard.add(label._replace(start=begun))

    def known_until(self, seconds: float) -> None:
        """State that no phoneme starts before a time: the last one lasts, or silence follows it.

        Raises
        ------
        ScheduleError
            The time is before the known time, or no phoneme was fed yet.
        """
        self._refuse_finished()
        at = checked_time("known_until", seconds)
        if not self._heard.labels:
            raise ScheduleError(
                f"the stream has no phonemes until {at:g} s; feed a phoneme first, or silence "
                f"({SILENCE!r})"
            )
        until = self._heard.until
        if at < until - SNAP_SECONDS:
            raise ScheduleError(
                f"the stream is known until {until:g} s already, which is after {at:g} s; "
                "`revise` removes phonemes"
            )
        refuse_jump("known_until", until, at)
        if at > until:
            self._heard.lasts(at)

    def ends_at(self, seconds: float) -> None:
        """State the end of the line, with its silence, before its phonemes are known.

        Gestures need it: each is placed only where it fits before the end. Without it, frames wait
        until the line is known as much farther as the longest gesture lasts.

        Raises
        ------
        ScheduleError
            The seconds are not a finite number.
        LipsyncError
            Another end was stated, or the stream is finished.
        """
        self._refuse_finished()
        at = checked_time("ends_at", seconds)
        if self._end not in (None, at):
            raise LipsyncError(f"the end of the line was stated as {self._end:g} s already")
        self._end = at

    def revise(self, seconds: float) -> None:
        """Remove the phonemes from a time on, so that others can be fed.

        A phoneme that lasts at that time ends there.

        Raises
        ------
        LipsyncError
            Returned frames depend on these phonemes, or the time divides a word.
        """
        self._refuse_finished()
        at = checked_time("revise", seconds)
        word = self._heard.parted(at)
        if word is not None:
            raise LipsyncError(
                f"{at:g} s is within a word with its own curves or pronunciation; "
                f"remove the whole word, from {word:g} s"
            )
        # a copy, since the frames may turn out to depend on what is removed
        other = self._heard.apart()
        other.take_back(at)
        if self._given and self._settled(other) < self._given:
            shown = self._frames.seconds(self._heard, self._given - 1)
            raise LipsyncError(
                f"frames until {shown:.3f} s were returned and depend on the phonemes from {at:g} "
                f"s on; only phonemes that start after {shown + self.delay:.3f} s can be removed"
            )
        if not self._given:
            self._frames.lead = None
        self._heard, self._made = other, self._made[:0]

    def finish(self) -> None:
        """End the stream: the mouth comes to rest, and all frames are final.

        Raises
        ------
        LipsyncError
            No phoneme was fed, the end of the last phoneme is unknown, or the line does not end as
            stated, in silence.
        """
        if self.finished:
            return
        heard = self._heard
        if not heard.labels or not heard.sounds:
            raise LipsyncError("the stream has no phonemes; feed at least one before you finish it")
        last = heard.labels[-1]
        if last.end is None:
            if heard.until <= last.start:
                raise LipsyncError(
                    f"the phoneme from {last.start:g} s has no end; give its end with `known_until`"
                )
            heard.end(heard.until)
        if self._end is not None and (
            abs(heard.until - self._end) > SNAP_SECONDS
            or self._frames.counted(heard) != self._frames.counted(heard, self._end)
        ):
            least = self.performer.motion.added_silence
            raise LipsyncError(
                f"the line ends at {heard.until:g} s, but was stated to end at {self._end:g} s "
                f"after a silence of {least:g} s; add silence (`known_until`), or state its end"
            )
        self._frames.finish(heard)

    def frames(self, until: float | None = None) -> FinalFrames:
        """Return the final frames that were not returned before.

        Parameters
        ----------
        until : time of the last frame to return, in seconds; None for all final frames
        """
        begin, heard, frames = self._given, self._heard, self._frames
        stop = final = self.final
        if until is not None:
            passed = min((checked_time("until", until) - heard.start) * self.fps, MAX_FRAMES)
            shown = floor(passed + ROUNDED_FRAMES) + (frames.lead or 0) + 1
            stop = min(final, max(shown, begin))
        parts = [self._made]
        at = begin + len(self._made)
        while at < stop:
            parts.append(frames.weights(heard, at, min(at + BLOCK, final)))
            at += len(parts[-1])
        made = parts[0] if len(parts) == 1 else np.concatenate(parts)
        moved = None
        if self._gestures:
            first, count = frames.seconds(heard, 0), frames.count
            if self._end is not None and stop > begin:
                count = frames.counted(heard, self._end)
            moved = self._gestures.curves(heard, first, begin, stop, count, ended=self.finished)
        if stop > begin:
            heard.freeze_levels(frames.seconds(heard, stop + frames.ahead.ahead))
            self._given, self._made = stop, made[stop - begin :]
            frames.forget(heard, stop)
        times, weights = frames.laid(heard, begin, stop).times(), made[: stop - begin]
        return FinalFrames(times, weights if moved is None else np.hstack((weights, moved)))

    @property
    def final(self) -> int:
        """Number of final frames from the first on, including returned ones."""
        return max(self._settled(self._heard), self._given)

    def _settled(self, heard: HeardLabels) -> int:
        final = self._frames.settled(heard)
        if not (final and self._gestures) or self.finished:
            return final
        start = self._frames.seconds(heard, 0)
        return min(final, self._gestures.settled(heard, start, ending=self._end is not None))

    def _feed_part(self, part: Schedule, moved: float) -> None:
        labels, words, spoken = self._intake.part(part, moved)
        whole = any(label.whole is not None for label in labels)
        begun = self._begin(part.source, labels[0].start, labels[-1].end, whole=whole)
        if begun is None:
            return
        kept = [label for label in labels if label.end is None or label.end > begun]
        first = self._heard.number - (len(labels) - len(kept))
        for label in kept:
            self._heard.add(label._replace(start=max(label.start, begun)))
        self._heard.words += [word._replace(number=first + word.number) for word in words]
        self._heard.spoken += [
            word._replace(number=first + word.number, stop=first + word.stop) for word in spoken
        ]

    def _begin(
        self, here: str, start: float, end: float | None, *, whole: bool = False
    ) -> float | None:
        """Return the start of the next phoneme after late times are cut; None if it is dropped.

        A `whole` one, with a word that has its own curves, cannot be shortened.
        """
        heard = self._heard
        if not heard.labels:
            return start
        last, until = heard.labels[-1], heard.until
        refuse_jump(here, until, start)
        # a label without an end lasts until the next one starts
        lasting = last.end is None
        early = start < until - SNAP_SECONDS or (lasting and start <= last.start)
        if early and (self.late == "refuse" or whole or (lasting and until <= last.start)):
            raise ScheduleError(
                f"{here} starts at {start:g} s, but the stream is known until {until:g} s: the "
                "phoneme is late, or the times are not in order. Remove phonemes that are not "
                "final (`revise`), or open the stream with `late='shorten'`"
            )
        if lasting and not early:
            return start
        if start > until + SNAP_SECONDS:
            heard.lasts(start)
            return start
        if end is not None and end <= until:
            return None
        if lasting:
            heard.end(until)
        return until

    def _refuse_finished(self) -> None:
        if self.finished:
            raise LipsyncError("the stream is finished; open a new one")


def _refuse_words(stated: Mapping[str, Any]) -> None:
    """Refuse a character whose delivery counts the words of a line."""
    for what in ("styles", "dials"):
        for name, points in stated[what].items():
            if len(points) > 1:
                raise LipsyncError(
                    f"the character's {what}: {name} has points at words of a line, but a stream "
                    f"has no lines; give {name} a single level"
                )
