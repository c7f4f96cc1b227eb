"""Gestures: placed by the facts of a line, the same in every build, within bounds and speed."""

import json
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from strategies import RATES

import lipsync_lang as ll
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.gesturing import gesture_curves, line_facts
from lipsync_lang.pipeline.gestures.laying import GestureSet
from lipsync_lang.pipeline.gestures.pitch import pitches
from lipsync_lang.pipeline.gestures.placing import LineFact, LineFacts, PlacedGesture, place
from lipsync_lang.schedules.schedule import Audio, Word

BLINK = [[0, 0], [0.08, 1], [0.12, 1], [0.26, 0]]
NOD = [[0, 0], [0.18, 1], [0.5, 0]]


def stated(name, **fields):
    usual = {"curve": BLINK, "poses": {"lids": 1.0}, "on": [], "share": 1.0, "lead": 0.0}
    usual |= {"rates": None, "at": [], "apart": 0.0, "spread": 0.7, "by_pitch": False}
    return {"name": name, **usual, "place": "face.yaml:1:1", **fields}


def gesture_set(*gestures):
    channel = {"names": [], "node": None, "rotation": None}
    bone = {"names": [], "node": "Head", "rotation": [1, 0, 0]}
    poses = [
        {"name": "lids", "most": 1.0, "speed_limit": 20.0, "channel": {"name": "lids", **channel}},
        {"name": "nod", "most": 9.0, "speed_limit": 60.0, "channel": {"name": "nod", **bone}},
    ]
    return GestureSet.from_plain({"poses": poses, "gestures": list(gestures), "words": {}})


def line(end=4.0, **facts):
    made = {name: [LineFact(at) for at in times] for name, times in facts.items()}
    starts = [0.3 * n for n in range(int(end / 0.3))]
    return LineFacts(0.0, end, [(0.2, end - 0.2)], made, starts, [7919 * n for n in range(99)])


def placed(gesture, facts):
    return [one.begin for one in place(gesture_set(gesture).shapes, [1.0], facts)]


# Placing


def test_a_gesture_begins_before_its_fact_by_its_lead():
    brows = stated("accent", on=["emphasis"], lead=0.1)
    assert placed(brows, line(emphasis=[1.0, 2.5])) == pytest.approx([0.9, 2.4])


def test_a_share_of_facts_has_the_gesture():
    every = [0.05 + 0.3 * n for n in range(66)]
    found = placed(stated("nod", on=["stress"], share=0.4), line(20.0, stress=every))
    assert 0.25 * len(every) < len(found) < 0.55 * len(every)
    assert not placed(stated("nod", on=["stress"], share=0.0), line(20.0, stress=every))


def test_gestures_keep_apart():
    near = [0.5 + 0.1 * n for n in range(30)]
    found = placed(stated("blink", on=["pause"], apart=0.7), line(stress=[], pause=near))
    assert min(b - a for a, b in pairwise(found)) >= 0.7 - 1e-9


@pytest.mark.parametrize(("speech", "low", "high"), [(True, 20, 30), (False, 12, 20)])
def test_gestures_by_themselves_keep_their_rate(speech, low, high):
    shapes = gesture_set(stated("blink", rates=[26, 17], apart=0.5)).shapes
    count = seconds = 0
    for number in range(300):
        length = 2.0 + number % 9
        spoken = [(0.0, length)] if speech else []
        facts = LineFacts(0.0, length, spoken, {}, [], [number * 7919])
        count += len(place(shapes, [1.0], facts))
        seconds += length
    assert low < count / seconds * 60 < high


def test_a_pause_nearby_draws_a_blink():
    blink = stated("blink", rates=[26, 17], at=["pause"])
    alone = placed(blink, line(20.0))
    drawn = place(gesture_set(blink).shapes, [1.0], line(20.0, pause=[alone[1] + 0.3]))
    assert [one.begin for one in drawn if one.trigger == "pause"] == [alone[1] + 0.3]


