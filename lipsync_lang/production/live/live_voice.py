"""Live voice: frames of a voice that arrives as sound, in step with the clock.

Sound is heard as a player would play it: at once, and no faster than its own rate. So a recording
that arrives all at once moves the mouth for as long as it lasts. Where sound is missing, silence is
heard. Times are seconds of the session.
"""

from collections import deque
from collections.abc import Callable
from math import inf
from threading import Condition, Event

import numpy as np

from lipsync_lang.base.arrays import Singles
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.pipeline.perform import FinalFrames
from lipsync_lang.production.live.live_frame import LiveFrame
from lipsync_lang.sound.listening.listener import Listener
from lipsync_lang.text.lines.line_readers import Remark

MAX_QUEUED_SECONDS = 5.0
"""Sound that waits; a source of more waits as well, and so is a recording."""

SETTLING_SECONDS = 0.2
"""Time from the start of a session in which the sound that waits already is read."""

EARLY_SECONDS = 0.01
"""Time by which sound is heard before it is due, so that small delays do not add up."""

MISSING_SECONDS = 0.3
"""Time without sound after which silence is heard."""

STALLED_SECONDS = 2.0
"""Time without sound after which a message says so."""

SLOW_SECONDS = 5.0
"""Sound after which its rate is judged."""

SLOW_SHARE = 0.1
"""Share of the time in which sound is missing, from which its rate is told to be wrong."""

BURST_FRAMES = 60
"""Most frames that are made before they are sent."""

TAIL_SECONDS = 0.3
"""Silence after the end, in which the mouth comes to rest."""

HASTE = 0.02
"""Share by which sound is heard faster while little of it waits, so that no delay remains."""

LITTLE_SECONDS = 1.0
"""Sound that waits, below which a source is live."""


