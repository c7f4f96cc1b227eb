"""The compiled kernel gives the bytes of gestures that the modules in Python give, on any line."""

from functools import cache

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from strategies import RATES

import lipsync_lang as ll
from lipsync_lang.performing.gesturing import gesture_curves, with_gestures
from lipsync_lang.pipeline import kernel
from lipsync_lang.schedules.schedule import Word

pytestmark = pytest.mark.skipif(
    kernel.compiled is None, reason="no C compiler built the kernel, or it is switched off"
)

POSE_SETS = ("arkit", "crab", "facefx", "vrm")
LABELS = ("_", "_", "M", "AA", "AA1", "IY0", "UW2", "K", "AH1", "S")
TEXTS = ("no", "Yes!", "who", "don’t", "日本", "\ud800", "", "key", "Not", "so")

performer_of = cache(lambda poseset: ll.resolve("english", poseset))

sounds_of = st.lists(
    st.tuples(st.integers(0, len(LABELS) - 1), st.sampled_from([0.03, 0.08, 0.12, 0.3, 1.7])),
    min_size=1,
    max_size=60,
)
words_of = st.lists(
    st.tuples(st.integers(0, 2), st.integers(1, 5), st.sampled_from(TEXTS), st.booleans()),
    max_size=12,
)


def spoken(sounds, words):
    """Return a schedule of labels and seconds, and of words after some labels without one."""
    times = np.cumsum([0.2, *(seconds for _, seconds in sounds)])
    labels, made, at = [LABELS[number] for number, _ in sounds], [], 0
    for gap, length, text, emphasis in words:
        first, at = at + gap, at + gap + length
        if at <= len(labels):
            made.append(Word(text, first, at, emphasis=float(emphasis)))
    return ll.Schedule(labels, times, words=made, notation="arpabet", language="english")


def line_of(poseset, schedule, fps, scale):
    """Return (T, 2) weights of other poses, and the arguments of gestures after them."""
    performer = performer_of(poseset)
    (sounds,) = performer.labels.read([schedule])
    times = schedule.start - 0.1 + np.arange(int((schedule.end + 0.3) * fps) + 2) / fps
    scales = [scale * (number % 3 != 1) for number in range(len(performer.gesture_set.shapes))]
    weights = np.arange(2.0 * len(times)).reshape(-1, 2)
    settings = {"line": None, "placed": None, "whole": None}
    return weights, sounds, (performer, schedule, times, fps, scales, settings)


@given(st.sampled_from(POSE_SETS), sounds_of, words_of, RATES, st.sampled_from([0.4, 1.0, 2.0]))
@example("arkit", [(4, 0.3)] * 60, [(0, 3, "no", True)] * 12, 60.0, 2.0)
@example("facefx", [(3, 0.08), (0, 0.3)] * 30, [], 60.0, 1.0)
def test_the_kernel_gives_the_bytes_of_the_modules(poseset, sounds, words, fps, scale):
    weights, read, line = line_of(poseset, spoken(sounds, words), fps, scale)
    curves, _ = gesture_curves(*line)
    made = with_gestures(weights, *line[:2], read, *line[2:])
    assert made[:, :2].tobytes() == weights.tobytes()
    assert made[:, 2:].tobytes() == curves.tobytes()


class Recorder:
    """The compiled kernel, which keeps the last arguments of each call."""

    def __init__(self):
        self.calls = {}

    def __getattr__(self, name):
        def called(*arguments):
            self.calls[name] = arguments
            return getattr(kernel.load(), name)(*arguments)

        return called


@pytest.fixture
def calls(monkeypatch):
    """The arguments of `gestures` and `gesture` for a line of three words."""
    recorder = Recorder()
    monkeypatch.setattr(kernel, "compiled", recorder)
    line = spoken([(3, 0.2), (4, 0.3)] * 20, [(0, 2, "no", True), (1, 3, "who", False)])
    ll.resolve("english", "arkit").perform(line, gestures="all")
    return recorder.calls


ANY_NUMBER = {"gestures": (), "gesture": (12, 13)}
"""Arrays that may have any number of rows: words with emphasis, and facts of words."""


def faulty(name, arguments):
    """Yield damaged copies of arguments, one of them at a time."""
    for number, value in enumerate(arguments):
        others = [None]
        if isinstance(value, np.ndarray) and value.size:
            others.append(value.ravel()[:-1].copy())
        if isinstance(value, np.ndarray) and value.size and number not in ANY_NUMBER[name]:
            others.append(np.concatenate((value.ravel(), value.ravel())))
        if name == "gesture" and number in {3, 4}:  # seconds of the frames
            others += [float("nan"), float("inf"), -1e300]
        if isinstance(value, int):
            others += [-1, 2**40, 2**63 - 1]
        for other in others:
            yield number, (*arguments[:number], other, *arguments[number + 1 :])


@pytest.mark.parametrize("name", ["gestures", "gesture"])
def test_arguments_that_could_not_be_read_are_refused(calls, name):
    call = getattr(kernel.load(), name)
    for number, arguments in faulty(name, calls[name]):
        if name == "gestures" and number == 0:  # what makes arrays is asked only at a call
            continue
        with pytest.raises((ValueError, TypeError, OverflowError)):
            call(*arguments)
    with pytest.raises(TypeError):
        call()


@pytest.mark.parametrize(("number", "odd"), [(5, 2**40), (7, -1), (11, 99), (13, -1), (13, 99)])
def test_numbers_that_are_no_index_are_refused(calls, number, odd):
    arguments = calls["gesture"]
    assert arguments[number].size
    wrong = np.full_like(arguments[number], odd)
    with pytest.raises(ValueError, match=r"is not below|out of range"):
        kernel.load().gesture(*arguments[:number], wrong, *arguments[number + 1 :])


@pytest.mark.parametrize("column", range(7))
def test_numbers_of_gestures_out_of_range_are_refused(calls, column):
    arguments = calls["gestures"]
    wrong = arguments[12].copy()
    wrong[1, column] = np.nan
    with pytest.raises(ValueError, match="gesture 1 is out of range"):
        kernel.load().gestures(*arguments[:12], wrong, *arguments[13:])
