"""Rigs: channels of a model keep the promises of poses, and packs state them briefly."""

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from packs_tree import put
from shipped import LIBRARY
from strategies import RATES, any_lines, motions

from lipsync_lang import LipsyncError, Schedule, resolve
from lipsync_lang.base.errors import PackError
from lipsync_lang.faces.rigs.recognise import loss_table, losses
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models.rig_models import channels_of, expanded, paired
from lipsync_lang.pipeline.drive import Rig, drive, sides
from lipsync_lang.pipeline.limit import lower_envelope, ramps, rest_at_ends
from lipsync_lang.pipeline.prepare import GIVEN

EXACT = 1e-9


# Braces


@pytest.mark.parametrize(
    ("name", "names"),
    [
        ("jawOpen", ["jawOpen"]),
        ("smile{Left,Right}", ["smileLeft", "smileRight"]),
        ("{a,b,c}", ["a", "b", "c"]),
        ("x{U,D}{L,R}.y", ["xUL.y", "xUR.y", "xDL.y", "xDR.y"]),
        ("", [""]),
        ("a{}", ["a{}"]),
        ("a{b}", ["a{b}"]),
        ("a{b,}", ["a{b,}"]),
        ("a{b", ["a{b"]),
        ("a}b,c{", ["a}b,c{"]),
        ("a{b,c}{d", ["a{b,c}{d"]),
        ("a{b,{c,d}}", ["a{b,{c,d}}"]),
        ("a{b,c}" * 30, ["a{b,c}" * 30]),
    ],
)
def test_braces_stand_for_several_names(name, names):
    assert list(expanded(name)) == names


@given(st.text("ab{},"))
def test_any_text_stands_for_at_least_one_name(name):
    names = expanded(name)
    assert names
    assert names == (name,) or not set("{}") & set("".join(names))


def test_names_in_braces_pair_off():
    assert paired("b{L,R}", 2) == (("bL",), ("bR",))
    assert paired("b", 2) == (("b",), ("b",))
    assert paired("b{L,R}", 1) == (("bL", "bR"),)
    assert paired("b{x,y,z}", 2) is None


# Channels as arrays


@dataclass(frozen=True, eq=False, repr=False)
class Driven:
    """Poses, and the channels that a rig derives from them."""

    weights: np.ndarray
    rig: Rig
    step: float
    channels: np.ndarray
    held: tuple = ()
    """Floors of the contacts, and the frames of each."""

    @property
    def asked(self):
        return np.clip(self.weights @ self.rig.gains.T, self.rig.low, self.rig.high)

    @property
    def reached(self):
        """The way that each channel gets from rest until a frame, and back until the last one."""
        frames = np.arange(len(self.channels))[:, None]
        return np.minimum(frames, frames[::-1]) * self.step * self.rig.span

    @property
    def alone(self):
        """The channels that yield to none."""
        return ~np.isin(np.arange(len(self.rig.low)), [c for c, _ in self.rig.at_most])


def some_rig(rng, poses, floors, *, signs=True):
    """Random channels of packs: shapes, bones with and without a range, and yielding ones."""
    count = int(rng.integers(1, 13))
    gains = rng.uniform(0, 1.5, (count, poses)) * (rng.random((count, poses)) < 0.6)
    low, high = np.zeros(count), np.ones(count)
    if signs:
        gains *= rng.choice([1, 1, -1], gains.shape) * rng.choice([1, -1], (count, 1))
        ranged = rng.random(count) < 0.6
        low = np.where(ranged, rng.choice([-1, -0.7, -0.4, 0.2], count), low)
        high = np.where(ranged, low + rng.choice([0, 0.4, 0.7, 2], count), high)
        bone = rng.random(count) < 0.3
        gains[bone] *= 20
        low[bone & ~ranged], high[bone & ~ranged] = -np.inf, np.inf
    order = rng.permutation(count)
    at_most = tuple(
        (int(channel), int(other))
        for place, channel in enumerate(order)
        for other in order[:place]
        if rng.random() < 0.1
    )
    return Rig(gains, low, high, at_most, sides(gains, floors))


SEEDS = st.integers(0, 2**32 - 1)


