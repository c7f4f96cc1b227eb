"""GLB: written files are read back, and the content of a user's file is kept."""

import json
from base64 import b64encode
from copy import deepcopy

import numpy as np
import pytest
from glb_files import (
    BINARY,
    FACE,
    OTHER_CHUNK,
    SHAPES,
    SLIDE,
    document_of,
    glb,
    mesh,
    model_of,
    parts,
    rich,
    save,
    tracks,
)
from places import ROOT

import lipsync_lang as ll
from lipsync_lang.base.errors import ModelError, OutputError
from lipsync_lang.faces.rigs import model as rigs_model
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.model import read_model


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


SHIPPED = sorted(ROOT.glob("posesets/*/model.glb"))


def check_real(animate, path):
    """Write noise on every shape of a real model's first mesh, and read it back."""
    before, chunks = parts(path.read_bytes())
    shapes = read_model(path).meshes[0].shapes
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


# What cannot be written


def test_more_than_a_glb_holds_is_refused(animate, monkeypatch, tmp_path):
    from lipsync_lang.faces.rigs import container

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
    assert read_model(path).meshes[0].shapes == SHAPES
    with pytest.raises(
        ModelError, match=r"model.gltf: keeps a part in another file .* in one file"
    ):
        save(animate(path))
