"""Models compressed by Draco or meshoptimizer: the same points, or an error message."""

import sys
from functools import partial

import numpy as np
import pytest
from test_video import FPS, Maker, animation_of

from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.base.errors import ModelError
from lipsync_lang.faces.rigs.accessors import Accessors
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.render.staging import staged
from lipsync_lang.studio.array_pack import ArrayPack
from lipsync_lang.studio.face_data import face_data

SIDE = 12
GRID = np.stack(np.mgrid[:SIDE, :SIDE], -1).reshape(-1, 2) / (SIDE - 1)
POINTS = np.column_stack([GRID - 0.5, np.sin(5 * GRID[:, 0])]).astype("f4")
FACING = np.tile(np.array([0.0, 0.6, 0.8], "f4"), (SIDE**2, 1))
MOVES = np.column_stack([0 * GRID, GRID[:, 1] ** 2]).astype("f4")
NUMBERS = np.arange(SIDE**2).reshape(SIDE, SIDE)
CORNERS = np.concatenate(
    [
        np.stack([NUMBERS[:-1, :-1], NUMBERS[1:, :-1], NUMBERS[:-1, 1:]], -1).reshape(-1, 3),
        np.stack([NUMBERS[1:, 1:], NUMBERS[:-1, 1:], NUMBERS[1:, :-1]], -1).reshape(-1, 3),
    ]
).astype("u4")
BOUND = 1 / 16000
"""Half a step of a position in 16 bits, and some rounding."""


@pytest.fixture(scope="module")
def meshopt():
    return pytest.importorskip("meshopt", reason="an extra: models")


@pytest.fixture(scope="module")
def draco():
    return pytest.importorskip("DracoPy", reason="an extra: models")


def accessor(maker, values, view, **rest):
    code = {"f4": 5126, "u4": 5125, "u2": 5123, "i2": 5122, "u1": 5121, "i1": 5120}
    shape = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[values.shape[1]]
    row = {"componentType": code[values.dtype.str[1:]], "count": len(values), "type": shape}
    place = {} if view is None else {"bufferView": view}
    maker.document["accessors"].append(row | place | rest)
    return len(maker.document["accessors"]) - 1


def plain(maker, values, **rest):
    values = np.ascontiguousarray(values)
    return accessor(maker, values, maker.view(values.tobytes()), **rest)


def face(path, maker, attributes, corners, moves, **rest):
    """Write a model of one mesh that moves; return its animation."""
    maker.document["nodes"] = [{"mesh": 0, **rest.pop("node", {})}]
    maker.mesh(attributes, ["up"], [{"POSITION": moves}], indices=corners, **rest)
    return animation_of(maker.write(path), Channel("up"))


@pytest.fixture
def reference(tmp_path):
    maker = Maker()
    attributes = {"POSITION": plain(maker, POINTS), "NORMAL": plain(maker, FACING)}
    attributes["TEXCOORD_0"] = plain(maker, GRID.astype("f4"))
    corners = plain(maker, CORNERS.reshape(-1, 1))
    moves = plain(maker, MOVES)
    return staged(face(tmp_path / "plain.glb", maker, attributes, corners, moves))


def same(scene, reference, bound):
    """Compare two scenes point for point, over time."""
    for seconds in (0.0, 0.5 / FPS, 1 / FPS):
        np.testing.assert_allclose(
            scene.points(seconds), reference.points(seconds), rtol=0, atol=bound
        )
    np.testing.assert_allclose(scene.normals, reference.normals, rtol=0, atol=0.02)
    np.testing.assert_allclose(scene.places, reference.places, rtol=0, atol=1e-3)
    assert edges(scene) == edges(reference)


def edges(scene):
    """List the triangles, each from its first corner on."""
    rows = [np.roll(row, -row.argmin()).tolist() for row in scene.triangles]
    return sorted(rows)


# meshoptimizer


class Packer:
    """Compressed views and their accessors, as gltfpack writes them."""

    def __init__(self, library, extension="EXT_meshopt_compression"):
        self.library, self.extension = library, extension
        self.maker = Maker()

    def add(self, values, rows=None, mode="ATTRIBUTES", kind="NONE", stride=None, **rest):
        """Add values whose stored rows may be longer, or in the form of a filter."""
        rows = np.ascontiguousarray(values if rows is None else rows)
        size = rows.nbytes // len(rows)
        data = self.library.encode_gltf_buffer(rows, mode)
        view = self.maker.view(data)
        packed = self.maker.document["bufferViews"][view]
        packed |= {"mode": mode, "filter": kind, "count": len(rows), "byteStride": size}
        own = {"buffer": 1, "byteLength": rows.nbytes, "extensions": {self.extension: packed}}
        self.maker.document["bufferViews"][view] = own | ({"byteStride": stride} if stride else {})
        return accessor(self.maker, values, view, **rest)

    def write(self, tmp_path, attributes, corners, moves, **rest):
        animation = face(tmp_path / "face.glb", self.maker, attributes, corners, moves, **rest)
        self.maker.document["buffers"].append({"byteLength": 9**9})  # the fallback has no data
        return animation


