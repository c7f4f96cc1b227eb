"""Pictures of a line: every format, every label, any length, and no changed settings."""

import re
import subprocess
import sys
from dataclasses import replace
from html import unescape
from importlib.util import find_spec
from io import BytesIO
from itertools import chain

import numpy as np
import pytest
from lanes import full, swept

from lipsync_lang.base.errors import OutputError
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.pipeline.motion import PRESETS
from lipsync_lang.render.plot import PLOT_FORMATS, STAGES, Spectrogram, View, draw_spectrogram, plot
from lipsync_lang.schedules.schedule import Audio, Schedule, Word

MAGIC = {
    "png": b"\x89PNG\r\n\x1a\n",
    "svg": b"<?xml",
    "pdf": b"%PDF-",
    "jpg": b"\xff\xd8\xff",
    "webp": b"RIFF",
}
drawn = pytest.mark.skipif(
    find_spec("matplotlib") is None, reason='needs matplotlib: pip install "lipsync-lang[plot]"'
)


@pytest.fixture(scope="module")
def performer():
    return resolve("english", "facefx", cache=False)


@pytest.fixture(scope="module")
def schedule():
    tone = (8000 * np.sin(np.arange(16_000) / 9)).astype(np.int16)
    return Schedule(
        ("_", "h", "ə", "l", "oʊ", "w", "ɜː", "l", "d", "_"),
        np.array([0, 0.05, 0.12, 0.18, 0.25, 0.45, 0.52, 0.75, 0.78, 0.85, 1.0]),
        (Word("Hello", 1, 5), Word("world", 5, 9)),
        notation="ipa",
        audio=Audio(tone, 16_000),
    )


@pytest.fixture(scope="module")
def animation(performer, schedule):
    return performer.perform(schedule)


def picture(animation, name="png"):
    out = BytesIO()
    plot(animation, out, name)
    return out.getvalue()


def texts(animation):
    """Return every text of a picture, in the order of drawing."""
    found = re.findall(r"<text[^>]*>([^<]*)</text>", picture(animation, "svg").decode())
    return [unescape(text) for text in found]


@full
@drawn
@pytest.mark.parametrize("name", swept(PLOT_FORMATS, quick=["png"]))
def test_every_format_is_drawn_alike_each_time(animation, name):
    first = picture(animation, name)
    assert first.startswith(MAGIC[name])
    assert first == picture(animation, name.upper())


@full
@drawn
def test_the_users_own_settings_neither_show_nor_change(animation):
    import matplotlib as mpl

    plain = picture(animation, "svg")
    with mpl.rc_context({"font.size": 30, "axes.facecolor": "red", "svg.fonttype": "path"}):
        before = dict(mpl.rcParams)
        assert picture(animation, "svg") == plain
        assert dict(mpl.rcParams) == before


@drawn
def test_words_phonemes_and_what_they_became_are_all_there(performer, schedule, animation):
    shown = texts(animation)
    for label in schedule.labels:
        assert shown.count(label) >= schedule.labels.count(label), label
    assert {"Hello", "world", "Hello world"} <= set(shown)
    ids, *_ = performer.common_phonemes(schedule)
    assert {performer.compiled.phonemes[number] for number in ids} <= set(shown)
    assert any(
        performer.language in text and performer.character in text and "60 fps" in text
        for text in shown
    )


@drawn
def test_only_poses_that_move_have_a_row(performer, animation):
    shown = texts(animation)
    moving = animation.weights.max(axis=0) > 0.01
    assert moving.any()
    assert not moving.all()
    for pose, moves in zip(performer.poses, moving, strict=True):
        assert (pose in shown) == moves, pose
    resting = next(text for text in shown if "at rest: " in text)
    for pose in np.array(performer.poses)[~moving]:
        assert pose in resting


@drawn
@pytest.mark.parametrize("preset", swept(PRESETS))
def test_the_legend_names_the_stages_in_their_order(performer, schedule, preset):
    changed = performer.with_motion(preset)
    names = [STAGES[stage.name][0] for stage in changed.performance(schedule, 60).stages(0, 9)]
    shown = texts(changed.perform(schedule))
    assert [text for text in shown if text in names] == names
    assert any(f"motion: {preset}" in text for text in shown) == (preset != "default")


