"""Keys with tangents: the error of the fit, contacts, and the form in each format."""

import json
import re
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from file_bytes import bytes_of
from hypothesis import given
from hypothesis import strategies as st
from small_models import glb

import lipsync_lang as ll
from lipsync_lang.animations.animation import ExportSettings
from lipsync_lang.animations.animation_writers import template
from lipsync_lang.animations.keys import CONTACT_TOLERANCE, curves, fit
from lipsync_lang.animations.readers.glb import read_glb
from lipsync_lang.faces.rigs.tracks import Spline, sample
from lipsync_lang.packs.yaml.events import load_yaml
from lipsync_lang.plugins.programs import blender as blender_file

LABELS = (
    *("HH", "AH0", "L", "OW1", "_", "P", "AA1", "P", "M", "AH0", "S"),
    *("UW1", "_", "B", "EY1", "B", "IY0", "F", "AA1", "V", "_"),
)
ERRORS = [0.02, 0.005]


@pytest.fixture(scope="module")
def animation(tmp_path_factory):
    times = np.arange(len(LABELS) + 1) / 9
    schedule = ll.Schedule(LABELS, times, notation="arpabet")
    animation = ll.resolve("english", "facefx").perform(schedule)
    model = glb(tmp_path_factory.mktemp("model") / "face.glb", *animation.poses)
    return replace(animation, model=model)


def shown(times, spline):
    return sample(times[spline.frames], spline, times)


# The fit


@st.composite
def tracks(draw):
    """Return times and two curves: noise, slow noise, steps, and runs that hold."""
    count = draw(st.integers(1, 50))
    level = st.sampled_from([0.0, 0.0, 0.5, 0.9, 1.0])
    value = st.one_of(level, st.floats(0, 1, width=32))
    values = np.array(draw(st.lists(value, min_size=2 * count, max_size=2 * count)))
    if draw(st.booleans()):
        values = np.interp(np.arange(2 * count) / 4, np.arange(2 * count), values)
    return np.arange(count) / draw(st.sampled_from([12.0, 30.0, 60.0])), values.reshape(2, -1).T


@given(tracks(), st.sampled_from([1e-3, *ERRORS, 0.5]))
def test_no_frame_strays_by_more_than_the_error(track, error):
    times, values = track
    spline = fit(times, values, error)
    assert spline.frames[0] == 0
    assert spline.frames[-1] == len(times) - 1
    assert (np.diff(spline.frames) > 0).all()
    assert np.abs(shown(times, spline) - values).max() <= error + 1e-9


@given(tracks(), st.sampled_from(ERRORS))
def test_what_holds_is_held_exactly(track, error):
    times, values = track
    column = values[:, :1]
    curve = shown(times, fit(times, column, error))
    held = np.flatnonzero(np.diff(column[:, 0]) == 0)
    np.testing.assert_allclose(curve[held], column[held], rtol=0, atol=1e-12)
    np.testing.assert_allclose(curve[held + 1], column[held + 1], rtol=0, atol=1e-12)


def test_a_cubic_curve_needs_two_keys():
    times = np.arange(60) / 30
    values = (times * (2 - times) * times / 2)[:, None]
    assert fit(times, values, 1e-6).frames.tolist() == [0, 59]


def test_keys_have_one_slope_where_the_error_allows_it():
    times = np.arange(240) / 120
    spline = fit(times, 0.5 + 0.4 * np.sin(9 * times)[:, None], 0.02)
    joined = np.isclose(spline.arriving, spline.leaving)[1:-1]
    assert 4 < len(joined) < 12
    assert joined.mean() > 0.5


def test_a_corner_keeps_two_slopes():
    times = np.arange(61) / 60
    spline = fit(times, np.abs(times - 0.5)[:, None] * 2, 1e-4)
    corner = spline.frames.tolist().index(30)
    assert spline.arriving[corner, 0] == pytest.approx(-2, abs=0.05)
    assert spline.leaving[corner, 0] == pytest.approx(2, abs=0.05)


def test_a_spline_holds_its_ends():
    spline = Spline(np.array([0, 1]), *np.array([[[0.2], [0.8]], [[0], [0]], [[0], [0]]], float))
    found = sample(np.array([1.0, 2.0]), spline, np.array([0.0, 1.0, 1.5, 2.0, 9.0]))
    np.testing.assert_allclose(found[:, 0], [0.2, 0.2, 0.5, 0.8, 0.8])