def packed_face(tmp_path, library, extension="EXT_meshopt_compression", change=lambda _: None):
    """Write the face with all views compressed, and a filter for most."""
    pack = Packer(library, extension)
    points = library.encode_filter_exp(POINTS, 20)
    moves = library.encode_filter_exp(MOVES, 20)
    facing = library.encode_filter_oct(np.column_stack([FACING, FACING[:, :1] * 0]), 4, 8)
    grid = np.rint(GRID * 65535).astype("u2")
    attributes = {
        "POSITION": pack.add(POINTS, points, kind="EXPONENTIAL"),
        "NORMAL": pack.add(
            FACING.astype("i1"), facing, kind="OCTAHEDRAL", stride=4, normalized=True
        ),
        "TEXCOORD_0": pack.add(grid, normalized=True),
    }
    corners = pack.add(CORNERS.reshape(-1, 1), mode="TRIANGLES")
    up = pack.add(MOVES, moves, kind="EXPONENTIAL")
    change(pack.maker.document)
    return pack.write(tmp_path, attributes, corners, up)


@pytest.mark.parametrize("extension", ["EXT_meshopt_compression", "KHR_meshopt_compression"])
def test_a_model_of_meshoptimizer_is_the_plain_model(tmp_path, meshopt, reference, extension):
    scene = staged(packed_face(tmp_path, meshopt, extension))
    same(scene, reference, BOUND)


@pytest.mark.parametrize(("kind", "most"), [("i2", 32767), ("u2", 65535)])
def test_quantised_points_and_shapes_are_placed_by_their_node(tmp_path, meshopt, kind, most):
    pack = Packer(meshopt)
    low, scale = POINTS.min(axis=0), float(np.ptp(POINTS, axis=0).max())
    points, moves = (np.rint((v / scale) * most) for v in (POINTS - low, MOVES))

    def stored(values, own, **rest):
        wide = np.column_stack([values, 0 * values[:, :1]]).astype(own)
        return pack.add(values.astype(own), wide, stride=8, **rest)

    base = stored(points, kind, normalized=True)
    up = stored(np.rint(moves / most * 32767), "i2", normalized=True)
    corners = pack.add(CORNERS.reshape(-1, 1), mode="INDICES")
    node = {"translation": low.tolist(), "scale": [scale] * 3}
    scene = staged(pack.write(tmp_path, {"POSITION": base}, corners, up, node=node))
    np.testing.assert_allclose(scene.points(0.0), POINTS, rtol=0, atol=BOUND)
    np.testing.assert_allclose(scene.points(1 / FPS), POINTS + MOVES, rtol=0, atol=2 * BOUND)


