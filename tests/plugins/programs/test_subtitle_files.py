"""Subtitles of words: SubRip and WebVTT."""

import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest
from file_bytes import bytes_of

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.base.errors import OutputError

every_form = pytest.mark.parametrize("name", ["srt", "vtt"])
SPAN = re.compile(r"(\d\d):(\d\d):(\d\d)([,.])(\d{3}) --> (\d\d):(\d\d):(\d\d)\4(\d{3})")

WORDS = (ll.Word("hello", 0, 2), ll.Word("AT&T <b>", 2, 3), ll.Word("a --> b", 4, 5))


def spoken(words=WORDS, offset=0.0, times=(0, 0.1, 0.25, 0.5, 0.7504, 1.0)):
    schedule = ll.Schedule(("a", "b", "c", "_", "d"), np.array(times), words=words)
    return Animation(
        np.zeros(1), ("aa",), np.zeros((1, 1)), 30, schedule, export=ExportSettings(offset)
    )


def text_of(name, animation):
    return bytes_of(name, animation).decode("utf-8")


def read(name, text):
    """Return (start, end, text) of each cue, strictly as players take them."""
    assert text.endswith("\n")
    blocks = text.rstrip("\n").split("\n\n")
    if name == "vtt":
        assert blocks.pop(0) == "WEBVTT"
    found = []
    for number, block in enumerate(blocks, 1):
        lines = block.split("\n")
        if name == "srt":
            assert lines.pop(0) == str(number)
        span, line = lines
        assert "-->" not in line
        h, m, s, point, ms, *rest = SPAN.fullmatch(span).groups()
        assert point == {"srt": ",", "vtt": "."}[name]
        start = (int(h) * 60 + int(m)) * 60 + int(s) + int(ms) / 1000
        h, m, s, ms = map(int, rest)
        found.append((start, (h * 60 + m) * 60 + s + ms / 1000, line))
    return found


def holds(name):
    def check(content, animation):
        schedule = animation.schedule
        cues = read(name, content.decode("utf-8"))
        plain = [unescape(text) if name == "vtt" else text for _, _, text in cues]
        assert plain == [word.text for word in schedule.words]
        for (start, end, _), word in zip(cues, schedule.words, strict=True):
            assert start == pytest.approx(schedule.times[word.first] + animation.offset, abs=1e-3)
            assert end == pytest.approx(schedule.times[word.stop] + animation.offset, abs=1e-3)

    return check


READ_BACK = {name: holds(name) for name in ("srt", "vtt")}


def test_subrip_has_its_form():
    assert text_of("srt", spoken()) == (
        "1\n00:00:00,000 --> 00:00:00,250\nhello\n\n"
        "2\n00:00:00,250 --> 00:00:00,500\nAT&T <b>\n\n"
        "3\n00:00:00,750 --> 00:00:01,000\na → b\n\n"
    )


def test_webvtt_has_its_form():
    assert text_of("vtt", spoken()) == (
        "WEBVTT\n"
        "\n00:00:00.000 --> 00:00:00.250\nhello\n"
        "\n00:00:00.250 --> 00:00:00.500\nAT&amp;T &lt;b&gt;\n"
        "\n00:00:00.750 --> 00:00:01.000\na --&gt; b\n"
    )


@every_form
@pytest.mark.parametrize("offset", [0.0, 1.25, 3661.0005, 86399.0])
def test_an_offset_delays_every_word(name, offset):
    words = (ll.Word("hello", 0, 2), ll.Word("there", 2, 3))
    animation = spoken(words, offset)
    READ_BACK[name](text_of(name, animation).encode(), animation)


@every_form
def test_what_is_spoken_before_the_file_begins_is_cut(name):
    words = (ll.Word("gone", 0, 2), ll.Word("half", 2, 3), ll.Word("here", 4, 5))
    cues = read(name, text_of(name, spoken(words, -0.3)))
    assert [text for *_, text in cues] == ["half", "here"]
    assert [start for start, *_ in cues] == [0.0, 0.45]


@every_form
def test_a_word_is_on_one_line_and_lasts(name):
    words = (ll.Word("two\n\nlines\r\n", 0, 1), ll.Word("short", 1, 2), ll.Word(" \n", 2, 3))
    times = (0, 0.1, 0.1002, 0.5, 0.7, 1)
    cues = read(name, text_of(name, spoken(words, times=times)))
    assert [text for *_, text in cues] == ["two lines", "short"]
    assert all(start < end for start, end, _ in cues)


@every_form
def test_a_schedule_without_words_is_refused(name):
    animation = spoken(())
    animation = replace(animation, schedule=replace(animation.schedule, source="line.lab"))
    with pytest.raises(OutputError, match=r"no words to write: line\.lab has only phonemes"):
        text_of(name, animation)
