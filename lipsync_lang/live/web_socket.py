"""WebSocket server: sends frames to all clients, which send texts or phonemes.

It listens at the user's address, by default only for this machine. Pages of other sites are
refused by their `Origin`, since a page on the web could otherwise make the character speak.
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

from lipsync_lang.errors import LipsyncError
from lipsync_lang.extras import install_line
from lipsync_lang.live.client_messages import MAX_MESSAGE_BYTES, Client
from lipsync_lang.live.outlets import LOCAL, LiveAddress, as_row
from lipsync_lang.performing.stream import Stream

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

    from lipsync_lang.live.outlets import LiveFrame

_log = logging.getLogger(__name__)

OWN_ORIGIN = re.compile(r"https?://(localhost|127\.0\.0\.1|\[::1\])(:\d+)?")
"""Origins of pages on this machine; programs send no `Origin`."""

MAX_CLIENTS = 32

MAX_UNSENT_BYTES = 2**20
"""Maximum data that waits for a slow client; beyond it, the connection is closed."""

CLOSING_SECONDS = 1.0
"""Time that clients have to close their side of a connection."""

BUSY, SLOW = 1013, 1008
"""Close codes of the protocol: try again later, and policy violation."""


@dataclass(frozen=True)
class Session:
    """Greeting of a live session, and its services for clients."""

    greeting: Mapping[str, Any]
    """First message to a client: the names of the poses, and the frames per second."""
    say: Callable[[str], int]
    """Queue a text; return the number of texts before it."""
    open_stream: Callable[[str | None], Stream]
    """Open a stream in a notation."""


class WebSocketOutlet:
    """A WebSocket server in its own thread.

    It is a `LipsyncError` if websockets is not installed, or if the address is in use or of another
    machine.
    """

    def __init__(self, address: LiveAddress, session: Session) -> None:
        try:
            import websockets.asyncio.server
        except ImportError:
            raise LipsyncError(
                f"a WebSocket server needs the package websockets: {install_line('live')}"
            ) from None
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
        port: int = self.socket.getsockname()[1]
        return port

    def send(self, frame: "LiveFrame") -> None:
        """Send a frame to every client."""
        self.tell(as_row(frame))

    def tell(self, event: Mapping[str, Any]) -> None:
        """Send a message to every client."""
        text = json.dumps(event, separators=(",", ":"))
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
        client = Client(self.session.say, self.session.open_stream)
        try:
            await connection.send(json.dumps(self.session.greeting))
            self.clients.add(connection)
            async for message in connection:
                answer = await asyncio.to_thread(client.answer, message)
                await connection.send(json.dumps(answer, separators=(",", ":")))
        except ConnectionClosed:
            pass
        except Exception:  # noqa: BLE001 no traceback reaches a user; the log has it
            _log.exception("the connection of a client failed")
        finally:
            self.clients.discard(connection)