@pytest.mark.parametrize("error", [0.02, 0.1, 0.5])
def test_contacts_keep_their_floor(animation, error):
    assert animation.contacts == {"PBM": 0.7, "FV": 0.5}
    for curve in curves(
        animation.poses, animation.times, animation.weights, error, animation.contacts
    ):
        floor = animation.contacts.get(curve.name, 0)
        if floor:
            values = animation[curve.name]
            parts = (curve.values, curve.arriving, curve.leaving)
            spline = Spline(curve.frames, *(part[:, None] for part in parts))
            fitted = sample(curve.times, spline, animation.times)[:, 0]
            assert (values >= floor).any()
            assert (fitted[values >= floor] >= floor - CONTACT_TOLERANCE - 1e-9).all()


@pytest.mark.parametrize(("character", "error", "most"), [
    ("facefx", 0.02, 6.3), ("facefx", 0.005, 10), ("arkit", 0.02, 6.1), ("arkit", 0.005, 10),
])  # fmt: skip
def test_keys_are_few(character, error, most):
    times = np.cumsum([0.0, *(0.06 + 0.05 * (np.arange(len(LABELS)) % 3))])
    schedule = ll.Schedule(LABELS, times, notation="arpabet")
    animation = ll.resolve("english", character).perform(schedule)
    moving = np.flatnonzero(np.ptp(animation.weights, axis=0) > 0)
    curves = replace(animation, export=ExportSettings(key_error=error)).keyframes(error)
    seconds = animation.times[-1] - animation.times[0]
    lines = replace(animation, export=ExportSettings(key_error=error, key_lines=True)).keyframes(
        error
    )
    fitted, straight = (
        sum(len(found[n].frames) for n in moving) / seconds / len(moving)
        for found in (curves, lines)
    )
    assert fitted < most
    assert fitted < straight / 1.65


# What each format makes of them


def unity(content, animation):
    text = content.decode().split("\n", 3)[3]
    for row in load_yaml(text)["AnimationClip"]["m_FloatCurves"]:
        keys = row["curve"]["m_Curve"]
        assert {key["tangentMode"] for key in keys} <= {0, 1}
        assert all((k["inSlope"] == k["outSlope"]) == (k["tangentMode"] == 0) for k in keys)
        times = np.array([key["time"] for key in keys]) - animation.begins
        parts = (
            np.array([[key[of]] for key in keys]) / 100 for of in ("value", "inSlope", "outSlope")
        )
        spline = Spline(np.arange(len(keys)), *parts)
        name = row["attribute"].removeprefix("blendShape.")
        yield name, sample(times, spline, animation.times)[:, 0], len(keys)