class LiveVoice:
    """A voice as sound, which any thread offers and the thread of the session hears.

    Parameters
    ----------
    open_listener : for a rate in samples per second
    fps : frames per second of the listeners
    tell : takes a message about the sound
    paced : False to hear sound as soon as it arrives, as from a microphone
    """

    def __init__(
        self, open_listener: Callable[[int], Listener], fps: float, tell: Remark, *,
        paced: bool = True,
    ) -> None:  # fmt: skip
        self.open_listener, self.fps, self.tell = open_listener, fps, tell
        self.early = EARLY_SECONDS if paced else inf
        self.arrived = Event()
        self._changed = Condition()
        self._chunks: deque[tuple[int, Singles]] = deque()
        self._queued = 0.0
        self._ended = self._full = False
        self.owner: object = None
        """The source that offers sound; None while anyone may."""
        self._listener: Listener | None = None
        self._rate = 0
        self._due: float | None = None
        """Time at which the next sample is due; None before the first one."""
        self._expected = self._dry = False
        self._heard = self._missed = self._silent = 0.0

    @property
    def due(self) -> float:
        """Time at which sound that waits is due; infinite without any."""
        return self._due - self.early if self._chunks and self._due is not None else inf

    @property
    def busy(self) -> bool:
        """True while sound waits, or the mouth comes to rest after the last sound."""
        return bool(self._chunks) or self._due is not None

    def offer(self, rate: int, samples: Singles, *, wait: bool = True) -> None:
        """Add sound, in order.

        Parameters
        ----------
        wait : True to wait while much sound waits; False to refuse it then, as a LipsyncError
        """
        with self._changed:
            if self._queued >= MAX_QUEUED_SECONDS:
                self._full = True
                if not wait:
                    raise LipsyncError(
                        f"{MAX_QUEUED_SECONDS:g} s of sound wait already; send sound as it is "
                        "spoken, at its own rate"
                    )
                self._changed.wait_for(lambda: self._queued < MAX_QUEUED_SECONDS)
            self._ended = False
            self._chunks.append((rate, samples))
            self._queued += len(samples) / rate
        self.arrived.set()

    def claim(self, owner: object) -> None:
        """Reserve the voice for a source; a LipsyncError if it has another."""
        with self._changed:
            if self.owner not in (None, owner):
                raise LipsyncError(
                    "the session has a voice already; send sound without `for`, or when the "
                    "other has finished"
                )
            self.owner = owner

    def release(self, owner: object) -> None:
        """End the sound of a source, if it has the voice."""
        if self.owner is owner:
            self.end()
            self.owner = None

    def end(self) -> None:
        """State that no sound follows; the mouth comes to rest after what waits."""
        self._ended = True
        self.arrived.set()

    def wait(self, seconds: float) -> None:
        """Wait so long, or until sound arrives."""
        self.arrived.wait(seconds)
        self.arrived.clear()

    def frames(self, now: float) -> list[LiveFrame]:
        """Hear the sound that is due, and return its frames that are final."""
        if self._due is None and not self._begin(now):
            return []
        found: list[LiveFrame] = []
        while self._due is not None and self._due <= now + self.early and len(found) < BURST_FRAMES:
            part = self._next()
            if part is not None:
                self._resume(now)
                found += self._hear(*part)
            elif self._ended and self._silent >= TAIL_SECONDS:
                found += self._finish()
                self._due, self._expected = None, True
            elif self._ended or now - self._due >= MISSING_SECONDS:
                found += self._silence()
            else:
                self._dry = True
                break
        return found

    def _begin(self, now: float) -> bool:
        """Set the time of the first sample, if sound has arrived."""
        if now < SETTLING_SECONDS:
            return False
        if not self._chunks:
            self._expected = True
            return False
        # Live sound that waited for the session is over: it is heard at once. A recording is not.
        live = not (self._expected or self._full or self._ended)
        self._due = now - self._queued * live
        self._missed = self._silent = 0.0
        return True

    def _next(self) -> tuple[int, Singles] | None:
        """Take the next sound, for about one frame."""
        with self._changed:
            if not self._chunks:
                return None
            rate, samples = self._chunks.popleft()
            count = max(round(rate / self.fps), 1)
            if len(samples) > count:
                self._chunks.appendleft((rate, samples[count:]))
            part = samples[:count]
            # Sums of fractions may end a little below zero.
            self._queued = max(self._queued - len(part) / rate, 0.0)
            self._changed.notify()
        return rate, part

    def _resume(self, now: float) -> None:
        """Go on after sound was missing, and tell a rate that it cannot have."""
        if self._dry and self._due is not None:
            late = max(now - self._due, 0.0)
            # The clock is set back by the gap, or the voice would rush through the sound after it.
            self._missed += late
            self._due += late
            share = self._missed / (self._missed + self._heard)
            if self._heard > SLOW_SECONDS and share > SLOW_SHARE:
                found = f"about {self._rate * (1 - share):.0f} of {self._rate} samples per second"
                self.tell(f"the sound arrives too slowly, {found}; is its rate right?")
                self._missed = -inf  # once
        if self._silent >= STALLED_SECONDS:
            self.tell("the sound goes on")
        self._dry, self._silent = False, 0.0

    def _silence(self) -> list[LiveFrame]:
        """Hear silence in place of missing sound."""
        was = self._silent
        self._silent += 1 / self.fps
        if was < STALLED_SECONDS <= self._silent:
            self.tell(
                f"no sound has arrived for {STALLED_SECONDS:g} s; the mouth rests until it goes on"
            )
        return self._hear(self._rate, np.zeros(round(self._rate / self.fps), np.float32))

    def _hear(self, rate: int, samples: Singles) -> list[LiveFrame]:
        """Return the frames that are final with some samples; these are over then."""
        before: list[LiveFrame] = []
        if rate != self._rate or self._listener is None:
            if self._listener is not None:
                self.tell(f"the sound goes on at {rate} samples per second")
                before = self._finish()
            self._listener, self._rate, self._heard = self.open_listener(rate), rate, 0.0
        seconds = len(samples) / rate
        self._heard += seconds
        self._due = (self._due or 0.0) + seconds * (1 - HASTE * (self._queued < LITTLE_SECONDS))
        return before + self._timed(self._listener, self._listener.push(samples))

    def _finish(self) -> list[LiveFrame]:
        listener, self._listener = self._listener, None
        return [] if listener is None else self._timed(listener, listener.finish())

    def _timed(self, listener: Listener, final: FinalFrames) -> list[LiveFrame]:
        """Return frames at the times at which they are due."""
        moved = (self._due or 0.0) - self._heard + listener.delay
        return [*map(LiveFrame, (final.times + moved).tolist(), final.weights)]
