"""Packets of Live Link Face, the face capture app for Unreal Engine (version 6), over UDP.

One packet a frame, numbers big-endian: the version in a byte, the device and the subject as text
after their length in bytes, the frame's number, the share of a frame past it, numerator and
denominator of the rate, the count of values in a byte, and the values as floats: 52 ARKit shapes,
then the rotations of head and eyes, which speech leaves at 0. Left shapes always come before right
ones; the recordings of the app have two pairs in the opposite order.
"""

import struct
from collections.abc import Sequence
from fractions import Fraction
from uuid import NAMESPACE_DNS, uuid5

from lipsync_lang.animations.fixed import names, shapes_held
from lipsync_lang.live.outlets import LiveFrame
from lipsync_lang.rigs.channel import Channel

VERSION = 6
PACKET_SHAPES = "live-link-packet.txt"
LIVE_LINK_PROGRAM = "Live Link Face"
MAX_DENOMINATOR = 1001
MAX_SUBJECT_BYTES = 128
WRAP = 2**31
"""Number of frames after which the frame number restarts at 0."""


class LiveLinkPacket:
    """Packs frames for Unreal Engine.

    Parameters
    ----------
    columns : the channel of each weight
    fps : frames per second
    subject : name of the Live Link subject
    start : number of the frame at time zero

    Raises
    ------
    OutputError
        No column is a shape of ARKit.
    """

    def __init__(
        self, columns: Sequence[Channel], fps: float, subject: str, start: int = 0
    ) -> None:
        held = names(PACKET_SHAPES)
        numbers = {shape: number for number, shape in enumerate(held.shapes)}
        found = shapes_held(columns, held, LIVE_LINK_PROGRAM)
        self.places = [
            (column, numbers[shape]) for column, shapes in found.items() for shape in shapes
        ]
        rate = Fraction(fps).limit_denominator(MAX_DENOMINATOR)
        self.fps, self.start, self.count = fps, start, len(held.shapes) + len(held.turns)
        device = str(uuid5(NAMESPACE_DNS, subject)).upper().encode()
        name = subject.encode()[:MAX_SUBJECT_BYTES]
        self.head = struct.pack(f">BI{len(device)}sI{len(name)}s",
                                VERSION, len(device), device, len(name), name)  # fmt: skip
        self.rate = (rate.numerator, rate.denominator)

    def __call__(self, frame: LiveFrame) -> bytes:
        """Pack a frame."""
        values = [0.0] * self.count
        weights = frame.weights.tolist()
        for column, number in self.places:
            values[number] = max(values[number], min(max(weights[column], 0.0), 1.0))
        at = self.start + max(frame.seconds, 0.0) * self.fps
        whole = int(at + 1e-6)
        rest = struct.pack(
            f">ifIIB{self.count}f",
            whole % WRAP, max(at - whole, 0.0), *self.rate, self.count, *values,
        )  # fmt: skip
        return self.head + rest