@st.composite
def performed(draw, *, signs=True, **settings):
    """Channels of a performance."""
    line, fps = draw(any_lines()), draw(RATES)
    motion = draw(motions(**settings))
    tables = line.tables
    rng = np.random.default_rng(draw(SEEDS))
    rig = some_rig(rng, len(tables.priority), tables.floors, signs=signs)
    performance = line.perform(motion, fps)
    weights, step = performance.weights(), motion.speed_limit / fps
    frames = [(c.floor, h) for c, (_, h) in zip(tables.contacts, performance.held, strict=True)]
    return Driven(weights, rig, step, drive(weights, rig, step), tuple(frames))


@st.composite
def restless(draw):
    """Channels of poses that move at nearly maximum speed, with contacts throughout."""
    rng = np.random.default_rng(draw(SEEDS))
    poses, frames, step = draw(st.integers(1, 5)), draw(st.integers(1, 80)), draw(STEPS)
    floors = rng.random(poses) * (rng.random(poses) < 0.4)
    wanted = np.repeat(rng.random((poses, frames)) < 0.5, rng.integers(1, 6), axis=1)[:, :frames]
    weights = lower_envelope(
        rest_at_ends(wanted * 1.0, ramps(step, np.zeros(1, int)), head=True, tail=True), step
    ).T
    rig = some_rig(rng, poses, floors)
    far = np.minimum(np.arange(frames), np.arange(frames)[::-1]) * step >= 1
    return Driven(weights, rig, step, drive(weights, rig, step), ((floors, far),))


STEPS = st.one_of(st.sampled_from([0.25, 0.125, 1.0]), st.floats(0.05, 1.2))


def driven():
    return st.one_of(performed(), restless())


@given(driven())
def test_no_channel_leaves_its_range(one):
    assert one.channels.shape == (len(one.weights), len(one.rig.low))
    assert np.isfinite(one.channels).all()
    assert (one.channels >= one.rig.low).all()
    assert (one.channels <= one.rig.high).all()


@given(driven())
def test_no_channel_passes_the_speed_limit_by_its_span(one):
    limit = one.step * one.rig.span
    close = EXACT * np.maximum(one.rig.span, 1)
    for stride in (1, 2, 7):
        moved = np.abs(one.channels[stride:] - one.channels[:-stride])
        assert (moved <= stride * limit + close).all()


@given(driven())
def test_no_channel_passes_the_one_it_yields_to(one):
    for channel, other in one.rig.at_most:
        most = np.maximum(one.channels[:, other], one.rig.low[channel])
        assert (one.channels[:, channel] <= most + EXACT).all()


def bound(rig):
    """Channels whose direct or indirect at_most partner may be faster."""
    found = np.zeros(len(rig.low), bool)
    for channel, other in rig.at_most:
        found[channel] |= found[other] or rig.span[other] > rig.span[channel]
    return found


@given(driven())
def test_channels_start_and_end_at_rest(one):
    ends = one.channels[[0, -1]][:, ~bound(one.rig)]
    reach = 1e-4 * np.maximum(1, np.abs(one.rig.gains).sum(axis=1))[~bound(one.rig)]
    assert (np.abs(ends - one.rig.rest[~bound(one.rig)]) <= reach).all()


@given(SEEDS, st.integers(1, 6), st.integers(1, 50))
def test_without_poses_every_channel_rests(seed, poses, frames):
    rng = np.random.default_rng(seed)
    rig = some_rig(rng, poses, rng.random(poses) < 0.5)
    still = drive(np.zeros((frames, poses)), rig, 0.25)
    assert np.array_equal(still, np.tile(rig.rest, (frames, 1)))
    plain = ~np.isin(np.arange(len(rig.low)), [channel for channel, _ in rig.at_most])
    assert (rig.rest == np.clip(0, rig.low, rig.high))[plain].all()


@given(st.one_of(performed(contacts="hold", limit="before", hold=0), restless()))
def test_what_a_contact_raises_stays_up_and_what_it_lowers_stays_down(one):
    rest = np.clip(0, one.rig.low, one.rig.high)
    highest, lowest = rest + one.reached, rest - one.reached
    for floor, held in one.held:
        if not floor.any():
            continue
        up, down = (held[:, None] & (one.rig.contact == side) & one.alone for side in (1, -1))
        assert (one.channels >= np.minimum(one.asked, highest) - EXACT * 20)[up].all()
        assert (one.channels <= np.maximum(one.asked, lowest) + EXACT * 20)[down].all()


