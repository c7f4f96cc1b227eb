"""WebSocket server: sends frames to all clients, which send texts or phonemes.

It listens at the user's address, by default only for this machine. Pages of other sites are
refused by their `Origin`, since a page on the web could otherwise make the character speak.

A binary message has samples of a voice: `ClientSound` makes their frames. Any other message of a
client is a JSON object with one of these:

- `text`: a text to speak for all receivers, after the texts before it;
- `sound`: the rate and format of the samples that follow;
- `phonemes`: rows of label, start and end in seconds (null while it lasts), `known_until`,
  `ends_at`, `revise` and `finish: true`, for a stream of this client. The answer contains its new
  final frames; the next message after `finish` opens a new stream. `finish` also ends a voice. The
  message that opens a stream may ask for `gestures: true`, those of the line; its answer has their
  `delay`.

The answer to a message that cannot be read is `error`, and the message has no other effect.
"""

import asyncio
import json
import logging
import re
import socket
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from threading import Event, Thread
from typing import TYPE_CHECKING, Any

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.base.extras import needing
from lipsync_lang.performing.stream import Stream
from lipsync_lang.pipeline.perform import FinalFrames
from lipsync_lang.production.live.addresses import LOCAL, LiveAddress
from lipsync_lang.production.live.live_frame import LiveFrame, as_row
from lipsync_lang.production.live.live_gestures import LiveGestures, beside
from lipsync_lang.production.live.live_voice import LiveVoice
from lipsync_lang.production.live.sound_bytes import SampleForm, checked_form
from lipsync_lang.sound.listening.listener import Listener

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection


SOUND_FIELDS = ("rate", "format", "delay", "for")

FOR_ALL = "all"
"""Value of `for`: the receivers of the session follow the sound."""

OpenListener = Callable[[int, float | None], Listener]
"""Opens a listener for a rate and a delay in seconds; None is the session's delay."""

BELIEF_DECIMALS = 3

_log = logging.getLogger(__name__)

MAX_MESSAGE_BYTES = 64 * 1024
"""Maximum size of a message: some thousand phonemes, or a page of text."""

MAX_PHONEME_ROWS = 2000

MAX_OWN_SECONDS = 600.0
"""Longest phoneme or pause from a client: a message cannot request an hour of frames."""

FIELDS = (
    "text", "sound", "phonemes", "known_until", "ends_at", "revise", "finish", "notation",
    "gestures",
)  # fmt: skip

ROW = len(("label", "start", "end"))

OWN_ORIGIN = re.compile(r"https?://(localhost|127\.0\.0\.1|\[::1\])(:\d+)?")
"""Origins of pages on this machine; programs send no `Origin`."""

MAX_CLIENTS = 32

MAX_UNSENT_BYTES = 2**20
"""Maximum data that waits for a slow client; beyond it, the connection is closed."""

CLOSING_SECONDS = 1.0
"""Time that clients have to close their side of a connection."""

BUSY, SLOW = 1013, 1008
"""Close codes of the protocol: try again later, and policy violation."""


