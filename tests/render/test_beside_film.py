"""A film beside rendered heads: pictures at one height, the sound of the film, no head late."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

import lipsync_lang as ll

FPS, LATE_SECONDS = 25, 0.4


@pytest.fixture
def benchmark(root, monkeypatch):
    monkeypatch.syspath_prepend(root / "benchmarks")
    import beside_film

    yield beside_film
    for name in ("beside_film", "face_on"):
        sys.modules.pop(name, None)


def test_pictures_stand_side_by_side_from_the_start_of_the_sound(benchmark, tmp_path):
    program = pytest.importorskip("imageio_ffmpeg", reason="needs the extra video").get_ffmpeg_exe()
    quiet = [program, "-loglevel", "error", "-nostdin", "-y"]

    def run(*rest):
        return subprocess.run([*quiet, *map(str, rest)], check=True, capture_output=True).stdout

    def made(name, size, white_from):
        picture = (
            f"color=black:{size}:r={FPS}:d=2,drawbox=c=white:t=fill:enable='gte(t,{white_from})'"
        )
        run("-f", "lavfi", "-i", picture, tmp_path / name)
        return tmp_path / name

    clip, head = made("clip.mpg", "100x80", 1.0), made("head.mp4", "64x64", 1.0 + LATE_SECONDS)
    sound, out = tmp_path / "sound.wav", tmp_path / "out.mp4"
    run("-f", "lavfi", "-i", "sine=d=2", sound)
    benchmark.beside(clip, sound, {head: LATE_SECONDS}, out)
    raw = run("-i", out, "-f", "rawvideo", "-pix_fmt", "gray", "-")
    high = benchmark.PIXELS
    pictures = np.frombuffer(raw, np.uint8).reshape(-1, high, high * 100 // 80 + high)
    white = pictures[:, high // 2, [0, -1]] > 128
    turns = white.argmax(axis=0)
    assert abs(turns[0] - FPS) <= 1
    assert abs(turns[1] - turns[0]) <= 1
    heard = np.frombuffer(run("-i", out, "-vn", "-f", "s16le", "-"), np.int16)
    assert np.abs(heard).max() > 1000


def test_a_sound_is_shown_where_it_has_its_median_length(benchmark, monkeypatch, tmp_path):
    """A clip without a picture does not count."""
    line = ll.Schedule(
        tuple("_MAMAM_"), np.cumsum([0, 0.5, 0.1, 0.3, 0.2, 0.1, 0.6, 0.5]), notation="ipa"
    )
    film = benchmark.Film("mama", tmp_path / "a.ogg", None, tmp_path / "a.mpg")
    heard = []
    monkeypatch.setattr(ll, "align", lambda sounds, *_: heard.extend(sounds) or [line])
    films = {"a": film, "b": film._replace(sound=tmp_path / "b.ogg", picture=None)}
    same = SimpleNamespace(phonemes=("_", "bmp", "aa"))
    performer = SimpleNamespace(
        language="english",
        compiled=same,
        common_phonemes=lambda _: (np.array([0, 1, 2, 1, 2, 1, 0]), line.times, None),
    )
    found = benchmark.moments_of(films, ["m", "bmp", "aa"], performer)
    assert heard == [tmp_path / "a.ogg"]
    assert [one.seconds for one in found] == pytest.approx([1.0, 1.0, 0.75])
    with pytest.raises(SystemExit, match="no film has the sound sh: _ a aa bmp m"):
        benchmark.moments_of(films, ["sh"], performer)


def test_a_sheet_shows_the_film_above_the_heads(benchmark, monkeypatch, tmp_path):
    seen = {}
    line = ll.Schedule(("_", "m", "_"), (0, 0.5, 0.7, 1))
    moment = benchmark.Moment(benchmark.Film("mm", tmp_path, None, tmp_path / "a"), line, 0.6)
    grey = {"film": 40, "face": 200}

    def cell(kind):
        return lambda *_: np.full((benchmark.CELL, benchmark.CELL, 3), grey[kind], np.uint8)

    monkeypatch.setattr(benchmark, "find_ffmpeg", lambda: "ffmpeg")
    monkeypatch.setattr(benchmark, "filmed", lambda _: {})
    monkeypatch.setattr(
        benchmark, "moments_of", lambda _, sounds, __: seen.update(sounds=sounds) or [moment]
    )
    monkeypatch.setattr(benchmark, "frame", cell("film"))
    monkeypatch.setattr(benchmark, "face", cell("face"))
    out = tmp_path / "sheet.png"
    monkeypatch.setattr(sys, "argv", ["beside_film.py", str(tmp_path), "M", str(out)])
    benchmark.main()
    assert seen["sounds"] == ["m"]
    with Image.open(out) as picture:
        column = np.asarray(picture.convert("L"))[:, picture.width // 2]
    rows = [np.flatnonzero(column == one) for one in (40, 200)]
    assert all(len(one) >= benchmark.CELL for one in rows)
    assert rows[0].max() < rows[1].min()


def test_a_frame_is_taken_where_the_lips_of_the_sound_are(benchmark, tmp_path):
    program = pytest.importorskip("imageio_ffmpeg", reason="needs the extra video").get_ffmpeg_exe()
    picture = f"color=black:100x80:r={FPS}:d=2,drawbox=c=white:t=fill:enable='gte(t,1)'"
    clip = tmp_path / "a.mpg"
    quiet = [program, "-loglevel", "error", "-nostdin", "-y", "-f", "lavfi", "-i", picture, clip]
    subprocess.run([*map(str, quiet)], check=True)
    film = benchmark.Film("", tmp_path, None, clip)
    line = ll.Schedule(("_",), (0, 2))
    bright = [
        benchmark.frame(benchmark.Moment(film, line, 1.1), ahead, "40:40:0:0").mean() > 128
        for ahead in (0.0, 0.2)
    ]
    assert bright == [True, False]
    with pytest.raises(SystemExit, match=r"no frame at 1\.10 s"):
        benchmark.frame(benchmark.Moment(film, line, 1.1), 0.0, "400:400:0:0")


def test_an_unknown_clip_is_told_with_those_that_there_are(benchmark, tmp_path, monkeypatch):
    monkeypatch.setattr(benchmark, "filmed", lambda _: {"bin": SimpleNamespace(picture=tmp_path)})
    monkeypatch.setattr(sys, "argv", ["beside_film.py", str(tmp_path), "bun", "out.mp4"])
    with pytest.raises(SystemExit, match=r"bun is no film of .*: bin"):
        benchmark.main()