@given(performed(signs=False, contacts="hold", limit="before", hold=0))
def test_a_contact_has_its_share_of_every_shape(one):
    """Floors times gains, at most 1, and at most the room beside the channel that it yields to.

    Near the ends, a channel is only as far as it gets from rest. Poses that are shown one at a time
    leave the floors of all others. A floor with too little room above it may lose `GIVEN` to the
    softening of the poses.
    """
    for floor, held in one.held:
        kept = np.maximum(floor - GIVEN, 0)
        asked = np.minimum(np.clip(one.rig.gains @ kept, 0, 1), one.reached)
        for channel, other in one.rig.at_most:
            asked[:, channel] = np.minimum(asked[:, channel], one.channels[:, other])
        assert (one.channels[held] >= asked[held] - EXACT).all()


@given(driven())
def test_channels_without_contacts_never_go_farther_than_asked(one):
    free = one.alone & (one.rig.contact == 0)
    rest = np.clip(0, one.rig.low, one.rig.high)
    far = np.abs(one.channels - rest)[:, free] - np.abs(one.asked - rest)[:, free]
    assert far.max(initial=0) <= EXACT * 20


def test_a_channel_of_modest_gains_is_the_sum_itself():
    rng = np.random.default_rng(1)
    weights = np.clip(np.cumsum(rng.uniform(-0.25, 0.25, (200, 3)), axis=0), 0, 1)
    weights[[0, -1]] = 0
    weights = np.minimum(weights, np.minimum(np.arange(200), np.arange(200)[::-1])[:, None] * 0.25)
    gains = np.array([[0.5, 0.3, 0.2], [1.0, 0, 0], [0, -8.0, 3.0]])
    low, high = np.array([0, 0, -np.inf]), np.array([1, 1, np.inf])
    rig = Rig(gains, low, high, (), sides(gains, np.zeros(3)))
    assert np.array_equal(drive(weights, rig, 0.25), weights @ gains.T)


def test_a_fast_sum_is_slowed_and_a_contact_still_seen():
    weights = np.zeros((21, 2))
    weights[8:13] = [[0.5, 0.5], [1, 1], [1, 1], [1, 1], [0.5, 0.5]]
    gains = np.array([[1.0, 1.0]])
    free = Rig(gains, np.zeros(1), np.ones(1), (), sides(gains, np.zeros(2)))
    held = Rig(gains, np.zeros(1), np.ones(1), (), sides(gains, np.array([0.9, 0])))
    assert drive(weights, free, 0.5)[7:14, 0].tolist() == [0, 0.5, 1, 1, 1, 0.5, 0]
    assert drive(weights, held, 0.5)[7:14, 0].tolist() == [0.5, 1, 1, 1, 1, 1, 0.5]


def test_what_was_cut_out_of_a_line_is_not_brought_to_rest():
    weights = np.full((5, 1), 0.8)
    gains = np.array([[1.0]])
    rig = Rig(gains, np.zeros(1), np.ones(1), (), sides(gains, np.zeros(1)))
    assert np.array_equal(drive(weights, rig, 0.25), weights)


# Packs


RIGS = [
    rig for one in LIBRARY.names("poseset") if not one.shadowed_by for rig in LIBRARY.rigs(one.name)
]
assert RIGS, "a sweep over nothing passes"
every_rig = pytest.mark.parametrize("rig", RIGS, ids=lambda rig: rig.model.name)

FACE = """\
kind: character
format: 1
name: {name}
poseset: {poseset}
rig: {rig}
"""

SAID = ("HH", "AH0", "P", "IY1", "sil", "F", "AO1", "W", "SH", "UW1", "TH", "M", "AA1", "B", "sil")
TIMES = np.cumsum([0.1, 0.06, 0.09, 0.05, 0.12, 0.3, 0.04, 0.1, 0.05, 0.08, 0.1, 0.06, 0.02, 0.08,
                   0.03, 0.3])  # fmt: skip


@cache
def face(name, text=""):
    """A performer of English on the built-in pose set of a rig."""
    with TemporaryDirectory() as folder:
        poseset = next(rig.model.poseset for rig in RIGS if rig.model.name == name)
        put(Path(folder), "characters/face.yaml",
            FACE.format(name="face", poseset=poseset, rig=name) + text)  # fmt: skip
        return resolve("english", "face", paths=[folder], cache=False)


