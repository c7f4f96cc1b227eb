"""Outlets: send the frames of a live session to its receivers, each at its time and address.

Live Link Face is the face capture app for Unreal Engine (version 6). One packet a frame, numbers
big-endian: the version in a byte, the device and the subject as text after their length in bytes,
the frame's number, the share of a frame past it, numerator and denominator of the rate, the count
of values in a byte, and the values as floats: 52 ARKit shapes, then the rotations of head and eyes
in radians. The head turns to its left, bends forward and tilts to its right (yaw, pitch, roll); the
eyes have shapes, and their rotations stay 0. Left shapes always come before right ones; the
recordings of the app have two pairs in the opposite order.

The VMC protocol (Virtual Motion Capture) has bundles of OSC. One bundle a frame: a
`/VMC/Ext/Blend/Val` with name and weight for each pose, then `/VMC/Ext/Blend/Apply`, which shows
them. `/VMC/Ext/OK` before them announces the sender. `/VMC/Ext/Bone/Pos` has the place and the turn
of the bone `Head` in its parent, in the axes of Unity: x to its right, y up, z to the front,
left-handed.
"""

import errno
import json
import socket
import struct
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from time import localtime
from typing import TYPE_CHECKING, Any, TextIO
from uuid import NAMESPACE_DNS, uuid5

from lipsync_lang.animations.fixed import FixedColumns, names
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.extras import needing
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.faces.rigs.transforms import HeadTurn
from lipsync_lang.production.live.addresses import STANDARD_OUTPUT, LiveAddress
from lipsync_lang.production.live.live_frame import LiveFrame, Outlet, as_row

if TYPE_CHECKING:
    from pythonosc.osc_message import OscMessage

    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.production.live.live_player import LivePlayer
    from lipsync_lang.production.live.web_socket import Session


NOT_CONNECTED = (errno.ENOTCONN, errno.EDESTADDRREQ)
"""Errors of a socket that had no way to its receiver when it was opened."""

RECOVERED_SECONDS = 1.0
"""Time without an error after which a receiver is there again."""

VERSION = 6

PACKET_SHAPES = Path(__file__).with_name("live-link-packet-names.txt")

LIVE_LINK_PROGRAM = "Live Link Face"

MAX_DENOMINATOR = 1001

MAX_SUBJECT_BYTES = 128

WRAP = 2**31
"""Number of frames after which the frame number restarts at 0."""

VALUE, APPLY, READY = "/VMC/Ext/Blend/Val", "/VMC/Ext/Blend/Apply", "/VMC/Ext/OK"

BONE, HEAD = "/VMC/Ext/Bone/Pos", "Head"

LOADED = 1
"""Value of `/VMC/Ext/OK`: a model is loaded."""


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
        # The first address that the system prefers; UDP cannot tell which of several is answered.
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
            if self.failed is None:
                what = f"gets no frames ({error.strerror or error}); check the network"
                unheard = "does not listen; start the engine, frames are sent on"
                self.complain(f"{where} {unheard if refused else what}")
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
    player: "LivePlayer",
    session: "Session",
    *,
    subject: str,
    renamed: Mapping[str, str],
    complain: Callable[[str], None],
) -> Outlet:
    """Open an outlet; Live Link needs a `subject`, VMC `renamed` poses, a WebSocket the session."""
    performer, fps, channels = player.performer, player.fps, player.channels
    if player.gestures is not None:
        channels += performer.gesture_channels
    if address.kind == STANDARD_OUTPUT:
        return LineOutlet(sys.stdout)
    if address.kind == "ws":
        from lipsync_lang.production.live.web_socket import WebSocketOutlet

        return WebSocketOutlet(address, session)
    if address.kind == "livelink":
        now = localtime()
        start = round(((now.tm_hour * 60 + now.tm_min) * 60 + now.tm_sec) * fps)
        pack = LiveLinkPacket(channels, fps, subject, start)
        return PacketOutlet(address, pack, complain)
    shapes = [channel.name if channel.node is None else "" for channel in channels]
    if not (head := HeadTurn.of(channels)).columns:
        return PacketOutlet(address, vmc_messages(shapes, renamed), complain)
    place = _head_place(performer, channels[head.columns[0]].node, complain)
    return PacketOutlet(address, vmc_messages(shapes, renamed, head, place), complain)


