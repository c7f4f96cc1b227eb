"""Animations and every writer of them."""

import csv
import json
import re
import wave
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from glb_files import document_of, mesh, model_of, tracks
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from lanes import full, of_plug_in
from take_files import READ_BACK as TAKES
from test_line_page import data_of
from test_video import NEEDS
from test_video import READ_BACK as PICTURES

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.base.errors import LipsyncError, OutputError
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import TIMING_READERS, find_reader

assert WRITERS, "a sweep over nothing passes"
every_writer = pytest.mark.parametrize("writer", WRITERS.values(), ids=WRITERS)
every_file = pytest.mark.parametrize(
    "writer",
    [pytest.param(w, id=n, marks=[full] * (n in PICTURES)) for n, w in WRITERS.items()],
)
"""All writers; those of pictures have their own tests, and run in the full lane."""

FPS = 30
NOISE = np.random.default_rng(0).integers(-32768, 32767, 4000).astype(np.int16)


SCHEDULE = ll.Schedule(
    ("HH", "AH0", "L", "OW1", "_", "P"),
    (0, 0.1, 0.2, 0.3, 0.5, 0.52, 0.6),
    words=(ll.Word("hello", 0, 4), ll.Word("“p”, \\", 5, 6)),
    notation="arpabet",
    language="english",
    audio=ll.Audio(NOISE, 8000),
)

