"""Judgement of captures: good ones pass, spoiled ones are set aside with the reason."""

import csv
import gzip
import shutil
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from lanes import full

import lipsync_lang as ll
from lipsync_lang.plugins.capture.capture_clock import CLOCK_FPS, ClockReading, compared, read_clock
from lipsync_lang.plugins.capture.capture_reading import Captures, read_captures
from lipsync_lang.plugins.capture.fit_file import SetAside
from lipsync_lang.plugins.capture.fit_lines import CapturedLine
from lipsync_lang.plugins.capture.judging import (
    _check_words,
    _in_time,
    _unlike_the_others,
    judge_captures,
    outlying_lines,
)
from lipsync_lang.reports.quality.baselines import dominance

TEXTS = (
    "The birch canoe slid on the smooth planks.",
    "These days a chicken leg is a rare dish.",
    "The hogs were fed chopped corn and garbage.",
)


@cache
def performer(character="facefx"):
    return ll.resolve("english", character)


@cache
def spoken(number):
    """Estimated times of a text, so that no voice is needed."""
    return replace(ll.speak(TEXTS[number], "english", engine="none"), audio=None)


@cache
def capture(number=0, fps=60):
    """A noisy face that moves by another method than the shipped curves."""
    rng = np.random.default_rng(number)
    face = performer()
    moved = dominance(face, spoken(number), fps)
    noisy = moved.weights * rng.uniform(0.7, 1.2, len(face.poses))
    noisy = noisy + rng.normal(0, 0.04, noisy.shape)
    gains = np.eye(len(face.poses))
    return CapturedLine(f"line{number}", spoken(number), moved.times, face.poses, noisy, gains)


def sensed(number=0):
    """The same face as three measures of unknown scale."""
    line, face = capture(number), performer()
    measures = face.compiled.measures
    gains = np.array([[one.get(pose, 0.0) for pose in face.poses] for one in measures.values()])
    return replace(
        line,
        signals=tuple(measures),
        gains=gains,
        values=-7 + 11 * line.values @ gains.T,
        free=True,
    )


def judged(*lines, face=None):
    return judge_captures(face or performer(), Captures(lines, ()))


def kept(line):
    captures = judged(line)
    assert not captures.set_aside
    return captures.lines[0]


def why(line):
    captures = judged(line)
    assert not captures.lines
    return captures.set_aside[0].why


@pytest.mark.parametrize("make", [capture, sensed])
@pytest.mark.parametrize("number", range(len(TEXTS)))
def test_sound_lines_pass_as_they_are(make, number):
    line = make(number)
    found = kept(line)
    assert found.remarks == ()
    np.testing.assert_array_equal(found.values, line.values)
    np.testing.assert_array_equal(found.times, line.times)


@pytest.mark.parametrize("make", [capture, sensed])
@pytest.mark.parametrize("number", range(len(TEXTS)))
def test_timings_of_another_line_are_refused(make, number):
    other = spoken((number + 1) % len(TEXTS))
    told = why(replace(make(number), schedule=other))
    assert "follow its timings" in told or "clock drifts" in told or "motion is" in told


def loose(number):
    """Two measures of a face that moves as much in its own way as with its words."""
    line, random = sensed(number), np.random.default_rng(number)
    smooth = np.hanning(15)
    noise = random.normal(0, 1, line.values.shape)
    noise = np.column_stack([np.convolve(one, smooth, "same") for one in noise.T])
    values = line.values + noise * line.values.std(axis=0) / noise.std(axis=0)
    return replace(line, signals=line.signals[:2], values=values[:, :2], gains=line.gains[:2])


@pytest.mark.parametrize("number", range(len(TEXTS)))
def test_short_takes_that_follow_their_words_loosely_pass(number):
    line = loose(number)
    reading, _ = read_clock(performer(), line)
    assert 0.5 < reading.near < 0.75
    np.testing.assert_array_equal(kept(line).times, line.times)
    assert why(replace(line, schedule=spoken((number + 1) % len(TEXTS))))


def test_a_take_of_a_sure_likeness_may_be_nearer_to_chance():
    motion = compared(performer(), capture(), [spoken(0)])
    reading = ClockReading(0.6, 0.65, 0.02, 0.1, 0.1, 0.5, 0.65, 0, 0.45, 0.2)
    assert reading.beyond_chance(1) < reading.near < reading.beyond_chance(2)
    _check_words(reading, motion)
    for other in (reading._replace(near=0.59), reading._replace(chance=0.55)):
        with pytest.raises(ll.AnimationError, match="chance gives"):
            _check_words(other, motion)


