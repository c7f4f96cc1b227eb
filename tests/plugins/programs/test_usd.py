"""USD: the form of .usda, and its import by the USD library."""

import re
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from file_bytes import bytes_of
from small_models import glb

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.base.errors import OutputError
from lipsync_lang.faces.rigs.channel import Channel

NTSC = 24000 / 1001

ODD = ('a "quoted" one', "back\\slash", "a:colon", "ein Mündchen", "]]>", "two\nlines", "\t", "")

BOUND = """#usda 1.0
(
    defaultPrim = "Root"
    metersPerUnit = 1
    upAxis = "Y"
)

def SkelRoot "Root" (
    prepend apiSchemas = ["SkelBindingAPI"]
)
{
    rel skel:animationSource = </Root/Speech>
    rel skel:skeleton = </Root/Bones>

    def Skeleton "Bones"
    {
    }

    def "Speech" (
        references = @line.usda@
    )
    {
    }

    def Mesh "Face" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {
        float3[] extent = [(0, 0, 0), (1, 1, 0)]
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        uniform token[] skel:blendShapes = ["second", "first"]
        rel skel:blendShapeTargets = [</Root/Face/second>, </Root/Face/first>]

        def BlendShape "second"
        {
            uniform vector3f[] offsets = [(0, 0, 1), (0, 0, 0), (0, 0, 0)]
        }

        def BlendShape "first"
        {
            uniform vector3f[] offsets = [(0, 0, 0), (0, 0, 1), (0, 0, 0)]
        }
    }
}
"""
"""A model for the written animation, with its shapes in another order."""


def performed(character="facefx", fps=60, **rest):
    schedule = ll.Schedule(
        ("HH", "AH0", "L", "OW1", "_", "P", "AA1", "F"),
        np.cumsum([0, 0.1, 0.08, 0.12, 0.2, 0.1, 0.05, 0.2, 0.07]),
        notation="arpabet",
    )
    return replace(ll.resolve("english", character).perform(schedule, fps=fps), **rest)


def noise(names, fps=30, first=0, **rest):
    weights = np.random.default_rng(0).random((20, len(names)))
    times = (first + np.arange(20)) / fps
    return Animation(times, tuple(names), weights, fps, ll.Schedule(("_",), (0, 0.5)), **rest)


# Reading it back as text: seconds of the sound, and values, of each shape


def stated(content, name):
    return float(re.search(rf"^    {name} = (.*)$", content.decode(), re.MULTILINE)[1])


def from_usda(content, animation):
    text = content.decode("utf-8")
    assert text.startswith("#usda 1.0\n")
    rate = stated(content, "timeCodesPerSecond")
    assert rate == stated(content, "framesPerSecond") == animation.fps
    tokens = re.search(r"token\[\] blendShapes = \[(.*)\]\n", text)[1]
    names = re.findall(r'"((?:[^"\\]|\\.)*)"', tokens)
    rows = re.findall(r"^        (\S+): \[(.*)\],$", text, re.MULTILINE)
    codes = np.array([code for code, _ in rows], float)
    table = np.array([row.split(", ") for _, row in rows], float)
    assert codes[0] == stated(content, "startTimeCode")
    assert codes[-1] == stated(content, "endTimeCode")
    return {
        plain(name): (codes / rate - animation.offset, column)
        for name, column in zip(names, table.T, strict=True)
    }


def plain(token):
    """Return a token without its escapes."""
    letters = {"n": "\n", "r": "\r", "t": "\t"}
    return re.sub(r"\\(.)", lambda found: letters.get(found[1], found[1]), token)


def holds(content, animation):
    curves = from_usda(content, animation)
    assert curves
    for name, (times, values) in curves.items():
        np.testing.assert_allclose(times, animation.times, atol=1e-6)
        np.testing.assert_allclose(values, animation[name], atol=1e-5)


READ_BACK = {"usd": holds}


def test_a_usda_has_its_form():
    weights = np.array([[0.0, 1.0], [0.125, 1e-9], [1.0, 1 / 3]])
    schedule = ll.Schedule(("_",), (0, 0.2))
    animation = Animation(np.arange(-1, 2) / 24, ("open", 'a "b"'), weights, 24, schedule)
    assert bytes_of("usd", animation).decode() == (
        "#usda 1.0\n"
        "(\n"
        '    defaultPrim = "Speech"\n'
        "    endTimeCode = 1\n"
        "    framesPerSecond = 24\n"
        "    metersPerUnit = 1\n"
        "    startTimeCode = -1\n"
        "    timeCodesPerSecond = 24\n"
        '    upAxis = "Y"\n'
        ")\n"
        "\n"
        'def SkelAnimation "Speech"\n'
        "{\n"
        '    uniform token[] blendShapes = ["open", "a \\"b\\""]\n'
        "    float[] blendShapeWeights.timeSamples = {\n"
        "        -1: [0, 1],\n"
        "        0: [0.125, 0],\n"
        "        1: [1, 0.333333],\n"
        "    }\n"
        "}\n"
    )


