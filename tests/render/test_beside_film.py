"""A film beside rendered heads: pictures at one height, the sound of the film, no head late."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

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


def test_an_unknown_clip_is_told_with_those_that_there_are(benchmark, tmp_path, monkeypatch):
    monkeypatch.setattr(benchmark, "filmed", lambda _: {"bin": SimpleNamespace(picture=tmp_path)})
    monkeypatch.setattr(sys, "argv", ["beside_film.py", str(tmp_path), "bun", "out.mp4"])
    with pytest.raises(SystemExit, match=r"bun is no film of .*: bin"):
        benchmark.main()
