"""Models are read by name, and a file that is no model is reported with its cure."""

import struct

import pytest
from glb_files import FACE, OTHER_CHUNK, SHAPES, document_of, glb, model_of

from lipsync_lang.base.errors import ModelError
from lipsync_lang.faces.rigs.model import movable_nodes, read_model


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
    assert {mesh.name: mesh.shapes for mesh in model.meshes} == {
        "Face": SHAPES,
        "Teeth (mesh 1)": ("open",),
        "mesh 2": ("a", "b", "c"),
        "Bare": ("target 0", "target 1", "target 2"),
        "Teeth (mesh 4)": ("target 0", "target 1", "target 2"),
    }
    assert model.nodes == ("Jaw", "Jaw")
    assert model.path.name == "model.glb"


def test_the_binary_part_is_not_read_for_names(put, monkeypatch):
    from lipsync_lang.faces.rigs import container

    monkeypatch.setattr(container, "read_chunk", None)
    assert read_model(put(FACE)).meshes


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
    "blender": (b"\x28\xb5\x2f\xfd", "a compressed Blender file; .*File > Export > glTF 2.0"),
    "maya": (b"//Maya ASCII 2024", "a Maya file; export the model as GLB .* or VRM"),
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


@pytest.mark.parametrize(("children", "moves"), [([], False), ([1], False), ([1, 3], True)])
def test_a_face_stays_if_its_turn_would_leave_its_eyes_or_teeth_behind(children, moves):
    nodes = [
        {"name": "Head", "mesh": 0, "children": children}, {"name": "eyes", "mesh": 1},
        {"name": "teeth", "mesh": 1}, {"name": "mouth", "children": [2]}, {"name": "neck"},
    ]  # fmt: skip
    meshes = [{"primitives": [{"targets": [{}, {}]}]}, {"primitives": [{"targets": [{}]}]}]
    names = movable_nodes({"nodes": nodes, "meshes": meshes}).values()
    assert ("Head" in names) == moves
    assert {"eyes", "teeth", "mouth", "neck"} <= {*names}
