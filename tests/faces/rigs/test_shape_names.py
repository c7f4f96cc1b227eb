"""Names of shapes in any spelling: equal names are found, with a remark on duplicates."""

import re

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from shipped import LIBRARY, POSESETS

from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.model import Mesh
from lipsync_lang.faces.rigs.shape_matching import fits, folded, on_mesh, placed
from lipsync_lang.packs.models.rig_models import pose_names

SETS = {name: LIBRARY.poseset(name).model for name in POSESETS}


def listed(text):
    """The words of a text."""
    return text.split()


ARKIT = listed(
    "eyeBlinkLeft eyeLookDownLeft eyeLookInLeft eyeLookOutLeft eyeLookUpLeft eyeSquintLeft "
    "eyeWideLeft eyeBlinkRight eyeLookDownRight eyeLookInRight eyeLookOutRight eyeLookUpRight "
    "eyeSquintRight eyeWideRight jawForward jawLeft jawRight jawOpen mouthClose mouthFunnel "
    "mouthPucker mouthLeft mouthRight mouthSmileLeft mouthSmileRight mouthFrownLeft "
    "mouthFrownRight mouthDimpleLeft mouthDimpleRight mouthStretchLeft mouthStretchRight "
    "mouthRollLower mouthRollUpper mouthShrugLower mouthShrugUpper mouthPressLeft mouthPressRight "
    "mouthLowerDownLeft mouthLowerDownRight mouthUpperUpLeft mouthUpperUpRight browDownLeft "
    "browDownRight browInnerUp browOuterUpLeft browOuterUpRight cheekPuff cheekSquintLeft "
    "cheekSquintRight noseSneerLeft noseSneerRight tongueOut"
)
assert len(ARKIT) == 52


def channels(*names, **spelled):
    """Return channels by name, some with spellings."""
    return [Channel(n, tuple(spelled.get(n, ()))) for n in dict.fromkeys((*names, *spelled))]


def called(some, shapes):
    """Map the channels that are found to their shapes."""
    return {some[number].name: own for number, own in placed(some, shapes).shapes.items()}


# One name


@pytest.mark.parametrize(
    "shape",
    [
        "mouthSmileLeft",
        "MouthSmileLeft",
        "mouthsmileleft",
        "MOUTHSMILELEFT",
        "mouth_smile_left",
        "MOUTH_SMILE_LEFT",
        "Mouth Smile Left",
        "mouth-smile-left",
        "mouth.smile.left",
        "mouthSmile_L",
        "mouthSmile.L",
        "mouthSmile-l",
        "mouthSmileL",
        "MOUTH_SMILE_L",
        "Mouth_Smile_L",
        "L_mouthSmile",
        "left_mouthSmile",
        "Left Mouth Smile",
        "Mouth_L_Smile",
        "mouthSmile_left",
        "blendShape1.mouthSmileLeft",
        "blendShape1.mouthSmile_L",
        "Face|mouthSmileLeft",
        "ns:mouthSmileLeft",
    ],
)
def test_one_name_in_many_spellings(shape):
    some = channels("mouthSmileLeft", "mouthSmileRight", "mouthLeft", "jawOpen")
    assert called(some, [shape, "browInnerUp"]) == {"mouthSmileLeft": [shape]}


@pytest.mark.parametrize(
    "shape", ["mouthSmileRight", "mouthSmile_R", "mouthSmiles_L", "smileLeft", "mouthLeft", "L", ""]
)
def test_other_names_are_other_names(shape):
    assert called(channels("mouthSmileLeft"), [shape, "browInnerUp", "x"]) == {}


@pytest.mark.parametrize(
    "prefix",
    ["blendShape1.", "head_geo_", "viseme_", "CTRL_expressions_", "ARKit-", "Face.M_F00_"],
)
def test_a_prefix_that_most_names_share_is_dropped(prefix):
    shapes = [prefix + name for name in ARKIT]
    assert called(channels(*ARKIT), shapes) == {n: [prefix + n] for n in ARKIT}
    mixed = [*shapes, *map("other{}".format, range(len(shapes) - 1))]
    assert called(channels(*ARKIT), mixed) == {n: [prefix + n] for n in ARKIT}