def bezier(keys, at):
    """Return the values of keys (time, value, left handle, right handle) at times.

    Handles must be a third of the way to the neighbours, where Bezier curves are cubic in time.
    """
    found = np.empty(len(at))
    for (start, first, _, after), (end, last, before, _) in pairwise(keys):
        assert after[0] == pytest.approx((end - start) / 3, abs=2e-5 * max(1, end))
        assert before[0] == pytest.approx((start - end) / 3, abs=2e-5 * max(1, end))
        u = (at - start) / (end - start)
        inside = (u >= -1e-6) & (u <= 1 + 1e-6)
        u = u[inside]
        points = (first, first + after[1], last + before[1], last)
        shares = ((1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u * u * (1 - u), u**3)
        found[inside] = sum(p * s for p, s in zip(points, shares, strict=True))
    return found


def godot(content, animation):
    text = content.decode()
    assert 'type = "value"' not in text
    arrays = r'"points": PoolRealArray\( (.*?) \),\n"times": PoolRealArray\( (.*?) \)'
    paths = re.findall(r'NodePath\("\.:blend_shapes/(\w+)"\)', text)
    for name, (points, times) in zip(paths, re.findall(arrays, text), strict=True):
        table = np.array(points.split(", "), float).reshape(-1, 5)
        at = np.array(times.split(", "), float) - animation.begins
        keys = [
            (t, value, (x, y), (z, w)) for t, (value, x, y, z, w) in zip(at, table, strict=True)
        ]
        yield name, bezier(keys, animation.times), len(keys)


class Point(SimpleNamespace):
    """A key of a curve in Blender, with what a script may set."""


def blender(content, animation):
    text = content.decode()
    take = json.loads(text.split('json.loads(r"""\n')[1].split('\n"""')[0])
    source = template(blender_file.__file__)[0]
    bend = "def bend" + source.split("def bend")[1].split("\n\n\n")[0]
    scope = {}
    exec(bend, scope)  # noqa: S102 our own template
    for channel in take["channels"]:
        pairs = zip(channel["frames"], channel["values"], strict=True)
        points = [Point(co=pair) for pair in pairs]
        scope["bend"](points, channel["slopes"])
        assert {point.interpolation for point in points} == {"BEZIER"}
        keys = [
            (
                *point.co,
                np.subtract(point.handle_left, point.co),
                np.subtract(point.handle_right, point.co),
            )
            for point in points
        ]
        at = 1 + animation.times * animation.fps
        yield channel["names"][0], bezier(keys, at), len(keys)


def model(content, animation):
    path = animation.model.with_name("written.glb")
    path.write_bytes(content)
    there = read_glb(path, b"")
    for name, values in zip(there.names, there.values.T, strict=True):
        yield name, np.interp(animation.times, there.times, values), 0


MAYA_CURVE = re.compile(
    r"anim (\w+) \1 (\w+) 0 0 (\d+);\nanimData \{\n  input time;\n  output unitless;\n"
    r"  weighted 0;\n  preInfinity constant;\n  postInfinity constant;\n  keys \{\n(.*?)  \}\n\}\n",
    re.DOTALL,
)
MAYA_RATES = {"game": 15, "film": 24, "pal": 25, "ntsc": 30, "show": 48, "palf": 50, "ntscf": 60}


def maya(content, animation):
    """Read the curves as Maya does: tangents by the angle over a frame, cubic between keys."""
    text = content.decode("ascii")
    head = dict(re.findall(r"^(\w+) ([\w.-]+);$", text.partition("anim ")[0], re.MULTILINE))
    assert (head["animVersion"], head["angularUnit"]) == ("1.1", "deg")
    rate = MAYA_RATES.get(head["timeUnit"], 1)
    rows = MAYA_CURVE.findall(text)
    assert "".join(found[0] for found in MAYA_CURVE.finditer(text)) == text[text.index("anim ") :]
    assert [int(number) for _, _, number, _ in rows] == list(range(len(rows)))
    for name, _, _, keys in rows:
        lines = [line.removesuffix(";").split() for line in keys.splitlines()]
        assert {(one[2], one[3], one[5], one[6]) for one in lines} == {("fixed", "fixed", "1", "0")}
        assert all((one[4] == "1") == (one[7] == one[9]) for one in lines)
        table = np.array([[one[n] for n in (0, 1, 7, 9)] for one in lines], float)
        times = table[:, 0] / rate - 1 / animation.fps - animation.offset
        slopes = np.tan(np.radians(table[:, 2:])) * animation.fps
        spline = Spline(np.arange(len(lines)), table[:, 1:2], slopes[:, :1], slopes[:, 1:])
        yield name, sample(times, spline, animation.times)[:, 0], len(lines)


TANGENTS = {"unity": unity, "godot": godot, "blender": blender, "glb": model, "maya": maya}
LINES = {"unreal", "smartbody", "usd"}


@pytest.mark.parametrize("error", ERRORS)
@pytest.mark.parametrize("name", TANGENTS)
def test_formats_with_tangents_stay_within_the_error(name, error, animation):
    chosen = replace(animation, export=ExportSettings(key_error=error))
    found = list(TANGENTS[name](bytes_of(name, chosen), chosen))
    assert {pose for pose, _, _ in found} == set(animation.poses)
    for pose, values, _ in found:
        assert np.abs(values - animation[pose]).max() <= error + 1e-4, pose
    lines = sum(
        len(c.frames)
        for c in replace(
            animation, export=ExportSettings(key_error=error, key_lines=True)
        ).keyframes(error)
    )
    assert sum(count for _, _, count in found) < lines / 1.5


@pytest.mark.parametrize("name", sorted(LINES))
def test_formats_without_tangents_have_fewer_lines(name, animation):
    coarse = bytes_of(name, replace(animation, export=ExportSettings(key_error=0.02)))
    assert len(coarse) < 0.9 * len(
        bytes_of(name, replace(animation, export=ExportSettings(key_error=0.001)))
    )


def test_lines_of_a_table_stay_within_the_error(animation):
    thin = replace(animation, export=ExportSettings(key_error=0.02)).thinned()
    assert len(thin) < len(animation)
    for pose, values in thin:
        kept = np.interp(animation.times, thin.times, values)
        assert np.abs(kept - animation[pose]).max() <= 0.02


@pytest.mark.parametrize(("fps", "unit"), [(24, "film"), (23.976, "sec"), (72, "sec")])
def test_times_in_maya_are_frames_of_a_named_rate_or_seconds(fps, unit, animation):
    rated = animation.source.performer.perform(animation.schedule, fps)
    chosen = replace(rated, export=ExportSettings(key_error=0.01, offset=1.5))
    content = bytes_of("maya", chosen)
    assert f"timeUnit {unit};".encode() in content
    for pose, values, _ in maya(content, chosen):
        assert np.abs(values - chosen[pose]).max() <= 0.01 + 1e-4, pose


def test_names_in_maya_are_those_of_attributes(animation):
    channels = (animation.columns[0]._replace(name="jaw open"), *animation.columns[1:])
    odd = replace(animation, channels=channels, model=None, export=ExportSettings(key_error=0.01))
    assert b"anim jaw_open jaw_open face 0 0 0;" in bytes_of("maya", odd)


def test_a_model_has_one_spline_for_the_shapes_of_a_mesh(animation):
    content = bytes_of("glb", replace(animation, export=ExportSettings(key_error=0.02)))
    document = json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])
    [take] = document["animations"]
    [sampler] = take["samplers"]
    clock, output = (document["accessors"][sampler[end]] for end in ("input", "output"))
    assert sampler["interpolation"] == "CUBICSPLINE"
    assert output["count"] == clock["count"] * 3 * len(animation.poses)
    assert clock["count"] < len(animation) / 3
    assert clock["max"] == [pytest.approx(float(animation.timeline[-1]))]


