"""Video and stills: triangles are filled exactly, and the picture shows the performed frame."""

import json
import struct
import subprocess
import sys
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full, swept

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.base.errors import ModelError, OutputError
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.render import sheet, video
from lipsync_lang.render.model.camera import framed
from lipsync_lang.render.model.picture import Artist
from lipsync_lang.render.model.raster import Window, area, fill, planes, shown
from lipsync_lang.render.model.scene import FAN, STRIP, Material, _triangles
from lipsync_lang.render.picture_writers import write_mp4, write_png
from lipsync_lang.render.staging import staged

SIZE, FPS, RATE = 96, 30, 8000
WHOLE = Window(0, 0, 64, 64)

coordinates = st.floats(-20, 84, allow_nan=False)
inside = st.floats(1, 62)


def filled(*triangles, depth=None, window=WHOLE, names=None, **rest):
    corners = np.array(triangles, float)
    depth = np.ones((len(corners), 3)) if depth is None else np.array(depth, float)
    keys = np.zeros((window.bottom - window.top) * window.width, np.uint64)
    names = np.arange(len(corners)) if names is None else np.array(names)
    fill(keys, window, corners, depth, names, **rest)
    return shown(keys).reshape(-1, window.width)


# Triangles


@given(st.lists(st.tuples(inside, inside), min_size=1, max_size=5))
def test_triangles_that_share_edges_cover_every_sample_once(points):
    square = [(0, 0), (63, 0), (63, 63), (0, 63)]
    fan = [[points[0], a, b] for a, b in zip(square, square[1:] + square[:1], strict=True)]
    covered = sum((filled(triangle) == 0).astype(int) for triangle in fan)
    assert (covered[:63, :63] == 1).all()
    assert covered[63].sum() == covered[:, 63].sum() == 0


@given(st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=3))
def test_a_sample_shows_a_triangle_where_it_lies_inside(points):
    (ax, ay), (bx, by), (cx, cy) = points
    y, x = np.mgrid[:64, :64]
    sides = [
        (bx - ax) * (y - ay) - (by - ay) * (x - ax),
        (cx - bx) * (y - by) - (cy - by) * (x - bx),
        (ax - cx) * (y - cy) - (ay - cy) * (x - cx),
    ]
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    if abs(area) < 1e-3:
        return
    signed = np.array(sides) * np.sign(area)
    seen = filled(points) == 0
    assert seen[(signed > 1e-6).all(axis=0)].all()
    assert not seen[(signed < -1e-6).any(axis=0)].any()


@given(st.permutations(range(4)))
def test_the_nearest_triangle_is_seen_whatever_is_drawn_first(order):
    triangle = [(0, 0), (63, 0), (0, 63)]
    near = [0.2, 0.9, 0.4, 0.3]
    seen = filled(*[triangle] * 4, depth=[[near[n]] * 3 for n in order], names=order)
    assert set(np.unique(seen)) == {-1, 1}


def test_triangles_that_pierce_each_other_part_where_they_meet():
    square = [(0, 0), (200, 0), (0, 200)]
    seen = filled(square, square, depth=[[1, 1, 1], [0.5, 0.5 + 200 / 64, 0.5]])
    assert (seen[:, :32] == 0).all()
    assert (seen[:, 33:] == 1).all()


def test_a_window_shows_its_part_of_the_whole():
    triangle = [(3, 2), (60, 20), (10, 59)]
    part = Window(10, 6, 40, 50)
    np.testing.assert_array_equal(filled(triangle, window=part), filled(triangle)[6:50, 10:40])


def test_what_nothing_is_seen_of_hides_nothing():
    big, small = [(0, 0), (200, 0), (0, 200)], [(5, 5), (40, 5), (5, 40)]
    seen = filled(small, big, depth=[[2] * 3, [1] * 3], seen=lambda s: s.triangle == 1)
    assert (seen == 1).all()