def test_a_drift_that_chance_explains_is_left_alone():
    motion, line = compared(performer(), capture(), [spoken(0)]), capture()
    reading = ClockReading(0.7, 0.7, 0, 0.1, 0.1, 0.5, 0.78, 0.24, 0.4, 0.16)
    assert 1 < reading.drift_gain < 2
    assert _in_time(line, reading) is line
    with pytest.raises(ll.AnimationError, match="clock drifts"):
        _in_time(line, reading._replace(drifting=0.86))
    # the drift that is no fault helps no other words either
    with pytest.raises(ll.AnimationError, match="chance gives"):
        _check_words(reading._replace(near=0.5, drifting=0.55, chance=0.1), motion)


def test_channels_that_share_a_movement_otherwise_are_alike():
    face = performer("arkit")
    moved = dominance(face, spoken(0), 60)
    values, noise = moved.weights.copy(), np.random.default_rng(3)
    for pose in face.poses:
        if pose.endswith("Left"):  # tracking gives one side more of a smile, and the other less
            way = 2 * np.convolve(noise.normal(0, 1, len(values)), np.hanning(31) / 15, "same")
            values[:, face.poses.index(pose)] += way
            values[:, face.poses.index(pose.replace("Left", "Right"))] -= way
    gains = np.eye(len(face.poses))
    line = CapturedLine("arkit", spoken(0), moved.times, face.poses, values, gains)
    channels = replace(line, free=True)  # which are compared one by one
    both = [compared(face, one, [line.schedule]) for one in (line, channels)]
    alike, apart = (motion.likenesses([0.0])[0, 0] for motion in both)
    assert alike > 0.9
    assert apart < 0.7


def test_speeds_tell_other_words_from_slow_turns():
    line = sensed()
    slow = np.hanning(61) / np.hanning(61).sum()
    values = np.column_stack([np.convolve(one, slow, "same") for one in line.values.T])
    turns = compared(performer(), replace(line, values=values), [line.schedule])
    assert len(turns.signals()) == len(line.signals)
    assert turns.likenesses([0.0])[0, 0] < turns.signals().mean() - 0.05


def test_chance_never_asks_for_the_impossible():
    reading = ClockReading(0.8, 0.8, 0, 0.1, 0.1, 0.5, 0.8, 0, 0.4, 0.17)
    needed = [reading.beyond_chance(deviations) for deviations in (0, 1, 2.5, 3.5, 10)]
    assert needed == sorted(needed)
    assert needed[0] == pytest.approx(0.4)
    assert needed[2] == pytest.approx(np.tanh(np.arctanh(0.4) + 2.5 * 0.17))
    assert needed[-1] < 1


def test_a_line_far_less_alike_than_the_others_is_a_stray():
    names = [f"line{n}" for n in range(5)]
    sure = ClockReading(0.8, 0.8, 0, 0.1, 0.1, 0.5, 0.8, 0, 0.2, 0.06)
    doubtful = sure._replace(near=0.42)
    lines = [replace(capture(), name=name) for name in names]
    strays = _unlike_the_others(list(zip(lines, [sure] * 4 + [doubtful], strict=True)))
    assert [one.line for one in strays] == ["line4"]
    assert "likeness 0.42, median 0.80" in strays[0].why
    quiet = sure._replace(near=0.6)
    assert not _unlike_the_others(list(zip(lines, [sure] * 4 + [quiet], strict=True)))
    assert not _unlike_the_others(list(zip(lines, [*[sure] * 4, None], strict=True)))
    assert not _unlike_the_others([(lines[0], sure), (lines[1], doubtful)])


def test_noise_is_refused_with_numbers():
    line = capture()
    noise = np.random.default_rng(5).normal(0.3, 0.1, line.values.shape)
    told = why(replace(line, values=noise))
    assert "does not follow its timings (likeness 0." in told
    assert "chance gives" in told


@pytest.mark.parametrize("make", [capture, sensed])
@pytest.mark.parametrize("late", [-0.2, -0.12, 0.12, 0.2])
def test_small_offsets_are_corrected_and_told(make, late):
    line = make()
    found = kept(replace(line, times=line.times + late))
    np.testing.assert_allclose(found.times, line.times, atol=0.04)
    assert f"s {'late' if late > 0 else 'early'} and was shifted" in found.remarks[0]


