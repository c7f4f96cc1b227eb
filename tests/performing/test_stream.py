"""A stream returns the frames of the whole schedule for any parts, in bounded memory."""

from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from math import isinf

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from lanes import full, swept
from shipped import RESTING
from strategies import RATES, any_lines, motions

import lipsync_lang as ll
from lipsync_lang import Schedule
from lipsync_lang.base.errors import LipsyncError, ScheduleError
from lipsync_lang.performing.heard import HeardLabel, HeardLabels, HeardWord
from lipsync_lang.performing.stream_frames import StreamFrames
from lipsync_lang.pipeline.levels import Blend, Dial, Level
from lipsync_lang.pipeline.prepare import prepare

EQUAL = 1e-6
LENGTHS = st.one_of(st.sampled_from([0.005, 0.05, 0.1, 0.3]), st.floats(0.005, 1.5))
WAYS = ("closed", "open", "part", "open and lasting")
PAIRS = [("english", "facefx"), ("german", "arkit"), ("mandarin", "crab"), ("hindi", "oculus")]


@cache
def resolved(language, character):
    return ll.resolve(language, character)


@pytest.fixture(scope="module")
def performer():
    return resolved("english", "facefx")


@st.composite
def spoken(draw, performer, notation):
    """A schedule in a notation, silences among its labels."""
    known = sorted(performer.labels.notations[notation].table)
    label = st.one_of(st.sampled_from(known), st.sampled_from(known), st.just("_"))
    labels = draw(st.lists(label, min_size=1, max_size=14))
    lengths = draw(st.lists(LENGTHS, min_size=len(labels), max_size=len(labels)))
    start = draw(st.sampled_from([0.0, 0.137, -2.5, 4000.0]))
    stress = draw(st.one_of(st.just(()), st.lists(st.sampled_from([None, 0, 1, 2]),
                  min_size=len(labels), max_size=len(labels))))  # fmt: skip
    times = start + np.concatenate(([0.0], np.cumsum(lengths)))
    return Schedule(tuple(labels), times, notation=notation, stress=tuple(stress))


def part_of(schedule, first, stop):
    return Schedule(
        schedule.labels[first:stop],
        schedule.times[first : stop + 1],
        notation=schedule.notation,
        stress=schedule.stress[first:stop],
    )


def fed(stream, schedule, draw):
    """Feed a schedule in drawn parts, ask for frames now and then, and return all of them."""
    found = []
    for number, (start, end) in enumerate(pairwise(schedule.times.tolist())):
        way = draw(st.sampled_from(WAYS))
        if way == "part" or schedule.stress:
            stream.feed(part_of(schedule, number, number + 1))
        else:
            stream.feed(schedule.labels[number], start, end if way == "closed" else None)
        if way == "open and lasting" and not schedule.stress:
            found.append(stream.frames())
            stream.known_until((start + end) / 2)
        if draw(st.booleans()):
            found.append(stream.frames(draw(st.one_of(st.none(), st.floats(-3, 10)))))
    stream.known_until(schedule.end)
    stream.finish()
    found.append(stream.frames())
    return [np.concatenate(parts) for parts in zip(*found, strict=True)]


def assert_as_whole(performer, schedule, fps, draw):
    whole = performer.perform(schedule, fps)
    marked = bool(performer.labels.stresses(*performer.labels.read([schedule])).size)
    stream = performer.stream(fps, notation=schedule.notation, stress=marked)
    times, weights = fed(stream, schedule, draw)
    assert np.array_equal(times, whole.times)
    assert np.abs(weights - whole.weights).max() <= EQUAL


@pytest.mark.parametrize(
    ("language", "character"), [PAIRS[0], *(pytest.param(*one, marks=full) for one in PAIRS[1:])]
)
@given(st.data(), RATES)
def test_frames_are_those_of_the_whole_however_it_comes(language, character, data, fps):
    performer = resolved(language, character)
    schedule = data.draw(spoken(performer, "ipa"))
    try:
        performer.common_phonemes(schedule)
    except ScheduleError:
        assume(False)  # noqa: FBT003 none of its labels has a sound
    assert_as_whole(performer, schedule, fps, data.draw)