def _head_place(
    performer: "Performer", bone: str | None, complain: Callable[[str], None]
) -> tuple[float, float, float]:
    """Return the place of the head in its parent, in the axes of Unity, if a model tells it."""
    document = read_model(performer.model).document if performer.model else {}
    for node in document.get("nodes", ()):
        if node.get("name") == bone:
            x, y, z = node.get("translation", (0.0, 0.0, 0.0))
            return (-x, y, z) if performer.compiled.gestures["front"] == "z" else (x, y, -z)
    complain(
        f"vmc: no model tells the place of the head, '{bone}'; perform on your model (-c FILE), or "
        "let the receiver take no places of bones (EVMC4U: BonePositionSynchronize)"
    )
    return 0.0, 0.0, 0.0


class LiveLinkPacket:
    """Packs frames for Unreal Engine; `start` is the number of the frame at time zero."""

    def __init__(
        self, columns: Sequence[Channel], fps: float, subject: str, start: int = 0
    ) -> None:
        held = names(PACKET_SHAPES)
        self.arranged = FixedColumns(columns, held, LIVE_LINK_PROGRAM)
        # Broadcast rates are fractions over 1001, which a float only comes near to.
        rate = Fraction(fps).limit_denominator(MAX_DENOMINATOR)
        self.fps, self.start, self.count = fps, start, len(held.shapes) + len(held.turns)
        device = str(uuid5(NAMESPACE_DNS, subject)).upper().encode()
        name = subject.encode()[:MAX_SUBJECT_BYTES]
        self.head = struct.pack(f">BI{len(device)}sI{len(name)}s",
                                VERSION, len(device), device, len(name), name)  # fmt: skip
        self.rate = (rate.numerator, rate.denominator)

    def __call__(self, frame: LiveFrame) -> bytes:
        """Pack a frame."""
        (values,) = self.arranged(frame.weights[None]).tolist()
        at = self.start + max(frame.seconds, 0.0) * self.fps
        whole = int(at + 1e-6)
        rest = struct.pack(
            f">ifIIB{self.count}f",
            whole % WRAP, max(at - whole, 0.0), *self.rate, self.count, *values,
        )  # fmt: skip
        return self.head + rest


def vmc_messages(
    poses: Sequence[str],
    renamed: Mapping[str, str],
    head: HeadTurn | None = None,
    place: Sequence[float] = (0.0, 0.0, 0.0),
) -> Callable[[LiveFrame], bytes]:
    """Return a function that packs frames, with other names of poses in the receiver's model.

    A column with an empty name is left out.

    Parameters
    ----------
    place : of the head in its parent, in the receiver's axes
    """
    with needing(LipsyncError, "VMC needs the package python-osc:", "live"):
        from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
        from pythonosc.osc_message_builder import OscMessageBuilder

    def message(address: str, *values: tuple[str, str | float | int]) -> "OscMessage":
        made = OscMessageBuilder(address)
        for kind, value in values:
            made.add_arg(value, kind)
        return made.build()

    names = [(number, renamed.get(pose, pose)) for number, pose in enumerate(poses) if pose]
    ready, apply = message(READY, ("i", LOADED)), message(APPLY)

    def pack(frame: LiveFrame) -> bytes:
        bundle = OscBundleBuilder(IMMEDIATELY)
        bundle.add_content(ready)
        weights = frame.weights.tolist()
        for number, name in names:
            bundle.add_content(message(VALUE, ("s", name), ("f", weights[number])))
        if head is not None:
            ((x, y, z, w),) = head(frame.weights[None]).tolist()
            # A mirrored axis turns the sign of rotations about the two others.
            moved = [("f", number) for number in (*place, x, -y, -z, w)]
            bundle.add_content(message(BONE, ("s", HEAD), *moved))
        bundle.add_content(apply)
        return bundle.build().dgram

    return pack
