"""Recordings of phones and films: decoded by ffmpeg, or refused in words."""

import subprocess

import numpy as np
import pytest
from lanes import full

import lipsync_lang as ll
from lipsync_lang.sound.speech import decoding
from lipsync_lang.sound.speech.sound import read_audio

soundfile = pytest.importorskip("soundfile", reason="the extra `audio` is not installed")

RATE = 44_100
FORMS = {
    "m4a": ("-c:a", "aac"),
    "aac": ("-c:a", "aac"),
    "mov": ("-c:a", "pcm_s16le"),
    "mp4": ("-c:a", "aac", "-movflags", "+faststart"),
    "webm": ("-c:a", "libopus"),
    "wma": ("-c:a", "wmav2"),
    "wv": ("-c:a", "wavpack"),
}
"""Options of ffmpeg that write a file with each suffix."""


@pytest.fixture
def ffmpeg():
    program = decoding.find_ffmpeg()
    if program is None:
        pytest.skip("no ffmpeg is installed")
    return lambda *words: subprocess.run(
        [program, "-nostdin", "-v", "error", *map(str, words)], check=True, timeout=60
    )


@pytest.fixture
def tone(tmp_path):
    """Two channels of which one is silent, as a WAV file."""
    seconds = np.arange(RATE) / RATE
    both = np.stack([0.5 * np.sin(440 * 2 * np.pi * seconds**2), 0 * seconds], axis=1)
    soundfile.write(tmp_path / "tone.wav", both, RATE)
    return tmp_path / "tone.wav"


@pytest.mark.parametrize("suffix", FORMS)
def test_a_recording_is_what_ffmpeg_writes_as_wav(ffmpeg, tone, tmp_path, suffix):
    path, wav = tmp_path / f"a take.{suffix}", tmp_path / "same.wav"
    ffmpeg("-i", tone, *FORMS[suffix], path)
    ffmpeg("-i", path, wav)
    for channel in (None, 1, 2):
        found, same = read_audio(path, channel), read_audio(wav, channel)
        assert found.rate == same.rate
        assert np.array_equal(found.samples, same.samples)
    assert found.seconds == pytest.approx(1, abs=0.1)
    with pytest.raises(ll.SpeechError, match=rf"a take\.{suffix}: has no channel 3"):
        read_audio(path, 3)


@pytest.mark.parametrize("atom", [b"wide", b"free", b"skip"])
def test_a_film_may_begin_with_any_atom_of_quicktime(ffmpeg, tone, tmp_path, atom):
    ffmpeg("-i", tone, "-c:a", "pcm_s16le", tmp_path / "film.mov")
    whole = (tmp_path / "film.mov").read_bytes()
    assert whole[4:8] == b"ftyp"
    (tmp_path / "old.mov").write_bytes(whole[:4] + atom + whole[8:])
    found, same = read_audio(tmp_path / "old.mov"), read_audio(tmp_path / "film.mov")
    assert np.array_equal(found.samples, same.samples)


@pytest.mark.parametrize("size", [10, 300, 70_000])
def test_a_tag_before_the_sound_is_passed_over(ffmpeg, tone, tmp_path, size):
    length = bytes(size >> by & 0x7F for by in (21, 14, 7, 0))
    for form in ("aac", "mp3"):
        ffmpeg("-i", tone, "-id3v2_version", "0", tmp_path / f"plain.{form}")
        sound = (tmp_path / f"plain.{form}").read_bytes()
        tag = b"ID3\x04\0\0" + length + bytes(size)
        (tmp_path / f"tagged.{form}").write_bytes(tag + sound)
        found, same = (
            read_audio(tmp_path / f"tagged.{form}"),
            read_audio(tmp_path / f"plain.{form}"),
        )
        assert np.array_equal(found.samples, same.samples)


def test_a_film_gives_its_first_sound(ffmpeg, tone, tmp_path):
    film, mute = tmp_path / "film.mov", tmp_path / "mute.mov"
    picture = ("-f", "lavfi", "-i", "color=size=16x16:rate=5:duration=1")
    ffmpeg(*picture, "-i", tone, "-shortest", film)
    assert read_audio(film).samples.max() > 5000
    ffmpeg(*picture, mute)
    with pytest.raises(ll.SpeechError, match=r"mute\.mov: .*finds no sound in it: .*\w; check"):
        read_audio(mute)