@dataclass
class Standing:
    """The part of a performer that stream frames use, over any tables."""

    made: object
    motion: object
    opening_poses: object = None

    def tables(self, _blends):
        return self.made

    @property
    def poses(self):
        return range(len(self.made.priority))

    def styled_motion(self, _blends):
        return self.motion


@full
@given(any_lines(), motions(hold=0), RATES, st.data())
@settings(max_examples=120)
def test_frames_are_those_of_the_whole_with_any_tables_and_motion(line, motion, fps, data):
    """Random tables, constraints, contacts, edits, styles and dials, label by label."""
    line = replace(line, edits=tuple(sorted(line.edits)))
    used = line.tables.papers if motion.thresholds == "paper" else line.tables
    reaches = prepare(used, motion, fps).reach.values()
    assume(not any(isinf(one.ahead) for one in reaches))
    whole = line.perform(motion, fps)
    expected = whole.weights()
    every = np.arange(len(line.tables.priority))
    ends = line.times[[0, -1]]
    blends = tuple(Blend(n, Level(ends, np.array(s))) for n, s in enumerate(line.shares))
    dials = tuple(Dial(every % n == 0, Level(ends, np.array(s))) for n, *s in line.dials)
    frames = StreamFrames(Standing(line.tables, motion), fps, blends, dials, emphasis=False)
    heard = HeardLabels(line.tables.silence)
    number = 0
    found = []

    def made():
        nonlocal number
        stop = frames.settled(heard)
        if stop > number:
            found.append(frames.weights(heard, number, stop))
            number = stop
            frames.forget(heard, stop)

    laid = [(one, int(np.argmin(np.abs(line.times - one.start)))) for one in line.overlays()]
    for n, (start, end) in enumerate(pairwise(line.times.tolist())):
        if data.draw(st.booleans()):
            heard.add(HeardLabel(start, None, ((int(line.ids[n]), 1.0),)))
            made()
            heard.end(end)
        else:
            heard.add(HeardLabel(start, end, ((int(line.ids[n]), 1.0),)))
        ramp = (start, start, end + 9, end + 9)
        heard.words += [HeardWord(n, ramp, 0.0, (one,)) for one, at in laid if at == n]
        if data.draw(st.booleans()):
            made()
    frames.finish(heard)
    made()
    assert frames.count == whole.frames.count
    assert np.abs(np.concatenate(found) - expected).max() <= EQUAL


@pytest.mark.parametrize("first", [0.0, 0.1, 0.4])
def test_evenly_stretched_bigrams_wait_for_the_length_of_the_next_sound(first):
    performer = resolved("english", "facefx").with_motion("paper")
    performer = performer.with_motion({"smooth": "none", "ends": "rest", "silence_reach": 0.25})
    labels, times = ("_", "AA", "M", "_", "IY"), np.array([0, 0, 0.25, 0.6, 0.7, 1.1])
    times[1:] += first
    schedule = Schedule(labels[not first :], times[not first :], notation="arpabet")
    stream = performer.stream(notation="arpabet", stress=False)
    found = []
    for label, start in zip(schedule.labels, schedule.times, strict=False):
        stream.feed(label, float(start))
        found.append(stream.frames().weights)
    stream.known_until(schedule.end)
    stream.finish()
    weights = np.concatenate([*found, stream.frames().weights])
    assert np.abs(weights - performer.perform(schedule).weights).max() <= EQUAL


# Stress


MARKS = ("in the labels", "beside them", "none")


@st.composite
def marked(draw, performer, notation):
    """A schedule whose first vowels may have no mark, in any way in which marks are written."""
    schedule = draw(spoken(performer, notation))
    where = draw(st.sampled_from(MARKS))
    known = performer.labels.notations[notation]
    marks = [draw(st.sampled_from([None, None, 0, 1, 2])) for _ in schedule.labels]
    if where != "in the labels":
        return replace(schedule, stress=tuple(marks) if where == "beside them" else ())
    signs = {None: "", 0: "", 1: "ˈ", 2: "ˌ"}
    written = [signs[mark] + label for mark, label in zip(marks, schedule.labels, strict=True)]
    heard = [
        new if known.find(new) == known.find(old) and known.stress(new) is not None else old
        for new, old in zip(written, schedule.labels, strict=True)
    ]
    return replace(schedule, labels=tuple(heard), stress=())


