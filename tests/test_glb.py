"""Models and GLB: written files are read back, and the content of a user's file is kept."""

import json
import math
import struct
from base64 import b64encode
from copy import deepcopy
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.animations.glb import write_glb
from lipsync_lang.errors import ModelError, OutputError
from lipsync_lang.rigs import model as rigs_model
from lipsync_lang.rigs.channel import Channel
from lipsync_lang.rigs.model import read_model

JSON_CHUNK, BINARY_CHUNK, OTHER_CHUNK = 0x4E4F534A, 0x004E4942, 0x12345678
SHAPES = ("open", "wide", "Lips_Up")
POSES = ("open", "wide")

# A model of our own, with more in it than we know


def chunk(kind, data):
    padded = data + (b" " if kind == JSON_CHUNK else b"\0") * (-len(data) % 4)
    return struct.pack("<2I", len(padded), kind) + padded


def glb(document, *chunks):
    text = document if isinstance(document, bytes) else json.dumps(document).encode()
    body = chunk(JSON_CHUNK, text) + b"".join(chunk(*one) for one in chunks)
    return struct.pack("<4s2I", b"glTF", 2, 12 + len(body)) + body


def mesh(name, shapes, **rest):
    targets = [{"POSITION": 1 + number} for number in range(len(shapes))]
    primitive = {"attributes": {"POSITION": 0}, "indices": 4, "targets": targets}
    row = {"primitives": [primitive], "extras": {"targetNames": list(shapes)}, **rest}
    return row | {"name": name} if name else row


def document_of(*meshes, **rest):
    """Return a document of a triangle with three shapes, and a node for each mesh."""
    points = [[0, 0, 0], [1, 1, 0]]
    view = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
    rows = [view | {"byteOffset": 36 * n, "min": points[0], "max": points[1]} for n in range(4)]
    index = {"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}
    names = [one.get("name", f"node {n}") for n, one in enumerate(meshes)]
    return {
        "asset": {"version": "2.0", "generator": "a test", "copyright": "ours"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(meshes)))}],
        "nodes": [{"name": name, "mesh": n} for n, name in enumerate(names)],
        "meshes": list(meshes),
        "accessors": [*rows, index],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 144, "byteStride": 12},
            {"buffer": 0, "byteOffset": 144, "byteLength": 3, "target": 34963},
        ],
        "buffers": [{"byteLength": 147}],
        **rest,
    }


BINARY = np.tile(np.array([0, 0, 0, 1, 0, 0, 0, 1, 0], "<f4"), 4).tobytes() + bytes([0, 1, 2])


def model_of(document, *chunks):
    return glb(document, (BINARY_CHUNK, BINARY), *chunks)


FACE = document_of(mesh("Face", SHAPES), mesh("Teeth", ("open",)))


def rich():
    """Return a document with fields of all kinds, and unknown fields."""
    document = deepcopy(FACE)
    document["meshes"][0] |= {"weights": [0, 0.25, 0.5]}
    document["nodes"] += [
        {"name": "Jaw", "rotation": [0, 0, 0, 1.0], "vendor": {"deep": [1, 2.0, None]}},
        {"name": "Face again", "mesh": 0, "weights": [0, 0.125, 1], "extras": {"é": "\ud800"}},
    ]
    document["animations"] = [
        {
            "name": "hello",
            "channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}}],
            "samplers": [{"input": 5, "output": 6}],
        }
    ]
    view = {"bufferView": 0, "componentType": 5126, "count": 1}
    document["accessors"] += [
        view | {"type": "SCALAR", "min": [0], "max": [0]},
        view | {"type": "VEC3"},
    ]
    document |= {
        "extensionsUsed": ["EXT_ours"],
        "extensions": {"EXT_ours": {"é": [1e-05, 1, 1.0, -0.0, True, None]}},
        "vendor": {"top": 12345678901234567890},
        "extras": {"日本": "語"},
    }
    document["bufferViews"][0]["extensions"] = {"EXT_ours": {"buffer": 0}}
    document["buffers"][0]["extras"] = {"kept": True}
    document["asset"]["extras"] = {"kept": True}
    return document


@pytest.fixture
def put(tmp_path):
    """Write a model, as bytes or as a document, and return its path."""

    def written(content, name="model.glb"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else model_of(content))
        return path

    return written


