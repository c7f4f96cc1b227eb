"""Outlets: where the frames of a session go, one by one, at their time."""

import json
import socket
import sys
from collections.abc import Callable, Mapping, Sequence
from time import localtime
from typing import TYPE_CHECKING, Any, Protocol, TextIO

from lipsync_lang.errors import LipsyncError, did_you_mean
from lipsync_lang.live.addresses import STANDARD_OUTPUT, LiveAddress
from lipsync_lang.live.live_frame import LiveFrame

if TYPE_CHECKING:
    from lipsync_lang.live.web_socket import Session
    from lipsync_lang.performing.performer import Performer

DIGITS = 5
"""Decimals of weights as text."""


class Outlet(Protocol):
    """A receiver of frames."""

    def send(self, frame: LiveFrame) -> None:
        """Send a frame now."""

    def tell(self, event: Mapping[str, Any]) -> None:
        """Tell of what begins or fails, where the receiver reads text."""

    def close(self) -> None:
        """End the connection."""


def as_row(frame: LiveFrame) -> dict[str, Any]:
    """Return a frame as JSON data."""
    weights = [round(weight, DIGITS) for weight in frame.weights.tolist()]
    return {"time": round(frame.seconds, DIGITS), "weights": weights}


class LineOutlet:
    """Writes frames as lines of JSON."""

    def __init__(self, out: TextIO) -> None:
        self.out = out

    def send(self, frame: LiveFrame) -> None:
        """Write a line: its time in seconds, and its weights."""
        self._write(as_row(frame))

    def tell(self, event: Mapping[str, Any]) -> None:
        """Write a line."""
        self._write(event)

    def _write(self, data: Mapping[str, Any]) -> None:
        self.out.write(json.dumps(data, separators=(",", ":")) + "\n")
        self.out.flush()

    def close(self) -> None:
        """Leave the stream open: it is not ours."""


class PacketOutlet:
    """Sends frames as packets over UDP.

    Raises
    ------
    LipsyncError
        The host is unknown.
    """

    def __init__(self, address: LiveAddress, pack: Callable[[LiveFrame], bytes]) -> None:
        self.address, self.pack = address, pack
        try:
            found = socket.getaddrinfo(address.host, address.port, type=socket.SOCK_DGRAM)
        except OSError as error:
            raise LipsyncError(
                f"{address.kind}: no host '{address.host}' ({error.strerror or error}); name this "
                "machine (127.0.0.1), or the address of the one that the engine runs on"
            ) from None
        family, kind, protocol, _, target = found[0]
        self.target: Any = target
        self.socket = socket.socket(family, kind, protocol)

    def send(self, frame: LiveFrame) -> None:
        """Send a packet; nobody need be there to receive it."""
        try:
            self.socket.sendto(self.pack(frame), self.target)
        except OSError as error:
            raise LipsyncError(
                f"{self.address.kind}: cannot send to {self.address.host}:{self.address.port} "
                f"({error.strerror or error}); is the network up?"
            ) from None

    def tell(self, event: Mapping[str, Any]) -> None:
        """Tell nothing: an engine reads frames alone."""

    def close(self) -> None:
        """Close the socket."""
        self.socket.close()


def outlet(  # noqa: PLR0913 what is sent, and how it is named
    address: LiveAddress,
    performer: "Performer",
    fps: float,
    session: "Session",
    *,
    subject: str,
    renamed: Mapping[str, str],
) -> Outlet:
    """Open an outlet.

    Parameters
    ----------
    session : answers the clients of a WebSocket
    subject : name of the subject in Live Link
    renamed : other names of poses, for VMC
    """
    if address.kind == STANDARD_OUTPUT:
        return LineOutlet(sys.stdout)
    if address.kind == "ws":
        from lipsync_lang.live.web_socket import WebSocketOutlet

        return WebSocketOutlet(address, session)
    if address.kind == "livelink":
        from lipsync_lang.live.live_link_packet import LiveLinkPacket

        now = localtime()
        start = round(((now.tm_hour * 60 + now.tm_min) * 60 + now.tm_sec) * fps)
        packet = LiveLinkPacket(performer.channels, fps, subject, start)
        return PacketOutlet(address, packet)
    from lipsync_lang.live.vmc_messages import vmc_messages

    return PacketOutlet(address, vmc_messages(performer.poses, renamed))


def refuse_unknown(renamed: Mapping[str, str], poses: Sequence[str]) -> None:
    """Refuse other names for unknown poses."""
    for pose in renamed:
        if pose not in poses:
            hint = did_you_mean(pose, poses)
            raise LipsyncError(f"--rename {pose}: unknown pose '{pose}'; {hint}")