def test_an_edited_line_with_sound_has_the_gestures_of_a_fresh_one():
    seconds = np.arange(6 * 16_000) / 16_000
    tone = 8000 * np.sin(2 * np.pi * np.cumsum(120 + 60 * np.sin(2 * seconds)) / 16_000)
    performer = ll.resolve("english", "arkit")
    labels, times = ("K", "AA1", "T", "IY1", "M", "AE1") * 10, np.arange(61) * 0.1
    audio = Audio(tone.astype(np.int16), 16_000)
    one = ll.Schedule(labels, times, notation="arpabet", audio=audio)
    performer.perform(one, gestures="all")
    moved = np.where(np.arange(61) == 7, times + 0.04, times)
    edited = replace(one, times=moved)
    fresh = replace(edited, audio=Audio(audio.samples.copy(), 16_000))
    weights = [performer.perform(said, gestures="all").weights for said in (edited, fresh)]
    assert weights[0].tobytes() == weights[1].tobytes()
    assert weights[0].tobytes() != performer.perform(one, gestures="all").weights.tobytes()


def test_a_sound_of_few_samples_a_second_has_no_pitch():
    for rate in (1, 10, 30, 100, 799):
        assert not pitches(np.ones(4 * rate, np.int16), rate, np.array([0.5, 2.0])).any()


def test_a_long_list_of_pitches_is_that_of_its_parts():
    tone = 8000 * np.sin(2 * np.pi * 110 * np.cumsum(np.linspace(1, 2, 64_000)) / 16_000)
    times = np.linspace(0.1, 3.9, 2500)
    found = pitches(tone.astype(np.int16), 16_000, times)
    alone = [pitches(tone.astype(np.int16), 16_000, times[n : n + 7]) for n in range(0, 2500, 7)]
    assert found.tobytes() == np.concatenate(alone).tobytes()


def test_a_gesture_by_hand_stands_for_those_near_it():
    blink = stated("blink", on=["pause"], apart=0.5)
    by_hand = (PlacedGesture(0, 1.1, 1.0, "by hand", 1.1),)
    facts = replace(line(pause=[0.9, 1.4, 3.0]), by_hand=by_hand)
    assert sorted(placed(blink, facts)) == pytest.approx([1.1, 3.0])


# Laying


@given(
    RATES,
    st.lists(st.tuples(st.integers(0, 2), st.floats(-0.2, 3.2), st.floats(0, 2)), max_size=12),
)
@example(60, [(1, 0.0, 2.0), (1, 0.01, 2.0), (1, -0.1, 2.0), (1, 2.6, 2.0), (1, 2.5, 2.0)])
def test_every_pose_keeps_its_bounds_its_speed_and_its_rest(fps, found):
    own = gesture_set(
        stated("blink"),
        stated("nod", curve=NOD, poses={"nod": 7.0, "lids": 0.3}),
        stated("back", curve=NOD, poses={"nod": -7.0}),
    )
    gestures = [PlacedGesture(n, begin, by, "pause", begin) for n, begin, by in found]
    curves, _ = own.lay(gestures, 0.0, int(3 * fps), fps)
    assert (curves >= own.low).all()
    assert (curves <= own.high).all()
    assert (np.abs(np.diff(curves, axis=0)) <= own.speed / fps + 1e-9).all()
    assert not curves[[0, -1]].any()
    backwards, laid = own.lay(gestures[::-1], 0.0, int(3 * fps), fps)
    assert np.abs(curves - backwards).max() < 1e-8
    assert [one.first for one in laid] == sorted(one.first for one in laid)


@given(RATES, st.floats(0.5, 2.0))
def test_a_blink_shuts_the_lids_at_any_frame_rate(fps, begin):
    blink = PlacedGesture(0, begin, 1.0, "pause", begin)
    curves, (laid,) = gesture_set(stated("blink")).lay([blink], 0.0, int(3 * fps), fps)
    assert curves[:, 0].max() == 1
    assert abs(curves[:, 0].argmax() / fps - (begin + 0.1)) < 0.02 + 1 / fps
    assert not curves[: laid.first].any()
    assert not curves[laid.stop :].any()


def test_a_gesture_at_the_end_moves_inwards_or_is_left_out():
    own = gesture_set(stated("blink"))
    ends = [PlacedGesture(0, begin, 1.0, "pause", begin) for begin in (1.85, 2.1)]
    assert own.lay(ends[:1], 0.0, 121, 60)[0][:, 0].max() == 1
    assert not own.lay(ends[1:], 0.0, 121, 60)[1]


# Pitch


