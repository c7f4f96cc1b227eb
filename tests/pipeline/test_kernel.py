"""The compiled kernel agrees with the stages in numpy on any input."""

import os
import runpy
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lanes import full
from places import ROOT
from strategies import RATES, any_lines, lines, motions, real

import lipsync_lang as ll
from lipsync_lang.pipeline import kernel, kernel_plan
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.prepare import prepare
from lipsync_lang.pipeline.tables import RESOLUTION

AGREED = 1e-11
"""Tolerance of weights, since the kernel adds in another order, over one block."""

needs_kernel = pytest.mark.skipif(
    kernel.compiled is None, reason="no C compiler built the kernel, or it is switched off"
)
SERVED = motions(smooth="none", hold=0)


def in_numpy(performance):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kernel, "compiled", None)
        return performance.weights()


def kept_of(performance):
    made = performance
    return kernel_plan.keep(made.tables, made.motion, made.prepared, made.frames.fps)


def usual():
    """Return a built-in pair as the kernel keeps it."""
    tables = real().compiled.tables
    return tables, kernel_plan.keep(tables, Motion(), prepare(tables, Motion(), 60.0), 60.0)


def assert_agreement(line, motion, fps):
    """Compare the kernel with numpy on a line, from its track and from its phonemes."""
    performance = replace(line, edits=(), shares=()).perform(motion, fps)
    weights = performance.weights()
    assert np.abs(weights - in_numpy(performance)).max() <= AGREED
    if len(performance.track.trigrams):  # the kernel performs their rows, but lays no such track
        return
    ids, dials = line.ids.astype(np.intp), performance.dials
    times, again = kept_of(performance).utter(ids, line.times, dials)
    assert np.array_equal(times, performance.frames.times())
    assert np.array_equal(weights, again)


@needs_kernel
@given(any_lines(two_dials=True), SERVED, RATES)
def test_the_kernel_agrees_with_numpy(line, motion, fps):
    assert kernel_plan.serves(motion)
    assert_agreement(line, motion, fps)


@needs_kernel
@given(lines(loose=True), SERVED, RATES)
def test_the_kernel_agrees_with_numpy_where_contacts_exclude_each_other(line, motion, fps):
    assert_agreement(line, motion, fps)


@needs_kernel
@given(any_lines(), SERVED, RATES, st.data())
def test_a_span_of_frames_is_performed_as_if_there_were_no_others(line, motion, fps, data):
    performance = replace(line, edits=(), shares=()).perform(motion, fps)
    count = performance.frames.count
    begin = data.draw(st.integers(0, count - 1))
    stop = data.draw(st.integers(begin + 1, count))
    made = performance.last(begin, stop)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kernel, "compiled", None)
        assert np.abs(made - performance.last(begin, stop)).max() <= AGREED
    kept, (first, end) = kept_of(performance), data.draw(st.sampled_from([(-1, 1), (0, count + 1)]))
    with pytest.raises(ValueError, match="frames out of range"):
        kept.weigh(performance.track, performance.frames, (first, end), ())


@full
@needs_kernel
@settings(max_examples=2000)
@given(any_lines(longest=60), SERVED, RATES)
def test_the_kernel_agrees_with_numpy_on_thousands_of_lines(line, motion, fps):
    assert_agreement(line, motion, fps)


@needs_kernel
@given(any_lines(), motions(), RATES)
def test_settings_that_the_kernel_does_not_know_are_left_to_numpy(line, motion, fps):
    performance = line.perform(motion, fps)
    known = motion.smooth == "none" and not motion.hold
    assert kernel_plan.serves(motion) is known
    if not known or performance.overlays or performance.blends:
        assert np.array_equal(performance.weights(), in_numpy(performance))


@needs_kernel
def test_blurs_of_every_reach_agree_with_numpy():
    performer, line = real(), ll.Schedule(tuple("mapifuta"), np.linspace(0, 1, 9))
    reaches = set()
    for fps in range(20, 200, 10):
        blurs = prepare(performer.compiled.tables, performer.motion, float(fps)).shared
        reaches |= {len(weights) // 2 for _, weights in blurs}
        performed = performer.perform(line, fps)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(kernel, "compiled", None)
            plain = replace(performer).perform(line, fps)
        assert np.abs(plain.weights - performed.weights).max() <= AGREED
    assert reaches >= set(range(1, 9))


@needs_kernel
def test_a_performer_plays_other_rates_in_turn_and_without_the_kernel():
    performer, line = ll.resolve("english", "facefx"), ll.Schedule(("M", "AA"), [0, 0.1, 0.4])
    for fps in (60, 24, 60):
        new = replace(performer).perform(line, fps)
        again = performer.perform(line, fps)
        assert np.array_equal(new.times, again.times)
        assert np.array_equal(new.weights, again.weights)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kernel, "compiled", None)
        plain = performer.perform(line, 60)
    assert np.abs(plain.weights - again.weights).max() <= AGREED