SUITED = {
    "azure": ("arkit", 60),
    "live-link-face": ("arkit", 60),
    "rhubarb-json": ("rhubarb", FPS),
    "rhubarb-tsv": ("rhubarb", FPS),
    "rhubarb-xml": ("rhubarb", FPS),
}
"""Character and frame rate for writers with requirements."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("model")


def performed(character, fps, folder):
    animation = ll.resolve("english", character).perform(SCHEDULE, fps=fps)
    model = folder / f"{character}.glb"
    model.write_bytes(model_of(document_of(mesh("Face", animation.poses[:3]))))
    return replace(animation, model=model)


@pytest.fixture
def suited(writer, folder, monkeypatch):
    """Settings for a writer of the sweep; videos are small."""
    for package in NEEDS.get(writer.name, ()):
        pytest.importorskip(package, reason=f"{writer.name} needs {package}, which is an extra")
    monkeypatch.setattr("lipsync_lang.render.video.FRAME_PIXELS", 64)
    return performed(*SUITED.get(writer.name, ("facefx", FPS)), folder)


@pytest.fixture(scope="module")
def animation(folder):
    return performed("facefx", FPS, folder)


def written(writer, animation):
    out = BytesIO()
    writer.write(animation, out)
    assert not out.closed, "the stream belongs to the caller"
    return out.getvalue()


def read_csv(content):
    rows = list(csv.reader(content.decode("utf-8").splitlines()))
    numbers = np.array(rows[1:], float)
    return rows[0][0], tuple(rows[0][1:]), numbers[:, 0], numbers[:, 1:]


def as_csv(content, animation):
    first, poses, times, weights = read_csv(content)
    assert (first, poses) == ("time_s", animation.poses)
    np.testing.assert_allclose(times, animation.times, atol=1e-6)
    np.testing.assert_allclose(weights, animation.weights, atol=1e-5)


IN_DOUBT = st.integers(-300_000, 300_000).map(lambda n: (n + 0.5) / 1e5)
"""Weights half way between two numbers of five digits, as exact as floats can be."""


@given(arrays(float, (3, 2), elements=st.floats(-360, 360) | IN_DOUBT))
def test_json_holds_weights_as_python_rounds_them(weights):
    animation = Animation(np.arange(3) / 30, ("a", "b"), weights, 30, SCHEDULE)
    frames = json.loads(written(WRITERS["json"], animation))["frames"]
    rounded = [[round(weight, 5) for weight in row] for row in weights.tolist()]
    assert str(frames) == str(rounded)


def test_json_has_a_row_per_frame():
    animation = Animation(np.arange(2) / 30, ("a", "b"), np.eye(2), 30, SCHEDULE)
    text = written(WRITERS["json"], animation).decode()
    assert text.endswith(' "frames": [\n  [1.0, 0.0],\n  [0.0, 1.0]\n ]\n}\n')


def test_csv_is_the_same_however_many_rows_are_formatted_at_once(monkeypatch):
    animation = ll.resolve("english", "facefx").perform(SCHEDULE)
    whole = written(WRITERS["csv"], animation)
    monkeypatch.setattr("lipsync_lang.animations.writers.csv.ROWS_AT_ONCE", 7)
    assert written(WRITERS["csv"], animation) == whole
    assert whole.count(b"\n") == len(animation) + 1


def as_json(content, animation):
    document = json.loads(content)
    frames = np.array(document["frames"])
    times = document["start"] + np.arange(len(frames)) / document["fps"]
    assert document["poses"] == list(animation.poses)
    np.testing.assert_allclose(times, animation.times, atol=1e-5)
    np.testing.assert_allclose(frames, animation.weights, atol=1e-5)
    schedule = animation.schedule
    assert [row["label"] for row in document["phonemes"]] == list(schedule.labels)
    assert [row["text"] for row in document["words"]] == [word.text for word in schedule.words]
    np.testing.assert_allclose([r["start"] for r in document["phonemes"]], schedule.times[:-1])
    np.testing.assert_allclose([r["end"] for r in document["phonemes"]], schedule.times[1:])
    assert (document["language"], document["notation"]) == (schedule.language, schedule.notation)


def as_wav(content, animation):
    audio = animation.schedule.audio
    with wave.open(BytesIO(content)) as sound:
        assert sound.getparams()[:4] == (1, 2, audio.rate, len(audio.samples))
        samples = np.frombuffer(sound.readframes(len(audio.samples)), "<i2")
    np.testing.assert_array_equal(samples, audio.samples)


def as_glb(content, animation):
    row, times, found = tracks(content)
    np.testing.assert_allclose(times, animation.times - animation.times[0], atol=1e-6)
    np.testing.assert_allclose(found["Face", "weights"], animation.weights[:, :3], atol=1e-6)
    assert row["extras"]["audio_start"] == pytest.approx(-animation.times[0], abs=1e-6)


def as_page(content, animation):
    (take,) = data_of(content.decode("utf-8"))["takes"]
    assert take["poses"] == list(animation.poses)
    np.testing.assert_allclose(
        np.column_stack([one["values"] / 65535 for one in take["curves"]]),
        animation.weights,
        atol=1e-5,
    )


def as_timings(name):
    """Return a check that a file of timings contains the schedule, without stress and words."""

    def check(content, animation):
        if name not in TIMING_READERS:
            pytest.skip("the plug-in that reads it was removed")
        found = find_reader(source := TimingFile(Path(f"line.{name}"), content), name).read(source)
        assert found.labels == animation.schedule.labels
        np.testing.assert_allclose(found.times, animation.schedule.times, atol=6e-4)

    return check


TIMINGS = {
    "audacity": as_timings("audacity"),
    "elan": as_timings("elan"),
    "textgrid": as_timings("textgrid"),
    "timings-csv": as_timings("table"),
    "timings-json": as_timings("json"),
}

READ_BACK = {
    "csv": as_csv,
    "glb": as_glb,
    "html": as_page,
    "json": as_json,
    "wav": as_wav,
    **of_plug_in("test_avatar_files", "READ_BACK"),
    **of_plug_in("test_engine_files", "READ_BACK"),
    **of_plug_in("test_godot", "READ_BACK"),
    **of_plug_in("test_subtitle_files", "READ_BACK"),
    **of_plug_in("test_usd", "READ_BACK"),
    **of_plug_in("test_drawn_mouth_files", "READ_BACK"),
    **PICTURES,
    **TAKES,
    **TIMINGS,
}


def test_every_writer_is_read_back():
    assert set(READ_BACK) == set(WRITERS)


@every_file
def test_what_is_written_is_what_was_performed(writer, suited):
    READ_BACK[writer.name](written(writer, suited), suited)
    READ_BACK[writer.name](written(writer, suited.cut()), suited.cut())


@every_file
def test_writing_twice_gives_the_same_bytes(writer, suited):
    again = suited.source.performer.perform(suited.schedule, fps=suited.fps)
    again = replace(again, model=suited.model)
    assert written(writer, suited) == written(writer, again)


@every_file
def test_saving_writes_the_same_bytes(writer, suited, tmp_path):
    for path in (tmp_path / f"line{writer.suffix}", tmp_path / f"loud{writer.suffix.upper()}"):
        suited.save(path)
        assert path.read_bytes() == written(writer, suited)
        suited.save(str(path))
    assert len(list(tmp_path.iterdir())) == 2


@every_writer
def test_every_writer_says_what_it_writes(writer):
    assert writer.title.endswith(".")
    assert writer.suffix == writer.suffix.lower()
    assert writer.suffix.startswith(".")


def test_every_module_with_a_writer_is_known():
    found = [
        name
        for path in Path(ll.__file__).parent.rglob("*.py")
        for name in re.findall(
            r'^@(?:binary_)?writer\(\s*"([^"]+)"', path.read_text("utf-8"), re.MULTILINE
        )
    ]
    assert sorted(found) == sorted(WRITERS)


def test_the_lead_in_stays_before_time_zero(animation):
    assert animation.times[0] == pytest.approx(-0.25, abs=1 / FPS)
    assert animation.times[-1] == pytest.approx(0.85, abs=1 / FPS)
    assert not animation.weights[[0, -1]].any()
    assert json.loads(written(WRITERS["json"], animation))["start"] < 0
    assert read_csv(written(WRITERS["csv"], animation))[2][0] < 0
    late = ll.Schedule(("P",), (10, 10.1))
    times = animation.source.performer.perform(late, fps=FPS).times
    assert times[0] == pytest.approx(9.75, abs=1 / FPS)


@pytest.mark.parametrize("fps", [12, 23.976, 30, 60, 120])
def test_cutting_leaves_the_frames_of_the_schedule(fps, animation):
    whole = animation.source.performer.perform(animation.schedule, fps=fps)
    cut = whole.cut()
    assert cut.times[0] == 0
    assert cut.times[-1] == pytest.approx(0.6, abs=0.5 / fps)
    assert len(cut.times) == len(cut.weights)
    inside = np.isin(whole.times, cut.times)
    np.testing.assert_array_equal(whole.weights[inside], cut.weights)
    assert whole.times[~inside].size, "the animation itself is longer"


def test_a_curve_is_had_by_its_name(animation):
    for number, pose in enumerate(animation.poses):
        np.testing.assert_array_equal(animation[pose], animation.weights[:, number])


def test_a_schedule_without_sound_writes_no_wav_and_no_file(animation, tmp_path):
    silent = replace(animation, schedule=replace(animation.schedule, audio=None))
    with pytest.raises(OutputError, match="no sound to write: schedule has no audio; speak"):
        silent.save(tmp_path / "line.wav")
    assert not list(tmp_path.iterdir())


def test_letters_that_no_file_holds_are_escaped(animation):
    odd = replace(animation.schedule, words=(ll.Word("\ud800", 0, 1),))
    content = written(WRITERS["json"], replace(animation, schedule=odd))
    assert json.loads(content)["words"][0]["text"] == "\ud800"


def test_an_animation_from_elsewhere_cannot_be_explained(animation):
    with pytest.raises(LipsyncError, match="was read from a file, so it cannot be"):
        replace(animation, source=None).explain(0.1)