def test_a_prefix_may_end_where_a_capital_begins():
    shapes = {name: f"bs{name[0].upper()}{name[1:]}" for name in ARKIT}
    assert called(channels(*ARKIT), [*shapes.values()]) == {n: [own] for n, own in shapes.items()}


def test_a_word_that_few_names_share_is_not_a_prefix():
    assert called(channels("open", "close"), ["jawOpen", "mouthClose", "jawLeft", "brow"]) == {}


# Real models


def test_names_of_the_reallusion_kind():
    shapes = listed(
        "Jaw_Open Mouth_Close Mouth_Pucker_Up_L Mouth_Pucker_Up_R Mouth_Pucker_Down_L "
        "Mouth_Pucker_Down_R Mouth_Press_L Mouth_Press_R Mouth_L Mouth_R Tongue_Out Eye_Blink_L"
    )
    pucker = ("Mouth_Pucker_Up", "Mouth_Pucker_Down")
    some = channels("jawOpen", "mouthPressLeft", "mouthLeft", "tongueOut", mouthPucker=pucker)
    assert called(some, shapes) == {
        "jawOpen": ["Jaw_Open"],
        "mouthPressLeft": ["Mouth_Press_L"],
        "mouthLeft": ["Mouth_L"],
        "tongueOut": ["Tongue_Out"],
        "mouthPucker": shapes[2:6],
    }


REAL = {
    "VRoid": ("vrm", "Fcl_ALL_Joy Fcl_MTH_Up Fcl_MTH_A Fcl_MTH_I Fcl_MTH_U Fcl_MTH_E Fcl_MTH_O"),
    "VRoid, named by its mesh": (
        "vrm",
        (
            "Face.M_F00_000_00_Fcl_BRW_Fun Face.M_F00_000_00_Fcl_MTH_A Face.M_F00_000_00_Fcl_MTH_I "
            "Face.M_F00_000_00_Fcl_MTH_U Face.M_F00_000_00_Fcl_MTH_E Face.M_F00_000_00_Fcl_MTH_O"
        ),
    ),
    "MikuMikuDance": ("vrm", "まばたき 笑い あ い う え お"),
    "VRM 0": ("vrm0", "A I U E O blink"),
    "Ready Player Me": (
        "oculus",
        (
            "mouthOpen viseme_sil viseme_PP viseme_FF viseme_TH viseme_DD viseme_kk viseme_CH "
            "viseme_SS viseme_nn viseme_RR viseme_aa viseme_E viseme_I viseme_O viseme_U mouthSmile"
        ),
    ),
    "VRChat": (
        "oculus",
        (
            "vrc.v_sil vrc.v_pp vrc.v_ff vrc.v_th vrc.v_dd vrc.v_kk vrc.v_ch vrc.v_ss vrc.v_nn "
            "vrc.v_rr vrc.v_aa vrc.v_e vrc.v_ih vrc.v_oh vrc.v_ou"
        ),
    ),
    "ARKit, as MetaHuman prefixes it": (
        "arkit",
        " ".join(map("CTRL_expressions_{}".format, ARKIT)),
    ),
    "ARKit in capitals": ("arkit", " ".join(re.sub("([A-Z])", r"_\1", n).upper() for n in ARKIT)),
    "Character Creator 4": (
        "arkit",
        (
            "Jaw_Open Mouth_Close Mouth_Funnel_Up_L Mouth_Funnel_Up_R Mouth_Funnel_Down_L "
            "Mouth_Funnel_Down_R Mouth_Pucker_Up_L Mouth_Pucker_Up_R Mouth_Roll_In_Lower_L "
            "Mouth_Roll_In_Lower_R Mouth_Roll_In_Upper_L Mouth_Roll_In_Upper_R Mouth_Press_L "
            "Mouth_Press_R Mouth_Down_Lower_L Mouth_Down_Lower_R Mouth_Up_Upper_L Mouth_Up_Upper_R "
            "Mouth_Stretch_L Mouth_Stretch_R Tongue_Out Mouth_L Mouth_R Jaw_L Jaw_Forward "
            "Mouth_Shrug_Upper"
        ),
    ),
}