@pytest.fixture
def animate(put):
    """Return an animation of noise on a model."""

    def animated(content, columns=POSES, frames=20, first=-0.25, **rest):
        named = tuple(c if isinstance(c, str) else c.name for c in columns)
        channels = () if named == tuple(columns) else tuple(columns)
        weights = np.random.default_rng(0).random((frames, len(named)))
        times = first + np.arange(frames) / 60
        schedule = rest.pop("schedule", ll.Schedule(("P",), (0, 0.1)))
        path = content if hasattr(content, "suffix") else put(content)
        rest = {"channels": channels, "model": path} | rest
        return Animation(times, named, weights, 60, schedule, **rest)

    return animated


# Reading it back


def parts(content):
    """Return the document of a GLB, and its other chunks."""
    magic, version, length = struct.unpack_from("<4s2I", content)
    assert (magic, version, length) == (b"glTF", 2, len(content))
    found, start = [], 12
    while start < length:
        size, kind = struct.unpack_from("<2I", content, start)
        assert size % 4 == start % 4 == 0
        found.append((kind, content[start + 8 : start + 8 + size]))
        start += 8 + size
    assert found[0][0] == JSON_CHUNK
    return json.loads(found[0][1].decode("utf-8")), found[1:]


def save(animation):
    out = BytesIO()
    write_glb(animation, out)
    return out.getvalue()


def test_a_model_that_many_lines_are_written_into_is_read_once(put, animate, monkeypatch):
    monkeypatch.setattr(rigs_model, "SETTLED_SECONDS", 0)
    path, reads = put(rich()), []
    monkeypatch.setattr(
        rigs_model, "read_model", lambda path, **k: reads.append(path) or read_model(path, **k)
    )
    contents = {save(animate(path)) for _ in range(5)}
    assert len(contents) == len(reads) == 1
    put(FACE)  # another size: the file is another one
    document, _ = parts(save(animate(path)))
    assert len(reads) == 2
    assert "vendor" not in document


def test_a_model_changed_a_moment_ago_is_read_again(put, animate):
    before = put(FACE)
    save(animate(before))
    after = deepcopy(FACE)
    after["asset"]["generator"] = "b test"  # of the same size, perhaps in the same tick
    put(after)
    document, _ = parts(save(animate(before)))
    assert document["asset"]["generator"] == "b test"


def values(document, binary, number):
    row = document["accessors"][number]
    view = document["bufferViews"][row["bufferView"]]
    assert view["buffer"] == 0
    start = view["byteOffset"] + row["byteOffset"]
    assert start % 4 == 0
    wide = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[row["type"]]
    assert row["byteOffset"] + 4 * row["count"] * wide <= view["byteLength"]
    array = np.frombuffer(binary, "<f4", row["count"] * wide, start)
    return array if wide == 1 else array.reshape(-1, wide)


def tracks(content):
    """Return the last animation: its row, times, and {(node, path): values}."""
    document, ((kind, binary), *_) = parts(content)
    assert kind == BINARY_CHUNK
    assert document["buffers"][0]["byteLength"] <= len(binary)
    animation = document["animations"][-1]
    found, inputs, driven = {}, set(), set()
    for one in animation["channels"]:
        sampler = animation["samplers"][one["sampler"]]
        assert sampler["interpolation"] == "LINEAR"
        inputs.add(sampler["input"])
        curve = values(document, binary, sampler["output"])
        target = one["target"]
        assert (target["node"], target["path"]) not in driven
        driven.add((target["node"], target["path"]))
        node = document["nodes"][target["node"]].get("name")
        found[node, target["path"]] = curve
    (shared,) = inputs
    times = values(document, binary, shared)
    row = document["accessors"][shared]
    assert (row["min"], row["max"]) == ([times[0]], [times[-1]])
    shaped = {k: v.reshape(len(times), -1) if k[1] == "weights" else v for k, v in found.items()}
    return animation, times, shaped


# What is written


def test_weights_are_read_back_to_the_last_bit(animate):
    animation = animate(FACE)
    row, times, found = tracks(save(animation))
    np.testing.assert_array_equal(times, (animation.times + 0.25).astype("<f4"))
    assert set(found) == {("Face", "weights"), ("Teeth", "weights")}
    expected = animation.weights.astype("<f4")
    np.testing.assert_array_equal(found["Face", "weights"][:, :2], expected)
    assert not found["Face", "weights"][:, 2].any()
    np.testing.assert_array_equal(found["Teeth", "weights"], expected[:, :1])
    assert row["extras"] == {"audio_start": 0.25}
    assert row["name"] == "lipsync"


def test_an_animation_that_starts_late_is_not_shifted(animate):
    animation = animate(FACE, first=9.75)
    row, times, _ = tracks(save(animation))
    assert times[0] == 9.75
    assert row["extras"] == {"audio_start": 0}


