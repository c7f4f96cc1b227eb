"""Outlets: send the frames of a live session to its receivers, each at its time and address."""

import errno
import json
import socket
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from time import localtime
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TextIO

from lipsync_lang.arrays import Floats
from lipsync_lang.errors import LipsyncError, did_you_mean

if TYPE_CHECKING:
    from lipsync_lang.live.web_socket import Session
    from lipsync_lang.performing.performer import Performer

NOT_CONNECTED = (errno.ENOTCONN, errno.EDESTADDRREQ)
"""Errors of a socket that had no way to its receiver when it was opened."""

RECOVERED_SECONDS = 1.0
"""Time without an error after which a receiver is there again."""

FRAME_DECIMALS = 5
"""Decimal places of times and weights in text."""

STANDARD_OUTPUT = "-"
USUAL_PORTS = {"livelink": 11111, "vmc": 39539, "ws": 8765}
LOCAL = "127.0.0.1"
MAX_PORT = 65535


class LiveAddress(NamedTuple):
    """A receiver of frames."""

    kind: str
    """A kind of `USUAL_PORTS`, or `STANDARD_OUTPUT`."""
    host: str = ""
    port: int = 0


def parse_address(text: str) -> LiveAddress:
    """Parse ``livelink:HOST:PORT``, ``vmc:HOST:PORT``, ``ws:HOST:PORT`` or ``-``.

    The defaults are this machine and the usual port of the receiver. An IPv6 address is in
    brackets.

    >>> parse_address("vmc:192.168.1.20:39540")
    LiveAddress(kind='vmc', host='192.168.1.20', port=39540)
    >>> parse_address("livelink")
    LiveAddress(kind='livelink', host='127.0.0.1', port=11111)
    """
    if text == STANDARD_OUTPUT:
        return LiveAddress(text)
    kind, _, rest = text.partition(":")
    if kind not in USUAL_PORTS:
        raise LipsyncError(
            f"--to {text}: '{kind}' is not a kind of receiver; {did_you_mean(kind, USUAL_PORTS)}. "
            "Write KIND:HOST:PORT, or - for standard output"
        )
    if rest.startswith("["):
        host, _, port = rest[1:].partition("]")
        port = port.removeprefix(":")
    else:
        host, colon, port = rest.rpartition(":")
        if not colon and not rest.isdecimal():  # a number without a host is a port
            host, port = rest, ""
    if port and not (port.isascii() and port.isdecimal() and 0 < int(port) <= MAX_PORT):
        what = f"--to {text}: '{port}' is not a port; give a number from 1 to {MAX_PORT}"
        raise LipsyncError(what)
    return LiveAddress(kind, host or LOCAL, int(port) if port else USUAL_PORTS[kind])


class LiveFrame(NamedTuple):
    """A frame and its time."""

    seconds: float
    """Time since the start of the session."""
    weights: Floats
    """(P,) in [0, 1]."""


class Outlet(Protocol):
    """A receiver of frames."""

    def send(self, frame: LiveFrame) -> None:
        """Send a frame now."""

    def tell(self, event: Mapping[str, Any]) -> None:
        """Report the start of an utterance or an error, if the receiver reads text."""

    def close(self) -> None:
        """End the connection."""


def as_row(frame: LiveFrame) -> dict[str, Any]:
    """Return a frame as JSON data."""
    weights = [round(weight, FRAME_DECIMALS) for weight in frame.weights.tolist()]
    return {"time": round(frame.seconds, FRAME_DECIMALS), "weights": weights}


class LineOutlet:
    """Writes frames as lines of JSON."""

    def __init__(self, out: TextIO) -> None:
        self.out = out

    def send(self, frame: LiveFrame) -> None:
        """Write the time and the weights of a frame."""
        self.tell(as_row(frame))

    def tell(self, event: Mapping[str, Any]) -> None:
        """Write an event."""
        self.out.write(json.dumps(event, separators=(",", ":")) + "\n")
        self.out.flush()

    def close(self) -> None:
        """Leave the stream open; its owner closes it."""


