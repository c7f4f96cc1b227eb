"""Sound of a client of a WebSocket: a voice of its own, or one that all receivers follow."""

from collections.abc import Callable
from typing import Any

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.pipeline.perform import FinalFrames
from lipsync_lang.production.live.live_frame import LiveFrame, as_row
from lipsync_lang.production.live.live_gestures import LiveGestures, beside
from lipsync_lang.production.live.live_voice import LiveVoice
from lipsync_lang.production.live.sound_bytes import SampleForm, checked_form
from lipsync_lang.sound.listening.listener import Listener

SOUND_FIELDS = ("rate", "format", "delay", "for")

FOR_ALL = "all"
"""Value of `for`: the receivers of the session follow the sound."""

OpenListener = Callable[[int, float | None], Listener]
"""Opens a listener for a rate and a delay in seconds; None is the session's delay."""

BELIEF_DECIMALS = 3


class ClientSound:
    """The sound of one client."""

    def __init__(
        self,
        open_listener: OpenListener,
        voice: LiveVoice,
        gestures: "LiveGestures | None" = None,
    ) -> None:
        self.open_listener, self.voice, self.gestures = open_listener, voice, gestures
        self.form = SampleForm()
        self.delay: float | None = None
        self.for_all = False
        self.listener: Listener | None = None
        self.heard = 0.0

    def begin(self, asked: object) -> dict[str, Any]:
        """Open a voice with the settings that a client states, and end the one before it."""
        if not isinstance(asked, dict):
            raise LipsyncError('`sound` must be an object, such as {"rate": 48000}')
        for name in asked:
            if name not in SOUND_FIELDS:
                hint = did_you_mean(name, SOUND_FIELDS)
                raise LipsyncError(f"unknown field '{name[:40]}' of `sound`; {hint}")
        form = checked_form(asked.get("rate"), asked.get("format"))
        delay, whose = asked.get("delay"), asked.get("for")
        if delay is not None and (isinstance(delay, bool) or not isinstance(delay, int | float)):
            raise LipsyncError("`delay` must be a number of seconds, such as 0.08")
        if whose not in (None, FOR_ALL):
            raise LipsyncError(f'`for` must be "{FOR_ALL}", or be left out')
        if whose == FOR_ALL and delay is not None:
            raise LipsyncError("the session states the delay of its voice (`--delay`)")
        listener = self.open_listener(form.rate, delay) if whose is None else None
        if whose == FOR_ALL:
            self.voice.claim(self)
        else:
            self.voice.release(self)
        last = self._end()
        self.form, self.delay, self.for_all, self.listener = form, delay, whose == FOR_ALL, listener
        told: dict[str, Any] = {"rate": form.rate, "format": form.format}
        if listener is not None:
            delays = {name: round(one, 4) for name, one in listener.delays.items()}
            told |= {"phones": listener.phones, "delay": round(listener.delay, 4), "delays": delays}
        return {"listening": told} | last

    def hear(self, raw: bytes) -> dict[str, Any]:
        """Hear samples, and return the frames that are final with them."""
        size = self.form.frame_bytes
        if len(raw) % size:
            raise LipsyncError(
                f"a message of {len(raw)} bytes ends within a sample of {self.form.format}, and "
                "is not heard; send whole samples"
            )
        samples = self.form.samples(raw)
        if self.for_all:
            self.voice.claim(self)
            self.voice.offer(self.form.rate, samples, wait=False)
        elif self.listener is None:
            self.listener = self.open_listener(self.form.rate, self.delay)
        self.heard += len(samples) / self.form.rate
        if self.listener is None:
            return {"heard": round(self.heard, 4)}
        return self._told(self.listener, self.listener.push(samples))

    def finish(self) -> dict[str, Any]:
        """End the voice, and return its last frames."""
        self.voice.release(self)
        return self._end()

    def _end(self) -> dict[str, Any]:
        told: dict[str, Any] = {"frames": []}
        if self.listener is not None:
            told = self._told(self.listener, self.listener.finish())
        self.listener, self.heard = None, 0.0
        return told

    def _told(self, listener: Listener, final: FinalFrames) -> dict[str, Any]:
        lips = [*map(LiveFrame, final.times.tolist(), final.weights)]
        frames = [*map(as_row, beside(self.gestures, lips))]
        belief = [round(one, BELIEF_DECIMALS) for one in listener.belief.tolist()]
        return {"frames": frames, "belief": belief, "heard": round(self.heard, 4)}