@pytest.mark.parametrize("size", [8, 200, 3000])
def test_a_file_that_is_cut_short_or_damaged_is_told(ffmpeg, tone, tmp_path, size):
    path = tmp_path / "line.m4a"
    ffmpeg("-i", tone, path)
    path.write_bytes(path.read_bytes()[:size])
    with pytest.raises(ll.SpeechError, match=r"line\.m4a: .*ffmpeg finds no sound in it"):
        read_audio(path)


@pytest.mark.usefixtures("ffmpeg")
def test_a_file_opens_no_other(tmp_path):
    secret = tmp_path / "secret.wav"
    soundfile.write(secret, np.ones(9600), RATE)
    for text in (f"ffconcat version 1.0\nfile '{secret}'\n", f"#EXTM3U\n#EXTINF:1,\n{secret}\n"):
        for one in decoding.COMPRESSIONS:
            path = tmp_path / "line.mp4"
            path.write_bytes(bytes(one.at) + one.mark + text.encode())
            with pytest.raises(ll.SpeechError, match=r"line\.mp4"):
                read_audio(path)


@pytest.mark.parametrize("one", decoding.COMPRESSIONS, ids=lambda one: f"{one.mark}")
def test_ffmpeg_is_told_the_format_and_to_open_files_alone(tmp_path, monkeypatch, one):
    asked = []

    def run(command, **_):
        asked.extend(command)
        return subprocess.CompletedProcess(command, 1, b"", b"no sound")

    monkeypatch.setattr(decoding, "find_ffmpeg", lambda: "ffmpeg")
    monkeypatch.setattr(decoding.subprocess, "run", run)
    (tmp_path / "-i.mp4").write_bytes(bytes(one.at) + one.mark + bytes(100))
    with pytest.raises(ll.SpeechError, match="no sound"):
        read_audio(tmp_path / "-i.mp4")
    before = asked[: asked.index("-i")]
    assert before[before.index("-protocol_whitelist") + 1] == "file"
    assert before[before.index("-f") + 1] == one.demuxer
    assert asked[asked.index("-i") + 1] == f"file:{tmp_path / '-i.mp4'}"


@full
@pytest.mark.usefixtures("ffmpeg")
def test_a_program_that_does_not_end_is_ended(tmp_path, monkeypatch):
    slow = tmp_path / "slow"
    slow.write_text("#!/bin/sh\nexec sleep 60\n")
    slow.chmod(0o755)
    monkeypatch.setattr(decoding, "find_ffmpeg", lambda: str(slow))
    monkeypatch.setattr(decoding, "DECODING_SECONDS", 1)
    (tmp_path / "line.m4a").write_bytes(b"\0\0\0\x20ftypM4A " + bytes(2000))
    with pytest.raises(ll.SpeechError, match=r"line\.m4a: ffmpeg has not decoded it"):
        read_audio(tmp_path / "line.m4a")


def test_without_ffmpeg_the_message_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setattr(decoding, "find_ffmpeg", lambda: None)
    (tmp_path / "line.m4a").write_bytes(b"\0\0\0\x20ftypM4A " + bytes(2000))
    told = r"line\.m4a: it is MPEG-4 .*, which ffmpeg reads, .* get it with: .*pip install .*video"
    with pytest.raises(ll.SpeechError, match=told):
        read_audio(tmp_path / "line.m4a")


def test_a_decoded_file_that_is_too_large_is_refused(ffmpeg, tone, tmp_path, monkeypatch):
    path = tmp_path / "long.m4a"
    ffmpeg("-i", tone, path)
    monkeypatch.setattr(decoding, "MAX_DECODED_BYTES", 50_000)
    with pytest.raises(ll.SpeechError, match=r"long\.m4a: is larger than .* when decoded"):
        read_audio(path)


def test_a_recording_of_a_phone_is_aligned(ffmpeg, cli, folder):
    said = ("Buy five more maps.", "-l", "english", "-c", "facefx")
    assert cli("run", *said, "--cut", "-o", "line.wav").code == 0
    ffmpeg("-i", "line.wav", "line.m4a")
    assert cli("run", *said, "--audio", "line.m4a", "-o", "line.csv").code == 0
    ended = cli("run", *said, "--audio", "line.wav", "-o", "same.csv")
    assert "aligned" in ended.err
    assert (folder / "line.csv").stat().st_size > 1000