def of_set(poseset):
    names = pose_names(poseset.poses)
    return [Channel(pose, tuple(names[pose])) for pose in poseset.poses]


@pytest.mark.parametrize("model", REAL)
def test_real_models_have_every_pose_of_their_set(model):
    poseset, shapes = REAL[model]
    found = placed(of_set(SETS[poseset]), shapes.split())
    assert len(found.shapes) == len(SETS[poseset].poses)
    taken = [shape for own in found.shapes.values() for shape in own]
    assert len(taken) == len(set(taken))
    assert not found.shared
    assert not found.doubts


# Sides


def test_a_channel_without_a_side_is_both_shapes_of_a_pair():
    some = channels("mouthPucker", "jawOpen")
    pair = ["MOUTH_PUCKER_L", "MOUTH_PUCKER_R"]
    assert called(some, ["JAW_OPEN", *pair]) == {"mouthPucker": pair, "jawOpen": ["JAW_OPEN"]}
    assert called(some, ["mouthPucker", *pair]) == {"mouthPucker": ["mouthPucker"]}


def test_a_pair_shares_a_shape_without_a_side_and_it_is_told():
    some = channels("mouthSmileLeft", "mouthSmileRight")
    found = placed(some, ["Mouth_Smile", "x"])
    assert found.shapes == {0: ["Mouth_Smile"], 1: ["Mouth_Smile"]}
    assert found.shared == {"Mouth_Smile": [0, 1]}
    assert not found.doubts


def test_a_side_that_the_model_has_is_not_shared():
    some = channels("mouthSmileLeft", "mouthSmileRight")
    found = placed(some, ["mouthSmile_L", "mouthSmile"])
    assert found.shapes == {0: ["mouthSmile_L"], 1: ["mouthSmile"]}
    assert found.shared == {"mouthSmile": [1]}


def test_left_and_right_of_a_jaw_are_no_sides_of_its_opening():
    assert called(channels("jawLeft", "jawRight"), ["jawOpen", "mouth"]) == {}


# Which comparison decides


def test_exact_comes_before_folded_and_folded_before_a_pattern():
    some = channels(Open=(), a=("open",), b=("*open*",))
    assert called(some, ["open"]) == {"a": ["open"]}
    assert called(some, ["OPEN"]) == {"Open": ["OPEN"]}
    assert called(some, ["OPEN", "open"]) == {"a": ["open"], "Open": ["OPEN"]}
    assert called(some, ["xopen"]) == {"b": ["xopen"]}


def test_two_that_mean_one_shape_are_told():
    found = placed(channels(a=("*pen",), b=("*PEN",)), ["open"])
    assert found.shapes == {0: ["open"]}
    assert found.doubts == ["'open' is used for 'a', but also fits 'b'"]


def test_one_that_means_two_shapes_takes_the_first_and_tells():
    found = placed(channels("jawOpen"), ["Jaw_Open", "JAW.OPEN", "x"])
    assert found.shapes == {0: ["Jaw_Open"]}
    assert found.doubts == ["'jawOpen' is 'Jaw_Open', but 'JAW.OPEN' has a similar spelling"]


def test_the_longer_pattern_decides():
    some = channels(a=("*open",), b=("*jawopen",))
    assert called(some, ["x_jawOpen", "x_open"]) == {"b": ["x_jawOpen"], "a": ["x_open"]}


@pytest.mark.parametrize(
    ("pattern", "shape", "does"),
    [
        ("*Fcl_MTH_A", "Face.M_F00_000_00_Fcl_MTH_A", True),
        ("*Fcl_MTH_A", "Fcl_MTH_A", True),
        ("*Fcl_MTH_A", "Fcl_MTH_Angry", False),
        ("*_A", "MTH_A", True),
        ("*_A", "Extra", False),
        ("*A", "Extra", True),
        ("jaw_*", "jawOpen", True),
        ("jaw_*", "jaws", False),
        ("*", "", True),
        ("[ab]?*", "a1", False),
        ("[ab]?*", "[AB]?1", True),
    ],
)
def test_patterns(pattern, shape, does):
    assert fits(shape, pattern) is does


