"""Packets of frames over UDP, for Unreal Engine (Live Link Face) and for receivers of VMC.

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

import struct
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING
from uuid import NAMESPACE_DNS, uuid5

from lipsync_lang.animations.fixed import FixedColumns, names
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.extras import install_line
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.transforms import HeadTurn
from lipsync_lang.production.live.live_frame import LiveFrame

if TYPE_CHECKING:
    from pythonosc.osc_message import OscMessage

VERSION = 6
PACKET_SHAPES = "live-link-packet.txt"
LIVE_LINK_PROGRAM = "Live Link Face"
MAX_DENOMINATOR = 1001
MAX_SUBJECT_BYTES = 128
WRAP = 2**31
"""Number of frames after which the frame number restarts at 0."""

VALUE, APPLY, READY = "/VMC/Ext/Blend/Val", "/VMC/Ext/Blend/Apply", "/VMC/Ext/OK"
BONE, HEAD = "/VMC/Ext/Bone/Pos", "Head"

LOADED = 1
"""Value of `/VMC/Ext/OK`: a model is loaded."""


class LiveLinkPacket:
    """Packs frames for Unreal Engine; `start` is the number of the frame at time zero."""

    def __init__(
        self, columns: Sequence[Channel], fps: float, subject: str, start: int = 0
    ) -> None:
        held = names(PACKET_SHAPES)
        self.arranged = FixedColumns(columns, held, LIVE_LINK_PROGRAM)
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
    try:
        from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
        from pythonosc.osc_message_builder import OscMessageBuilder
    except ImportError:
        raise LipsyncError(f"VMC needs the package python-osc: {install_line('live')}") from None

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
            moved = [("f", number) for number in (*place, x, -y, -z, w)]
            bundle.add_content(message(BONE, ("s", HEAD), *moved))
        bundle.add_content(apply)
        return bundle.build().dgram

    return pack
