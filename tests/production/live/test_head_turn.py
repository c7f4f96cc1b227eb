"""Turns of the head at engines: receivers of this test read the packets and look where it looks."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lipsync_lang as ll
from lipsync_lang.faces.rigs.transforms import HeadTurn, head_angles
from lipsync_lang.production.live.addresses import LiveAddress
from lipsync_lang.production.live.live_frame import LiveFrame
from lipsync_lang.production.live.live_gestures import LiveGestures
from lipsync_lang.production.live.live_player import LivePlayer
from lipsync_lang.production.live.outlets import outlet

SETS = ("arkit", "vrm", "vrm0", "facefx")
NO_TILT = ("vrm", "vrm0")
TURNS = {"nod": "chin down", "turn": "to its left", "tilt": "to its right", "lift": "chin up"}
DEGREES = 4.0


def packet(name, kind, amounts, *, gestures=True, how=None):
    """Return the packet of a frame with some amounts of poses, and the warnings of the command."""
    performer, told = ll.resolve("english", name), []
    own = performer.gesture_set
    moving = LiveGestures(own, [1.0] * len(own.shapes), 60) if gestures else None
    player = LivePlayer(performer, 60, [], how, gestures=moving)
    address = LiveAddress(kind, "127.0.0.1", 9)
    made = outlet(address, player, None, subject="Ada", renamed={}, complain=told.append)
    poses = [one.name for one in player.channels] + [*own.poses] * gestures
    weights = np.array([amounts.get(pose, 0.0) for pose in poses])
    raw = made.pack(LiveFrame(0.0, weights))
    made.close()
    return raw, told


def messages(raw):
    """Read a bundle of OSC: address and values of each message."""
    assert raw.startswith(b"#bundle\0")
    at, found = 16, []
    while at < len(raw):
        (size,) = struct.unpack_from(">i", raw, at)
        part, at = raw[at + 4 : at + 4 + size], at + 4 + size
        address, part = text(part)
        kinds, part = text(part)
        values = []
        for kind in kinds[1:]:
            if kind == "s":
                value, part = text(part)
            else:
                (value,), part = struct.unpack(f">{kind}", part[:4]), part[4:]
            values.append(value)
        found.append((address, values))
    return found


def text(raw):
    """Read a text of OSC; return it and the rest."""
    end = raw.index(b"\0")
    return raw[:end].decode(), raw[end + 4 - end % 4 :]


def moved(point, turn):
    """Turn a point by a quaternion x, y, z, w."""
    axis, w = np.array(turn[:3]), turn[3]
    return point + 2 * np.cross(axis, np.cross(axis, point) + w * np.array(point))


def looked(turn):
    """Say where a head of Unity looks: x to its right, y up, z to the front."""
    nose, right = moved((0, 0, 1), turn), moved((1, 0, 0), turn)
    found = {"chin down": -nose[1], "chin up": nose[1], "to its left": -nose[0]}
    return max(found | {"to its right": -right[1]}, key={**found, "to its right": -right[1]}.get)


@pytest.mark.parametrize(
    ("name", "pose"),
    [(name, pose) for name in SETS for pose in TURNS if pose != "tilt" or name not in NO_TILT],
)
def test_a_head_of_unity_turns_as_the_pose_says(name, pose):
    pytest.importorskip("pythonosc")
    raw, told = packet(name, "vmc", {pose: DEGREES})
    found = messages(raw)
    ((bone, *numbers),) = [values for address, values in found if address == "/VMC/Ext/Bone/Pos"]
    assert bone == "Head"
    assert looked(numbers[3:]) == TURNS[pose]
    assert 2 * math.degrees(math.acos(numbers[6])) == pytest.approx(DEGREES, abs=1e-3)
    assert found[-1][0] == "/VMC/Ext/Blend/Apply"
    assert not any(pose in values for _, values in found)
    if ll.resolve("english", name).model is None:
        assert numbers[:3] == [0, 0, 0]
        assert "no model tells the place of the head" in told[0]


def test_the_place_of_the_head_is_that_of_the_model():
    pytest.importorskip("pythonosc")
    raw, told = packet("facefx", "vmc", {})
    ((_, *numbers),) = [values for address, values in messages(raw) if address.endswith("Bone/Pos")]
    assert numbers[3:] == [0, 0, 0, 1]
    assert not told


@pytest.mark.parametrize("gestures", [True, False])
@pytest.mark.parametrize("kind", ["vmc", "livelink"])
def test_without_gestures_no_head_turns(kind, gestures):
    pytest.importorskip("pythonosc")
    raw, _ = packet("arkit", kind, {"nod": DEGREES, "jawOpen": 0.5}, gestures=gestures)
    assert (b"Bone/Pos" in raw) == (gestures and kind == "vmc")
    if kind == "livelink":
        head = struct.unpack(">3f", raw[-36:-24])
        assert head == pytest.approx([0, math.radians(DEGREES) * gestures, 0], abs=1e-6)


def test_live_link_has_the_angles_of_a_head_in_radians():
    raw, _ = packet("arkit", "livelink", {"nod": 3.0, "turn": -7.0, "tilt": 2.0, "lift": 1.0})
    assert raw[-245] == 61
    yaw, pitch, roll = struct.unpack(">3f", raw[-36:-24])
    # angles add up but for the turns of one another's axes
    assert np.degrees([yaw, pitch, roll]) == pytest.approx([-7, 2, 2], abs=0.5)
    assert struct.unpack(">6f", raw[-24:]) == (0,) * 6


def test_a_posture_stands_before_the_turns_of_the_head():
    smile = {"mouthSmileLeft": 0.5, "nod": DEGREES}
    raw, _ = packet("arkit", "livelink", smile, how={"styles": {"happy": 1.0}})
    values = struct.unpack(">61f", raw[-244:])
    assert values[23] == 0.5
    assert values[52:55] == pytest.approx([0, math.radians(DEGREES), 0], abs=1e-6)


@given(st.lists(st.floats(-15, 15), min_size=4, max_size=4))
def test_angles_give_the_turn_again(amounts):
    performer = ll.resolve("english", "arkit")
    head = HeadTurn.of(performer.gesture_channels)
    weights = np.zeros((1, head.columns[-1] + 1))
    weights[:, [*head.columns]] = amounts
    turn = head(weights)
    again = HeadTurn(np.eye(3)[[1, 0, 2]], (0, 1, 2))(np.degrees(head_angles(turn)))
    assert again == pytest.approx(turn, abs=1e-12)