@pytest.mark.parametrize("fps", [12, NTSC, 30, 30000 / 1001, 120])
@pytest.mark.parametrize("offset", [0.0, 3600.0, 1.0037])
def test_a_time_code_is_a_frame_at_any_rate(fps, offset):
    animation = performed(fps=fps, export=ExportSettings(offset))
    holds(bytes_of("usd", animation), animation)


def test_shapes_are_called_as_the_model_calls_them(tmp_path):
    model = glb(tmp_path / "face.glb", Head=("Open", "Wide"), Teeth=("Open",))
    animation = noise(("open", "wide"), model=model)
    assert list(from_usda(bytes_of("usd", animation), animation)) == ["Open", "Wide"]


def test_a_shape_that_moves_apart_on_two_meshes_is_refused():
    columns = (Channel("open", mesh="Head"), Channel("open", mesh="Teeth"))
    with pytest.raises(OutputError, match="open: moves differently on different meshes"):
        bytes_of("usd", noise(("open", "open"), channels=columns))


def test_bones_are_left_out_and_that_is_told():
    columns = (Channel("open"), Channel("nod", node="neck", rotation=(1, 0, 0)))
    mixed = noise(("open", "nod"), channels=columns)
    assert list(WRITERS["usd"].remarks(mixed)) == ["a .usda has nothing for nod"]
    assert list(from_usda(bytes_of("usd", mixed), mixed)) == ["open"]
    alone = replace(mixed, poses=("nod",), weights=mixed.weights[:, 1:], channels=columns[1:])
    with pytest.raises(OutputError, match="only bones move"):
        bytes_of("usd", alone)


# The library of USD


needs_usd = pytest.mark.skipif(
    find_spec("pxr") is None, reason="no usd-core: nothing of USD's own reads what we write"
)


def faults(stage):
    from pxr import UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 10
    return [e.GetMessage() for e in UsdValidation.ValidationContext(validators).Validate(stage)]


@needs_usd
@pytest.mark.parametrize("fps", [24, NTSC, 60])
@pytest.mark.parametrize("offset", [0.0, 3600.0])
def test_usd_reads_the_weights_that_were_performed(tmp_path, fps, offset):
    from pxr import Usd, UsdSkel

    animation = performed(fps=fps, export=ExportSettings(offset))
    path = tmp_path / "line.usda"
    animation.save(path)
    stage = Usd.Stage.Open(str(path))
    assert not faults(stage)
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == fps
    take = UsdSkel.Animation(stage.GetDefaultPrim())
    assert tuple(take.GetBlendShapesAttr().Get()) == animation.poses
    weights = take.GetBlendShapeWeightsAttr()
    assert weights.GetNumTimeSamples() == len(animation.times)
    for seconds in np.linspace(animation.times[0], animation.times[-1], 10):
        code = (seconds + offset) * fps
        wanted = [np.interp(seconds, animation.times, animation[pose]) for pose in animation.poses]
        np.testing.assert_allclose(weights.Get(code), wanted, atol=1e-5)


@needs_usd
def test_a_model_that_binds_the_animation_moves_by_it(tmp_path):
    from pxr import Gf, Usd, UsdGeom, UsdSkel

    animation = noise(("first", "second", "third"), fps=24, first=-3)
    animation.save(tmp_path / "line.usda")
    (tmp_path / "model.usda").write_text(BOUND)
    stage = Usd.Stage.Open(str(tmp_path / "model.usda"))
    assert not faults(stage)
    root = UsdSkel.Root(stage.GetDefaultPrim())
    assert UsdSkel.BakeSkinning(root, Gf.Interval(-3, 16))
    points = UsdGeom.Mesh(stage.GetPrimAtPath("/Root/Face")).GetPointsAttr()
    for frame, (first, second, _) in zip(range(-3, 17), animation.weights, strict=True):
        depth = [point[2] for point in points.Get(frame)]
        np.testing.assert_allclose(depth, [second, first, 0], atol=1e-5)


@needs_usd
def test_usd_reads_names_of_any_letters(tmp_path):
    from pxr import Usd, UsdSkel

    animation = noise(ODD)
    animation.save(tmp_path / "line.usda")
    stage = Usd.Stage.Open(str(tmp_path / "line.usda"))
    take = UsdSkel.Animation(stage.GetDefaultPrim())
    assert tuple(take.GetBlendShapesAttr().Get()) == ODD