# Bad input

BAD = [0.0, -0.01, 0.51, float("nan"), float("inf")]


OUT_OF_RANGE = r"above 0 and at most 0\.5"


@pytest.mark.parametrize("error", BAD)
def test_an_error_out_of_range_is_refused_before_anything_is_written(error, animation, tmp_path):
    path = tmp_path / "line.anim"
    with pytest.raises(ll.LipsyncError, match=OUT_OF_RANGE):
        animation.save(path, keys=error)
    assert not path.exists()
    for name in (*TANGENTS, *LINES):
        with pytest.raises(ll.LipsyncError, match=OUT_OF_RANGE):
            bytes_of(name, replace(animation, export=ExportSettings(key_error=error)))


def test_an_animation_is_still_a_mapping_of_curves(animation):
    assert list(dict(animation)) == list(animation.poses)


def test_save_takes_keys(animation, tmp_path):
    for keys in (None, 0.02, 0.005):
        animation.save(tmp_path / f"{keys}.anim", keys=keys)
    sizes = [(tmp_path / f"{keys}.anim").stat().st_size for keys in (0.02, 0.005, None)]
    assert sizes == sorted(sizes)
    assert sizes[0] < sizes[2] / 1.8


LINE = ("-l", "english", "-c", "facefx", "--schedule", "line.json")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = [{"label": label, "start": n / 9, "end": (n + 1) / 9} for n, label in enumerate(LABELS)]
    (tmp_path / "line.json").write_text(json.dumps({"phonemes": rows}), "utf-8")
    return tmp_path


def test_run_writes_keys(cli, folder):
    assert cli("run", *LINE, "--keys", "0.02", "-o", "few.anim").code == 0
    assert cli("run", *LINE, "-o", "many.anim").code == 0
    few, many = ((folder / name).stat().st_size for name in ("few.anim", "many.anim"))
    assert few < many / 1.8


@pytest.mark.parametrize("error", ["0", "-1", "nan", "0.6", "inf"])
def test_run_refuses_an_error_out_of_range(cli, folder, error):
    ended = cli("run", *LINE, "--keys", error, "-o", "line.anim")
    assert ended.code == 2
    assert "--keys" in ended.err
    assert "above 0 and at most 0.5 (--keys 0.01)" in ended.err
    assert not (folder / "line.anim").exists()