class PacketOutlet:
    """Sends frames as packets over UDP; `complain` takes messages about the receiver.

    An unknown host is a LipsyncError.
    """

    def __init__(
        self,
        address: LiveAddress,
        pack: Callable[[LiveFrame], bytes],
        complain: Callable[[str], None],
    ) -> None:
        self.address, self.pack, self.complain = address, pack, complain
        self.failed: float | None = None
        """Time of the last frame that was not received; None while all are."""
        try:
            found = socket.getaddrinfo(address.host, address.port, type=socket.SOCK_DGRAM)
        except OSError as error:
            raise LipsyncError(
                f"{address.kind}: no host '{address.host}' ({error.strerror or error}); give the "
                "address of the machine that the engine runs on; 127.0.0.1 is this machine"
            ) from None
        family, kind, protocol, _, target = found[0]
        self.target: Any = target
        self.socket = socket.socket(family, kind, protocol)
        with suppress(OSError):  # then the system tells which packets no program received
            self.socket.connect(target)

    def send(self, frame: LiveFrame) -> None:
        """Send a packet, even if no program receives it."""
        packet, kind = self.pack(frame), self.address.kind
        where = f"{kind}: {self.address.host}:{self.address.port}"
        try:
            self._send(packet)
        except OSError as error:
            refused = isinstance(error, ConnectionRefusedError)
            if self.failed is None and refused:
                self.complain(f"{where} does not listen; start the engine, frames are sent on")
            elif self.failed is None:
                why = error.strerror or error
                self.complain(f"{where} gets no frames ({why}); check the network")
            self.failed = frame.seconds
            if refused:  # the error is of an earlier packet, and this one was not sent
                with suppress(OSError):
                    self._send(packet)
        else:
            if self.failed is not None and frame.seconds - self.failed > RECOVERED_SECONDS:
                self.complain(f"{where} gets frames again")
                self.failed = None

    def _send(self, packet: bytes) -> None:
        try:
            self.socket.send(packet)
        except OSError as error:
            if error.errno not in NOT_CONNECTED:
                raise
            self.socket.connect(self.target)
            self.socket.send(packet)

    def tell(self, event: Mapping[str, Any]) -> None:
        """Do nothing: an engine reads only frames."""

    def close(self) -> None:
        """Close the socket."""
        self.socket.close()


def outlet(  # noqa: PLR0913 the frames, the names that a receiver knows, and the user
    address: LiveAddress,
    performer: "Performer",
    fps: float,
    session: "Session",
    *,
    subject: str,
    renamed: Mapping[str, str],
    gestures: bool,
    complain: Callable[[str], None],
) -> Outlet:
    """Open an outlet; Live Link needs a `subject`, VMC `renamed` poses, a WebSocket the session.

    `gestures` tells whether frames have the amounts of gestures after the weights of poses.
    """
    channels = (*performer.channels, *(performer.gesture_channels if gestures else ()))
    if address.kind == STANDARD_OUTPUT:
        return LineOutlet(sys.stdout)
    if address.kind == "ws":
        from lipsync_lang.live.web_socket import WebSocketOutlet

        return WebSocketOutlet(address, session)
    if address.kind == "livelink":
        from lipsync_lang.live.packets import LiveLinkPacket

        now = localtime()
        start = round(((now.tm_hour * 60 + now.tm_min) * 60 + now.tm_sec) * fps)
        pack = LiveLinkPacket(channels, fps, subject, start)
        return PacketOutlet(address, pack, complain)
    from lipsync_lang.live.packets import vmc_messages

    shapes = [channel.name if channel.node is None else "" for channel in channels]

    return PacketOutlet(address, vmc_messages(shapes, renamed), complain)


def refuse_unknown(renamed: Mapping[str, str], poses: Sequence[str]) -> None:
    """Refuse to rename unknown poses."""
    for pose in renamed:
        if pose not in poses:
            hint = did_you_mean(pose, poses)
            raise LipsyncError(f"--rename {pose}: unknown pose '{pose}'; {hint}")