# Meshes


def test_a_channel_that_names_a_mesh_comes_first_there_and_is_nowhere_else():
    face, teeth = (Mesh(n, name, name, ("open",), (0.0,)) for n, name in enumerate(("f", "t")))
    some = Channel("open"), Channel("bite", ("open",), mesh="t")
    assert on_mesh(some, face).shapes == {0: ["open"]}
    assert on_mesh(some, teeth).shapes == {1: ["open"]}


def test_bones_are_no_shapes():
    assert placed([Channel("jaw", node="jaw")], ["jaw"]).shapes == {}


# Any spelling of any set


CASES = (str, str.upper, str.lower, str.capitalize)
JOINS = ("_", ".", "-", " ", "")
SIDES = {"Left": ("Left", "left", "L", "l"), "Right": ("Right", "right", "R", "r")}


def words_of(name):
    return re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name)


@st.composite
def styles(draw):
    """Draw a way to spell all names of a model."""
    join = draw(st.sampled_from(JOINS))
    case = draw(st.sampled_from(CASES if join else CASES[:1]))
    return {
        "join": join,
        "case": case,
        "long": draw(st.booleans()),
        "first": draw(st.booleans()),
        "prefix": draw(
            st.sampled_from(["", "blendShape1.", "head_geo_", "CTRL_expressions_", "M_"])
        ),
    }


def spell(name, style):
    """Spell a name in a style: `mouthSmileLeft` as `L_MOUTH_SMILE`."""
    words = words_of(name)
    if style["join"]:
        words = [style["case"](word) for word in words]
    else:
        words = [words[0], *(word[0].upper() + word[1:] for word in words[1:])]
    side = words[-1].capitalize()
    if side in SIDES and len(words) > 1:
        if not style["long"]:
            words[-1] = words[-1][0]
        if style["first"]:
            words = [words[-1], *words[:-1]]
            words[1] = words[1] if style["join"] else words[1][0].upper() + words[1][1:]
    return style["prefix"] + style["join"].join(words)


@given(styles(), st.randoms(use_true_random=False))
def test_arkit_is_found_in_any_spelling(style, random):
    shapes = {name: spell(name, style) for name in ARKIT}
    mixed = [*shapes.values()]
    random.shuffle(mixed)
    assert called(channels(*ARKIT), mixed) == {name: [own] for name, own in shapes.items()}
    assert not placed(channels(*ARKIT), mixed).doubts


@given(styles(), st.sampled_from(sorted(SETS)))
def test_every_set_is_found_in_any_spelling(style, name):
    poses = [*SETS[name].poses]
    shapes = {pose: spell(pose, {**style, "first": False, "long": True}) for pose in poses}
    if len({folded(shape) for shape in shapes.values()}) < len(shapes):
        return  # spelled so, two poses are one name
    if len(shapes) == 1 and style["prefix"]:
        return  # one shape has no prefix that others share
    some = of_set(SETS[name])
    assert called(some, [*shapes.values()]) == {pose: [own] for pose, own in shapes.items()}


NAMES = st.text("abLRleftigh_.A-あ ", max_size=8)


@given(
    st.lists(NAMES, unique=True, max_size=6),
    st.lists(st.tuples(NAMES, st.lists(NAMES | st.just("*a"), max_size=2)), max_size=6),
)
@example(["a_L", "a"], [("aLeft", []), ("aRight", [])])
def test_no_shape_is_taken_twice_but_by_a_pair(shapes, named):
    some = [Channel(name, tuple(names)) for name, names in named]
    found = placed(some, shapes)
    takers = {}
    for number, own in found.shapes.items():
        assert own
        assert len(set(own)) == len(own)
        for shape in own:
            assert shape in shapes
            takers.setdefault(shape, []).append(number)
    for shape, numbers in takers.items():
        assert len(numbers) == 1 or found.shared[shape] == numbers
        assert len(numbers) <= 2