def test_times_that_float32_cannot_tell_apart_are_dropped(animate):
    animation = animate(FACE, frames=400, first=80_000)
    _, times, found = tracks(save(animation))
    assert 100 < len(times) == len(found["Face", "weights"])
    assert (np.diff(times) > 0).all()


def test_all_of_the_users_file_is_kept(animate):
    before = rich()
    content = model_of(before, (OTHER_CHUNK, b"abcde"))
    after, ((_, binary), (kind, other)) = parts(save(animate(content)))
    assert binary.startswith(BINARY)
    assert (kind, other) == (OTHER_CHUNK, b"abcde\0\0\0")
    assert after["buffers"][0].pop("byteLength") > before["buffers"][0].pop("byteLength")
    added = {"accessors": 4, "bufferViews": 1, "animations": 1}
    for name, count in added.items():
        assert len(after[name]) == len(before[name]) + count
        after[name] = after[name][:-count]
    assert after == before
    assert json.dumps(after) == json.dumps(before), "1 and 1.0, and the order, are kept too"


def test_shapes_that_nothing_drives_rest_where_the_node_or_the_mesh_says(animate):
    _, _, found = tracks(save(animate(rich(), columns=("open",))))
    np.testing.assert_array_equal(np.unique(found["Face", "weights"][:, 1:], axis=0), [[0.25, 0.5]])
    again = np.unique(found["Face again", "weights"][:, 1:], axis=0)
    np.testing.assert_array_equal(again, [[0.125, 1]])


def test_nodes_that_show_one_mesh_share_its_curve(animate):
    document = deepcopy(FACE)
    document["nodes"] += [{"name": "twin", "mesh": 0}, {"name": "idle"}]
    row, _, found = tracks(save(animate(document)))
    assert len(row["samplers"]) == 2
    np.testing.assert_array_equal(found["Face", "weights"], found["twin", "weights"])


def test_meshes_that_no_pose_moves_are_left_alone(animate):
    _, _, found = tracks(save(animate(FACE, columns=("wide",))))
    assert set(found) == {("Face", "weights")}


def test_a_channel_may_name_its_mesh(animate):
    columns = (Channel("open", mesh="Teeth"), Channel("wide"))
    animation = animate(FACE, columns=columns)
    _, _, found = tracks(save(animation))
    expected = animation.weights.astype("<f4")
    np.testing.assert_array_equal(found["Teeth", "weights"], expected[:, :1])
    np.testing.assert_array_equal(found["Face", "weights"][:, 1], expected[:, 1])
    assert not found["Face", "weights"][:, 0].any()


def test_models_may_spell_a_shape_otherwise(animate):
    columns = (Channel("lipsUp"), Channel("mouth", names=("wid*",)))
    animation = animate(FACE, columns=columns)
    found = tracks(save(animation))[2]["Face", "weights"]
    np.testing.assert_array_equal(found[:, [2, 1]], animation.weights.astype("<f4"))


def test_of_two_columns_for_one_shape_the_larger_counts(animate):
    document = document_of(mesh("Face", ("smile",)))
    animation = animate(document, columns=(Channel("smileLeft"), Channel("smileRight")))
    found = tracks(save(animation))[2]["Face", "weights"]
    np.testing.assert_array_equal(found[:, 0], animation.weights.max(axis=1).astype("<f4"))


@pytest.mark.parametrize(
    ("schedule", "name"),
    [
        (ll.Schedule(("P",), (0, 1), words=(ll.Word("hi", 0, 1),)), "hi"),
        (ll.Schedule(("P",), (0, 1), source="lines/hi there.json"), "hi there"),
        (ll.Schedule(("P",), (0, 1), words=(ll.Word("hello", 0, 1),)), "hello 2"),
        (ll.Schedule(("P",), (0, 1), words=(ll.Word("é\ud800", 0, 1),)), "é\ud800"),
        (ll.Schedule(("P",), (0, 1)), "lipsync"),
    ],
)
def test_animations_are_told_apart_by_name(schedule, name, animate, put):
    once = save(animate(rich(), schedule=schedule))
    assert tracks(once)[0]["name"] == name
    twice = save(animate(put(once, "once.glb"), schedule=schedule))
    names = [row["name"] for row in parts(twice)[0]["animations"]]
    assert names[:2] == ["hello", name]
    assert len(set(names)) == 3


def test_a_model_may_be_written_over_itself(animate):
    animation = animate(FACE)
    content = save(animation)
    animation.save(animation.model)
    assert animation.model.read_bytes() == content