def test_the_pitch_of_a_voice_is_found_and_that_of_noise_is_not():
    times = np.arange(32000) / 16000
    voice = sum(np.sin(2 * np.pi * 150 * n * times) / n for n in range(1, 9))
    noise = np.random.default_rng(0).normal(size=32000)
    heard = [(4000 * one).astype(np.int16) for one in (voice, noise)]
    assert pitches(heard[0], 16000, np.array([0.5, 1.0])) == pytest.approx([150, 150], rel=0.04)
    assert not pitches(heard[1], 16000, np.array([0.5, 1.0])).any()
    assert not pitches(heard[0][:10], 16000, np.array([0.5])).any()


# Performing

WORDS = [("M AA1 M AH0", "mama"), ("T IY1", "tea"), ("S OW1 D AH0", "soda"), ("K AA1 R", "car")] * 4


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "arkit")


def said(words=WORDS, seconds=0.12, pause=3):
    labels, spans = ["_"] * pause, []
    for sounds, text in words:
        spans.append(Word(text, len(labels), len(labels) + len(sounds.split())))
        labels += sounds.split()
    labels += ["_"] * pause
    return ll.Schedule(labels, np.arange(len(labels) + 1) * seconds, spans, notation="arpabet")


def test_speech_is_the_same_beside_gestures(performer):
    spoken, moving = performer.perform(said()), performer.perform(said(), gestures="all")
    assert np.array_equal(moving.weights[:, : len(spoken.poses)], spoken.weights)
    assert moving["nod"].any()
    assert len(moving.columns) == len(moving.poses) == moving.weights.shape[1]
    assert moving.columns[moving.poses.index("nod")].node == "Head"
    plain = moving.without_gestures()
    assert plain.poses == spoken.poses
    assert np.array_equal(plain.weights, spoken.weights)
    assert spoken.without_gestures() is spoken


def test_the_same_line_has_the_same_gestures(performer):
    one, other = (performer.perform(said(), gestures="all") for _ in range(2))
    assert one.weights.tobytes() == other.weights.tobytes()
    both = performer.perform_many([said(WORDS[:3]), said()], gestures="all")
    assert both[1].weights.tobytes() == one.weights.tobytes()


@pytest.mark.parametrize("changed", range(6, len(WORDS)))
def test_a_changed_word_leaves_gestures_up_to_a_second_before_it(performer, changed):
    words = [*WORDS[:changed], ("B IY1 B ER0 D", "bird"), *WORDS[changed + 1 :]]
    one, other = (performer.perform(said(w), gestures="all") for w in (WORDS, words))
    until = np.searchsorted(one.times, said().words[changed].start - 1)
    assert np.array_equal(one.weights[:until, 17:], other.weights[:until, 17:])


def test_emphasis_draws_the_brows(performer):
    schedule = said()
    marked = replace(schedule, words=[replace(w, emphasis=float(w is schedule.words[5]))
                                      for w in schedule.words])  # fmt: skip
    times = np.arange(0, 6, 1 / 60)
    scales = [1.0] * len(performer.gesture_set.shapes)
    _, laid = gesture_curves(performer, marked, times, 60, scales, {})
    facts = [one.gesture.fact for one in laid if one.gesture.trigger == "emphasis"]
    near = [at for at in facts if abs(at - marked.words[5].start) <= 0.5]
    assert all(marked.words[5].start <= at < marked.words[5].end for at in near)


def test_a_raised_voice_gives_height(performer):
    every = performer.compiled.gestures
    sure = {**every, "gestures": [one | {"share": 1.0} for one in every["gestures"]]}
    performer = replace(performer, compiled=replace(performer.compiled, gestures=sure))
    schedule = said()
    rate, times = 16000, np.arange(int(16000 * schedule.end)) / 16000
    tone = np.where((times > 2) & (times < 2.6), 170.0, 110.0)
    sound = (6000 * np.sin(2 * np.pi * np.cumsum(tone) / rate)).astype(np.int16)
    heard = replace(schedule, audio=Audio(sound, rate))
    scales = [1.0] * len(performer.gesture_set.shapes)
    laid = gesture_curves(performer, heard, np.arange(0, 6, 1 / 60), 60, scales, {})[1]
    nods = [one.gesture for one in laid if one.gesture.trigger == "stress"]
    high = [one.height for one in nods if 2 < one.fact < 2.5]
    low = [one.height for one in nods if one.fact < 1.5]
    assert high
    assert min(high) > max(low)


