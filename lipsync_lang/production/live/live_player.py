"""Live player: performs utterances as frames in real time, and speaks the texts that arrive.

Times are seconds. Utterances follow each other. Frames are sent when they are due, and late ones
at once. An utterance that arrives before the frames of the previous one run out continues the
same stream; otherwise the mouth comes to rest in between. A thread speaks texts sentence by
sentence, in the order of their arrival.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from math import floor, inf
from queue import Empty, SimpleQueue
from threading import Lock, Thread
from time import monotonic, sleep
from typing import Any

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.gesturing import line_facts
from lipsync_lang.performing.performer import Performer
from lipsync_lang.performing.stream import Stream
from lipsync_lang.production.live.live_frame import LiveFrame, Outlet
from lipsync_lang.production.live.live_gestures import LiveGestures
from lipsync_lang.production.live.live_voice import LiveVoice
from lipsync_lang.schedules.schedule import Schedule

IDLE_SECONDS = 0.5
"""Interval at which a mouth at rest is sent again, so that an engine keeps the connection."""

EASE_SECONDS = 0.2
"""Time in which an interrupted mouth comes to rest, or passes from sound to a text."""

ROUNDED_TICKS = 1e-6
"""Tolerance of the time of a tick, as a share of a tick."""

AHEAD_SECONDS = 1.0
"""Time known beyond the look-ahead of the stages; below it, the next utterance is taken."""

AHEAD_FRAMES = 2
"""Final frames that must lie ahead of the clock; with fewer, the stream ends."""

SENTENCE_END = re.compile(r"(?<=[.!?…।؟])\s+|(?<=[。！？])")
"""Ends of sentences: the first sentence plays while the next ones are synthesised."""

MAX_WAITING_TEXTS = 100

MAX_SPOKEN_CHARS = 20_000


class LivePlayer:
    """Performs schedules in the order of their arrival; tests replace `clock` and `wait`."""

    def __init__(  # noqa: PLR0913 the performer, the receivers and the clock
        self,
        performer: Performer,
        fps: float,
        outlets: list[Outlet],
        how: Mapping[str, Any] | None = None,
        *,
        voice: LiveVoice | None = None,
        gestures: LiveGestures | None = None,
        clock: Callable[[], float] = monotonic,
        wait: Callable[[float], None] = sleep,
    ) -> None:
        self.performer, self.fps, self.outlets = performer, fps, outlets
        self.how, self.clock, self.wait = dict(how or {}), clock, wait
        self.voice, self.gestures = voice, gestures
        self.channels = performer.stream(fps, **self.how).channels
        """Channel of each column of speech."""
        self.waiting: SimpleQueue[Schedule] = SimpleQueue()
        self.stream: Stream | None = None
        self.began = clock()
        self.zero = 0.0
        """Session time of second 0 of the stream."""
        self.passing = LiveFrame(-inf, np.zeros(len(self.channels)))
        """Last frame before the mouth passed from sound to a text, or back."""
        self.last = LiveFrame(0.0, np.zeros(len(self.channels)))

    @property
    def resting(self) -> bool:
        """True while no utterance is performed or waits."""
        return self.stream is None and self.waiting.empty()

    def say(self, schedule: Schedule) -> int:
        """Queue an utterance; return the number of those before it. Any thread may call this."""
        before = self.waiting.qsize() + (self.stream is not None)
        self.waiting.put(schedule)
        return before

    def run(self, more: Callable[[], bool]) -> None:
        """Perform until the queue is empty, and `more` denies that utterances can still come."""
        self._send(self.last._replace(seconds=self._now()))
        while more() or not self.resting:
            now = self._now()
            self._take_in(now)
            heard = self.voice.frames(now) if self.voice is not None else []
            frames = heard if self.stream is None else self._spoken(self.stream, now)
            for frame in frames:
                self._send(self._passed(frame))
            if self.stream is None and (self.voice is None or not self.voice.busy):
                self.rest()
            if now - self.last.seconds >= self._idle_seconds:
                self._send(self.last._replace(seconds=now))
            # Ticks of the session's clock instead of waits of one frame, whose errors would add up.
            due = (floor(now * self.fps + ROUNDED_TICKS) + 1) / self.fps
            due = due if self.voice is None else min(due, self.voice.due)
            self.wait(max(due - self._now(), 0.0))

    @property
    def _idle_seconds(self) -> float:
        """Interval of frames while nothing is heard: a face with gestures moves on."""
        heard = self.voice is not None and self.voice.busy
        moving = self.gestures is not None and self.stream is None and not heard
        return 0.9 / self.fps if moving else IDLE_SECONDS

    def _spoken(self, stream: Stream, now: float) -> list[LiveFrame]:
        """Return the frames of an utterance that are due, which go before those of a voice."""
        at = now - self.zero
        if not stream.finished and (stream.final_until or 0.0) < at + AHEAD_FRAMES / self.fps:
            stream.finish()
        final = stream.frames(until=at)
        if stream.finished and stream.given == stream.final:
            self.stream, self.passing = None, LiveFrame(now, np.zeros_like(self.last.weights))
        times = (final.times + self.zero).tolist()
        return [*map(LiveFrame, times, final.weights)]

    def _passed(self, frame: LiveFrame) -> LiveFrame:
        """Ease a frame soon after the mouth passed from sound to a text, or back."""
        share = 1 - (frame.seconds - self.passing.seconds) / EASE_SECONDS
        if share <= 0:
            return frame
        share = min(share, 1.0)
        return frame._replace(weights=share * self.passing.weights + (1 - share) * frame.weights)

    def rest(self) -> None:
        """Bring the mouth to rest from its current pose."""
        self.stream = None
        start = self.last
        for step, share in self._fading() if start.weights.any() else ():
            self._send(LiveFrame(start.seconds + step / self.fps, start.weights * share))
            self.wait(1 / self.fps)

    def _fading(self) -> Iterator[tuple[int, float]]:
        """Yield the frames in which a mouth comes to rest: their numbers, and shares of it."""
        steps = max(1, round(EASE_SECONDS * self.fps))
        return ((step, 1 - step / steps) for step in range(1, steps + 1))

    def end(self) -> None:
        """Bring mouth and gestures to rest."""
        self.rest()
        if self.gestures is None:
            return
        amounts = self.gestures.amounts
        for _, share in self._fading():
            self.last = self.last._replace(seconds=self.last.seconds + 1 / self.fps)
            self._give(np.concatenate((self.last.weights, amounts * share)))
            self.wait(1 / self.fps)

    def _now(self) -> float:
        return self.clock() - self.began

    def _take_in(self, now: float) -> None:
        """Feed the next utterance to the open stream, or to a new one."""
        stream = self.stream
        # The stages look ahead by the delay, so only what lies beyond it is in reserve.
        known = 0.0 if stream is None else (stream.known or 0.0) - stream.delay
        ahead = known + self.zero - now
        if stream is not None and (stream.finished or ahead > AHEAD_SECONDS):
            return
        try:
            schedule = self.waiting.get_nowait()
        except Empty:
            return
        if stream is not None and stream.known is not None:
            start = stream.known - schedule.start
            stream.feed(schedule, start)
            self._tell(schedule, self.zero + start)
            return
        how = {"emphasis": True} | self.how
        stream = self.performer.stream(self.fps, **how)
        stream.feed(schedule)
        if stream.start is None:  # so short that nothing is final yet
            stream.finish()
        self.zero = now - (schedule.start if stream.start is None else stream.start)
        self.stream = stream
        # A mouth at rest needs no easing.
        self.passing = self.last if self.last.weights.any() else LiveFrame(-inf, self.last.weights)
        self._tell(schedule, self.zero)

    def _tell(self, schedule: Schedule, start: float) -> None:
        if self.gestures is not None:
            self.gestures.expect(line_facts(self.performer, schedule), start)
        text = " ".join(word.text for word in schedule.words)
        for outlet in self.outlets:
            outlet.tell({"said": text, "start": round(start + schedule.start, 4)})

    def _send(self, frame: LiveFrame) -> None:
        # Times of sound and of texts differ by less than a frame where one follows the other.
        self.last = frame._replace(seconds=max(frame.seconds, self.last.seconds))
        shown = self.last if self.gestures is None else self.gestures.beside(self.last)
        self._give(shown.weights)

    def _give(self, weights: Floats) -> None:
        for outlet in self.outlets:
            outlet.send(self.last._replace(weights=weights))


class TextSpeaker:
    """Turns texts into schedules, which `say` takes; `complain` takes messages about others."""

    def __init__(
        self,
        speak: Callable[[str], Schedule],
        say: Callable[[Schedule], object],
        complain: Callable[[str], None],
    ) -> None:
        self.speak, self.perform, self.complain = speak, say, complain
        self.texts: SimpleQueue[str] = SimpleQueue()
        self.lock, self.pending = Lock(), 0
        Thread(target=self._work, daemon=True).start()

    @property
    def busy(self) -> bool:
        """True while a text waits or is being spoken."""
        with self.lock:
            return self.pending > 0

    def say(self, text: str) -> int:
        """Queue a text from any thread; return the number of those before it, or refuse it."""
        if not text.strip():
            raise LipsyncError("the text is empty; write at least one word")
        if len(text) > MAX_SPOKEN_CHARS:
            long = f"{len(text)} characters, more than {MAX_SPOKEN_CHARS}"
            raise LipsyncError(f"the text has {long}; send it in parts")
        with self.lock:
            if self.pending >= MAX_WAITING_TEXTS:
                raise LipsyncError(f"{MAX_WAITING_TEXTS} texts wait already; send this text later")
            self.pending += 1
            before = self.pending - 1
        self.texts.put(text)
        return before

    def _work(self) -> None:
        while True:
            text = self.texts.get()
            try:
                for sentence in SENTENCE_END.split(text):
                    try:
                        if sentence.strip():
                            self.perform(self.speak(sentence))
                    except LipsyncError as error:
                        self.complain(str(error))
            finally:
                with self.lock:
                    self.pending -= 1