def test_data_is_made_for_a_file_that_has_none(animate):
    document = {key: value for key, value in FACE.items() if key in {"asset", "meshes", "nodes"}}
    bare, extra = glb(document), glb(document, (OTHER_CHUNK, b"kept"))
    for content in (bare, extra, json.dumps(document).encode()):
        out = save(animate(content))
        _, _, found = tracks(out)
        assert found["Face", "weights"].shape == (20, 3)
        assert (b"kept" in out) == (content is extra)


def test_data_within_the_json_moves_to_the_binary_part(animate):
    document = deepcopy(FACE)
    uri = "data:application/octet-stream;base64," + b64encode(BINARY).decode()
    document["buffers"][0]["uri"] = uri
    out = save(animate(json.dumps(document).encode()))
    after, ((_, binary),) = parts(out)
    assert "uri" not in after["buffers"][0]
    assert binary.startswith(BINARY)


SHIPPED = sorted(Path(__file__).parents[1].glob("posesets/*/model.glb"))


def check_real(animate, path):
    """Write noise on every shape of a real model's first mesh, and read it back."""
    before, chunks = parts(path.read_bytes())
    shapes = next(iter(read_model(path).shapes.values()))
    animation = animate(path, columns=shapes)
    content = save(animation)
    _, times, found = tracks(content)
    assert len(times) == len(animation.times)
    face = next(iter(found.values()))
    np.testing.assert_array_equal(face, animation.weights.astype("<f4"))
    after, ((_, binary), *_) = parts(content)
    assert binary.startswith(chunks[0][1])
    changed = {"accessors", "bufferViews", "buffers", "animations"}
    assert {k: v for k, v in after.items() if k not in changed} == {
        k: v for k, v in before.items() if k not in changed
    }


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.parent.name)
def test_our_own_models_are_animated(path, animate):
    check_real(animate, path)


def test_a_real_head_is_animated(animate, data):
    path = data / "rigs" / "head_arkit52_oculus15.glb"
    if not path.is_file():
        pytest.skip(f"there is no {path}")
    check_real(animate, path)


# Bones

JAW = (Channel("open"), Channel("jaw", node="Jaw", rotation=(2, 0, 0)))
SLIDE = (Channel("jaw", node="Jaw", translation=(0, -0.5, 1)),)


def with_jaw(**pose):
    document = deepcopy(FACE)
    document["nodes"].append({"name": "Jaw", **pose})
    document["scenes"][0]["nodes"].append(2)
    return document


def rotated(quaternion, vector):
    """Return vectors turned by (T, 4) quaternions."""
    xyz, w = quaternion[:, :3].astype(float), quaternion[:, 3:].astype(float)
    return vector + 2 * np.cross(xyz, np.cross(xyz, vector) + w * vector)