def test_gestures_are_chosen_and_scaled(performer):
    blinks = performer.perform(said(), gestures="blink")
    assert blinks["eyeBlinkLeft"].max() == 1
    assert not blinks["nod"].any()
    every, low = (performer.perform(said(), gestures=g)["nod"] for g in ("nod", {"nod": 0.5}))
    assert low == pytest.approx(every / 2)
    assert not performer.perform(said(), gestures="all, nod:0")["nod"].any()
    assert performer.perform(said(), gestures="none").poses == performer.poses


def test_a_character_and_a_line_scale_gestures(performer):
    plain = performer.compiled
    quiet = replace(
        performer,
        compiled=replace(
            plain,
            delivery={**plain.delivery, "gestures": {"nod": 0.0}},
            line_deliveries={"loud": {"gestures": {"nod": 1.0, "blink": 0.0}}},
            line_edits={"loud": []},
        ),
    )
    usual = quiet.perform(said(), gestures="all")
    assert usual["eyeBlinkLeft"].any()
    assert not usual["nod"].any()
    loud = quiet.perform(said(), line="loud", gestures="all")
    assert loud["nod"].any()
    assert not loud["eyeBlinkLeft"].any()


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        ("blinc", "unknown gesture 'blinc'; did you mean 'blink'"),
        ("blink:x", "gesture blink:x: write NAME or NAME:FACTOR, such as blink:0.5"),
        ("blink:3", "gesture blink: 3 is not from 0 to 2"),
        ({"nod": -1.0}, "gesture nod: -1 is not from 0 to 2"),
    ],
)
def test_faulty_gestures_are_refused(performer, asked, why):
    with pytest.raises(LipsyncError, match=why):
        performer.perform(said(), gestures=asked)


def test_a_set_without_gestures_has_none_and_refuses_names():
    bare = ll.resolve("english", "rhubarb")
    assert bare.perform(said(), gestures="all").poses == bare.poses
    with pytest.raises(LipsyncError, match="rhubarb has no gestures"):
        bare.perform(said(), gestures="blink")


def test_a_gesture_is_explained_by_its_trigger_and_its_line(performer):
    moving = performer.perform(said(), gestures="all")
    told = str(moving.explain(moving.times[moving["nod"].argmax()]))
    assert "nod: stress at '" in told
    assert "arkit/poseset.yaml:" in told
    cut = str(moving.cut().explain(moving.times[moving["nod"].argmax()]))
    assert cut == told


def test_a_rig_passes_gestures_on_and_check_leaves_them_out(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "characters").mkdir()
    (tmp_path / "characters/rigged.yaml").write_text(
        "kind: character\nformat: 1\nname: rigged\nposeset: facefx\nrig: facefx-to-arkit\n"
    )
    rigged = ll.resolve("english", "rigged", paths=[tmp_path])
    posed = rigged.perform(said(), gestures="all")
    shown = rigged.rigged(posed)
    assert np.array_equal(shown["nod"], posed["nod"])
    assert shown.columns[shown.poses.index("nod")].node == "head"
    assert rigged.rigged(shown) is shown
    spoken = rigged.rigged(rigged.perform(said()))
    assert shown.without_gestures().poses == spoken.poses
    assert ll.check(shown).figures == ll.check(spoken).figures


# Words, voices and hands


def triggers(performer, schedule, line=None, times=None):
    scales = [1.0] * len(performer.gesture_set.shapes)
    times = np.arange(0, schedule.end, 1 / 60) if times is None else times
    _, laid = gesture_curves(performer, schedule, times, 60, scales, {"line": line})
    names = [shape.name for shape in performer.gesture_set.shapes]
    return [(names[one.gesture.number], one.gesture.trigger, one.gesture.fact) for one in laid]


def test_words_of_the_language_deny_agree_and_ask(performer):
    schedule = said([("Y EH1 S", "Yes,"), ("M AA1 M AH0", "mama"), ("W EH1 R", "Where"), *WORDS])
    found = triggers(performer, schedule)
    assert ("assent", "agreement", schedule.words[0].start) in found
    assert ("ask", "question", schedule.words[2].start) in found
    british = ll.resolve("english-uk", "arkit")
    assert british.gesture_set.words == performer.gesture_set.words


