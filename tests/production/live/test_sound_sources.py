"""Sources of sound: the microphone of a fake library, standard input, and recordings."""

import os
import sys
import threading

import numpy as np
import pytest

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.production.live import sound_sources
from lipsync_lang.production.live.sound_bytes import SampleForm
from lipsync_lang.production.live.sound_sources import SoundFeed, is_microphone, open_source

FORM = SampleForm()


class PortAudioError(Exception):
    pass


class Library:
    """The part of sounddevice that is used, with a microphone that may be pulled out."""

    PortAudioError = PortAudioError

    class default:  # noqa: N801 the library's name
        device = (2, 0)

    def __init__(self, fails_after=10_000):
        self.opened, self.left = [], fails_after
        self.known = [
            {"name": "Speakers", "max_input_channels": 0, "default_samplerate": 48000.0},
            {"name": "Webcam", "max_input_channels": 1, "default_samplerate": 44100.0},
            {"name": "Headset (USB)", "max_input_channels": 2, "default_samplerate": 48000.0},
        ]

    def query_devices(self):
        return self.known

    def InputStream(self, **how):  # noqa: N802 the library's name
        self.opened.append(how)
        return Stream(self, how["samplerate"] or 48_000)


class Stream:
    def __init__(self, library, rate):
        self.library, self.samplerate = library, float(rate)

    def start(self):
        if self.samplerate == 11_111:
            raise PortAudioError("Invalid sample rate [PaErrorCode -9997]")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def read(self, count):
        if not self.library.left:
            self.library.left = 5
            raise PortAudioError("Unanticipated host error [PaErrorCode -9999]")
        self.library.left -= 1
        return np.full((count, 1), 8192, np.int16), self.library.left == 1


@pytest.fixture
def library(monkeypatch):
    made = Library()
    monkeypatch.setitem(sys.modules, "sounddevice", made)
    monkeypatch.setattr(sound_sources, "RETRY_SECONDS", 0.0)
    return made


def test_the_usual_microphone_is_heard_in_small_blocks(library):
    rate, samples = next(open_source("mic", FORM, None, print))
    assert (rate, len(samples), float(samples[0])) == (48_000, 480, 0.25)
    assert library.opened[0]["device"] == 2


@pytest.mark.parametrize(("text", "number"), [("mic:webcam", 1), ("mic:usb", 2), ("mic:1", 1)])
def test_a_microphone_is_named_by_a_part_of_its_name_or_its_number(library, text, number):
    assert next(open_source(text, FORM, 16_000, print))[0] == 16_000
    assert library.opened[0]["device"] == number


def test_microphones_are_listed(library, cli):
    told = cli("live", "--list").out.splitlines()
    assert told == ["1  Webcam         44100 Hz", "2  Headset (USB)  48000 Hz  usual"]
    library.known.clear()
    assert cli("live", "--list").out == "no microphone is plugged in\n"


def test_a_microphone_that_stops_is_told_and_opened_again(library):
    library.left, told = 3, []
    source = open_source("mic", FORM, None, told.append)
    for _ in range(5):
        next(source)
    assert told == [
        "some sound of the microphone was lost; this machine is busy",
        "the microphone 'Headset (USB)' stopped (Unanticipated host error); is it plugged in?",
        "the microphone 'Headset (USB)' is back",
    ]
    assert len(library.opened) == 2


def test_odd_microphones_are_refused(library, monkeypatch, tmp_path):
    with pytest.raises(LipsyncError, match="no microphone is named 'webcan'; did you mean"):
        open_source("mic:webcan", FORM, None, print)
    with pytest.raises(LipsyncError, match=r"does not open at 11111 samples.*leave out --rate"):
        open_source("mic", FORM, 11_111, print)
    library.known.clear()
    with pytest.raises(LipsyncError, match="has no microphone; plug one in"):
        open_source("mic", FORM, None, print)

    def broken(*_):
        raise PortAudioError("Unanticipated host error [PaErrorCode -9999]")

    with monkeypatch.context() as patch:
        patch.delitem(sys.modules, "sounddevice")
        patch.setattr("builtins.__import__", broken)
        with pytest.raises(LipsyncError, match=r"does not start \(Unanticipated host error\)"):
            sound_sources.devices()
    lacking = "raise OSError('PortAudio library not found')"
    monkeypatch.delitem(sys.modules, "sounddevice")
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "sounddevice.py").write_text(lacking, encoding="utf-8")
    with pytest.raises(LipsyncError, match="apt install libportaudio2"):
        open_source("mic", FORM, None, print)
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    with pytest.raises(LipsyncError, match=r"needs the package sounddevice.*microphone"):
        open_source("mic", FORM, None, print)


def test_a_file_named_like_a_microphone_is_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert is_microphone("mic")
    assert is_microphone("mic:2")
    (tmp_path / "mic").touch()
    assert not is_microphone("mic")
    assert not is_microphone("mice.wav")
    assert not is_microphone(None)


def test_a_recording_is_a_source(tmp_path):
    soundfile = pytest.importorskip("soundfile")
    soundfile.write(tmp_path / "take.flac", np.full(800, 0.5), 8000)
    ((rate, samples),) = open_source(str(tmp_path / "take.flac"), FORM, None, print)
    assert (rate, len(samples), float(samples[0])) == (8000, 800, 0.5)


class Voice:
    """Takes what is offered."""

    def __init__(self):
        self.offered, self.ended = [], threading.Event()

    def offer(self, rate, samples):
        self.offered.append((rate, samples))

    def end(self):
        self.ended.set()


def fed(source):
    voice = Voice()
    feed = SoundFeed(source, voice)
    assert voice.ended.wait(10)
    return feed, voice.offered


def test_a_feed_offers_all_and_keeps_the_error():
    feed, offered = fed(iter([(8000, np.zeros(5)), (8000, np.ones(5))]))
    assert (len(offered), feed.error) == (2, None)

    def torn():
        yield 8000, np.zeros(5)
        raise LipsyncError("torn")

    feed, offered = fed(torn())
    assert (len(offered), str(feed.error)) == (1, "torn")
    assert "no sound came" in str(fed(iter([]))[0].error)


def test_standard_input_is_read_as_it_arrives(monkeypatch):
    ours, theirs = os.pipe()
    with os.fdopen(ours) as stdin, os.fdopen(theirs, "wb", buffering=0) as pipe:
        monkeypatch.setattr(sys, "stdin", stdin)
        source = open_source("-", SampleForm(48_000), None, print)
        pipe.write(np.arange(4096, dtype="<i2").tobytes())
        rate, samples = next(source)
        assert (rate, len(samples)) == (48_000, 2048)
        assert len(next(source)[1]) == 2048
        pipe.write(b"\1\0\2")
        assert len(next(source)[1]) == 1
        pipe.close()
        assert next(source, None) is None


def test_a_terminal_or_a_closed_input_is_no_source(monkeypatch):
    with open(os.devnull) as stdin:  # noqa: PTH123 a device
        monkeypatch.setattr(os, "isatty", lambda _: True)
        monkeypatch.setattr(sys, "stdin", stdin)
        with pytest.raises(LipsyncError, match="pipe sound to it, or listen to --audio mic"):
            open_source("-", FORM, None, print)
    monkeypatch.setattr(sys, "stdin", None)
    with pytest.raises(LipsyncError, match="is closed"):
        open_source("-", FORM, None, print)