def test_a_bone_turns_about_its_axis_in_degrees(animate):
    animation = animate(with_jaw(), columns=JAW)
    turn = tracks(save(animation))[2]["Jaw", "rotation"]
    angle = np.radians(animation["jaw"])
    there = np.column_stack([0 * angle, np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(rotated(turn, np.array([0, 1, 0])), there, atol=1e-6)


def test_a_model_of_bones_alone_is_animated(animate):
    document = with_jaw()
    for one in document["meshes"]:
        one.pop("extras", None)
        for part in one["primitives"]:
            part.pop("targets", None)
    animation = animate(document, columns=JAW)
    assert list(tracks(save(animation))[2]) == [("Jaw", "rotation")]
    with pytest.raises(ModelError, match="no mesh has morph targets"):
        save(animate(document))


def test_what_a_model_does_not_show_is_told(animate):
    columns = (Channel("wide"), Channel("nowhere"), Channel("tail", node="Tail"), *JAW)
    animation = animate(with_jaw(), columns=columns)
    save(animation)
    assert list(WRITERS["glb"].remarks(animation)) == [
        f"{animation.model} has nothing for nowhere, Tail"
    ]
    still = replace(animation, weights=animation.weights * 0)
    assert not list(WRITERS["glb"].remarks(still))


def test_a_bone_turns_about_the_axis_as_it_rests(animate):
    quarter = math.sqrt(0.5)  # a quarter turn about z takes x to y
    animation = animate(with_jaw(rotation=[0, 0, quarter, quarter]), columns=JAW)
    turn = tracks(save(animation))[2]["Jaw", "rotation"]
    still = np.tile([0, 1, 0], (20, 1))
    np.testing.assert_allclose(rotated(turn, np.array([1, 0, 0])), still, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(turn, axis=1), 1, atol=1e-6)


def test_a_bone_moves_from_where_it_rests(animate):
    animation = animate(with_jaw(translation=[1, 2, 3]), columns=SLIDE)
    _, _, found = tracks(save(animation))
    expected = [1, 2, 3] + animation["jaw"][:, None] * [0, -0.5, 1]
    assert set(found) == {("Jaw", "translation")}
    np.testing.assert_allclose(found["Jaw", "translation"], expected, atol=1e-6)


def test_two_channels_may_turn_and_move_one_bone(animate):
    columns = (
        *JAW[1:],
        Channel("side", node="Jaw", rotation=(0, 1, 0)),
        Channel("out", node="Jaw", translation=(1, 0, 0)),
        Channel("down", node="Jaw", translation=(0, 1, 0)),
    )
    animation = animate(with_jaw(), columns=columns)
    _, _, found = tracks(save(animation))
    moved = np.column_stack([animation["out"], animation["down"], np.zeros(20)])
    np.testing.assert_allclose(found["Jaw", "translation"], moved, atol=1e-6)
    assert found["Jaw", "rotation"].shape == (20, 4)


def matrix_of(quaternion, scale, translation):
    axes = [rotated(np.array([quaternion]), np.eye(3)[n])[0] * scale[n] for n in range(3)]
    return [*axes[0], 0, *axes[1], 0, *axes[2], 0, *translation, 1]


@given(
    st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: math.hypot(*q) > 0.1),
    st.lists(st.floats(0.1, 10), min_size=3, max_size=3),
    st.booleans(),
)
def test_a_bone_with_a_matrix_is_parted(quaternion, scale, mirrored):
    from lipsync_lang.rigs.transforms import parts as part

    unit = np.array(quaternion) / math.hypot(*quaternion)
    scale[0] *= -1 if mirrored else 1
    matrix = np.reshape(matrix_of(unit, scale, [1, 2, 3]), (4, 4))
    found = part(matrix)
    again = matrix_of(found.rotation, found.scale, found.translation)
    np.testing.assert_allclose(np.ravel(matrix), again, atol=1e-9)


def test_a_parted_bone_is_kept_in_meaning(animate):
    matrix = matrix_of(np.array([0, 0, math.sqrt(0.5), math.sqrt(0.5)]), [2, 2, 2], [1, 2, 3])
    animation = animate(with_jaw(matrix=matrix, extras={"a": 1}), columns=JAW)
    document, _ = parts(save(animation))
    node = document["nodes"][2]
    assert "matrix" not in node
    assert node["extras"] == {"a": 1}
    assert node["translation"] == [1, 2, 3]
    np.testing.assert_allclose(node["scale"], [2, 2, 2])
    untouched, _ = parts(save(animate(with_jaw(matrix=matrix))))
    assert untouched["nodes"][2]["matrix"] == matrix


SHEARED = [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
FLAT = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


@pytest.mark.parametrize(
    ("pose", "columns", "message"),
    [
        ({"matrix": SHEARED}, JAW, "node 'Jaw' is sheared or flat, .*; apply its transform"),
        ({"matrix": FLAT}, SLIDE, "node 'Jaw' is sheared or flat, .*; apply its transform"),
        ({"matrix": [1]}, JAW, "matrix of node 'Jaw': not a list of 16 numbers; .* export"),
        ({"matrix": "x"}, JAW, "matrix of node 'Jaw': not a list of 16 numbers; .* export"),
        ({"rotation": [0, 0, 0, 0]}, JAW, "rotation of node 'Jaw': is 0 throughout; .* export"),
        ({"rotation": [0, 0, True, 1]}, JAW, "rotation of node 'Jaw': not a list of 4 numbers"),
        ({"translation": [0, None, 1]}, SLIDE, "translation of node 'Jaw': not a list of 3"),
        ({"mesh": 0, "weights": [1]}, POSES, "weights of node 2: not a list of 3 numbers"),
    ],
)
def test_bones_that_cannot_be_driven_are_told(pose, columns, message, animate):
    with pytest.raises(ModelError, match=rf"model\.glb: {message}"):
        save(animate(with_jaw(**pose), columns=columns))


def test_an_axis_needs_a_direction(animate):
    columns = (Channel("jaw", node="Jaw", rotation=(0, 0, 0)),)
    with pytest.raises(OutputError, match=r"'jaw': a rotation about \(0, 0, 0\) has no effect; gi"):
        save(animate(with_jaw(), columns=columns))


# What cannot be written


def test_more_than_a_glb_holds_is_refused(animate, monkeypatch, tmp_path):
    from lipsync_lang.rigs import container

    monkeypatch.setattr(container, "LARGEST_WRITTEN", 1000)
    with pytest.raises(OutputError, match="is too long for one GLB; write fewer frames per second"):
        animate(FACE).save(tmp_path / "line.glb")
    assert [path.name for path in tmp_path.iterdir()] == ["model.glb"]


def test_without_a_model_nothing_is_written(animate, tmp_path):
    animation = animate(FACE, model=None)
    with pytest.raises(
        OutputError,
        match=r"no model to animate; name one .`model`., or state "
        r"`mod",
    ):
        animation.save(tmp_path / "line.glb")
    assert [path.name for path in tmp_path.iterdir()] == ["model.glb"]


@pytest.mark.parametrize("columns", [("smile", "frown"), SLIDE, (Channel("open", mesh="Tongue"),)])
def test_where_no_name_is_known_both_sides_are_told(columns, animate, tmp_path):
    animation = animate(FACE, columns=columns)
    named = "smile, frown" if columns[0] == "smile" else columns[0].node or columns[0].name
    with pytest.raises(OutputError, match=rf"it has open, wide, Lips_Up; .* {named}\. Give .* rig"):
        animation.save(tmp_path / "line.glb")
    assert [path.name for path in tmp_path.iterdir()] == ["model.glb"]


def test_meshes_that_no_node_shows_cannot_be_moved(animate):
    with pytest.raises(OutputError, match="no shape has the name"):
        save(animate(FACE | {"nodes": [{"name": "empty"}]}))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"buffers": [{"byteLength": 147, "uri": "a.bin"}]},
            r"in another file \('a.bin'\); export",
        ),
        ({"buffers": [{"byteLength": 147, "uri": 5}]}, r"in another file \('5'\); export"),
        ({"buffers": [{"byteLength": 147}, {"uri": "b.bin"}]}, r"in another file \('b.bin'\)"),
        ({"images": [{"uri": "skin.png"}]}, r"keeps a part in another file \('skin.png'\); export"),
        ({"buffers": [{"byteLength": 147, "uri": "data:,%"}]}, "binary data is not Base64"),
        ({"buffers": [{"byteLength": 147, "uri": "data:,é"}]}, "binary data is not Base64"),
        (
            {"buffers": [{"byteLength": 147, "uri": "data:;base64,AAAA"}]},
            "3 bytes of binary data, ",
        ),
        (
            {"buffers": [{"byteLength": 149}]},
            "148 bytes of binary data, fewer than it states; .* exp",
        ),
        (
            {"buffers": [{"byteLength": "9"}]},
            "148 bytes of binary data, fewer than it states; .* exp",
        ),
    ],
)
def test_data_that_is_not_there_is_told(change, message, animate):
    with pytest.raises(ModelError, match=message):
        save(animate(FACE | change))