@every_rig
def test_every_rig_drives_a_line_and_keeps_its_promises(rig):
    performer = face(rig.model.name)
    schedule = Schedule(SAID, TIMES, notation="arpabet")
    bare = performer.perform(schedule, fps=60)
    animation = performer.rigged(bare)
    made = performer.driver.rig
    assert animation.poses == tuple(channels_of(rig.model))
    assert animation.poses == tuple(channel.name for channel in animation.channels)
    assert np.array_equal(animation.times, bare.times)
    assert animation.weights.max() > 0.3
    assert (animation.weights >= made.low).all()
    assert (animation.weights <= made.high).all()
    step = performer.motion.speed_limit / 60
    assert (np.abs(np.diff(animation.weights, axis=0)) <= step * made.span + EXACT).all()
    assert np.abs(animation.weights[[0, -1]]).max() <= EXACT
    limits = {name: c.at_most for name, c in channels_of(rig.model).items() if c.at_most}
    for name, other in limits.items():
        assert (animation[name] <= animation[other] + EXACT).all()
    assert performer.rigged(animation) is animation
    assert animation.explain(0.4).to_dict() == bare.explain(0.4).to_dict()


NEAR = 0.06
"""Tolerance of a ceiling, which a separate pose set would keep exactly."""


@pytest.mark.parametrize("fps", [24, 60])
@pytest.mark.parametrize(
    "rig", [rig for rig in RIGS if rig.model.to], ids=lambda rig: rig.model.name
)
def test_contacts_look_like_those_of_the_set_that_is_driven(rig, fps):
    performer = face(rig.model.name)
    schedule = Schedule(SAID, TIMES, notation="arpabet")
    animation = performer.rigged(performer.perform(schedule, fps))
    performance = performer.performance(schedule, fps)
    made, own = (LIBRARY.poseset(name).model for name in (rig.model.poseset, rig.model.to))
    frames_of = (frames for _, frames in performance.held)
    held = {c.phonemes: h for c, h in zip(made.contacts.values(), frames_of, strict=True)}
    compared = 0
    for contact in own.contacts.values():
        frames = held.get(contact.phonemes)
        if frames is None:
            continue
        for pose, floor in contact.floor.items():
            assert (animation[pose][frames] >= 0.9 * floor - EXACT).all(), pose
        for pose, ceiling in contact.ceiling.items():
            if pose in animation.poses:
                assert (animation[pose][frames] <= ceiling + NEAR).all(), pose
                compared += 1
    assert compared


@every_rig
def test_every_rig_says_why_it_loses_what_it_loses(rig):
    for loss in losses(LIBRARY, rig):
        assert loss.why, str(loss)
        assert loss.what, f"{loss.pose} is not lost"


@pytest.mark.parametrize("performer", [resolve("english", "facefx", cache=False)])
def test_a_face_without_a_rig_drives_its_poses(performer):
    schedule = Schedule(SAID, TIMES, notation="arpabet")
    animation = performer.perform(schedule)
    assert performer.rigged(animation) is animation
    assert tuple(channel.name for channel in animation.channels) == performer.poses


def test_a_rig_drives_no_poses_but_its_own():
    performer = face("facefx-to-arkit")
    animation = performer.perform(Schedule(SAID, TIMES, notation="arpabet"))
    other = replace(animation, poses=animation.poses[::-1])
    with pytest.raises(LipsyncError, match="needs the poses of face"):
        performer.rigged(other)


POSESET = """\
kind: poseset
format: 1
name: face
model: face.glb
poses:
  grin: {names: ["smile{Left,Right}", Grin]}
  gape: {}
  press: {}
  wince: {}
"""

RIG = """\
kind: rig
format: 1
name: bones
poseset: face
channels:
  "corner{L,R}": {gains: {grin: 0.8, wince: 0.3}, at_most: "lip{L,R}"}
  "lip{L,R}": {gains: {grin: 0.5, gape: 0.5}}
  jaw: {node: Jaw, rotation: [1, 0, 0], gains: {gape: 18, press: 4}}
names:
  "corner{L,R}": ["Corner_{Left,Right}", Corner]
  lipL: ["Lip{A,B}"]
lost: {wince: no brows}
"""


