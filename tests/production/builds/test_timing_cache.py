"""Timings on disk: nothing is timed twice, and no file of a stranger is trusted."""

import wave
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from build_project import Game

import lipsync_lang as ll
from lipsync_lang.production.builds import timing
from lipsync_lang.production.builds.planned_line import PlannedLine
from lipsync_lang.production.builds.timing import MARK, TIMERS, TimingCache, prune_timings
from lipsync_lang.resolver.cache import sealed
from lipsync_lang.sound.speech.hearing import alignment
from lipsync_lang.sound.speech.sound import read_audio

PROJECT = """\
kind: project
format: 1
language: english
character: facefx
fps: 30
lines: script.csv
audio: "vo/{id}.wav"
outputs: ["takes/{character}/{id}.csv"]
"""

SPOKEN = ll.Schedule(
    ("_", "m", "ɑː"),
    [0, 0.1, 0.25, 1 / 3],
    (ll.Word("ma", 1, 3, 0.5, 0.25),),
    notation="ipa",
    language="english",
    audio=ll.Audio(np.arange(-500, 500, dtype=np.int16), 8000, -19.0),
    remarks=("a remark",),
    confidence=0.75,
    stress=(None, None, 1),
    dropped=("<b>",),
)


def line(**changes):
    found = PlannedLine("a", "english", "facefx", "ma", "", "a.csv:2", None, None, ())
    return replace(found, **changes)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / "cache"))
    return TimingCache(tmp_path, "english by its voice")


def record(path):
    """Write the sound of SPOKEN to a file."""
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, SPOKEN.audio.rate, 0, "NONE", ""))
        file.writeframes(SPOKEN.audio.samples.tobytes())


def plain(schedule):
    sound = schedule.audio and (schedule.audio.samples.tobytes(), schedule.audio.rate)
    return repr(replace(schedule, audio=None)), schedule.times.tobytes(), sound


def kept(cache):
    (path,) = (cache.folder / "cache" / "timings").iterdir()
    return path


def test_a_spoken_line_comes_back_as_it_was(cache):
    assert cache.load(line()) is None
    cache.save(line(), SPOKEN)
    assert cache.has(line())
    assert plain(cache.load(line())) == plain(SPOKEN)
    assert cache.load(line()).audio.usual_level == -19.0
    assert cache.load(line(text="moi")) is None
    assert replace(cache, reading="another voice").load(line()) is None
    assert replace(cache, reuse=False).load(line()) is None
    cache.save(line(text="?"), ll.SpeechError("nothing to say"))
    assert cache.load(line(text="?")) is None


def test_an_aligned_line_is_found_by_the_content_of_its_recording(cache):
    said = line(audio=Path("a.wav"))
    record(cache.folder / "a.wav")
    cache.save(said, SPOKEN)
    assert cache.load(said).audio.samples.tobytes() == SPOKEN.audio.samples.tobytes()
    assert kept(cache).stat().st_size < 1000, "the recording is kept in its own file"
    (cache.folder / "b.wav").write_bytes((cache.folder / "a.wav").read_bytes())
    assert cache.has(line(audio=Path("b.wav")))
    (cache.folder / "a.wav").write_bytes(b"RIFF another sound")
    assert not cache.has(said)
    (cache.folder / "a.wav").unlink()
    assert (cache.has(said), cache.load(said)) == (False, None)


@pytest.mark.parametrize(
    "damaged",
    [
        lambda _: b"",
        lambda content: content[:-1],
        lambda content: content.replace(b'"language": "english"', b'"language": "finnish"'),
        lambda _: MARK + bytes(100),
        lambda _: b"".join(sealed(MARK, [bytes(8)])),
        lambda _: b"".join(sealed(MARK, [(2).to_bytes(8, "little") + b"{}"])),
        lambda _: b"".join(sealed(MARK, [b"\xff" * 100])),
    ],
)
def test_a_damaged_file_is_none(cache, damaged):
    cache.save(line(), SPOKEN)
    kept(cache).write_bytes(damaged(kept(cache).read_bytes()))
    assert cache.load(line()) is None


def test_the_oldest_timings_go_beyond_the_size_limit(cache, monkeypatch):
    for text in ("ma", "mama", "mamama"):
        cache.save(line(text=text), SPOKEN)
    monkeypatch.setattr(timing, "MAX_KEPT_TIMINGS_BYTES", 1)
    prune_timings()
    assert len([*(cache.folder / "cache" / "timings").iterdir()]) == 1


def test_a_cache_that_is_off_keeps_nothing(cache, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", "off")
    cache.save(line(), SPOKEN)
    assert (cache.has(line()), cache.load(line())) == (False, None)
    prune_timings()


@pytest.fixture
def recorded(tmp_path, monkeypatch, capsys):
    """Make a game of two recordings; return it with the texts that are aligned."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / ".cache"))
    asked = []

    def align_many(_, pairs):
        for audio, text in pairs:
            asked.append(text)
            yield replace(SPOKEN, audio=read_audio(audio))

    monkeypatch.setattr(alignment, "align_many", align_many)
    game = Game(tmp_path, capsys)
    game.script(["low", "map"])
    for name in ("low", "map"):
        (tmp_path / f"vo/{name}.json").unlink()
        record(tmp_path / f"vo/{name}.wav")
    game.write("lipsync.yaml", PROJECT)
    return game, asked


def test_another_frame_rate_or_character_aligns_no_recording_again(recorded):
    game, asked = recorded
    assert (game.build().built, len(asked)) == (["low", "map"], 2)
    game.write("lipsync.yaml", PROJECT.replace("facefx", "crab").replace("fps: 30", "fps: 60"))
    assert (game.build().built, len(asked)) == (["low", "map"], 2)
    takes = game.takes()
    assert (game.build("--force").built, len(asked)) == (["low", "map"], 4)
    assert game.takes() == takes


def test_marks_of_a_character_are_aligned_where_they_are_of_the_same_text(recorded):
    game, asked = recorded
    head = "kind: character\nformat: 1\nposeset: facefx\n"
    own = "name: ann\nlines: {low: {text: '*low*'}, map: {text: 'the *map*'}}\n"
    game.write("characters/ann.yaml", f"{head}{own}")
    assert game.build().built == sorted(asked) == ["low", "map"]
    game.write("lipsync.yaml", PROJECT.replace("character: facefx", "character: ann"))
    assert game.build().built == ["low", "map"]
    assert asked[2:] == ["*low*"]
    asked.clear()
    game.write("characters/ann.yaml", f"{head}{own.replace('*low*', 'low')}")
    assert (game.build().built, asked) == (["low"], [])


def test_the_code_that_times_lines_is_where_it_is_sought():
    package = Path(ll.__file__).parent
    folders = {folder for folder in TIMERS if not folder.startswith("plugins/")}
    assert all(list((package / folder).rglob("*.py")) for folder in folders)