def test_json_alone_with_data_beside_it_can_be_read_but_not_written(animate, put):
    document = FACE | {"buffers": [{"byteLength": 147, "uri": "model.bin"}]}
    path = put(json.dumps(document).encode(), "model.gltf")
    assert read_model(path).shapes["Face"] == SHAPES
    with pytest.raises(
        ModelError, match=r"model.gltf: keeps a part in another file .* in one file"
    ):
        save(animate(path))


# Names


def test_names_are_read(put):
    primitive = FACE["meshes"][0]["primitives"][0]
    named = {"extras": {"targetNames": ["a", "b", "c"]}}
    rows = (
        *FACE["meshes"],
        {"primitives": [primitive | named]},
        {"name": "Bare", "primitives": [primitive]},
        {"name": "Teeth", "primitives": [primitive], "extras": {"other": 1}},
        {"name": "Hat", "primitives": [{"attributes": {}}]},
    )
    model = read_model(put(document_of(*rows) | {"nodes": [{}, {"name": "Jaw"}, {"name": "Jaw"}]}))
    assert model.shapes == {
        "Face": SHAPES,
        "Teeth (mesh 1)": ("open",),
        "mesh 2": ("a", "b", "c"),
        "Bare": ("target 0", "target 1", "target 2"),
        "Teeth (mesh 4)": ("target 0", "target 1", "target 2"),
    }
    assert model.nodes == ("Jaw", "Jaw")
    assert model.path.name == "model.glb"


def test_the_binary_part_is_not_read_for_names(put, monkeypatch):
    from lipsync_lang.rigs import container

    monkeypatch.setattr(container, "read_chunk", None)
    assert read_model(put(FACE)).shapes


# What is no model


def whole(**change):
    """Return a file with parts of its document replaced."""
    return model_of(FACE | change)


def one_mesh(**change):
    return whole(meshes=[FACE["meshes"][0] | change, FACE["meshes"][1]])


