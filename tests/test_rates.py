"""Frame rates: what is written at any of them closes the mouth where it must be closed."""

from dataclasses import replace

import numpy as np
import pytest
from small_models import glb
from test_engine_files import READERS, bytes_of, shown
from test_godot import from_tres
from test_held_files import READERS as DRAWN
from test_usd import from_usda

import lipsync_lang as ll
from lipsync_lang.animations.readers.registry import read_animation
from lipsync_lang.animations.registry import load_writers
from lipsync_lang.quality.checks import check

WRITERS = load_writers()
RATES = (12, 23.976, 24, 25, 29.97, 30, 48, 60, 90, 120)

ONLY = {"azure": (60,)}
"""Rates of formats that have no others."""

SCHEDULE = ll.Schedule(
    ("P", "AA1", "B", "IY1", "_", "M", "AH0", "F", "AA1", "V", "P", "OW1", "M"),
    np.cumsum([0, 0.031, 0.2, 0.005, 0.17, 0.4, 0.02, 0.11, 0.03, 0.2, 0.011, 0.06, 0.3, 0.09]),
    notation="arpabet",
)
"""Contacts of 5 ms and longer, after each other and between open mouths."""

DRAWABLE = ll.Schedule(
    (*SCHEDULE.labels[:9], *SCHEDULE.labels[11:]),
    np.delete(SCHEDULE.times, [10, 11]),
    notation="arpabet",
)
"""The same without two contacts on one frame, of which a drawing can show only one."""


def seen(animation, weights):
    """Return how many sounds make the contact that they demand, and how many do not."""
    figures = check(replace(animation, weights=weights)).figures
    parts = [figure.parts for figure in figures if figure.name.startswith("contacts")]
    return sum(part["made"] for part in parts), sum(part["missed"] for part in parts)


def by_reading(name, animation, tmp_path):
    """Return (T, P) what our own reader finds in a file."""
    path = tmp_path / f"line{WRITERS[name].suffix}"
    path.write_bytes(bytes_of(name, animation))
    there = read_animation(path)
    columns = [there.names.index(pose) for pose in animation.poses]
    found = [np.interp(animation.times, there.times, there.values[:, n]) for n in columns]
    return np.column_stack(found)


@pytest.mark.parametrize("fps", RATES)
def test_contacts_are_seen_in_every_file_at_every_rate(fps, tmp_path):
    animation = ll.resolve("english", "arkit").perform(SCHEDULE, fps=fps)
    model = glb(tmp_path / "face.glb", *animation.poses)
    animation = replace(animation, model=model)
    assert seen(animation, animation.weights) == (7, 0)
    for name in READERS:
        if fps in ONLY.get(name, RATES):
            assert seen(animation, shown(name, bytes_of(name, animation), animation)) == (7, 0)
    for name in ("csv", "glb", "json"):
        assert seen(animation, by_reading(name, animation, tmp_path)) == (7, 0)
    sparse = replace(animation, tolerance=0.005)
    assert seen(animation, by_reading("glb", sparse, tmp_path)) == (7, 0)
    for name, read, prefix in (("godot", from_tres, ".:blend_shapes/"), ("usd", from_usda, "")):
        curves = read(bytes_of(name, animation), animation)
        found = [np.interp(animation.times, *curves[prefix + pose]) for pose in animation.poses]
        assert seen(animation, np.column_stack(found)) == (7, 0)


@pytest.mark.parametrize("fps", RATES)
@pytest.mark.parametrize("character", ["rhubarb", "preston-blair", "facefx"])
def test_contacts_are_seen_in_every_file_of_drawings_at_every_rate(character, fps):
    animation = ll.resolve("english", character).perform(DRAWABLE, fps=fps)
    assert seen(animation, animation.weights) == (5, 0)
    for name in DRAWN if character == "rhubarb" else ["moho"]:
        cues = DRAWN[name](bytes_of(name, animation), animation)
        weights = np.zeros_like(animation.weights)
        for frame, seconds in enumerate(animation.times.clip(0, DRAWABLE.end - 0.01) + 0.006):
            shape = next(shape for start, _, shape in reversed(cues) if start <= seconds)
            if shape in animation.poses:
                weights[frame, animation.poses.index(shape)] = 1
        assert seen(animation, weights) == (5, 0), name


@pytest.mark.parametrize("fps", RATES)
def test_the_first_and_the_last_frame_of_every_file_are_at_rest(fps):
    animation = ll.resolve("english", "arkit").perform(SCHEDULE, fps=fps)
    for name in READERS:
        if fps in ONLY.get(name, RATES):
            weights = shown(name, bytes_of(name, animation), animation)
            assert np.abs(weights[[0, -1]]).max() < 1e-4, name