@pytest.mark.parametrize("mode", [STRIP, FAN])
def test_triangles_of_strips_and_fans_all_face_the_same_way(mode):
    turns = np.arange(7)[:, None]
    strip, fan = np.hstack([turns // 2, turns % 2]), np.hstack([np.cos(turns), np.sin(turns)])
    points = strip if mode == STRIP else fan[:6]
    found = area(points[_triangles(np.arange(len(points)), mode)].astype(float))
    assert len(found) == len(points) - 2
    assert (np.sign(found) == np.sign(found[0])).all()
    assert found[0] != 0


def test_planes_have_their_values_at_the_corners():
    rng = np.random.default_rng(1)
    corners, values = rng.random((5, 3, 2)) * 50, rng.random((5, 3, 4))
    flat = planes(corners, values)[:, None]
    x, y = corners[..., :1], corners[..., 1:]
    np.testing.assert_allclose(flat[:, :, 0] + flat[:, :, 1] * x + flat[:, :, 2] * y, values)


# Models of our own


class Maker:
    """A GLB that is built row by row."""

    def __init__(self):
        self.data = b""
        self.document = {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            **{name: [] for name in ("nodes", "meshes", "accessors", "bufferViews")},
        }

    def view(self, data):
        offset = len(self.data)
        self.data += data + b"\0" * (-len(data) % 4)
        row = {"buffer": 0, "byteOffset": offset, "byteLength": len(data)}
        self.document["bufferViews"].append(row)
        return len(self.document["bufferViews"]) - 1

    def array(self, values, kind="<f4", **rest):
        values = np.array(values, kind)
        code = {"<f4": 5126, "<u2": 5123, "<i2": 5122, "u1": 5121}[kind]
        shape = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
        width = values.shape[1] if values.ndim > 1 else 1
        row = {"componentType": code, "count": len(values), "type": shape[width], **rest}
        if "sparse" not in rest:
            row["bufferView"] = self.view(values.tobytes())
        self.document["accessors"].append(row)
        return len(self.document["accessors"]) - 1

    def mesh(self, attributes, names=(), targets=(), **rest):
        primitive = {"attributes": attributes, "targets": list(targets), **rest}
        self.document["meshes"].append(
            {"primitives": [primitive], "extras": {"targetNames": list(names)}}
        )

    def write(self, path):
        self.document["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        body = struct.pack("<II", len(text), 0x4E4F534A) + text
        body += struct.pack("<II", len(self.data), 0x004E4942) + self.data
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
        return path


SQUARE = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, -1, 0), (1, 1, 0), (-1, 1, 0)]
CORNERS = [(0, 1), (1, 1), (1, 0), (0, 1), (1, 0), (0, 0)]


def animation_of(model, *channels, values=(0.0, 1.0), **rest):
    times = np.arange(len(values)) / FPS
    schedule = ll.Schedule(("A",), (0, max(times[-1], 0.1)))
    weights = np.tile(np.array(values)[:, None], (1, len(channels)))
    names = tuple(channel.name for channel in channels)
    return Animation(times, names, weights, FPS, schedule, channels=channels, model=model, **rest)


def test_sparse_and_normalised_values_are_read(tmp_path):
    maker = Maker()
    maker.document["nodes"] = [{"mesh": 0}]
    whole = np.array(SQUARE)
    base = maker.array(whole * 32767 - (whole < 0), "<i2", normalized=True)
    rows = maker.array([1, 4], "<u2")
    few = maker.array([(0, 0, 1), (0, 0, 2)])
    views = [maker.document["accessors"][number]["bufferView"] for number in (rows, few)]
    sparse = {
        "count": 2,
        "indices": {"bufferView": views[0], "componentType": 5123},
        "values": {"bufferView": views[1]},
    }
    target = maker.array(np.zeros((6, 3)), sparse=sparse)
    maker.mesh({"POSITION": base}, ["up"], [{"POSITION": target}])
    scene = staged(animation_of(maker.write(tmp_path / "a.glb"), Channel("up")))
    np.testing.assert_array_equal(scene.points(0.0), SQUARE)
    np.testing.assert_allclose(scene.points(1 / FPS)[:, 2], [0, 1, 0, 0, 2, 0], atol=1e-4)
    np.testing.assert_allclose(scene.points(0.5 / FPS)[:, 2], [0, 0.5, 0, 0, 1, 0], atol=1e-4)


def boned(tmp_path, *values):
    """A square bound to a skull and a jaw, and an animation of the jaw in degrees."""
    maker = Maker()
    inverse = np.tile(np.eye(4), (2, 1, 1))
    inverse[1, 3, 1] = -1.0
    maker.document["nodes"] = [
        {"children": [1, 3]},
        {"children": [2], "name": "skull"},
        {"name": "jaw", "translation": [0, 1, 0]},
        {"mesh": 0, "skin": 0, "translation": [9, 9, 9]},
    ]
    bones = np.zeros((6, 4), "u1")
    bones[:, 1] = 1
    shares = np.zeros((6, 4))
    shares[:3, 0], shares[3:5, 1], shares[5, :2] = 1, 1, 0.25  # made to add up to 1
    maker.document["skins"] = [
        {"joints": [1, 2], "inverseBindMatrices": maker.array(inverse.reshape(2, 16))}
    ]
    attributes = {
        "POSITION": maker.array(SQUARE),
        "JOINTS_0": maker.array(bones, "u1"),
        "WEIGHTS_0": maker.array(shares),
    }
    maker.mesh(attributes)
    channel = Channel("jaw", node="jaw", rotation=(0, 0, 1))
    return animation_of(maker.write(tmp_path / "a.glb"), channel, values=values)


def test_bones_turn_what_hangs_on_them(tmp_path):
    scene = staged(boned(tmp_path, 0.0, 90.0))
    np.testing.assert_allclose(scene.rest, SQUARE, atol=1e-6)
    turned = np.array(SQUARE, float)
    about = turned[3:5] - (0, 1, 0)
    turned[3:5] = np.column_stack([-about[:, 1], about[:, 0] + 1, about[:, 2]])
    turned[5] = (np.array(SQUARE[5]) + np.array([0.0, 0.0, 0.0])) / 2
    np.testing.assert_allclose(scene.points(1 / FPS)[:5], turned[:5], atol=1e-6)
    corner = np.array(SQUARE[5], float)
    moved = np.array([-(corner[1] - 1), corner[0] + 1, 0])
    np.testing.assert_allclose(scene.points(1 / FPS)[5], (corner + moved) / 2, atol=1e-6)
    assert scene.moving.all()


def textured(tmp_path, **material):
    """A square whose left half is green, and whose right half is red and cut out."""
    image = pytest.importorskip("PIL.Image", reason="textures need Pillow, an extra")
    texels = np.zeros((8, 8, 4), np.uint8)
    texels[:, :4], texels[:, 4:] = (0, 255, 0, 255), (255, 0, 0, 0)
    data = BytesIO()
    image.fromarray(texels).save(data, "PNG")
    maker = Maker()
    maker.document |= {
        "nodes": [{"mesh": 0}],
        "images": [{"bufferView": maker.view(data.getvalue()), "mimeType": "image/png"}],
        "textures": [{"source": 0}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "doubleSided": True}
            | material
        ],
    }
    still, moved = maker.array(np.zeros((6, 3))), maker.array([(0, 0, 0.1)] * 6)
    attributes = {"POSITION": maker.array(SQUARE), "TEXCOORD_0": maker.array(CORNERS)}
    targets = [{"POSITION": still}, {"POSITION": moved}]
    maker.mesh(attributes, ["still", "moved"], targets, material=0)
    return animation_of(maker.write(tmp_path / "a.glb"), Channel("moved"))