PRIMITIVE = FACE["meshes"][0]["primitives"][0]
GOOD = model_of(FACE)
NOT_MODELS = {
    "nothing": (b"", "is not GLB; it seems to be empty; export the model as GLB"),
    "fbx": (b"Kaydara FBX Binary  \0\x1a", "seems to be an FBX file; export the model as GLB"),
    "ascii fbx": (
        b"; FBX 7.3.0 project file\n",
        "seems to be an FBX file; export the model as GLB",
    ),
    "obj": (
        b"# Blender\nmtllib a.mtl\no Cube\nv 1 1 1\n",
        "an OBJ file, which has no morph targets",
    ),
    "png": (b"\x89PNG\r\n\x1a\n", "seems to be a PNG image"),
    "zip": (b"PK\x03\x04", "seems to be a zip archive; unpack it first"),
    "lfs": (b"version https://git-lfs.github.com/spec/v1\n", "a Git LFS pointer; .*git lfs pull"),
    "html": (b"<!doctype HTML><html>", "seems to be a web page; download the file itself"),
    "noise": (b"\x00\x01", "is not GLB; it seems to be something else; export"),
    "blank": (b"\n\n", "is not GLB; it seems to be something else; export"),
    "json": (b'{"a": 1}', "is JSON, but not glTF; export the model as GLB"),
    "torn json": (b'{"a": ', "its JSON cannot be read: .*; it is damaged"),
    "magic": (b"glTF", "ends after 4 bytes; copy or download it again"),
    "cut": (GOOD[:-7], rf"ends after {len(GOOD) - 7} of {len(GOOD)} bytes; copy or download"),
    "longer": (GOOD + b"abcd", rf"has {len(GOOD) + 4} bytes, but its header states {len(GOOD)}"),
    "version": (GOOD[:4] + b"\1" + GOOD[5:], "is GLB version 1; export .*version 2"),
    "huge part": (
        GOOD[:12] + b"\xf0\xff\xff\xff" + GOOD[16:],
        "in the middle of a part of 42949672",
    ),
    "first part": (
        GOOD[:16] + b"BIN\0" + GOOD[20:],
        "does not begin with JSON, which GLB requires",
    ),
    "torn part": (
        struct.pack("<4s2I", b"glTF", 2, len(GOOD) + 3) + GOOD[12:] + b"abc",
        "middle of",
    ),
    "parts": (glb(FACE, *[(OTHER_CHUNK, b"")] * 2000), "has more than 1000 parts"),
    "no json": (glb(b"{]"), "its JSON cannot be read: .*; it is damaged; export"),
    "latin": (glb('{"é": 1}'.encode("latin-1")), r"its JSON is not UTF-8 text \(byte 2\)"),
    "utf-16": (glb('{"a": 1}'.encode("utf-16")), r"its JSON is not UTF-8 text \(byte 0\)"),
    "deep": (glb(b'{"a": ' + b"[" * 100_000), "its JSON is nested too deep for a model"),
    "nan": (glb(b'{"a": NaN}'), "its JSON cannot be read: NaN is not a number"),
    "infinite": (glb(b'{"a": 1e999}'), "its JSON cannot be read: 1e999 is not a number"),
    "digits": (glb(b'{"a": %s}' % (b"9" * 5000)), "its JSON cannot be read: "),
    "list": (glb(b"[1]"), "is JSON, but not glTF"),
    "gltf 1": (whole(asset={"version": "1.0"}), "is glTF version 1.0; export .*version 2"),
    "asset": (whole(asset={"version": [2]}), r"is glTF version \[2\]; export"),
    "no meshes": (whole(meshes=[]), "has no meshes; export the model itself"),
    "meshes": (whole(meshes={"a": 1}), "its meshes are not a list of objects; it is damaged"),
    "mesh": (whole(meshes=[1]), "its meshes are not a list of objects; it is damaged"),
    "nodes": (whole(nodes=None), "its nodes are not a list of objects"),
    "node's mesh": (whole(nodes=[{"mesh": 2}]), "node 0 has a mesh that does not exist"),
    "node's name": (whole(nodes=[{"name": 2}]), "the name of node 0 is not text"),
    "mesh's name": (one_mesh(name=["a"]), "the name of a mesh is not text"),
    "primitives": (one_mesh(primitives=None), "the primitives of 'Face' are not a list of o"),
    "targets": (one_mesh(primitives=[PRIMITIVE | {"targets": 3}]), "the morph targets of 'Face'"),
    "two counts": (
        one_mesh(primitives=[PRIMITIVE, {}]),
        "'Face': its parts have different numbers",
    ),
    "names": (one_mesh(extras={"targetNames": [1, 2, 3]}), "'Face': .* not a list of texts"),
    "names' form": (one_mesh(extras={"targetNames": "abc"}), "'Face': .* not a list of texts"),
    "fewer names": (one_mesh(extras={"targetNames": ["a"]}), "'Face': has 3 morph .* but 1 names"),
    "repeats": (
        one_mesh(extras={"targetNames": ["a", "b", "a"]}),
        "'Face': several morph targets share a name: a; give every morph target a name of its own",
    ),
    "unnamed": (
        one_mesh(extras={"targetNames": ["a", " ", "c"]}),
        "its morph target 1 has no name",
    ),
    "weights": (one_mesh(weights=[0, 1]), "weights of 'Face': not a list of 3 numbers"),
    "large weights": (one_mesh(weights=[0, 1, 10**50]), "weights of 'Face': not a list of 3 num"),
    "no shapes": (
        whole(meshes=[{"name": "Hat", "primitives": [{}]}, {"primitives": []}], nodes=[]),
        r"no mesh has morph targets \(meshes: Hat, mesh 1\); export it with its shape keys",
    ),
}


