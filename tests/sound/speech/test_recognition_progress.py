"""Progress of work on long recordings."""

import io
import sys
import threading

import numpy as np
import pytest

from lipsync_lang.commands.output import listening
from lipsync_lang.sound.speech.hearing.align import bending
from lipsync_lang.sound.speech.hearing.progress import followed, part, tell
from lipsync_lang.sound.speech.hearing.sphinx import forced
from lipsync_lang.sound.speech.hearing.sphinx.features import HeardFrames


def test_shares_are_told_within_the_block_and_in_its_thread_alone():
    told = []
    tell(1, 2)
    with followed(told.append):
        tell(1, 2)
        tell(3, 2)
        tell(1, 0)
        thread = threading.Thread(target=tell, args=(1, 4))
        thread.start()
        thread.join()
    tell(1, 2)
    assert told == [0.5, 1.0]


def test_a_part_tells_its_share_of_the_whole():
    told = []
    with part(10, 20, 40):
        tell(1, 2)
    with followed(told.append):
        with part(10, 20, 40):
            tell(0, 2)
            tell(1, 2)
        tell(1, 1)
    assert told == [0.25, 0.375, 1.0]


def test_the_model_tells_of_each_window(monkeypatch):
    def window(_model, features, _words, done, *, anchored):
        assert not anchored
        stop = min(1000, len(features))
        return [forced.HeardPhoneme(done, 1, 0, stop, 0.0)]

    monkeypatch.setattr(forced, "_window", window)
    told = []
    with followed(told.append):
        assert forced.lay(None, HeardFrames(np.zeros((4000, 3, 13))), [[(1,)]] * 4)
    assert told[:4] == [0, 0.25, 0.5, 0.75]


def test_the_warp_tells_of_each_part(monkeypatch):
    pytest.importorskip("dtaidistance", reason="the extra `audio` is not installed")
    for name, value in (("MAX_DIRECT_FRAMES", 100), ("PART_FRAMES", 100), ("CONTEXT_FRAMES", 20)):
        monkeypatch.setattr(bending, name, value)
    frames = np.random.default_rng(1).normal(size=(400, 8))
    told = []
    with followed(told.append):
        bending._edges(frames, frames, bending._coarse(frames, frames)[0])  # noqa: SLF001
    assert told[-4:] == [0, 0.25, 0.5, 0.75]


@pytest.mark.parametrize("terminal", [True, False])
def test_a_terminal_shows_the_share_and_a_file_nothing(monkeypatch, terminal):
    stream = io.StringIO()
    monkeypatch.setattr(stream, "isatty", lambda: terminal, raising=False)
    monkeypatch.setattr(sys, "stderr", stream)
    with listening("listening to take.wav"):
        tell(1, 3)
    shown = "\x1b[2Klistening to take.wav ...\r\x1b[2Klistening to take.wav: 33% ...\r\x1b[2K\r"
    assert stream.getvalue() == (shown if terminal else "")