def test_large_offsets_are_refused_with_their_size():
    line = capture()
    long = np.arange(line.times[0] - 1, line.times[-1] + 1, 1 / 60)
    values = [np.interp(long, line.times, one) for one in line.values.T]
    told = why(replace(line, times=long + 0.6, values=np.column_stack(values)))
    assert "motion is 0.6" in told
    assert "s late" in told
    assert "state its start" in told


@pytest.mark.parametrize("make", [capture, sensed])
@pytest.mark.parametrize("speed", [0.9, 1.12])
def test_a_drifting_clock_is_refused(make, speed):
    line = make()
    told = why(replace(line, times=line.times[0] + (line.times - line.times[0]) * speed))
    assert "clock drifts: it " + ("loses" if speed > 1 else "gains") in told


def test_a_frame_rate_that_lies_is_refused():
    line = capture()
    told = why(replace(line, times=line.times * 2))
    assert "its frame rate is wrong: the motion fits at 2 times its speed" in told


def test_a_slow_capture_is_refused():
    line = capture(fps=15)
    assert "has 15 frames per second, too few for closures of the lips" in why(line)


def test_a_capture_that_ends_before_the_speech_is_refused():
    line = capture()
    half = len(line.times) // 2
    told = why(replace(line, times=line.times[:half], values=line.values[:half]))
    assert "but the speech lasts from" in told


def test_minutes_without_any_motion_are_refused():
    line = capture()
    assert "nothing moves in" in why(replace(line, values=np.full_like(line.values, 0.2)))
    lost = np.full_like(line.values, np.nan)
    assert "all signals are lost" in why(replace(line, values=lost))