def rising(seconds, at, end):
    """Return a tone of 100 Hz that reaches another pitch shortly before a time."""
    rate = 16_000
    times = np.arange(int(rate * seconds)) / rate
    tone = np.interp(times, [0, at - 0.5, at - 0.15], [100, 100, end])
    return Audio((6000 * np.sin(2 * np.pi * np.cumsum(tone) / rate)).astype(np.int16), rate)


@pytest.mark.parametrize(("end", "asks"), [(150.0, True), (80.0, False)])
def test_a_voice_that_rises_at_the_end_asks(performer, end, asks):
    schedule = said(WORDS[:4])
    audio = rising(schedule.end, schedule.end, end)
    found = triggers(performer, replace(schedule, audio=audio))
    assert ("rise" in {trigger for _, trigger, _ in found}) == asks


@pytest.mark.parametrize(("pause", "asks"), [("comma", False), ("full stop", True)])
def test_a_voice_that_rises_before_a_comma_does_not_ask(performer, pause, asks):
    seconds = {"comma": 0.15, "full stop": 0.3}[pause]
    labels = ("M", "AA1", "M", "AH0", "_", "M", "AA1")
    ends = np.cumsum([0, 0.2, 0.4, 0.1, 0.4, seconds, 0.2, 0.4])
    words = (ll.Word("mama", 0, 4), ll.Word("ma", 5, 7))
    schedule = ll.Schedule(labels, ends, words=words, notation="arpabet")
    audio = rising(schedule.end, ends[4], 150.0)
    found = triggers(performer, replace(schedule, audio=audio))
    assert any(trigger == "rise" and fact < ends[4] for _, trigger, fact in found) == asks


def test_one_sound_with_other_times_has_the_facts_of_those_times(performer):
    """The voice rises once within the line, and at its end."""
    schedule, rate, found = said(), 16_000, []
    times = np.arange(int(rate * schedule.end)) / rate
    places = [2, 2.1, 2.6, 2.7, schedule.end - 0.5, schedule.end - 0.15]
    tone = np.interp(times, places, [1, 1.5, 1.5, 1, 1, 1.5])
    sound = 6000 * np.sin(2 * np.pi * np.cumsum(110 * tone) / rate)
    audio = Audio(sound.astype(np.int16), rate)
    for share in (1.0, 0.6, 1.0):
        timed = replace(schedule, times=schedule.times * share, audio=audio)
        found.append(line_facts(performer, timed).facts)
        assert found[-1] == line_facts(performer, replace(timed, audio=replace(audio))).facts
    first, second = ([one.height for one in facts["stress"]] for facts in found[:2])
    assert first != second
    assert len(found[0]["rise"]) > len(found[1]["rise"])


@pytest.fixture
def by_hand(performer):
    def made(*placed):
        plain = performer.compiled
        compiled = replace(
            plain, line_deliveries={"hi": {"gestures": {}, "placed": list(placed)}},
            line_edits={"hi": []},
        )  # fmt: skip
        return replace(performer, compiled=compiled)

    return made


def test_a_person_places_gestures_at_times_and_words(by_hand):
    own = by_hand({"gesture": "nod", "at": 1.0, "scale": 2.0}, {"gesture": "blink", "word": 2})
    found = triggers(own, said(), "hi")
    assert ("nod", "by hand", 1.0) in found
    assert ("blink", "by hand", said().words[2].start) in found
    near = [at for name, trigger, at in found if name == "nod" and trigger != "by hand"]
    assert all(abs(at - 1.0) >= 0.5 for at in near)
    assert own.perform(said(), line="hi", gestures="nod")["nod"].max() == pytest.approx(10, abs=0.1)
    assert not own.perform(said(), line="hi", gestures="blink")["nod"].any()
    with pytest.raises(LipsyncError, match="'nod' of line 'hi' is at word 99, counted from 0"):
        by_hand({"gesture": "nod", "word": 99}).perform(said(), line="hi", gestures="all")


def test_a_gesture_by_hand_stands_beside_its_word(by_hand):
    start = said().words[2].start
    found = triggers(by_hand({"gesture": "blink", "word": 2, "after": -0.2}), said(), "hi")
    assert ("blink", "by hand", pytest.approx(start - 0.2)) in found