@drawn
def test_a_changed_setting_is_in_the_title(performer, schedule):
    shown = texts(performer.with_motion({"window": 0.1, "contacts": "free"}).perform(schedule))
    assert any("motion: window 0.1, contacts free" in text for text in shown)


@drawn
@pytest.mark.parametrize("warp", ["anchored", "linear"])
def test_the_bigrams_are_those_that_the_stitched_curve_joins(performer, schedule, warp):
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

    from lipsync_lang.render.plot import _bigrams

    animation = performer.with_motion({"warp": warp, "stitch": "max"}).perform(schedule, 240)
    view = View(animation, animation.source)
    axes = Figure().add_axes((0, 0, 1, 1), xlim=(view.begin, view.end))
    _bigrams(axes, view)
    lines = [c.get_segments() for c in axes.collections if isinstance(c, LineCollection)]
    highest = np.zeros((len(view.moving), len(view.times)))
    for segment in chain.from_iterable(lines):
        row = int(np.searchsorted(view.tops, segment[0, 1])) - 1
        weights = 1 - (segment[:, 1] - view.tops[row]) / view.row
        curve = np.interp(view.times, segment[1:-1, 0], weights[1:-1], left=0, right=0)
        highest[row] = np.maximum(highest[row], curve)
    np.testing.assert_allclose(highest, view.stages[0].curves[view.moving], atol=0.04)


@drawn
def test_contacts_are_marked_where_there_are_some(performer, schedule):
    mark = "bounds of a contact"
    assert mark not in texts(performer.perform(schedule))
    pressed = replace(schedule, labels=("_", "p", *schedule.labels[2:]))
    assert mark in texts(performer.perform(pressed))


@drawn
def test_neither_sound_nor_words_are_needed(performer, schedule):
    bare = replace(schedule, words=(), audio=None, estimated=True)
    shown = texts(performer.perform(bare))
    assert "words" not in shown
    assert " ".join(schedule.labels) in shown
    assert any("times are estimated" in text for text in shown)


def test_a_spectrogram_shows_when_and_how_high_a_tone_is():
    rate = 16_000
    tone = (8000 * np.sin(2 * np.pi * 2000 * np.arange(rate) / rate)).astype(np.int16)
    audio = Audio(np.concatenate([np.zeros(rate, np.int16), tone]), rate)
    found = Spectrogram.of(audio, -0.25, 3.0, 200.0)
    rows, columns = found.image.shape
    assert (found.start, columns) == (0.0, 400)
    middles = found.start + (np.arange(columns) + 0.5) * found.step
    loud, quiet = found.image[:, middles > 1.01], found.image[:, middles < 0.99]
    hertz = found.image[:, 300].argmax() / (rows - 1) * found.highest
    assert hertz == pytest.approx(2000, abs=40)
    assert loud.max(axis=0).min() > 0.95
    assert quiet.max() == 0


@pytest.mark.parametrize(("begin", "end"), [(0.5, 1.5), (2.5, 3.0), (-1.0, 0.0), (0.0, 0.0001)])
@pytest.mark.parametrize("rate", [8000, 44_100])
def test_a_spectrogram_of_a_part_is_that_part(begin, end, rate):
    noise = np.random.default_rng(1).integers(-9000, 9000, 2 * rate).astype(np.int16)
    audio = Audio(noise, rate)
    part = Spectrogram.of(audio, begin, end, 100.0)
    whole = Spectrogram.of(audio, 0.0, 2.0, 100.0)
    assert part.highest == min(5500, rate / 2)
    assert part.image.shape == (len(whole.image), 100 if begin == 0.5 else 0)
    if begin == 0.5:  # loudness is relative to the loudest moment that is shown
        away = part.image - whole.image[:, 50:150]
        assert np.abs(away - np.median(away)).max() < 0.02