@pytest.mark.parametrize("language", swept(RESTING, 3))
@settings(max_examples=16)  # for each language
@given(st.data())
def test_marks_of_a_whole_schedule_count_from_its_first_vowel(language, data):
    """With the default: a schedule of any notation, whole, or in parts that come in time."""
    performer = resolved(language, "facefx")
    notation = data.draw(st.sampled_from(sorted(performer.labels.own_notations)))
    schedule = data.draw(marked(performer, notation))
    try:
        performer.common_phonemes(schedule)
    except ScheduleError:
        assume(False)  # noqa: FBT003 none of its labels has a sound
    stream = performer.stream(24, notation=schedule.notation)
    if data.draw(st.booleans()):
        stream.feed(schedule)
    else:
        for number in range(len(schedule)):
            stream.feed(part_of(schedule, number, number + 1))
    found = [stream.frames(data.draw(st.floats(-3, 10))) for _ in range(3)]
    stream.finish()
    found.append(stream.frames())
    weights = np.concatenate([one.weights for one in found])
    assert np.abs(weights - performer.perform(schedule, 24).weights).max() <= EQUAL


def test_a_mark_that_comes_late_leaves_returned_vowels_as_they_were(performer):
    """The curves go on from there without a jump; `stress=True` gives those of the whole."""
    labels = ("_", "AA", "M", "AA", "M", "AA1", "M", "AA")
    times = np.array([0, 1, 1.2, 3, 3.2, 5, 5.2, 7, 7.2])
    whole = performer.perform(Schedule(labels, times, notation="arpabet")).weights
    made = {}
    for stress in (None, True):
        stream = performer.stream(notation="arpabet", stress=stress)
        found = []
        for label, start, end in zip(labels, times, times[1:], strict=False):
            stream.feed(label, float(start), float(end))
            found.append(stream.frames().weights)
        stream.finish()
        made[stress] = np.concatenate([*found, stream.frames().weights])
    assert np.abs(made[True] - whole).max() <= EQUAL
    apart = np.abs(made[None] - whole).max(axis=1) > EQUAL
    assert apart[: 3 * 60].any()
    assert not apart[int(4.5 * 60) :].any()
    assert np.abs(np.diff(made[None], axis=0)).max() <= performer.motion.speed_limit / 60 + 1e-9


# Parts with words


def test_words_keep_their_curves_emphasis_and_pronunciations(performer):
    """Frames of a part that has them whole."""
    times = np.arange(0, 1.3, 0.1)
    labels = ("_", *["h", "ə", "l", "oʊ"], "_", *["w", "ɜː", "l", "d"], "m", "_")
    said = (ll.Word("hello", 1, 5), ll.Word("world", 6, 10, emphasis=1.5))
    schedule = Schedule(labels, times, words=said, notation="ipa", language="english")
    whole = performer.perform(schedule)
    stream = performer.stream(emphasis=True, stress=False)
    stream.feed(Schedule(labels[:6], times[:7] - 5, words=said[:1], notation="ipa"), 5.0)
    later = (ll.Word("world", 0, 4, emphasis=1.5),)
    first = stream.frames().weights
    stream.feed(Schedule(labels[6:], times[6:], words=later, notation="ipa"))
    stream.finish()
    weights = np.concatenate((first, stream.frames().weights))
    assert np.abs(weights - whole.weights).max() <= EQUAL
    plain = performer.perform(replace(schedule, words=()))
    assert np.abs(weights - plain.weights).max() > 0.05
    with pytest.raises(LipsyncError, match="emphasis=True"):
        performer.stream().feed(Schedule(labels[6:], times[6:], words=later, notation="ipa"))


# Late and revised