@pytest.fixture
def folder(tmp_path):
    put(tmp_path, "posesets/face/poseset.yaml", POSESET)
    put(tmp_path, "posesets/face/face.glb", b"glTF")
    put(tmp_path, "posesets/face/rigs/bones.yaml", RIG)
    put(tmp_path, "characters/anna.yaml", FACE.format(name="anna", poseset="face", rig="bones"))
    return tmp_path


def test_a_rig_is_kept_with_the_pair(folder, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(folder / "cache"))
    first, second = (resolve("english", "anna", paths=[folder], gaps="rest") for _ in range(2))
    assert first.compiled.rig == second.compiled.rig
    assert first.model == second.model == (folder / "posesets/face/face.glb").resolve()
    one, two = (performer.driver for performer in (first, second))
    assert one.channels == two.channels
    assert [(c.name, c.names) for c in one.channels] == [
        ("cornerL", ("Corner_Left", "Corner")),
        ("cornerR", ("Corner_Right", "Corner")),
        ("lipL", ("LipA", "LipB")),
        ("lipR", ()),
        ("jaw", ()),
    ]
    assert one.channels[4].node == "Jaw"
    assert one.channels[4].rotation == (1, 0, 0)
    assert sorted(one.rig.at_most) == [(0, 2), (1, 3)]
    assert one.rig.span.tolist() == [1, 1, 1, 1, 22]
    assert one.rig.low.tolist() == [0, 0, 0, 0, -np.inf]


def test_poses_are_spelled_as_their_pose_set_says(folder):
    performer = resolve("english", "face", paths=[folder], gaps="rest", cache=False)
    names = {channel.name: channel.names for channel in performer.channels}
    assert names == {
        "grin": ("smileLeft", "smileRight", "Grin"), "gape": (), "press": (), "wince": (),
    }  # fmt: skip


def test_a_characters_own_model_comes_before_that_of_its_pose_set(folder):
    text = FACE.format(name="anna", poseset="face", rig="bones")
    put(folder, "characters/anna.glb", b"glTF")
    put(folder, "characters/anna.yaml", f"{text}model: anna.glb\n")
    performer = resolve("english", "anna", paths=[folder], gaps="rest", cache=False)
    assert performer.model == (folder / "characters/anna.glb").resolve()


def test_an_unsound_rig_is_refused_with_its_place(folder):
    put(folder, "posesets/face/rigs/bones.yaml", RIG.replace("gape: 18", "gap: 18"))
    with pytest.raises(PackError, match=r"rigs/bones.yaml:8:49: P201 unknown pose 'gap'"):
        resolve("english", "anna", paths=[folder], gaps="rest", cache=False)


def test_channels_of_a_pose_set_are_spelled_as_it_says(folder):
    put(folder, "posesets/model/poseset.yaml",
        POSESET.replace("name: face", "name: model").replace("model: face.glb\n", ""))  # fmt: skip
    put(
        folder,
        "posesets/face/rigs/bones.yaml",
        "kind: rig\nformat: 1\nname: bones\nposeset: face\nto: model\n"
        "channels: {grin: {gains: {gape: 1}}}\nnames: {grin: [Own, Grin]}\n"
        "lost: {grin: no, press: no, wince: no}\n",
    )
    performer = resolve("english", "anna", paths=[folder], gaps="rest", cache=False)
    driver = performer.driver
    assert driver.channels[0].names == ("Own", "Grin", "smileLeft", "smileRight")


def test_what_a_rig_loses(folder):
    library = Library([folder], project=None)
    text = RIG.replace("gape: 0.5}", "gape: 0.5, wince: 0.03}").replace("wince: 0.3", "wince: 0.05")
    put(folder, "posesets/face/rigs/bones.yaml", text)
    found = losses(library, library.rigs("face")[0])
    assert [str(loss) for loss in found] == [
        "press: weak",
        "wince: looks like grin, weak (no brows)",
    ]
    assert [round(loss.shown, 3) for loss in found] == [0.182, 0.05]
    assert found[1].to_dict()["like"] == "grin"
    table = loss_table(found).splitlines()
    assert table[0].split() == ["pose", "shown", "lost", "why"]
    assert table[2] == "wince  0.05   looks like grin, weak  no brows"
    assert loss_table(()) == "every pose is shown as itself"
