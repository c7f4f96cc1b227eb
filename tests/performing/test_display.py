"""How performers and animations look in a console, in a notebook, and to numpy and data frames."""

import sys
from dataclasses import replace
from types import SimpleNamespace
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import lipsync_lang as ll


@pytest.fixture(scope="module")
def animation():
    schedule = ll.Schedule(
        ("HH", "AY", "M"), [0, 0.1, 0.3, 0.4], words=(ll.Word("<b>hi & me</b>", 0, 3),)
    )
    return ll.resolve("english", "facefx").perform(schedule)


def test_each_is_one_line_in_a_console(animation):
    assert repr(animation.source.performer) == (
        "<Performer english on facefx: 21 common phonemes, 9 poses>"
    )
    said = f"<Animation '<b>hi & me</b>': {len(animation)} frames of 9 poses at 60 fps, "
    assert repr(animation).startswith(said)
    assert repr(replace(animation, times=np.empty(0), weights=np.empty((0, 9)))) == (
        "<Animation '<b>hi & me</b>': 0 frames of 9 poses at 60 fps>"
    )
    assert len(repr(animation.source.performer.compiled)) < 100


def test_notebooks_show_the_curves_that_move(animation):
    page = ET.fromstring(animation._repr_html_())  # noqa: S314 our own
    moving = [pose for pose, curve in animation if np.ptp(curve) > 0]
    assert moving
    assert [line.findtext("title") for line in page.iter("polyline")] == moving
    assert [span.text for span in page.iter("span")] == moving
    assert "<b>" not in animation._repr_html_()
    points = next(page.iter("polyline")).get("points").split()
    assert (points[0].split(",")[0], points[-1].split(",")[0]) == ("0.0", "720.0")


def test_notebooks_show_a_name_as_it_is(animation):
    renamed = replace(animation, poses=("<script>", *animation.poses[1:]))
    assert "<script>" not in renamed._repr_html_()
    assert "&lt;script&gt;" in renamed._repr_html_()


def test_notebooks_stay_light(animation):
    often = 300
    long = replace(
        animation,
        times=np.arange(len(animation) * often) / 60,
        weights=np.tile(animation.weights, (often, 1)),
    )
    assert len(long._repr_html_()) < 100_000
    empty = replace(animation, times=np.empty(0), weights=np.empty((0, 9)))
    assert "0 frames" in empty._repr_html_()


def test_notebooks_show_what_a_performer_has(animation):
    shown = animation.source.performer._repr_html_()
    assert shown.startswith("<pre>english on facefx")
    assert shown.endswith("</pre>")


def test_an_animation_is_its_poses_and_their_curves(animation):
    assert len(animation) == len(animation.times)
    assert [pose for pose, _ in animation] == list(animation.poses)
    assert all(np.array_equal(curve, animation[pose]) for pose, curve in animation)
    assert np.array_equal(dict(animation)["open"], animation["open"])
    assert "open" in animation
    assert "opne" not in animation
    assert replace(animation, times=np.empty(0), weights=np.empty((0, 9)))


def test_numpy_takes_the_weights(animation):
    assert np.asarray(animation) is animation.weights
    assert np.array_equal(np.asarray(animation, np.float32), animation.weights.astype(np.float32))
    copied = np.array(animation)
    assert np.array_equal(copied, animation.weights)
    assert not np.shares_memory(copied, animation.weights)


@pytest.mark.parametrize(("asked", "there"), [
    (None, ["pandas", "polars"]), (None, ["polars"]), ("polars", ["pandas", "polars"]),
])  # fmt: skip
def test_data_frames_have_a_column_for_each_pose(animation, asked, there, monkeypatch):
    for name in ("pandas", "polars"):
        made = SimpleNamespace(DataFrame=lambda data, name=name: (name, data))
        monkeypatch.setitem(sys.modules, name, made if name in there else None)
    library, data = animation.to_frame(asked)
    assert library == (asked or there[0])
    assert list(data) == ["time_s", *animation.poses]
    assert np.array_equal(data["open"], animation["open"])


def test_a_library_that_is_missing_is_named(animation, monkeypatch):
    for name in ("pandas", "polars"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ll.LipsyncError, match="pandas and polars are not installed; install pan"):
        animation.to_frame()
    with pytest.raises(ll.LipsyncError, match=r"polars is not installed; .*pip install polars"):
        animation.to_frame("polars")
    with pytest.raises(ll.LipsyncError, match="`library` is 'excel'; it is one of 'pandas'"):
        animation.to_frame("excel")


def test_a_notebook_shows_the_page_in_a_frame_of_its_own(animation, tmp_path):
    animation.save(tmp_path / "line.html")
    shown = animation.show(500)
    frame = ET.fromstring(shown._repr_html_())  # noqa: S314 our own
    assert (frame.tag, frame.get("sandbox"), frame.get("height")) == (
        "iframe",
        "allow-scripts",
        "500",
    )
    assert frame.get("srcdoc") == (tmp_path / "line.html").read_text("utf-8").replace("\n", " ")
    assert "line.html" in repr(shown)