@needs_kernel
def test_threads_share_banks_and_plans():
    (tables, kept), rng = usual(), np.random.default_rng(3)
    lines = [
        (rng.integers(0, len(tables.pairs), n), np.cumsum(rng.uniform(0.03, 0.2, n + 1)))
        for n in (3, 900, 40, 2000, 1, 500)
    ]
    alone = [kept.utter(*line, ())[1] for line in lines]
    with ThreadPoolExecutor(6) as pool:
        for _ in range(5):
            made = pool.map(lambda line: kept.utter(*line, ())[1], lines)
            for one, other in zip(alone, made, strict=True):
                assert np.array_equal(one, other)


def faulty_phonemes(tables):
    """Yield invalid phonemes, times and dials, with the words of their refusal."""
    ids, times = np.array([1, 2, 3]), np.array([0, 0.1, 0.2, 0.3])
    poses, level = np.ones(len(tables.priority), bool), np.ones(2)
    for wrong in (-1, len(tables.pairs), 2**60, -(2**60)):
        yield np.array([1, wrong, 3]), times, (), "is not below"
    yield ids, times[:-1], (), "bytes for"
    yield ids[:0], times[:1], (), "no phonemes"
    yield ids[:0], times[:0], (), "bytes for"
    for wrong in (np.nan, np.inf, -np.inf, 1e300, -1.0):
        yield ids, np.array([0, wrong, 0.2, 0.3]), (), "times fall"
        yield ids, np.array([0, 0.1, 0.2, wrong]), (), "times fall"
    yield ids, times, ((poses[:-1], level, level),), "a dial"
    yield ids, times, ((poses, level[:0], level[:0]),), "a dial"
    yield ids, times, ((poses, level, level[:1]),), "a dial"
    yield ids, times, ((poses, level),), "tuple index"
    yield ids, times, (None,), "dials are a tuple of tuples"


@needs_kernel
def test_the_kernel_refuses_what_it_could_not_read():
    tables, (bank, plan) = usual()
    refused = (ValueError, IndexError, TypeError)
    for ids, times, dials, words in faulty_phonemes(tables):
        with pytest.raises(refused, match=words):
            kernel.compiled.utter(bank, plan, ids, times, dials)
    with pytest.raises(ValueError, match="PyCapsule"):
        kernel.compiled.utter(plan, bank, np.array([1]), np.array([0, 1.0]), ())
    with pytest.raises(TypeError, match="utter"):
        kernel.compiled.utter(bank)


@needs_kernel
@given(any_lines(longest=3), st.data())
def test_the_kernel_refuses_banks_of_other_sizes(line, data):
    tables = line.tables
    rows, _, poses = tables.curves.shape
    made = [
        rows, poses, len(tables.pairs), tables.silence, tables.curves.copy(),
        tables.boundary.copy(), tables.free.copy(), tables.pairs.astype(np.intp),
    ]  # fmt: skip
    kernel.compiled.bank(*made)
    at = data.draw(st.integers(0, len(made) - 1))
    wrong = data.draw(st.sampled_from([-1, 2**40, 2**62])) if at < 4 else made[at].ravel()[:-1]
    with pytest.raises((ValueError, OverflowError)):
        kernel.compiled.bank(*made[:at], wrong, *made[at + 1 :])
    made[-1][0, 0] = rows
    with pytest.raises(ValueError, match="pairs"):
        kernel.compiled.bank(*made)


NUMBERS = st.one_of(
    st.floats(),
    st.floats(-1, 2),
    st.integers(-10, 400_000).map(lambda number: number / 2e5),  # halves of the last digit
    st.integers(-10, 4_000_000).map(lambda number: np.nextafter(number / 2e6, 2)),
)