@given(st.data())
def test_what_is_not_final_may_be_revised(data):
    performer = resolved("english", "facefx")
    schedule = data.draw(spoken(performer, "arpabet"))
    assume(not schedule.stress)
    assume(any(performer.labels.notations["arpabet"].find(one) for one in schedule.labels))
    stream = performer.stream(
        notation="arpabet", stress=bool(performer.performance(schedule, 60).dials)
    )
    found = []
    for number, (start, end) in enumerate(pairwise(schedule.times.tolist())):
        until = data.draw(st.floats(start, end + 1.0))
        for label, to in (("AA", until), ("B", until + 0.3)):  # what proves wrong
            if to > stream_end(stream, start):
                stream.feed(label, stream_end(stream, start), to)
        stream.revise(start)
        stream.feed(schedule.labels[number], start, end)
        found.append(stream.frames())
    stream.finish()
    found.append(stream.frames())
    weights = np.concatenate([one.weights for one in found])
    assert np.abs(weights - performer.perform(schedule).weights).max() <= EQUAL


def stream_end(stream, otherwise):
    return otherwise if stream.known is None else stream.known


def test_what_was_given_stays(performer):
    stream = performer.stream(notation="arpabet", stress=False)
    stream.feed("HH", 0, 0.1)
    stream.feed("AA", 0.1, 1.0)
    stream.feed("M", 1.0, 1.1)
    given = stream.frames()
    last = float(given.times[-1])
    with pytest.raises(LipsyncError, match=f"until {last:.3f} s were returned"):
        stream.revise(0.5)
    assert stream.known == 1.1
    stream.revise(last + stream.delay + 0.05)
    stream.revise(1.05)  # the end of the last phoneme is as free as what follows
    stream.feed("AA", 1.05, 1.3)
    assert stream.known == 1.3


def test_a_late_phoneme_is_refused_or_shortened(performer):
    for late in ("refuse", "shorten"):
        stream = performer.stream(notation="arpabet", late=late)
        stream.feed("AA", 0, 0.1)
        stream.known_until(1.0)
        if late == "refuse":
            with pytest.raises(ScheduleError, match=r"0.8 s, but the stream is known until 1 s"):
                stream.feed("M", 0.8, 1.2)
            assert stream.known == 1.0
            continue
        stream.feed("M", 0.7, 0.9)  # it is over
        assert stream.known == 1.0
        stream.feed("M", 0.8, 1.2)
        stream.finish()
        cut = Schedule(("AA", "_", "M"), [0, 0.1, 1.0, 1.2], notation="arpabet")
        assert np.abs(stream.frames().weights - performer.perform(cut).weights).max() <= EQUAL


def test_a_gap_is_silence_and_an_open_phoneme_lasts(performer):
    stream = performer.stream(notation="arpabet")
    stream.feed("AA", 0, 0.1)
    stream.feed("M", 0.5)
    stream.feed("IY", 0.7, 0.8)
    stream.finish()
    same = Schedule(("AA", "_", "M", "IY"), [0, 0.1, 0.5, 0.7, 0.8], notation="arpabet")
    assert np.abs(stream.frames().weights - performer.perform(same).weights).max() <= EQUAL


# Delay and memory


@pytest.mark.parametrize("character", ["facefx", "arkit", "crab", "oculus"])
def test_a_frame_is_final_as_soon_as_its_delay_says(character):
    """A phoneme that starts after the delay makes the frame final, and not one frame later."""
    for stress in (None, False):
        stream = resolved("english", character).stream(60, notation="arpabet", stress=stress)
        stream.feed("_", 0, 2)
        stream.feed("AA", 2, 2.2)
        stream.feed("B", 2.2, 4.0)
        stream.feed("AA", 4.0)
        last = float(stream.frames().times[-1])
        beyond = 4.0 - (last + stream.delay)
        assert beyond + 1e-5 > -1e-9 or stress is None, beyond
        assert beyond < 1 / 60 + 1e-5
        assert stream.delay == pytest.approx(sum(stream.delays.values()))


def test_a_pause_does_not_keep_frames_back(performer):
    stream = performer.stream(notation="arpabet")
    stream.feed("AA", 0, 0.2)
    for second in range(1, 20):
        stream.known_until(second)
        stream.frames()
    wanted = 19 - stream.delay - performer.motion.silence_reach
    assert stream.final >= int((wanted + 0.25) * 60) - 1