def test_a_gesture_of_no_scale_leaves_out_what_comes_by_rule(performer, by_hand):
    before = triggers(performer, said())
    name, _, at = gone = next(one for one in before if one[0] == "nod")
    own = by_hand({"gesture": name, "at": at, "scale": 0})
    left = triggers(own, said(), "hi")
    assert sorted([*left, gone]) == sorted(before), "the others stay where they are"
    curves = own.perform(said(), line="hi", gestures="all")["nod"]
    usual = performer.perform(said(), gestures="all")["nod"]
    changed = np.flatnonzero(curves != usual) / 60
    assert len(changed)
    assert at - 0.1 < changed.min()
    assert changed.max() < at + 0.6


def test_a_call_places_gestures_instead_of_the_line(by_hand):
    own = by_hand({"gesture": "nod", "at": 1.0})
    placed = [{"gesture": "nod", "word": 3, "scale": 0.5}]
    called, stated = (
        one.perform(said(), line="hi", gestures="nod", **more)
        for one, more in ((own, {"placed": placed}), (by_hand(*placed), {}))
    )
    assert called.weights.tobytes() == stated.weights.tobytes()
    plain = own.perform(said(), line="hi", gestures="nod", placed=[])
    assert plain.weights.tobytes() == by_hand().perform(said(), gestures="nod").weights.tobytes()


@pytest.mark.parametrize(
    ("one", "why"),
    [
        ({"gesture": "nodd", "at": 1}, "unknown gesture 'nodd'; did you mean 'nod'?"),
        ({"gesture": "nod"}, "either `at` seconds, or at a `word`"),
        ({"gesture": "nod", "at": 1, "after": 1}, "`after` needs the `word`"),
        ({"gesture": "nod", "at": "now"}, "a gesture by hand: at: "),
        ({"gesture": "nod", "at": 1, "scale": 9}, "a gesture by hand: scale: "),
        ({"gesture": "nod", "word": 99}, "at word 99"),
    ],
)
def test_faulty_gestures_by_hand_are_refused(performer, one, why):
    with pytest.raises(LipsyncError, match=re.escape(why)):
        performer.perform(said(), gestures="all", placed=[one])


def test_a_named_line_has_the_gestures_of_one_without_a_name(performer, by_hand):
    named = by_hand().perform(said(), line="hi", gestures="all")
    assert named.weights.tobytes() == performer.perform(said(), gestures="all").weights.tobytes()


def test_a_line_rests_after_its_end_and_goes_on_breathing(performer):
    spoken, resting = (performer.perform(s) for s in (said(), said().resting(12)))
    count = len(spoken.times) - 30
    assert np.array_equal(spoken.weights[:count], resting.weights[:count])
    moving = performer.perform(said().resting(12), gestures="all")
    after = moving.times > said().end + 1
    assert moving["eyeBlinkLeft"][after].max() == 1
    assert moving["lift"][after].max() > 0.5
    assert not moving.weights[after, :17].any()
    limit = performer.gesture_set.speed / 60 + 1e-9
    assert (np.abs(np.diff(moving.weights[:, 17:], axis=0)) <= limit).all()
    with pytest.raises(LipsyncError, match="-1 s of rest"):
        said().resting(-1)


def test_breaths_are_more_regular_than_blinks():
    def irregular(**fields):
        shapes = gesture_set(stated("it", rates=[15, 15], **fields)).shapes
        facts = LineFacts(0.0, 600.0, [(0.0, 600.0)], {}, [], [7919])
        found = place(shapes, [1.0], facts)
        gaps = [b.begin - a.begin for a, b in pairwise(found)]
        return np.std(gaps) / np.mean(gaps)

    assert irregular(spread=0.15) < 0.25
    assert irregular() > 0.5


@pytest.mark.parametrize("name", ["facefx", "crab"])
def test_a_shipped_model_has_what_its_gestures_move(name):
    own = ll.resolve("english", name)
    content = own.model.read_bytes()
    size = int.from_bytes(content[12:16], "little")
    document = json.loads(content[20 : 20 + size])
    shapes = document["meshes"][0]["extras"]["targetNames"]
    nodes = [node["name"] for node in document["nodes"]]
    for channel in own.gesture_channels:
        assert channel.name in shapes if channel.node is None else channel.node in nodes
    assert len(content) < 2**20