def test_quantised_texture_coordinates_are_placed_by_their_material(tmp_path, meshopt):
    pack = Packer(meshopt)
    shift = (-0.25, 0.5)
    texture = {"scale": [65535 / 4095, 2 * 65535 / 4095], "offset": shift}
    surface = {"index": 0, "extensions": {"KHR_texture_transform": texture}}
    pack.maker.document |= {
        "images": [{"uri": "https://example.org/face.png"}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": surface}}],
    }
    attributes = {
        "POSITION": pack.add(POINTS),
        "TEXCOORD_0": pack.add(np.rint(GRID * 4095).astype("u2"), normalized=True),
    }
    corners = pack.add(CORNERS.reshape(-1, 1), mode="TRIANGLES")
    scene = staged(pack.write(tmp_path, attributes, corners, pack.add(MOVES), material=0))
    np.testing.assert_allclose(scene.places, GRID * (1, 2) + shift, rtol=0, atol=1e-3)


def test_turns_of_nodes_are_read_through_their_filter(tmp_path, meshopt):
    pack = Packer(meshopt)
    angles = np.linspace(0, 1, 9)
    turns = np.column_stack([np.sin(angles), 0 * angles, 0 * angles, np.cos(angles)])
    rows = meshopt.encode_filter_quat(turns.astype("f4"), 8, 16)
    number = pack.add(np.zeros((9, 4), "i2"), rows, kind="QUATERNION", normalized=True)
    model = read_model(pack.maker.write(tmp_path / "a.glb"), bones=True)
    found = Accessors(model)[number]
    np.testing.assert_allclose(np.abs((found * turns).sum(axis=1)), 1, atol=1e-3)


def extension_of(document, number):
    return document["bufferViews"][number]["extensions"]["EXT_meshopt_compression"]


LIES = {
    "more rows": ({"count": 10**6}, r"buffer view 0 states 1000000 rows of 12 bytes in \d+ bytes"),
    "endless rows": ({"count": 2**60}, "buffer view 0 states 1152921504606846976 for a count"),
    "rows than stored": ({"count": 300}, "buffer view 0 .*-[123]"),
    "no rows": ({"count": 0}, "buffer view 0 states 0 rows of 12 bytes"),
    "fewer rows": ({"count": 100}, "buffer view 0 .*-[123]"),
    "rows that are text": ({"count": "144"}, "buffer view 0 states 144 for a count"),
    "a row of half a word": ({"byteStride": 6}, "buffer view 0 a row must be 4 to 256 bytes"),
    "an endless row": ({"byteStride": 2**31}, "buffer view 0 states 2147483648 for a count"),
    "a row below nothing": ({"byteStride": -4}, "buffer view 0 states -4 for a count"),
    "a mode of no name": ({"mode": ["x"]}, "buffer view 0 mode must be"),
    "a filter of no name": ({"filter": {}}, "buffer view 0 filter must be"),
    "a filter of indices": ({"mode": "TRIANGLES"}, "buffer view 0 has a filter for indices"),
    "a filter of other rows": ({"filter": "QUATERNION"}, "buffer view 0 quaternion rows are 8"),
    "data past the end": ({"byteOffset": 10**6}, "buffer view 0 lies past the end of its data"),
    "no length": ({"byteLength": None}, "buffer view 0 lies past the end of its data"),
    "another buffer": ({"buffer": 1}, "has its data in several buffers"),
    "cut data": ({"byteLength": 40}, "buffer view 0 .*-[123]"),
}


@pytest.mark.parametrize("lie", LIES)
def test_a_view_that_lies_is_told(tmp_path, meshopt, lie):
    change, told = LIES[lie]
    animation = packed_face(
        tmp_path, meshopt, change=lambda document: extension_of(document, 0).update(change)
    )
    with pytest.raises(ModelError, match=rf"face.glb: {told}"):
        staged(animation)


def test_an_accessor_of_more_than_its_view_is_told(tmp_path, meshopt):
    animation = packed_face(
        tmp_path, meshopt, change=lambda document: document["accessors"][0].update(count=145)
    )
    with pytest.raises(ModelError, match="accessor 0 lies past the end of its data"):
        staged(animation)


# Draco


def draco_face(tmp_path, library, change=lambda *_: None, data=None, **rest):
    """Write the face with its base mesh as Draco; return its animation and order of points."""
    own = library.encode(
        POINTS,
        CORNERS,
        quantization_bits=16,
        normals=FACING.astype(float),
        tex_coord=GRID,
        **rest,
    )
    mesh = library.decode(own)
    order = np.abs(mesh.points[:, None] - POINTS).max(axis=2).argmin(axis=1)
    kinds = {0: "POSITION", 1: "NORMAL", 3: "TEXCOORD_0"}
    numbers = {kinds[one["attribute_type"]]: one["unique_id"] for one in mesh.attributes}
    maker = Maker()
    values = {"POSITION": POINTS, "NORMAL": FACING, "TEXCOORD_0": GRID.astype("f4")}
    attributes = {name: accessor(maker, rows, None) for name, rows in values.items()}
    corners = accessor(maker, CORNERS.reshape(-1, 1), None)
    moves = plain(maker, MOVES[order])
    view = maker.view(own if data is None else data(own))
    packed = {"KHR_draco_mesh_compression": {"bufferView": view, "attributes": numbers}}
    maker.document["extensionsRequired"] = list(packed)
    change(maker.document, packed["KHR_draco_mesh_compression"])
    return face(tmp_path / "face.glb", maker, attributes, corners, moves, extensions=packed), order


@pytest.mark.parametrize("rest", [{"preserve_order": True}, {"compression_level": 7}])
def test_a_model_of_draco_is_the_plain_model(tmp_path, draco, reference, rest):
    animation, order = draco_face(tmp_path, draco, **rest)
    scene = staged(animation)
    for seconds in (0.0, 1 / FPS):
        expected = reference.points(seconds)[order]
        np.testing.assert_allclose(scene.points(seconds), expected, rtol=0, atol=BOUND)
    np.testing.assert_allclose(scene.normals, FACING, rtol=0, atol=0.02)
    np.testing.assert_allclose(scene.places, GRID[order], rtol=0, atol=1e-3)
    scene.triangles = order[scene.triangles]
    assert edges(scene) == edges(reference)


def test_the_page_shows_a_compressed_model(tmp_path, draco, meshopt):
    for animation in (
        draco_face(tmp_path, draco)[0],
        packed_face(tmp_path, meshopt),
    ):
        shown = face_data(animation, ArrayPack())
        assert shown["unshown"] == []
        assert shown["count"] == SIDE**2


def number_of_bytes(own, count):
    """Replace the number of points of a mesh in sequential order, of two bytes."""
    return own[:13] + count + own[15:]


DRACO_LIES = {
    "cut": (None, lambda own: own[:200], "has Draco data that cannot be decoded"),
    "no data": (None, lambda own: own[:11], "has Draco data that end within their header"),
    "other data": (None, lambda own: b"x" * len(own), "is not a Draco mesh of bitstream 2.2"),
    "a cloud": (None, lambda own: own[:7] + b"\0" + own[8:], "is not a Draco mesh"),
    "endless points": (
        None,
        lambda own: number_of_bytes(own, b"\xff\xff\xff\xff\x0f"),
        "has 726 corners of 4294967295 points, but states 726 of 144",
    ),
    "an endless header": (None, lambda own: number_of_bytes(own, b"\xff" * 30), "end within their"),
    "fewer corners stated": (
        lambda document, _: document["accessors"][3].update(count=3),
        None,
        "has 726 corners of 144 points, but states 3 of 144",
    ),
    "more corners stated": (
        lambda document, _: document["accessors"][3].update(count=729),
        None,
        "accessor 3 states 729 values, and has 726",
    ),
    "endless corners stated": (
        lambda document, _: document["accessors"][3].update(count=2**25),
        None,
        "states 33554432 corners of 144 points in",
    ),
    "no count": (
        lambda document, _: document["accessors"][3].update(count=None),
        None,
        "accessor 3 states None values",
    ),
    "other attributes": (
        lambda _, packed: packed["attributes"].update(NORMAL=77),
        None,
        "has no NORMAL",
    ),
    "attributes of other points": (
        lambda document, _: document["accessors"][1].update(count=143),
        None,
        "accessor 1 states 143 values, and has 144",
    ),
    "no view": (lambda _, packed: packed.update(bufferView=99), None, "buffer view 99 has no"),
    "no names": (lambda _, packed: packed.pop("attributes"), None, "its meshes cannot be read"),
}


@pytest.mark.parametrize("lie", DRACO_LIES)
def test_a_draco_mesh_that_lies_is_told(tmp_path, draco, lie):
    change, data, told = DRACO_LIES[lie]
    animation, _ = draco_face(
        tmp_path, draco, change or (lambda *_: None), data, preserve_order=True
    )
    with pytest.raises(ModelError, match=rf"face.glb: .*{told}"):
        staged(animation)


def test_damaged_bytes_are_told_or_drawn(tmp_path, draco, meshopt):
    rng = np.random.default_rng(1)
    whole = tmp_path / "whole.glb"
    told = 0
    for make in (
        partial(draco_face, tmp_path, draco),
        partial(packed_face, tmp_path, meshopt),
    ):
        made = make()
        animation = made[0] if isinstance(made, tuple) else made
        content = animation.model.read_bytes()
        start = content.index(b"BIN\0")
        for _ in range(60):
            data = bytearray(content)
            for at in rng.integers(start + 4, len(data), 3):
                data[at] = rng.choice([0, 255, 127, 128])
            whole.write_bytes(data)
            try:
                staged(animation_of(whole, Channel("up")))
            except ModelError:
                told += 1
    assert 0 < told < 120


# Without the libraries


@pytest.mark.parametrize("name", ["EXT_meshopt_compression", "KHR_draco_mesh_compression"])
def test_without_its_decoder_a_model_says_how_to_read_it(
    tmp_path, monkeypatch, draco, meshopt, name
):
    if name.startswith("EXT"):
        animation = packed_face(tmp_path, meshopt)
    else:
        animation, _ = draco_face(tmp_path, draco)
    monkeypatch.setitem(sys.modules, "meshopt", None)
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    told = rf'face.glb: is compressed \({name}\); .*pip install "lipsync-lang\[models\]"'
    with pytest.raises(ModelError, match=told):
        staged(animation)
    assert "lipsync-lang[models]" in face_data(animation, ArrayPack())["unshown"][0]
    (remark,) = WRITERS["html"].remarks(animation)  # a command says it too
    assert remark.startswith("the page draws a simple mouth instead of the model: ")
    assert "lipsync-lang[models]" in remark