def test_a_texture_is_seen_where_it_belongs(tmp_path):
    picture = Artist(staged(textured(tmp_path)), SIZE).draw(1 / FPS).astype(int)
    for column, colour in ((SIZE // 4, 1), (3 * SIZE // 4, 0)):
        pixel = picture[SIZE // 2, column]
        assert pixel.argmax() == colour
        assert np.delete(pixel, colour).max() < 20


def test_a_texture_begins_at_its_upper_left_corner_and_repeats():
    image = pytest.importorskip("PIL.Image", reason="textures need Pillow, an extra")
    rows = np.arange(8, dtype=np.uint8).reshape(2, 1, 4)
    data = BytesIO()
    image.fromarray(rows).save(data, "PNG")
    surface = Material(np.ones(4), data.getvalue(), 0.0, double=True, gloss=0.0, lit=True)
    found = surface.texels(np.full(4, 0.5), np.array([0.25, 0.75, 1.25, -0.25]))
    np.testing.assert_array_equal(found, rows[[0, 1, 0, 1], 0])


def test_what_minds_no_light_has_the_colours_of_its_texture(tmp_path):
    bare = textured(tmp_path, extensions={"KHR_materials_unlit": {}})
    picture = Artist(staged(bare), SIZE).draw(0.0)
    np.testing.assert_array_equal(picture[SIZE // 2, SIZE // 4], (0, 255, 0))


@pytest.mark.parametrize("mode", ["MASK", "BLEND"])
def test_what_is_cut_out_shows_what_is_behind(tmp_path, mode):
    picture = Artist(staged(textured(tmp_path, alphaMode=mode)), SIZE).draw(1 / FPS)
    assert picture[SIZE // 2, SIZE // 4].argmax() == 1
    np.testing.assert_array_equal(picture[SIZE // 2, 3 * SIZE // 4], picture[SIZE // 2, SIZE - 1])


def test_a_material_says_how_much_is_cut_out(tmp_path):
    whole = textured(tmp_path, alphaMode="MASK", alphaCutoff=0.0)
    assert Artist(staged(whole), SIZE).draw(0.0)[SIZE // 2, 3 * SIZE // 4].argmax() == 0


def test_a_surface_is_seen_from_behind_only_if_it_has_two_sides(tmp_path):
    animation = textured(tmp_path, doubleSided=False)
    document = staged(animation)
    front = Artist(document, SIZE).draw(0.0)
    document.triangles = document.triangles[:, ::-1]
    behind = Artist(document, SIZE).draw(0.0)
    assert front[SIZE // 2, SIZE // 4].argmax() == 1
    assert (behind[:, : SIZE // 2] == behind[:, :1]).all()
    document = staged(textured(tmp_path))
    document.triangles = document.triangles[:, ::-1]
    assert Artist(document, SIZE).draw(0.0)[SIZE // 2, SIZE // 4].argmax() == 1


def damaged(tmp_path, change):
    maker = Maker()
    maker.document["nodes"] = [{"mesh": 0}]
    points = maker.array(SQUARE)
    maker.mesh({"POSITION": points}, ["up"], [{"POSITION": points}])
    change(maker.document)
    return animation_of(maker.write(tmp_path / "face.glb"), Channel("up"))


def test_what_a_node_shows_as_in_a_mirror_is_seen(tmp_path):
    mirrored = damaged(tmp_path, lambda d: d["nodes"][0].update(scale=[-1, 1, 1]))
    picture = Artist(staged(mirrored), SIZE).draw(0.0)
    assert (picture[SIZE // 2, SIZE // 2] != picture[SIZE // 2, 0]).any()


def test_what_has_moved_stays_where_it_is(tmp_path):
    scene = staged(damaged(tmp_path, lambda _: None))
    np.testing.assert_allclose(scene.points(9.0), scene.points(1 / FPS), atol=1e-6)
    np.testing.assert_allclose(scene.points(-9.0), scene.points(0.0), atol=1e-6)


def test_no_gap_opens_between_what_moves_and_what_stands_still(tmp_path):
    place = np.linspace(-1, 1, 41)
    points = np.array([(x, y, 0) for y in place for x in place])
    corner = np.array([41 * row + column for row in range(40) for column in range(40)])
    corners = [corner, corner + 1, corner + 42, corner, corner + 42, corner + 41]
    sheet = np.stack(corners, axis=1).reshape(-1, 3)
    # moves ever less from the middle outwards, and at last not at all
    fading = 0.0014 * (1 - np.linalg.norm(points, axis=1)).clip(0, 1)[:, None] ** 2 * (1, -1, 0)
    small = (points[sheet].mean(axis=1)[:, :2] < (-0.2, 0)).all(axis=1)
    maker, still = Maker(), np.zeros_like(points)
    for triangles, depth, moved, colour in (
        (sheet[small], 0, fading, (0, 1, 0, 1)),
        (sheet[~small], 0, fading, (0, 1, 0, 1)),
        (sheet, -0.1, still, (1, 0, 0, 1)),
    ):
        used, own = np.unique(triangles, return_inverse=True)
        faces = maker.array(own.ravel(), "<u2")
        attributes = {"POSITION": maker.array(points[used] + (0, 0, depth))}
        target, number = {"POSITION": maker.array(moved[used])}, len(maker.document["meshes"])
        maker.mesh(attributes, ["up"], [target], indices=faces, material=number)
        surface = {"baseColorFactor": colour, "metallicFactor": 0.0}
        maker.document.setdefault("materials", []).append({"pbrMetallicRoughness": surface})
    parts = [part for mesh in maker.document["meshes"] for part in mesh["primitives"]]
    maker.document["meshes"] = [maker.document["meshes"][0] | {"primitives": parts}]
    maker.document["nodes"] = [{"mesh": 0}]
    path = maker.write(tmp_path / "a.glb")
    scene = staged(animation_of(path, Channel("up")))
    assert scene.moving.any()
    assert not scene.moving.all()
    found = {}
    for point, moves in zip(scene.rest.round(4).tolist(), scene.moving, strict=True):
        assert found.setdefault(tuple(point), moves) == moves, "a seam moves on one side alone"
    picture = Artist(scene, 600).draw(1 / FPS)
    red, _, blue = picture[60:-60, 60:-60].astype(int).transpose(2, 0, 1)
    assert (red == blue).all(), "the backdrop is not seen"


def nodding(folder, frames):
    """A hill that a shape lifts, on a head that nods in front of a wall: both in each frame."""
    place, maker = np.linspace(-1, 1, 9), Maker()
    points = np.array([(x, y, 0.3 - (x * x + y * y) / 8) for y in place for x in place])
    corner = np.array([9 * row + column for row in range(8) for column in range(8)])
    corners = [corner, corner + 1, corner + 10, corner, corner + 10, corner + 9]
    lifted = 0.3 * (0.4 - np.linalg.norm(points[:, :2], axis=1)).clip(0)[:, None] * (0, 1, 1)
    faces = maker.array(np.stack(corners, axis=1).ravel(), "<u2")
    hill = {"POSITION": maker.array(points)}
    maker.mesh(hill, ["up"], [{"POSITION": maker.array(lifted)}], indices=faces)
    maker.mesh({"POSITION": maker.array(np.array(SQUARE) * 0.8 + (0.3, 0.3, -0.2))})
    maker.document["nodes"] = [{"name": "head", "children": [1]}, {"mesh": 0}, {"mesh": 1}]
    maker.document["scenes"] = [{"nodes": [0, 2]}]
    channels = Channel("up"), Channel("nod", node="head", rotation=(1, 0, 0))
    line = animation_of(maker.write(folder / "a.glb"), *channels, values=range(len(frames)))
    return staged(replace(line, weights=np.array(frames, float)))


@given(
    st.lists(
        st.tuples(st.sampled_from([0, 0.2, 1]), st.sampled_from([0, 0, 0, -9, 20])),
        min_size=3,
        max_size=9,
    )
)
def test_a_frame_is_the_same_whatever_was_drawn_before_it(tmp_path, frames):
    scene = nodding(tmp_path, frames)
    artist, whole = Artist(scene, SIZE), Artist(scene, SIZE)
    whole._calm = whole._usual  # noqa: SLF001
    for at in np.arange(0, len(frames), 0.5) / FPS:
        np.testing.assert_array_equal(artist.draw(at), whole.draw(at))


def test_between_two_nods_only_what_shapes_move_is_drawn_anew(tmp_path):
    artist = Artist(nodding(tmp_path, [(0, 0), (1, 0), (0.3, 0), (0.5, 9), (1, 0)]), SIZE)
    assert 0 < len(artist._calm.triangles) < len(artist._usual.triangles)  # noqa: SLF001
    artist._usual = None  # noqa: SLF001
    assert (artist.draw(1 / FPS) != artist.draw(2 / FPS)).any()
    with pytest.raises(AttributeError):
        artist.draw(3 / FPS)


@pytest.mark.parametrize(("rotation", "front"), [([0, 0, 0, 1], 1), ([0, 1, 0, 0], -1)])
def test_a_face_is_looked_at_from_its_front(tmp_path, rotation, front):
    maker = Maker()
    maker.document["nodes"] = [{"mesh": 0, "rotation": rotation}]
    face, back = (np.add(SQUARE, (0, 0, z)) for z in (1, -1))
    moved = maker.array([(0, 0.1, 0)] * 6 + [(0, 0, 0)] * 6)
    maker.mesh({"POSITION": maker.array([*face, *back])}, ["up"], [{"POSITION": moved}])
    scene = staged(animation_of(maker.write(tmp_path / "a.glb"), Channel("up")))
    np.testing.assert_array_equal(framed(scene).turn, np.diag([front, 1, front]))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            lambda d: d["bufferViews"][0].update(extensions={"EXT_meshopt_compression": {}}),
            "buffer view 0 lies past the end of its data",
        ),
        (
            lambda d: d["accessors"][0].update(count=10**12),
            r"0 states 10+ values in \d+ b",
        ),
        (
            lambda d: d["accessors"][0].update(type="VEC9"),
            "0 has numbers of an unknown",
        ),
        (lambda d: d["meshes"][0]["primitives"][0].update(material=7), "its meshes cannot be read"),
        (lambda d: d["scenes"][0].update(nodes=[7]), "its meshes cannot be read"),
        (lambda d: d["scenes"][0].update(nodes=[]), "shows no surfaces"),
        (lambda d: d["meshes"][0]["primitives"][0].update(mode=1), "shows no surfaces"),
        (lambda d: d["bufferViews"][0].update(buffer=1), "has its data in several buffers"),
    ],
)
def test_a_model_that_cannot_be_drawn_says_why(tmp_path, change, told):
    with pytest.raises(ModelError, match=rf"face.glb: .*{told}"):
        staged(damaged(tmp_path, change))


# What is seen


LABELS = ("B", "AA", "M", "AA", "F", "UW", "P", "IY")


@pytest.fixture(scope="module")
def spoken():
    """Return an animation of the built-in head or crab."""
    noise = np.random.default_rng(0).integers(-9000, 9000, int(1.6 * RATE)).astype(np.int16)
    words = (ll.Word("ba", 0, 2), ll.Word("mafoo", 2, 6), ll.Word("pee", 6, 8))
    times = np.arange(len(LABELS) + 1) * 0.2
    audio = ll.Audio(noise, RATE)
    schedule = ll.Schedule(LABELS, times, words, notation="arpabet", audio=audio)

    def perform(character, **how):
        performer = ll.resolve("english", character)
        return performer.rigged(performer.perform(schedule, fps=FPS, **how))

    return perform


@full
@pytest.mark.parametrize("character", ["facefx", "crab"])
def test_lips_meet_where_they_must_and_part_for_a_vowel(spoken, character):
    scene = staged(spoken(character))
    artist = Artist(scene, SIZE)
    rest = artist.draw(0.0).astype(int)
    change = {
        n: np.abs(artist.draw(scene.sound + 0.2 * n + 0.1) - rest).sum() for n in range(len(LABELS))
    }
    closed, wide = [change[LABELS.index(p)] for p in "BMP"], change[LABELS.index("AA")]
    assert wide > 3 * max(closed)


@full
def test_only_what_moves_is_drawn_anew_and_it_looks_the_same(spoken):
    animation = spoken("facefx")
    artist, scene = Artist(staged(animation), SIZE), staged(animation)
    scene.moving = np.ones(scene.count, bool)
    whole = Artist(scene, SIZE)
    for seconds in (0.0, 0.6, 1.0):
        difference = np.abs(artist.draw(seconds).astype(int) - whole.draw(seconds))
        assert difference.max() <= 3
    changed = (artist.draw(0.6) != artist.draw(0.0)).any(axis=2)
    assert changed[SIZE // 2 :].any()
    assert not changed[: SIZE // 3].any(), "the brow stays where it is"


@full
@pytest.mark.parametrize("character", ["facefx", "crab"])
def test_the_frames_of_a_head_that_nods_now_and_then_are_the_same(spoken, character):
    animation = spoken(character, gestures="all")
    weights = animation.weights.copy()
    bones = [number for number, one in enumerate(animation.columns) if one.node is not None]
    weights[:, bones] = 0
    weights[10:16, bones] = 3
    scene = staged(replace(animation, weights=weights))
    artist, whole = Artist(scene, SIZE), Artist(scene, SIZE)
    assert len(artist._calm.triangles) < len(artist._usual.triangles)  # noqa: SLF001
    whole._calm = whole._usual  # noqa: SLF001
    for seconds in np.arange(len(weights)) / FPS:
        np.testing.assert_array_equal(artist.draw(seconds), whole.draw(seconds))


@full
def test_a_head_fills_its_picture_from_the_middle(spoken):
    picture = Artist(staged(spoken("facefx")), SIZE).draw(0.0)
    drawn = (picture != picture[:, :1]).any(axis=2)
    rows, columns = np.flatnonzero(drawn.any(axis=1)), np.flatnonzero(drawn.any(axis=0))
    assert len(rows) > 0.75 * SIZE
    assert abs(columns.mean() - SIZE / 2) < 0.03 * SIZE


@full
def test_a_head_with_many_shapes_is_drawn(data):
    performer = ll.resolve("english", "arkit")
    schedule = ll.Schedule(LABELS, np.arange(9) * 0.2, notation="arpabet")
    animation = performer.rigged(performer.perform(schedule, fps=FPS))
    model = data / "rigs/head_arkit52_oculus15.glb"
    scene = staged(replace(animation, model=model))
    artist = Artist(scene, SIZE)
    wide, closed = (artist.draw(scene.sound + at).astype(int) for at in (0.3, 0.5))
    changed = np.abs(wide - closed).max(axis=2) > 40
    assert changed[SIZE // 2 :].sum() > 20
    assert not changed[: SIZE // 3].any()


# Files


@pytest.fixture
def ffmpeg(monkeypatch):
    """Return the ffmpeg of the extra, and make videos small."""
    reason = "videos need imageio-ffmpeg, an extra"
    found = pytest.importorskip("imageio_ffmpeg", reason=reason)
    pytest.importorskip("PIL", reason=reason)
    monkeypatch.setattr(video, "FRAME_PIXELS", SIZE)
    return found


@pytest.fixture
def stills(monkeypatch):
    """Require Pillow, and make stills small."""
    found = pytest.importorskip("PIL.Image", reason="stills need Pillow, an extra")
    monkeypatch.setattr(sheet, "CELL", SIZE)
    return found


def asked(ffmpeg, path, *rest):
    """Return ffmpeg's decoded data of a file, and its description."""
    command = [ffmpeg.get_ffmpeg_exe(), "-nostdin", "-hide_banner", "-i", path, *rest]
    done = subprocess.run(command, capture_output=True, check=False)
    return done.stdout, done.stderr.decode()


def frames_of(ffmpeg, path):
    raw, _ = asked(ffmpeg, path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-")
    return np.frombuffer(raw, np.uint8).reshape(-1, video.FRAME_PIXELS, video.FRAME_PIXELS, 3)


def sound_of(ffmpeg, path):
    raw, _ = asked(ffmpeg, path, "-vn", "-ac", "1", "-ar", str(RATE), "-f", "s16le", "-")
    return np.frombuffer(raw, "<i2")


def as_video(content, animation):
    """Checks of files in the sweep of all writers; `NEEDS` lists their packages."""
    import imageio_ffmpeg

    with TemporaryDirectory() as folder:
        path = Path(folder) / "line"
        path.write_bytes(content)
        seconds = animation.times[-1] - min(0.0, animation.times[0])
        assert len(frames_of(imageio_ffmpeg, path)) == round(seconds * animation.fps) + 1


def as_sheet(content, animation):
    from PIL import Image

    sounds = [label for label in animation.schedule.labels if label != "_"]
    with Image.open(BytesIO(content)) as page:
        step = sheet.CELL + sheet.FOOT
        assert (page.height - 2 * sheet.EDGE) / step == -(-len(sounds) // sheet.COLUMNS)


READ_BACK = {"mp4": as_video, "png": as_sheet, "webm": as_video}
NEEDS = {"mp4": ("imageio_ffmpeg", "PIL"), "png": ("PIL",), "webm": ("imageio_ffmpeg", "PIL")}


@full
@pytest.mark.parametrize(
    ("kind", "codec", "sound"), swept([("mp4", "h264", "aac"), ("webm", "vp9", "opus")])
)
def test_a_video_has_the_frames_and_the_sound_at_their_time(  # noqa: PLR0913, PLR0917
    ffmpeg, spoken, tmp_path, kind, codec, sound
):
    animation, path = spoken("crab"), tmp_path / f"line.{kind}"
    animation.save(path)
    _, about = asked(ffmpeg, path)
    for told in (f"Video: {codec}", "yuv420p", f"{SIZE}x{SIZE}", f"{FPS} fps", f"Audio: {sound}"):
        assert told in about
    pictures = frames_of(ffmpeg, path)
    assert len(pictures) == len(animation.times)
    scene = staged(animation)
    artist = Artist(scene, SIZE)
    for number in (0, 9, 22):
        drawn = artist.draw(number / FPS).astype(int)
        assert np.abs(pictures[number] - drawn).mean() < 6
    heard = sound_of(ffmpeg, path)
    loud = np.flatnonzero(np.abs(heard.astype(int)) > 1500) / RATE
    assert loud[0] == pytest.approx(-animation.times[0], abs=0.03)
    assert loud[-1] == pytest.approx(1.6 - animation.times[0], abs=0.03)


@full
def test_a_video_lasts_as_long_as_its_sound(ffmpeg, spoken, tmp_path):
    animation = spoken("crab")
    audio = ll.Audio(np.ones(RATE * 3, np.int16), RATE)
    longer = replace(animation, schedule=replace(animation.schedule, audio=audio))
    longer.cut().save(tmp_path / "line.mp4")
    assert len(frames_of(ffmpeg, tmp_path / "line.mp4")) == 3 * FPS + 1


def test_pictures_and_videos_wait_for_no_offset(spoken):
    animation = spoken("facefx")
    usual, late = (
        staged(animation),
        staged(replace(animation, export=ExportSettings(offset=3600.0))),
    )
    assert (late.seconds, late.sound) == (usual.seconds, usual.sound)
    np.testing.assert_array_equal(late.moves, usual.moves)


@full
def test_a_video_at_a_rate_of_television_has_it_exactly(ffmpeg, spoken, tmp_path):
    replace(spoken("facefx").cut(), fps=24000 / 1001).save(tmp_path / "line.mp4")
    assert " 23.98 fps" in asked(ffmpeg, tmp_path / "line.mp4")[1]


@full
def test_a_schedule_without_sound_makes_a_silent_video(ffmpeg, spoken, tmp_path):
    animation = spoken("crab")
    silent = replace(animation, schedule=replace(animation.schedule, audio=None))
    silent.save(tmp_path / "line.mp4")
    _, about = asked(ffmpeg, tmp_path / "line.mp4")
    assert "Video: h264" in about
    assert "Audio" not in about
    assert len(frames_of(ffmpeg, tmp_path / "line.mp4")) == len(animation.times)


def test_frames_come_in_order_whatever_is_drawn_first_and_few_are_drawn_ahead(monkeypatch):
    monkeypatch.setattr(video.os, "cpu_count", lambda: 3)
    begun, late = [], Event()

    def draw(seconds):
        begun.append(seconds)
        if seconds == 0:
            late.wait(60)  # the first frame ends after the second one
        if seconds == 1:
            late.set()
        return np.full(1, seconds)

    for number, frame in enumerate(video.drawn(draw, range(40))):
        assert frame == number
        assert len(begun) <= number + 3 * video.AHEAD
    assert sorted(begun) == list(range(40))


def test_a_frame_that_cannot_be_drawn_ends_the_film(monkeypatch):
    monkeypatch.setattr(video.os, "cpu_count", lambda: 2)
    begun = []

    def draw(seconds):
        begun.append(seconds)
        return 1 / (seconds - 5)

    with pytest.raises(ZeroDivisionError):
        list(video.drawn(draw, range(40)))
    assert len(begun) <= 2 * video.AHEAD


@full
@pytest.mark.usefixtures("ffmpeg")
def test_what_ffmpeg_says_is_told_and_no_file_is_left(spoken, tmp_path, monkeypatch):
    monkeypatch.setitem(video.CODECS, "mp4", ("-c:v", "nothing-like-it"))
    with pytest.raises(OutputError, match=r"ffmpeg.*: .*\w"):
        spoken("crab").save(tmp_path / "line.mp4")
    assert not [*tmp_path.iterdir()]


def test_a_sheet_has_a_still_of_every_sound_with_its_name_and_time(stills, spoken):
    out = BytesIO()
    write_png(spoken("crab"), out)
    page = np.asarray(stills.open(out))
    step = SIZE + sheet.GAP
    assert page.shape[1] == 2 * sheet.EDGE + sheet.COLUMNS * step - sheet.GAP
    assert page.shape[0] == 2 * sheet.EDGE + 2 * (SIZE + sheet.FOOT)
    for place in range(len(LABELS)):
        row, column = divmod(place, sheet.COLUMNS)
        left = sheet.EDGE + column * step
        top = sheet.EDGE + row * (SIZE + sheet.FOOT)
        assert np.ptp(page[top : top + SIZE, left : left + SIZE]) > 100
        assert page[top + SIZE : top + SIZE + sheet.FOOT, left : left + SIZE].min() < 120


def still_at(image, animation, seconds, **view):
    """Return the only picture of a sheet of one moment."""
    out = BytesIO()
    sheet.moments(animation, [seconds], out, **view)
    page = np.asarray(image.open(out)).astype(int)
    return page[sheet.EDGE : sheet.EDGE + SIZE, sheet.EDGE : sheet.EDGE + SIZE]


@full
def test_stills_of_any_line_are_taken_from_one_place(stills):
    performer = ll.resolve("english", "facefx")
    lines = [("P", "AA"), ("P", "S")]
    said = [performer.perform(ll.Schedule(one, [0, 0.1, 0.3]), fps=FPS) for one in lines]
    first, second = (still_at(stills, one, float(one.times[0])) for one in said)
    close = still_at(stills, said[0], float(said[0].times[0]), close=True)
    np.testing.assert_array_equal(first, second)
    assert np.abs(close - first).max() > 50
    opened = still_at(stills, said[0], 0.2)
    assert np.abs(opened - first).max() > 50


def test_stills_are_of_the_times_asked_for(stills, cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = [{"label": "P", "start": 0, "end": 0.1}, {"label": "AA", "start": 0.1, "end": 0.3}]
    Path("line.timings.json").write_text(json.dumps(rows), "utf-8")
    line = ("stills", "-l", "english", "-c", "facefx", "--schedule", "line.timings.json")
    done = cli(*line, "--at", "0.05,0.2", "-o", "line.png")
    assert done.code == 0, done.err
    width = np.asarray(stills.open("line.png")).shape[1]
    assert width == 2 * sheet.EDGE + 2 * SIZE + sheet.GAP
    for at, told in (
        ("9", "9 s is outside the animation"),
        ("soon", "write seconds separated by commas"),
    ):
        done = cli(*line, "--at", at, "-o", "other.png")
        assert (done.code, Path("other.png").exists()) == (2, False)
        assert told in done.err


def test_of_many_sounds_the_most_different_are_shown():
    labels = ("AA", "B") * 20
    schedule = ll.Schedule(("_", *labels, "UW"), np.arange(43) * 0.2, notation="arpabet")
    performer = ll.resolve("english", "facefx")
    chosen = sheet._chosen(performer.perform(schedule, fps=FPS))  # noqa: SLF001
    assert len(chosen) == sheet.MOST
    assert (np.diff(chosen) > 0).all()
    assert 0 not in chosen, "silence is no sound"
    assert 41 in chosen, "the only one of its kind"


@full
@pytest.mark.usefixtures("stills")
@pytest.mark.parametrize(
    "word",
    swept(["\ud800", "здравствуйте", "你好", "שלום", "नमस्ते", "a\nb", "x" * 200, "\U0001f600"]),
)
def test_words_in_any_script_are_written_or_boxed(spoken, word):
    animation = spoken("crab")
    words = (ll.Word(word, 0, 8),)
    out = BytesIO()
    write_png(replace(animation, schedule=replace(animation.schedule, words=words)), out)
    assert out.getvalue().startswith(b"\x89PNG")


@full
def test_the_command_line_makes_both(ffmpeg, stills, cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = [{"label": label, "start": n / 5, "end": (n + 1) / 5} for n, label in enumerate(LABELS)]
    (tmp_path / "line.json").write_text(json.dumps({"phonemes": rows, "notation": "arpabet"}))
    outputs = ["--fps", "24", "-o", "line.mp4", "-o", "line.png"]
    done = cli("run", "--schedule", "line.json", "-l", "english", "-c", "facefx", *outputs)
    assert done.code == 0, done.err
    assert len(frames_of(ffmpeg, "line.mp4")) == pytest.approx(24 * 2.1, abs=3)
    with stills.open("line.png") as page:
        assert page.width > 4 * SIZE


# What is missing


@pytest.mark.parametrize(
    ("write", "module", "told"),
    [
        (write_mp4, "imageio_ffmpeg", "video needs ffmpeg"),
        (write_mp4, "PIL", "pictures need Pillow"),
        (write_png, "PIL", "pictures need Pillow"),
    ],
)
def test_a_missing_library_names_the_extra(spoken, monkeypatch, write, module, told):
    if write is write_mp4 and module == "PIL":
        pytest.importorskip("imageio_ffmpeg", reason="it is asked for first")
    monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.setenv("PATH", "")  # another ffmpeg would serve
    with pytest.raises(OutputError, match=rf'{told}: .*pip install "lipsync-lang\[video\]"'):
        write(spoken("crab"), BytesIO())


@pytest.mark.parametrize("write", [write_mp4, write_png])
@pytest.mark.usefixtures("ffmpeg")
def test_without_a_model_one_is_asked_for(spoken, write):
    with pytest.raises(OutputError, match=r"no model.*`model`"):
        write(replace(spoken("crab"), model=None), BytesIO())
