"""Recordings without a text: heard once, counted, and told apart from what was read."""

import json

import pytest
from lanes import full

import lipsync_lang as ll
from lipsync_lang.reports.coverage.reading_cache import unwritten
from lipsync_lang.schedules.schedule import Schedule


@pytest.fixture
def heard(tmp_path, monkeypatch):
    """A folder of recordings, a log of those that were heard, and a cache of its own."""
    log = []

    def recognised(_, path, *, recogniser):
        log.append((path.name, recogniser))
        if path.name == "torn.wav":
            raise ll.SpeechError(f"{path}: is not sound")
        return Schedule(("m", "iː"), [0.0, 0.1, 0.2], notation="ipa", language="english")

    monkeypatch.setattr("lipsync_lang.reports.coverage.reading_cache.recognised", recognised)
    monkeypatch.setattr(
        "lipsync_lang.reports.coverage.reading_cache.folder", lambda: tmp_path / "cache"
    )
    monkeypatch.chdir(tmp_path)
    for name in ("a.wav", "b.flac", "with[1].wav", "torn.wav"):
        (tmp_path / "takes").mkdir(exist_ok=True)
        (tmp_path / "takes" / name).write_text(name)
    (tmp_path / "takes/with[1].txt").write_text("Moon.")
    return tmp_path / "takes", log


def test_recordings_with_a_text_are_not_heard(heard):
    folder, _ = heard
    assert [one.name for one in unwritten([folder])] == ["a.wav", "b.flac", "torn.wav"]


def test_recordings_are_heard_once_and_said_to_be(heard, cli):
    _, log = heard
    for _ in range(2):
        ended = cli("coverage", "takes", "-l", "english", "-c", "facefx")
        assert ended.code == 0
        assert "3 files, 3 lines, 1 word" in ended.out
        assert "heard in recordings, and not read: 2 lines" in ended.out
        assert "torn.wav: left out: is not sound" in ended.err
        assert "no reader" not in ended.err
    names = [name for name, _ in log]
    assert names == ["a.wav", "b.flac", "torn.wav", "torn.wav"]
    assert {recogniser for _, recogniser in log} == {"sound"}


def test_each_language_hears_a_recording_for_itself(heard, cli):
    _, log = heard
    ended = cli(
        "coverage", "takes/a.wav", "-l", "english", "-l", "german", "-c", "facefx", "--json"
    )
    assert ended.code == 0
    found = json.loads(ended.out)
    assert found["corpus"]["heard"] == 2
    assert [one["language"] for one in found["reports"]] == ["english", "german"]
    assert len(log) == 2


@full
def test_a_real_recording_is_counted(cli, tmp_path, monkeypatch):
    pytest.importorskip("pocketsphinx")
    soundfile = pytest.importorskip("soundfile")
    monkeypatch.chdir(tmp_path)
    spoken = ll.speak("Please buy five maps.", "english").audio
    soundfile.write("line.wav", spoken.samples, spoken.rate)
    ended = cli("coverage", "line.wav", "-l", "finnish", "-c", "facefx", "--json")
    assert json.loads(ended.out)["reports"][0]["occurrences"] > 3
