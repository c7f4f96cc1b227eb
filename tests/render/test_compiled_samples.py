"""The compiled kernel draws the samples that numpy draws, to the last bit."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full

import lipsync_lang as ll
from lipsync_lang.pipeline import kernel
from lipsync_lang.render.model import light, picture
from lipsync_lang.render.model.light import LINEAR_LIGHT
from lipsync_lang.render.model.picture import FINE, Artist, Faces
from lipsync_lang.render.model.raster import MIN_AREA, Window, area, fill, planes
from lipsync_lang.render.staging import staged

pytestmark = pytest.mark.skipif(
    kernel.compiled is None, reason="no C compiler built the kernel, or it is switched off"
)

# Corners on samples, beside them, at equal heights, and far outside.
places = st.one_of(
    st.integers(-3, 30).map(float), st.floats(-40, 70), st.sampled_from([0.5, 1e-12, 29.0, 1e5])
)
depths = st.one_of(st.floats(0.01, 2), st.just(0.5))
triangles = st.lists(
    st.tuples(*[st.tuples(places, places, depths)] * 3), min_size=1, max_size=12
).map(np.array)
windows = st.tuples(*[st.integers(0, 14)] * 2, *[st.integers(0, 14)] * 2).map(
    lambda sides: Window(
        2 * sides[0], 2 * sides[1], 2 * (sides[0] + sides[2]), 2 * sum(sides[1::2])
    )
)


def in_numpy(function, *arguments):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kernel, "compiled", None)
        return function(*arguments)


def visible(corners):
    """Return the corners, depths and numbers of triangles with an area."""
    some = np.abs(area(corners[..., :2])) > MIN_AREA
    parts = corners[some, :, :2].copy(), corners[some, :, 2].copy()
    return (*parts, np.flatnonzero(some))


@given(triangles, windows)
def test_triangles_cover_the_same_samples_at_the_same_depths(corners, window):
    def filled():
        keys = np.zeros(window.width * (window.bottom - window.top), np.uint64)
        fill(keys, window, *visible(corners))
        return keys

    np.testing.assert_array_equal(filled(), in_numpy(filled))


@given(st.integers(0, 2**32 - 1), st.integers(0, 9), st.integers(0, 9))
def test_samples_have_the_same_pixels(seed, rows, columns):
    rng = np.random.default_rng(seed)
    shape = 3, FINE * rows, FINE * columns
    steps = rng.integers(-99, 4200, shape) / light._SHADE_STEPS  # noqa: SLF001
    samples = (steps + rng.choice([0, 1e-4], shape)).astype(np.float32)
    made = picture._pixels(samples)  # noqa: SLF001
    np.testing.assert_array_equal(made, in_numpy(picture._pixels, samples))  # noqa: SLF001


@pytest.mark.parametrize("textured", [False, True])
@given(triangles, windows, st.integers(0, 2**32 - 1))
def test_samples_have_the_same_light(textured, corners, window, seed):
    rng, side = np.random.default_rng(seed), 56
    artist = artists("crab", textured=textured)
    flat, depth, names = visible(corners)
    values = rng.normal(0.3, 0.4, (len(flat), 3, 7 if textured else 4))
    values[..., 6:] = rng.uniform(0.5, 2, values[..., 6:].shape)
    looks = planes(flat, values).transpose(1, 2, 0).astype(np.float32, order="C")
    faces = Faces(rng.permutation(12_000)[: len(names)], flat, depth, looks)
    keys = np.zeros((side, side), np.uint64)
    ground = rng.random((3, side, side), dtype=np.float32)
    expected = in_numpy(artist._drawn, faces, window, keys, ground)  # noqa: SLF001
    found = artist._drawn(faces, window, keys, ground)  # noqa: SLF001
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)


@cache
def scenes(character, *, textured):
    """Return the scene of a short line that a character says with its gestures."""
    performer = ll.resolve("english", character)
    labels, times = ("B", "AA", "M", "UW", "F", "IY"), np.arange(7) * 0.1
    said = ll.Schedule(labels, times, notation="arpabet")
    animation = performer.rigged(performer.perform(said, fps=30, gestures="all"))
    weights = animation.weights.copy()
    for column, channel in enumerate(animation.columns):
        if channel.node is not None:
            weights[8:12, column] = 3
    scene = staged(replace(animation, weights=weights))
    if textured:  # all but one material
        rng = np.random.default_rng(5)
        for material in scene.materials[1:]:
            texels = rng.integers(0, 256, (*rng.integers(1, 9, 2), 4)).astype(np.uint8)
            object.__setattr__(material, "texture", texels)
        scene.places = rng.normal(0, 3, scene.places.shape)
    return scene


@cache
def artists(character, *, textured=False):
    return Artist(scenes(character, textured=textured), 40)


@pytest.mark.parametrize(
    ("character", "textured"),
    [("crab", False), ("crab", True), pytest.param("facefx", False, marks=full)],
)
def test_frames_have_the_same_bytes(character, textured):
    scene = scenes(character, textured=textured)
    other = in_numpy(Artist, scene, 40)
    assert other._textured.any() == textured  # noqa: SLF001
    assert not other._textured.all()  # noqa: SLF001
    for seconds in np.linspace(0, scene.seconds, 9):
        frame = artists(character, textured=textured).draw(seconds)
        np.testing.assert_array_equal(frame, in_numpy(other.draw, seconds))


def test_the_kernel_refuses_samples_that_it_could_not_read():
    keys, window, names = np.zeros(4, np.uint64), (0, 0, 2, 2), np.zeros(1, np.intp)
    corners, depth = np.zeros((1, 3, 2)), np.ones((1, 3))
    lit, looks = np.zeros((3, 4), np.float32), np.zeros((3, 7, 1), np.float32)
    textures = (None, np.zeros((2, 3, 4), np.uint8))
    shades, made = np.zeros(light._SHADE_STEPS, np.uint8), np.zeros((1, 1, 3), np.uint8)  # noqa: SLF001
    sound = {
        "fill": (keys, *window, corners, depth, names),
        "shade": (keys, *window, lit, names, 7, 1, looks, names + 1, textures, LINEAR_LIGHT),
        "average": (lit, 2, 2, 2, shades, made),
    }
    wrong = (None, -1, 2**40, np.zeros(7, np.float32), np.zeros((2, 3))[:, :2])
    for name, arguments in sound.items():
        call = getattr(kernel.compiled, name)
        call(*arguments)
        for at, _ in enumerate(arguments):
            for other in wrong:
                with pytest.raises((TypeError, ValueError, OverflowError, BufferError)):
                    call(*arguments[:at], other, *arguments[at + 1 :])
        with pytest.raises((TypeError, ValueError)):
            call(*arguments[1:])
        frozen = [one.copy() if isinstance(one, np.ndarray) else one for one in arguments]
        for one in frozen:
            if isinstance(one, np.ndarray):
                one.setflags(write=False)
        with pytest.raises((BufferError, ValueError), match=r"read-only|writable"):
            call(*frozen)
    objects = np.full(4, None)
    with pytest.raises(TypeError, match="keys: Python's objects instead of numbers"):
        kernel.compiled.fill(objects, *sound["fill"][1:])
    assert objects.tolist() == [None] * 4


def test_the_kernel_refuses_textures_that_are_none():
    window, names = (0, 0, 2, 2), np.zeros(1, np.intp)
    arrays = np.zeros(4, np.uint64), *window, np.zeros((3, 4), np.float32), names
    looks = {count: np.zeros((3, count, 1), np.float32) for count in (4, 7)}
    sound = np.zeros((2, 3, 4), np.uint8)
    flat, hollow, wide = sound[0], sound[:0], sound.astype(np.uint16)
    for count, number, textures in (
        (7, 0, (None,)), (7, 1, (sound,)), (7, 2**60, (sound,)), (4, 0, (sound,)), (7, 0, [sound]),
        (7, 0, (flat,)), (7, 0, (hollow,)), (7, 0, (wide,)), (7, 0, ("x",)),
        (7, 0, (sound[:, ::2],)),
    ):  # fmt: skip
        rest = count, 1, looks[count], names + number, textures, LINEAR_LIGHT
        with pytest.raises((TypeError, ValueError, BufferError)):
            kernel.compiled.shade(*arrays, *rest)
    kernel.compiled.shade(*arrays, 4, 1, looks[4], names - 1, (None, sound), LINEAR_LIGHT)
