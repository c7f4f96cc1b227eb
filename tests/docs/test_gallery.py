"""The gallery shows every pose set as a moving picture."""

import re
import runpy

import numpy as np
import pytest
from places import ROOT

import lipsync_lang as ll
from lipsync_lang.packs.yaml.events import load_yaml

DOCS = ROOT / "docs"
NAMES = sorted(p.parent.name for p in DOCS.parent.glob("posesets/*/poseset.yaml"))
assert NAMES, "a sweep over nothing passes"

PAGE = (DOCS / "gallery.md").read_text("utf-8")
SECTIONS = dict(re.findall(r"^## (\S+)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL))
MOST_BYTES = 6_000_000


def script():
    return runpy.run_path(str(DOCS / "draw_gallery.py"))


def test_the_sections_are_the_pose_sets():
    assert list(SECTIONS) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_section_has_a_picture_a_command_and_a_link(name):
    alt, path = re.search(r"!\[([^\]]+)\]\(([^)]+)\)", SECTIONS[name]).groups()
    assert path == f"images/gallery-{name}.webp"
    assert len(alt.split()) >= 8
    assert f"-c {name} " in SECTIONS[name]
    assert f"reference/posesets.md#{name})" in SECTIONS[name]


@pytest.mark.parametrize("name", NAMES)
def test_a_picture_moves(name):
    image = pytest.importorskip("PIL.Image")
    with image.open(DOCS / f"images/gallery-{name}.webp") as picture:
        assert picture.n_frames > 5


def test_the_pictures_are_small_and_none_is_left_over():
    files = sorted(DOCS.glob("images/gallery-*.webp"))
    assert sorted(path.stem.removeprefix("gallery-") for path in files) == NAMES
    assert sum(path.stat().st_size for path in files) < MOST_BYTES


def test_each_picture_has_a_small_film_with_sound():
    films = sorted(DOCS.glob("images/*.mp4"))
    assert {f"gallery-{name}" for name in NAMES} <= {path.stem for path in films}
    for path in films:
        content = path.read_bytes()
        assert path.with_suffix(".webp").is_file()
        assert b"soun" in content, "no track of sound"
        assert b"avc1" in content
        assert content.find(b"moov") < content.find(b"mdat"), "it starts before it is whole"
    assert sum(path.stat().st_size for path in films) < MOST_BYTES
    assert all(f"images/gallery-{name}.mp4" in SECTIONS[name] for name in NAMES)


def test_every_pose_of_a_drawn_set_has_a_drawing():
    pytest.importorskip("PIL")
    for name, mouths in script()["DRAWN"].items():
        text = (DOCS.parent / "posesets" / name / "poseset.yaml").read_text("utf-8")
        pack = load_yaml(text)
        assert set(mouths) == {*pack["poses"], pack["neutral"]}


def test_the_head_stands_for_itself_as_it_is():
    pytest.importorskip("PIL")
    drawing = script()
    poses = ("open", "W", "ShCh", "PBM", "FV", "wide")
    gains = drawing["worth"](drawing["HEAD"], poses, poses)
    assert abs(gains - np.eye(len(poses))).max() < 0.05


@pytest.mark.parametrize("name", ["arkit", "mpeg4", "oculus", "sapi"])
def test_the_head_shuts_its_lips_for_another_pose_set(name):
    pytest.importorskip("PIL")
    schedule = ll.Schedule(("_", "m", "ɑː", "_"), [0, 0.2, 0.4, 0.7, 0.9])
    animation = ll.resolve("english", name).perform(schedule, fps=60)
    head = script()["lent"](animation, name)
    shut, parted = (np.interp(0.3, head.times, head[p]) for p in ("PBM", "open"))
    assert shut > 0.6
    assert parted < 0.15
    assert np.interp(0.6, head.times, head["open"]) > 0.2


def test_the_human_head_has_its_credit_below_it():
    page = (DOCS / "how-to" / "make-a-face-look-alive.md").read_text("utf-8")
    _, below = page.split("images/human-head.webp)\n\n")
    credit = below.splitlines()[0]
    assert "images/human-head.mp4" in credit
    assert "ICT-FaceKit, (c) 2020 USC Institute for Creative Technologies, MIT" in credit
    assert all((DOCS / "images" / f"human-head.{form}").is_file() for form in ("webp", "mp4"))