@needs_kernel
@given(st.integers(1, 5), st.lists(NUMBERS, max_size=20))
def test_the_kernel_writes_numbers_as_python_does(columns, numbers):
    table = np.array(numbers[: len(numbers) // columns * columns], float)
    row = ",".join(["%.6f", *["%.5f"] * (columns - 1)]) + "\n"
    assert kernel.compiled.rows(columns, table) == row * (len(table) // columns) % tuple(table)


@needs_kernel
def test_the_kernel_refuses_tables_of_broken_rows():
    for columns, table in ((2, np.ones(3)), (0, np.ones(3)), (-1, np.ones(3)), (2**62, np.ones(3))):
        with pytest.raises(ValueError, match="row"):
            kernel.compiled.rows(columns, table)
    with pytest.raises(TypeError):
        kernel.compiled.rows(1, None)
    with pytest.raises(TypeError):
        kernel.compiled.rows(None, np.ones(3))


UNIT = 10
"""Unit of marks; labels with the highest number, 9, have none of their own."""


@needs_kernel
@given(st.lists(st.tuples(st.integers(0, UNIT - 1), st.integers(-1, 2)), min_size=1, max_size=9))
def test_the_kernel_looks_labels_up(read):
    table = {f"{number}{mark}": number + (mark + 1) * UNIT for number, mark in read}
    both, labels = np.zeros((2, len(read)), np.intp), tuple(f"{n}{mark}" for n, mark in read)
    numbers, marks = zip(*read, strict=True)
    answer = kernel.compiled.look_up(table, labels, both, UNIT)
    if UNIT - 1 in numbers:
        assert answer == -1
        return
    assert both.tolist() == [list(numbers), list(marks)]
    assert answer == (len(read) if max(marks) >= 0 else 0)
    unknown = (*labels[1:], "unknown")
    assert kernel.compiled.look_up(table, unknown, both, UNIT) == -1


@needs_kernel
def test_the_kernel_refuses_labels_that_it_cannot_look_up():
    both, frozen = np.zeros((2, 1), np.intp), np.zeros((2, 1), np.intp)
    frozen.setflags(write=False)
    for damaged in (
        (None, ("M",), both, UNIT), ({}, ["M"], both, UNIT), ({}, ("M",), None, UNIT),
        ({}, ([],), both, UNIT), ({"M": "x"}, ("M",), both, UNIT), ({}, ("M",), both, 2**70),
        ({}, ("M",), frozen, UNIT), ({}, ("M", "M"), both, UNIT), ({}, ("M",), both, 0), ({},),
        ({"M": 5}, ("M",), np.full((2, 1), None), UNIT),
    ):  # fmt: skip
        with pytest.raises((TypeError, ValueError, OverflowError, BufferError)):
            kernel.compiled.look_up(*damaged)


def test_the_library_tells_of_the_code_it_was_built_from(root):
    source = (root / "lipsync_lang" / "pipeline" / "kernel.c").read_text("utf-8")
    assert f"#define INTERFACE {kernel.INTERFACE} " in source
    assert f"#define RESOLUTION {RESOLUTION} " in source


@needs_kernel
def test_a_library_of_older_code_is_left_alone(monkeypatch):
    monkeypatch.delenv(kernel.SWITCH, raising=False)
    assert kernel.load() is kernel.compiled
    monkeypatch.setattr(kernel, "INTERFACE", kernel.INTERFACE + 1)
    assert kernel.load() is None


def test_a_variable_switches_the_kernel_off(monkeypatch):
    for value in ("off", " OFF "):
        monkeypatch.setenv(kernel.SWITCH, value)
        assert kernel.load() is None
        monkeypatch.setattr(kernel, "compiled", None)
        assert kernel.summary() == "numpy; LIPSYNC_LANG_KERNEL is off"
    monkeypatch.delenv(kernel.SWITCH)
    assert kernel.summary() == "numpy; no compiled kernel"


@full
def test_a_process_without_the_kernel_performs_alike():
    code = (
        "import lipsync_lang as ll, sys\n"
        "from lipsync_lang.pipeline import kernel\n"
        "line = ll.Schedule(('M', 'AA', 'B'), [0, 0.1, 0.3, 0.4])\n"
        "made = ll.resolve('english', 'facefx').perform(line)\n"
        "print(kernel.compiled is None, made.weights.round(9).tolist())"
    )
    said = [
        subprocess.run(
            [sys.executable, "-c", code], env={**os.environ, kernel.SWITCH: value},
            capture_output=True, encoding="utf-8", check=True, timeout=60,
        ).stdout.partition(" ")
        for value in ("off", "on")
    ]  # fmt: skip
    assert said[0][0] == "True"
    assert said[0][2] == said[1][2]


def test_a_library_that_is_newer_than_its_sources_is_kept(tmp_path, monkeypatch):
    pytest.importorskip("hatchling", reason="the dev extra is not installed")
    monkeypatch.delenv("LIPSYNC_LANG_KERNEL", raising=False)
    folder = tmp_path / "lipsync_lang/pipeline"
    folder.mkdir(parents=True)
    for name in ("_kernel.abi3.so", "_kernel.pyd"):  # of Windows
        (folder / name).write_bytes(b"kept")
    build = runpy.run_path(str(ROOT / "hatch_build.py"))
    assert build["compiled_or_reason"](tmp_path, anew=False).read_bytes() == b"kept"