def test_hours_need_no_more_memory_than_seconds(performer):
    stream = performer.stream(12, notation="arpabet", emphasis=True)
    sizes = []
    for number in range(1200):
        label = ("M", "AA1", "_", "_", "T", "IY0")[number % 6]
        stream.feed(label, number * 0.9, None if number % 5 == 0 else (number + 1) * 0.9)
        stream.frames(None if number % 3 else number * 0.9 - 3)
        sizes.append(stream.held)
    assert stream.final > 1200 * 0.9 * 12 - 60
    assert max(sizes[900:]) <= max(sizes[:200])


def test_known_silence_and_mute_labels_leave_nothing_behind(performer):
    stream = performer.stream(12, notation="ipa")
    stream.feed("m", 0, 1)
    sizes = []
    for number in range(1, 300):
        stream.feed("_", number, number + 0.5)
        stream.known_until(number + 1)
        stream.frames()
        sizes.append(stream.held)
    assert max(sizes[150:]) <= max(sizes[:50])


@pytest.mark.parametrize(
    "motion", [{"hold": 0.1}, {"smooth": "chord"}, {"ends": "cut"}, "paper"], ids=str
)
def test_settings_that_look_at_a_whole_line_are_refused(performer, motion):
    with pytest.raises(LipsyncError, match="needs the whole line"):
        performer.with_motion(motion).stream()


# Bad input


@pytest.mark.parametrize(
    ("act", "match"),
    [
        (lambda s: s.feed("M", float("nan"), 1), "finite"),
        (lambda s: s.feed("M", 0.1, float("inf")), "finite"),
        (lambda s: s.feed("M", "0", 1), "is not a time"),
        (lambda s: s.feed("M"), "is not a time"),
        (lambda s: s.feed(5, 0.1, 0.2), "is not a label"),
        (lambda s: s.feed("XYZ", 0.1, 0.2), r"stream at 0.1 s: .*'XYZ'"),
        (lambda s: s.feed("M", 0.2, 0.1), "before it starts"),
        (lambda s: s.feed("M", 0.05, 0.2), "the times are not in order"),
        (lambda s: s.feed("M", 100, 200_000), "milliseconds"),
        (lambda s: s.feed("M", 50_000, 50_001), "milliseconds"),
        (lambda s: s.known_until(0.05), "known until 0.1 s already"),
        (lambda s: s.known_until(float("nan")), "finite"),
        (lambda s: s.known_until(1e9), "milliseconds"),
        (lambda s: s.revise(float("inf")), "finite"),
        (lambda s: s.frames(float("nan")), "finite"),
    ],
)
def test_bad_input_is_stated_and_changes_nothing(performer, act, match):
    stream = performer.stream(notation="arpabet")
    stream.feed("AA", 0, 0.1)
    with pytest.raises(ScheduleError, match=match):
        act(stream)
    assert stream.known == 0.1
    stream.feed("M", 0.1, 0.2)
    stream.finish()
    same = Schedule(("AA", "M"), [0, 0.1, 0.2], notation="arpabet")
    assert np.abs(stream.frames().weights - performer.perform(same).weights).max() <= EQUAL


def test_a_stream_begins_and_ends_once(performer):
    stream = performer.stream(notation="arpabet")
    with pytest.raises(ScheduleError, match="feed a phoneme first"):
        stream.known_until(1)
    with pytest.raises(LipsyncError, match="no phonemes"):
        stream.finish()
    stream.feed("AA", 0)
    with pytest.raises(LipsyncError, match="has no end"):
        stream.finish()
    stream.known_until(0.2)
    stream.finish()
    stream.finish()
    assert stream.finished
    with pytest.raises(LipsyncError, match="is finished"):
        stream.feed("M", 0.2, 0.3)
    with pytest.raises(LipsyncError, match="finished"):
        stream.revise(0.1)


def test_arguments_are_checked(performer):
    with pytest.raises(LipsyncError, match="frames per second"):
        performer.stream(0)
    with pytest.raises(LipsyncError, match="`late`"):
        performer.stream(late="never")
    with pytest.raises(ScheduleError, match="no notation 'morse'"):
        performer.stream(notation="morse")
    with pytest.raises(LipsyncError, match="unknown style 'bored'"):
        performer.stream(styles={"bored": 1})