class ClientSound:
    """The sound of one client."""

    def __init__(
        self, open_listener: OpenListener, voice: LiveVoice, gestures: "LiveGestures | None" = None
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
        if len(raw) % self.form.frame_bytes:
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


class Client:
    """A client of a live session, who queues texts for all receivers, or has its own frames."""

    def __init__(self, session: "Session") -> None:
        self.session = session
        self.stream: Stream | None = None
        self.moving = False
        """True if the stream has the gestures of its line."""
        self.gestures = session.open_gestures()
        self.sound = ClientSound(session.open_listener, session.voice, self.gestures)

    def answer(self, message: str | bytes) -> dict[str, Any]:
        """Carry out the request of a message, and return the answer."""
        try:
            asked = None if isinstance(message, bytes) else json.loads(message)
        except (ValueError, RecursionError):
            return {"error": 'the message is not JSON; send an object such as {"text": "Hello"}'}
        try:
            if isinstance(message, bytes):
                return self.sound.hear(message)
            if isinstance(asked, dict):
                return self._answer(asked)
        except LipsyncError as error:
            return {"error": str(error)}
        return {"error": 'the message is not a JSON object; send one such as {"text": "Hello"}'}

    def _answer(self, asked: dict[str, Any]) -> dict[str, Any]:
        unknown = [name for name in asked if name not in FIELDS]
        if unknown or not asked:
            raise LipsyncError(
                (f"unknown field '{unknown[0][:40]}'; " if unknown else "the message is empty; ")
                + f"the fields of a message are {', '.join(FIELDS)}"
            )
        if "text" in asked:
            text = asked["text"]
            if not isinstance(text, str) or len(asked) > 1:
                raise LipsyncError(
                    '`text` must be a string, and the only field of its message: {"text": "Hello"}'
                )
            return {"waiting": self.session.say(text)}
        if "sound" in asked:
            if len(asked) > 1:
                raise LipsyncError("`sound` must be the only field of its message")
            return self.sound.begin(asked["sound"])
        if asked == {"finish": True} and self.stream is None and self.sound.heard:
            return self.sound.finish()
        if self.stream is None:
            notation = asked.get("notation")
            if notation is not None and not isinstance(notation, str):
                what = "`notation` must be a string: the name of a notation of the language"
                raise LipsyncError(what)
            self.moving = self._moving(asked.get("gestures", False))
            self.stream = self.session.open_stream(notation, self.moving)
        elif asked.get("gestures", self.moving) is not self.moving:
            raise LipsyncError("`gestures` belongs to the first message of a stream")
        return self._feed(self.stream, asked)

    def _moving(self, asked: object) -> bool:
        if not isinstance(asked, bool):
            raise LipsyncError("`gestures` must be true or false")
        if asked and self.gestures is None:
            raise LipsyncError("this session has no gestures; start it with --gestures all")
        return asked

    def _feed(self, stream: Stream, asked: dict[str, Any]) -> dict[str, Any]:
        if "revise" in asked:
            stream.revise(asked["revise"])
        # All rows are checked for their form before the first is fed; the stream checks times.
        rows = asked.get("phonemes", [])
        if not isinstance(rows, list) or len(rows) > MAX_PHONEME_ROWS:
            what = f"a list of at most {MAX_PHONEME_ROWS} rows of label, start and end"
            raise LipsyncError(f"`phonemes` must be {what}")
        if any(not isinstance(row, list) or len(row) != ROW for row in rows):
            what = 'a label, a start and an end, such as ["LABEL", 0.1, 0.25]'
            raise LipsyncError(f"each row of `phonemes` must be {what}")
        for label, start, end in rows:
            _refuse_long(stream, start if end is None else end)
            stream.feed(label, start, end)
        if "ends_at" in asked:
            stream.ends_at(asked["ends_at"])
        if "known_until" in asked:
            _refuse_long(stream, asked["known_until"])
            stream.known_until(asked["known_until"])
        if asked.get("finish"):
            stream.finish()
        final = stream.frames()
        lips = [*map(LiveFrame, final.times.tolist(), final.weights)]
        frames = map(as_row, lips if self.moving else beside(self.gestures, lips))
        answer = {"frames": [*frames], "known": stream.known}
        if self.moving:
            answer["delay"] = round(stream.delay, 4)
        if stream.finished:
            self.stream = None
        return answer


def _refuse_long(stream: Stream, seconds: object) -> None:
    known = stream.known
    if known is None or isinstance(seconds, bool) or not isinstance(seconds, (int, float)):
        return
    if seconds - known > MAX_OWN_SECONDS:
        long = f"{known:g} to {seconds:g} s is longer than {MAX_OWN_SECONDS:g} s"
        raise LipsyncError(f"{long}; give times in seconds, and send long pauses in parts")


@dataclass(frozen=True)
class Session:
    """Greeting of a live session, and its services for clients."""

    greeting: Mapping[str, Any]
    """First message to a client: the names of the poses, and the frames per second."""
    say: Callable[[str], int]
    """Queue a text; return the number of texts before it."""
    open_stream: Callable[[str | None, bool], Stream]
    """Open a stream in a notation, with or without the gestures of its line."""
    open_listener: OpenListener
    voice: "LiveVoice"
    """The voice that all receivers follow."""
    open_gestures: Callable[[], LiveGestures | None] = lambda: None
    """Open the gestures of a client's own frames; None for none."""


class WebSocketOutlet:
    """A WebSocket server in its own thread; a LipsyncError if it cannot listen."""

    def __init__(self, address: LiveAddress, session: Session) -> None:
        with needing(LipsyncError, "a WebSocket server needs the package websockets:", "live"):
            import websockets.asyncio.server
        family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
        try:
            self.socket = socket.create_server((address.host, address.port), family=family)
        except OSError as error:
            raise LipsyncError(
                f"ws: cannot listen at {address.host}:{address.port} ({error.strerror or error}); "
                f"choose another port (--to ws:{LOCAL}:{address.port + 1}), or stop the program "
                "that uses it"
            ) from None
        self.session = session
        self.clients: set[ServerConnection] = set()
        self.serve = websockets.asyncio.server.serve
        self.loop: asyncio.AbstractEventLoop
        self.ended, ready = asyncio.Event(), Event()
        self.thread = Thread(target=asyncio.run, args=(self._serve(ready),), daemon=True)
        self.thread.start()
        ready.wait()

    @property
    def port(self) -> int:
        """Port of the server."""
        return self.socket.getsockname()[1]

    def send(self, frame: LiveFrame) -> None:
        """Send a frame to every client."""
        self.tell(as_row(frame))

    def tell(self, event: Mapping[str, Any]) -> None:
        """Send a message to every client."""
        text = json.dumps(event, separators=(",", ":"))
        # Frames come from the session's thread, and asyncio belongs to that of the server.
        self.loop.call_soon_threadsafe(self._broadcast, text)

    def close(self) -> None:
        """Close every connection, and the server."""
        self.loop.call_soon_threadsafe(self.ended.set)
        self.thread.join(2 * CLOSING_SECONDS)
        self.socket.close()

    async def _serve(self, ready: Event) -> None:
        self.loop = asyncio.get_running_loop()
        # Failed handshakes of other programs stay out of the terminal.
        quiet = logging.getLogger(f"{__name__}.server")
        quiet.setLevel(logging.CRITICAL)
        server = self.serve(
            self._meet, sock=self.socket, origins=[None, OWN_ORIGIN], max_size=MAX_MESSAGE_BYTES,
            compression=None, server_header=None, close_timeout=CLOSING_SECONDS,
            logger=quiet,
        )  # fmt: skip
        async with server:
            ready.set()
            await self.ended.wait()

    def _broadcast(self, text: str) -> None:
        from websockets.asyncio.server import broadcast

        slow = [
            one for one in self.clients if one.transport.get_write_buffer_size() > MAX_UNSENT_BYTES
        ]
        for one in slow:
            self.clients.discard(one)
            self.loop.create_task(one.close(SLOW, "the client reads its frames too slowly"))
        broadcast(self.clients, text)

    async def _meet(self, connection: "ServerConnection") -> None:
        """Serve one client until it leaves."""
        from websockets.exceptions import ConnectionClosed

        if len(self.clients) >= MAX_CLIENTS:
            await connection.close(BUSY, f"{MAX_CLIENTS} clients are connected already")
            return
        client = Client(self.session)
        try:
            await connection.send(json.dumps(self.session.greeting))
            self.clients.add(connection)
            async for message in connection:
                # A stream takes milliseconds, in which other clients must get their frames.
                answer = await asyncio.to_thread(client.answer, message)
                await connection.send(json.dumps(answer, separators=(",", ":")))
        except ConnectionClosed:
            pass
        except Exception:  # noqa: BLE001 no traceback reaches a user; the log has it
            _log.exception("the connection of a client failed")
        finally:
            self.clients.discard(connection)
            client.sound.finish()