@drawn
def test_a_sound_has_its_boundaries_on_its_spectrogram(performer, schedule, animation):
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

    view = View(animation, animation.source)
    axes = Figure().add_axes((0, 0, 1, 1), xlim=(view.begin, view.end), ylim=(view.height, 0))
    draw_spectrogram(axes, view)
    (image,) = axes.images
    left, right, *_ = image.get_extent()
    assert left == 0
    assert right == pytest.approx(schedule.end, abs=view.spectrogram.step)
    drawn_at = [
        segment[0, 0]
        for lines in axes.collections
        if isinstance(lines, LineCollection)
        for segment in lines.get_segments()
    ]
    edges = {schedule.times[n] for word in schedule.words for n in (word.first, word.stop)}
    assert sorted(drawn_at) == sorted([*schedule.times, *edges])
    assert {"sound", "spectrum", "boundaries"} <= set(texts(animation))
    bare = texts(performer.perform(replace(schedule, audio=None)))
    assert not {"sound", "spectrum", "boundaries"} & set(bare)


@drawn
@pytest.mark.parametrize(("confidence", "doubt"), [(None, False), (0.9, False), (0.2, True)])
def test_words_in_doubt_are_hatched_and_underlined(performer, schedule, confidence, doubt):
    words = schedule.words[0], replace(schedule.words[1], confidence=confidence)
    animation = performer.perform(replace(schedule, words=words))
    assert ("word in doubt" in texts(animation)) == doubt
    spans = [(float(schedule.times[5]), float(schedule.times[9]))]
    assert View(animation, animation.source).doubts == (spans if doubt else [])


@drawn
@pytest.mark.parametrize("fps", swept([1, 12, 1000]))
def test_the_shortest_line_is_drawn_at_any_rate(performer, fps):
    short = Schedule(("t", "aɪ"), np.array([0.3, 0.301, 0.302]), notation="ipa")
    animation = performer.perform(short, fps)
    assert {"t", "aɪ"} <= set(texts(animation))
    assert picture(animation.cut()).startswith(MAGIC["png"])


@full
@drawn
def test_sound_may_be_silent_or_shorter_than_the_line(performer, schedule):
    for samples in (0, 1, 4000):
        audio = Audio(np.zeros(samples, np.int16), 16_000)
        assert picture(performer.perform(replace(schedule, audio=audio)))


@full
@drawn
def test_a_long_line_wraps_and_ends_after_a_minute(performer):
    count = 900
    labels = tuple("maptifows"[i % 9] if i % 9 not in {1, 4, 7} else "aɪ" for i in range(count))
    words = tuple(Word(f"word{i}", i, i + 9) for i in range(0, count, 9))
    line = Schedule(labels, np.arange(count + 1) * 0.1, words, notation="ipa")
    animation = performer.perform(line, 30)
    shown = texts(animation)
    assert any("the first 60 s of 90" in text for text in shown)
    assert shown.count("phonemes") == 10  # strips
    assert "word0" in shown
    assert "word585" in shown
    assert "word621" not in shown
    for word in words[:66]:
        assert shown.count(word.text) == 1
    height = int.from_bytes(picture(animation)[20:24], "big")
    assert height < 12_000


@full
@drawn
def test_text_in_any_script_is_kept_and_warns_of_nothing(performer, schedule):
    words = (Word("Ελλάδα мир", 1, 5), Word("$x_1$ & <b>", 5, 9))
    odd = performer.perform(replace(schedule, words=words))
    assert {"Ελλάδα мир", "$x_1$ & <b>"} <= set(texts(odd))
    for name in PLOT_FORMATS:
        assert picture(odd, name)


def test_an_unknown_format_names_the_known_ones(animation):
    with pytest.raises(OutputError, match=r"'bmp'.*png, svg, pdf"):
        picture(animation, "bmp")


def test_an_animation_made_elsewhere_is_refused(animation):
    with pytest.raises(OutputError, match="without a performer"):
        picture(replace(animation, source=None))


def test_without_matplotlib_the_extra_is_named(animation, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(OutputError, match=r'pip install "lipsync-lang\[plot\]"'):
        picture(animation)


@full
@drawn
def test_matplotlib_is_loaded_late_and_never_its_global_state():
    code = """
import io, sys
import numpy as np
from lipsync_lang.render.plot import plot
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.schedules.schedule import Schedule
assert "matplotlib" not in sys.modules
line = Schedule(("t", "aɪ"), np.array([0, 0.1, 0.3]), notation="ipa")
plot(resolve("english", "facefx", cache=False).perform(line), io.BytesIO())
assert "matplotlib.pyplot" not in sys.modules
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
