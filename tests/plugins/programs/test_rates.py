"""Frame rates: at all of them, written files close the mouth at contacts."""

from dataclasses import replace

import numpy as np
import pytest
from lanes import swept
from small_models import glb
from test_drawn_mouth_files import READERS as DRAWN
from test_engine_files import READERS, bytes_of, shown
from test_godot import from_tres
from test_usd import from_usda

import lipsync_lang as ll
from lipsync_lang.animations.animation import ExportSettings
from lipsync_lang.animations.animation_readers import read_animation
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.animations.rates import exact, parse_offset, parse_rate, timecode
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.reports.quality.check_animation import check

RATES = (12, 23.976, 24, 25, 29.97, 30, 48, 60, 90, 120)

ONLY = {"azure": (60,)}
"""Fixed frame rates of formats."""

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
"""The same line without two contacts on one frame, since a drawing can show only one."""


def seen(animation, weights):
    """Count the sounds that make their contact, and those that do not."""
    figures = check(replace(animation, weights=weights)).figures
    judged = (figure for figure in figures if figure.value is not None)
    parts = [figure.parts for figure in judged if figure.name.startswith("contacts ")]
    return sum(part["made"] for part in parts), sum(part["missed"] for part in parts)


def by_reading(name, animation, tmp_path):
    """Return the values that the package's reader finds in a file, (T, P)."""
    path = tmp_path / f"line{WRITERS[name].suffix}"
    path.write_bytes(bytes_of(name, animation))
    there = read_animation(path)
    columns = [there.names.index(pose) for pose in animation.poses]
    found = [np.interp(animation.times, there.times, there.values[:, n]) for n in columns]
    return np.column_stack(found)


@pytest.mark.parametrize("fps", swept(RATES, quick=[12, 24, 29.97]))
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
    sparse = replace(animation, export=ExportSettings(key_error=0.005, key_lines=True))
    assert seen(animation, by_reading("glb", sparse, tmp_path)) == (7, 0)
    for name, read, prefix in (("godot", from_tres, ".:blend_shapes/"), ("usd", from_usda, "")):
        curves = read(bytes_of(name, animation), animation)
        found = [np.interp(animation.times, *curves[prefix + pose]) for pose in animation.poses]
        assert seen(animation, np.column_stack(found)) == (7, 0)


@pytest.mark.parametrize("fps", swept(RATES, quick=RATES[::3]))
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


@pytest.mark.parametrize("fps", swept(RATES, quick=[60]))
def test_the_first_and_the_last_frame_of_every_file_are_at_rest(fps):
    animation = ll.resolve("english", "arkit").perform(SCHEDULE, fps=fps)
    for name in READERS:
        if fps in ONLY.get(name, RATES):
            weights = shown(name, bytes_of(name, animation), animation)
            assert np.abs(weights[[0, -1]]).max() < 1e-4, name


@pytest.mark.parametrize(
    ("written", "fps"),
    [
        ("23.976", 24000 / 1001),
        ("23.98", 24000 / 1001),
        ("29.97", 30000 / 1001),
        ("59.94", 60000 / 1001),
        ("119.88", 120000 / 1001),
        ("30000/1001", 30000 / 1001),
        ("24", 24),
        ("1", 1),
        ("12.5", 12.5),
        ("999", 999),
        ("1000", 1000),
    ],
)
def test_rates_of_television_are_the_fractions_that_they_stand_for(written, fps):
    assert parse_rate(written) == pytest.approx(fps, rel=1e-12)
    assert exact(parse_rate(written)) == parse_rate(written)


@pytest.mark.parametrize(
    ("text", "fps", "seconds"),
    [
        ("1.5", 24, 1.5),
        ("-5", 24, -5),
        ("01:00:00:00", 24, 3600),
        ("01:00:00:00", 24000 / 1001, 3603.6),
        ("00:01:01:15", 30, 61.5),
        ("24:00:00:00", 60, 86400),
        ("23:59:59:23", 24000 / 1001, 86486.4 - 1001 / 24000),
        ("0:0:0:24", 25, 0.96),
    ],
)
def test_an_offset_is_seconds_or_a_frame(text, fps, seconds):
    assert parse_offset(text, fps) == pytest.approx(seconds)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("01:00:00:25", "a second has frames 0 to 24 here"),
        ("01:00:00;00", "a semicolon means drop-frame"),
        ("99:00:00:00", "a timeline lasts at most one day"),
        ("-1e9", "a timeline lasts at most one day"),
        ("inf", "a timeline lasts at most one day"),
        ("nan", "a timeline lasts at most one day"),
        ("1:2:3", "write seconds"),
        ("", "write seconds"),
    ],
)
def test_an_offset_that_is_none_is_told(text, told):
    with pytest.raises(LipsyncError, match=f"--offset {text}: {told}"):
        parse_offset(text, 25)


@pytest.mark.parametrize("fps", RATES)
@pytest.mark.parametrize("frame", [0, 1, 59, 3599, 3600, 216_000, 2_591_999])
def test_a_timecode_is_read_back(frame, fps):
    rate = exact(fps)
    if frame / rate < 86_400:
        assert parse_offset(timecode(frame, rate), rate) == pytest.approx(frame / rate)