@pytest.mark.parametrize(("content", "message"), NOT_MODELS.values(), ids=NOT_MODELS)
def test_what_is_no_model_is_told_and_how_to_mend_it(content, message, put):
    with pytest.raises(ModelError, match=rf"model\.glb: .*{message}"):
        read_model(put(content))


def test_models_that_cannot_be_opened_are_told(tmp_path):
    with pytest.raises(
        ModelError, match=r"gone\.glb: cannot be read: No such file.*; check the pa"
    ):
        read_model(tmp_path / "gone.glb")
    with pytest.raises(ModelError, match=r"cannot be read: Is a directory; check the path"):
        read_model(tmp_path)
    with pytest.raises(ModelError, match=r"cannot be read: .*null .*; check the path"):
        read_model(tmp_path / "a\0.glb")


def test_a_file_of_gigabytes_is_not_read(tmp_path):
    path = tmp_path / "huge.glb"
    with path.open("wb") as stream:
        stream.write(struct.pack("<4s2I", b"glTF", 2, 2**31))
        stream.truncate(2**31)
    with pytest.raises(ModelError, match=r"huge\.glb: is larger than 1 GB; export it with smaller"):
        read_model(path)


# Whatever a file holds, what comes of it is an animation or a message

ANYTHING = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-3, 5)
    | st.sampled_from([2**40, 10**400, 0.5, 1e300, -1e-300, "", "open", "x", "data:,", "é"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=4,
)


def places_in(value, path=()):
    """Yield the path of every value in a document."""
    if path:
        yield path
    rows = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in rows if isinstance(value, (dict, list)) else ():
        if isinstance(inner, (dict, list)):
            yield from places_in(inner, (*path, key))
        else:
            yield (*path, key)


RICH = rich()
RICH["nodes"][2]["translation"] = [0, 0, 1]
RICH["nodes"].append({"name": "Neck", "matrix": np.eye(4).ravel().tolist()})
PLACES = list(places_in(RICH))
ALL = (*JAW, *SLIDE, Channel("neck", node="Neck", rotation=(0, 0, 1)))


def survives(content, folder):
    """Write onto a model; either this works, or it raises an error for the user."""
    path = folder / "model.glb"
    path.write_bytes(content)
    weights = np.zeros((2, len(ALL)))
    schedule = ll.Schedule(("P",), (0, 0.1))
    named = tuple(channel.name for channel in ALL)
    animation = Animation(np.arange(2.0), named, weights, 1, schedule, channels=ALL, model=path)
    try:
        tracks(save(animation))
    except (ModelError, OutputError) as error:
        told = str(error)
    else:
        return
    assert told.startswith(str(path))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("models")


@given(st.data())
def test_no_value_in_a_document_is_trusted(folder, data):
    document = deepcopy(RICH)
    for _ in range(data.draw(st.integers(1, 3))):
        *way, last = data.draw(st.sampled_from(PLACES))
        holder = document
        try:
            for key in way:
                holder = holder[key]
            holder[last]
        except (TypeError, LookupError):
            continue  # an earlier change took the place away
        if data.draw(st.booleans()) or not isinstance(holder, (dict, list)):
            if isinstance(holder, (dict, list)):
                holder[last] = data.draw(ANYTHING)
        else:
            del holder[last]
    survives(model_of(document), folder)


@given(st.data())
def test_no_byte_of_a_file_is_trusted(folder, data):
    content = bytearray(model_of(RICH))
    for _ in range(data.draw(st.integers(1, 4))):
        low = data.draw(st.sampled_from([20, len(content)]))
        content[data.draw(st.integers(0, low - 1))] = data.draw(st.integers(0, 255))
    survives(bytes(content[: data.draw(st.sampled_from([None, -1, 20, 300]))]), folder)