def test_frozen_and_lost_signals_are_left_out_and_named():
    line = capture()
    values = line.values.copy()
    values[:, 0] = 0.4
    values[: len(values) * 3 // 4, 1] = np.nan
    found = kept(replace(line, values=values))
    assert found.signals == line.signals[2:]
    np.testing.assert_array_equal(found.gains, line.gains[2:])
    told = " ".join(found.remarks)
    assert f"left out, because they are frozen: {line.signals[0]}" in told
    assert f"left out, because they are lost in most of the speech: {line.signals[1]}" in told


def test_a_stretch_without_tracking_is_taken_for_lost():
    line = capture()
    values = line.values.copy()
    values[60:100] = values[60]
    found = kept(replace(line, values=values))
    assert np.isnan(found.values[62:99]).all()
    assert np.isfinite(found.values[:60]).all()
    assert any("s of speech; they are left out" in told for told in found.remarks)


def test_minutes_of_silence_within_a_line_do_no_harm():
    first, other = spoken(0), spoken(1)
    pause = 180.0
    schedule = ll.Schedule(
        (*first.labels, "_", *other.labels),
        np.concatenate((first.times, first.end + pause + (other.times - other.start))),
        notation=first.notation,
    )
    moved = dominance(performer(), schedule, 60)
    noise = np.random.default_rng(3).normal(0, 0.06, moved.weights.shape)
    line = replace(capture(), schedule=schedule, times=moved.times, values=moved.weights + noise)
    assert kept(line).remarks == ()
    times = compared(performer(), line, [schedule]).times
    assert len(times) / CLOCK_FPS < schedule.end - pause + 2, "silence is not compared"
    late = kept(replace(line, times=line.times + 0.15))
    assert "0.1" in late.remarks[0]


def test_a_take_of_a_phone_on_a_rig_passes(tmp_path):
    (tmp_path / "characters").mkdir()
    text = "kind: character\nformat: 1\nname: max\nposeset: facefx\nrig: facefx-to-arkit\n"
    (tmp_path / "characters/max.yaml").write_text(text, "utf-8")
    face = ll.resolve("english", "max", paths=[tmp_path])
    for number in range(len(TEXTS)):
        moved = face.rigged(dominance(face, spoken(number), 60))
        moved.save(tmp_path / f"line{number}.csv", "live-link-face")
        spoken(number).save(tmp_path / f"line{number}.TextGrid")
    found = judge_captures(face, read_captures(face, tmp_path))
    assert len(found.lines) == len(TEXTS)
    assert not found.set_aside


def test_gaps_within_a_line_do_no_harm():
    line = sensed()
    values = line.values.copy()
    values[30:40] = np.nan
    assert kept(replace(line, values=values)).remarks == ()


def test_sensors_that_run_backwards_are_left_out():
    line = sensed()
    values = line.values.copy()
    values[:, 1] *= -1
    found = kept(replace(line, values=values))
    assert line.signals[1] not in found.signals
    assert "move against their curves" in found.remarks[0]


def test_a_line_twice_counts_once():
    line = capture()
    captures = judged(line, capture(1), replace(line, name="again"))
    assert [one.name for one in captures.lines] == ["line0", "line1"]
    assert captures.set_aside[0].line == "again"
    assert "its motion is identical to that of 'line0'" in captures.set_aside[0].why


def test_a_word_is_too_short_to_judge_its_clock():
    schedule = ll.Schedule(("_", "M", "AA", "_"), [0, 0.2, 0.3, 0.5, 0.8], notation="arpabet")
    made = performer().perform(schedule)
    line = CapturedLine("ma", schedule, made.times, made.poses, made.weights, np.eye(9))
    assert "has only 2 sounds, too few to judge its clock" in kept(line).remarks[-1]


def test_what_was_set_aside_before_stays_so_and_progress_is_told():
    seen = []
    before = (SetAside(line="x", why="y"),)
    captures = judge_captures(
        performer(), Captures((capture(),), before), progress=lambda *done: seen.append(done)
    )
    assert captures.set_aside == before
    assert seen == [(1, 1)]


def test_lines_with_far_residuals_are_named():
    usual = {f"line{n}": 0.05 + 0.002 * n for n in range(6)}
    assert outlying_lines(usual) == ()
    (one,) = outlying_lines({**usual, "odd": 0.2})
    assert one.line == "odd"
    assert "its error after the fit is 0.200, and the median is 0.056" in one.why
    assert outlying_lines({"a": 0.1, "b": 0.9}) == ()


def test_recordings_of_real_mouths_pass_and_exchanged_ones_do_not(root, data):
    german = ll.resolve("german", "facefx")
    captures = read_captures(
        german, data / "articulography", readout=root / "benchmarks/articulography.yaml"
    )
    found = judge_captures(german, captures)
    assert len(found.lines) == 3
    assert not found.set_aside
    for line, before in zip(found.lines, captures.lines, strict=True):
        assert line.signals == before.signals
        np.testing.assert_array_equal(line.times, before.times)
    lines = captures.lines
    for shift in (1, 2):
        wrong = [
            replace(one, schedule=lines[(at + shift) % 3].schedule) for at, one in enumerate(lines)
        ]
        assert not judged(*wrong, face=german).lines


@full
def test_most_short_takes_of_film_pass(data, tmp_path):
    """2 s of speech in each: the gap of the lips alone, 20 ms later than the sound."""
    films = data / "films"
    with (films / "grid_s1_texts.tsv").open(encoding="utf-8") as stream:
        texts = {row["clip"]: row["text"] for row in csv.DictReader(stream, delimiter="\t")}
    chosen = sorted(texts)[::19]
    with gzip.open(films / "grid_s1_lips.tsv.gz", "rt", encoding="utf-8") as stream:
        rows = [row for row in csv.DictReader(stream, delimiter="\t") if row["clip"] in chosen]
    for clip in chosen:
        own = [f"{float(row['second']) + 0.02},{row['inner_gap'] or 'nan'}"
               for row in rows if row["clip"] == clip]  # fmt: skip
        (tmp_path / f"{clip}.csv").write_text("\n".join(("time_s,gap", *own)), "utf-8")
        (tmp_path / f"{clip}.txt").write_text(texts[clip], "utf-8")
        shutil.copy(films / f"grid_s1_sound/{clip}.ogg", tmp_path)
    readout = "kind: readout\nformat: 1\nmeasures:\n  aperture: {gap: 1}\n"
    (tmp_path / "readout.yaml").write_text(readout, "utf-8")
    assert len(judge_captures(performer(), read_captures(performer(), tmp_path)).lines) >= 8


@full
@pytest.mark.parametrize("language", ["finnish", "german", "japanese", "spanish"])
def test_sound_lines_of_other_languages_pass(language):
    texts = {"finnish": "hyvää huomenta kaikille", "german": "guten Morgen zusammen",
             "japanese": "おはようございます", "spanish": "buenos días a todos"}  # fmt: skip
    face = ll.resolve(language, "facefx")
    schedule = replace(ll.speak(texts[language], language, engine="none"), audio=None)
    moved = dominance(face, schedule, 60)
    line = CapturedLine("one", schedule, moved.times, face.poses, moved.weights, np.eye(9))
    assert judged(line, face=face).lines
