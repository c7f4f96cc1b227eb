"""Stress reaches the schedule, and opens vowels a little more or less; every promise is kept."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shipped import LIBRARY
from strategies import assert_promises

import lipsync_lang as ll
from lipsync_lang import Schedule
from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.schedules.schedule import SILENCE
from lipsync_lang.sound.speech.speaking.espeak import intervals, read_events
from lipsync_lang.sound.speech.speaking.joining import estimate, join, stress_read
from lipsync_lang.sound.speech.speaking.transcripts import Transcript
from lipsync_lang.text.phonology.espeak.process import EspeakProcess, words_of
from lipsync_lang.text.phonology.g2p import SpokenWord, engine
from lipsync_lang.text.phonology.g2p.g2p_engines import Settings
from lipsync_lang.text.phonology.labels import Notation

TIMES = [0, 0.1, 0.3, 0.4, 0.6, 0.7, 0.9]


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "facefx")


def stresses(performer, schedule):
    found = performer.labels.stresses(*performer.labels.read([schedule]))
    return [None if stress < 0 else stress for stress in found.tolist()]


def jaw(performer, schedule, **motion):
    weights = performer.with_motion(motion).perform(schedule, 100).weights
    return weights[:, performer.poses.index("open")]


# Where it comes from


@pytest.mark.parametrize(
    ("notation", "labels"),
    [
        ("arpabet", ("B", "AA0", "B", "AA1", "B", "AA2")),
        ("arpabet", ("b", "aa", "b", "aa1", "b", "aa2")),
        ("ipa", ("b", "ɑː", "b", "ˈɑː", "b", "ˌɑː")),
        ("ipa", ("b", "ɑː", "ˈb", "ɑː", "ˌb", "ɑː")),
        ("sampa", ("b", "A:", '"b', "A:", "%b", "A:")),
        ("x-sampa", ("b", "A:", '"b', "A:", "%b", "A:")),
    ],
)
def test_marks_of_every_notation_reach_the_vowels(performer, notation, labels):
    schedule = Schedule(labels, TIMES, notation=notation)
    assert stresses(performer, schedule) == [None, 0, None, 1, None, 2]


def test_nothing_is_known_where_nothing_is_marked(performer):
    schedule = Schedule(("B", "AA", "B", "AA", "B", "AA"), TIMES, notation="arpabet")
    assert stresses(performer, schedule) == []
    assert not performer.performance(schedule, 60).dials


def test_a_mark_does_not_cross_a_pause(performer):
    schedule = Schedule(("ˈb", SILENCE, "ɑː"), TIMES[:4], notation="ipa")
    assert stresses(performer, schedule) == [None, None, 0]


def test_digits_are_stress_only_where_the_pack_says_so():
    tones = Notation({"ma": (("aa", 1.0),)})
    assert tones.stress("ma1") is None
    assert Notation(tones.table, digits=True).stress("ma1") == 1
    assert Notation({"ma1": (("aa", 1.0),)}, digits=True).stress("ma1") is None


def test_a_sign_of_the_table_is_no_mark():
    assert Notation({"'a": (("aa", 1.0),)}).stress("'a") is None


def test_the_notations_with_digits_are_notations_of_their_packs():
    packs = [LIBRARY.language(one.name).model for one in LIBRARY.names("language")]
    stated = [(pack.name, name) for pack in packs for name in pack.stress_digits]
    assert ("english", "arpabet") in stated
    assert all(name in LIBRARY.language(pack).model.notations for pack, name in stated)


def test_events_of_a_voice_carry_their_marks():
    names = ["b", "ˈɑː", "b", "ˌiː", "ʲ"]
    events = [["phoneme", 10 * n, name.encode().decode("latin-1")] for n, name in enumerate(names)]
    labels, _, _, stress = intervals(read_events(events, (), 60)[0], 5)
    assert labels == ["b", "ɑː", "b", "iːʲ"]
    assert stress == [None, 1, None, 2]


def test_reading_text_carries_the_marks_of_the_voice(monkeypatch, performer):
    """A voice's reading without sound has stress too, with estimated times."""
    monkeypatch.setattr(
        EspeakProcess,
        "transcribe",
        lambda _self, texts, _voice: [[words_of("h_ə_l_ˈoʊ b_ʌ_n_ˌæ_n_ə")] for _ in texts],
    )
    (said,) = engine("espeak", Settings("x"))(["hello banana"])
    assert [one.labels for one in said] == [("h", "ə", "l", "oʊ"), ("b", "ʌ", "n", "æ", "n", "ə")]
    transcript = Transcript(
        "hello banana", "english", "ipa", (*said[:1], SpokenWord(",", ()), *said[1:])
    )
    made = estimate(transcript, performer.speaker.manner, performer.speaker.notations["ipa"])
    vowels = [one for one in stresses(performer, made) if one is not None]
    assert vowels == [0, 1, 0, 2, 0]


def test_a_mark_goes_to_one_label_of_several(performer):
    words = SpokenWord("card", ("k", "ɑːɹ", "d"), stress=(None, 1, None))
    transcript, speaker = Transcript("card", "english", "ipa", (words,)), performer.speaker
    labels = ("K", "AA", "R", "D")
    found = stress_read(transcript, labels, "arpabet", speaker.manner, speaker.notations)
    assert found == (None, 1, None, None)


@pytest.mark.parametrize(
    ("labels", "notation", "stress"),
    [
        ("B AH _ N AE N AH", "arpabet", (None, None, None, None, 1, None, None)),
        ("B N AE N", "arpabet", (None, None, 1, None)),
        ("B AH0 N AE1 N AH0", "arpabet", ()),
        ("b ʌ ˈn æ n ə", "ipa", ()),
    ],
)
def test_labels_of_a_dictionary_take_the_marks_of_the_text(performer, labels, notation, stress):
    words = SpokenWord("banana", tuple("bʌnænə"), stress=(None, None, None, 1, None, None))
    speaker = performer.speaker
    found = stress_read(
        Transcript("banana", "english", "ipa", (words,)), labels.split(), notation,
        speaker.manner, speaker.notations,
    )  # fmt: skip
    assert found == stress


def test_joined_times_take_the_marks_of_the_voice_or_else_of_the_text(performer):
    speaker = performer.speaker
    words = (
        SpokenWord("b", ("b", "ʌ")),
        SpokenWord(",", ()),
        SpokenWord("n", ("n", "æ"), stress=(None, 1)),
    )
    text = Transcript("b, n", "english", "ipa", words)
    heard = Schedule(("b", "ʌ", SILENCE, "n", "æ"), TIMES[:6], notation="ipa")
    joined = join(text, heard, speaker.manner, speaker.notations)
    assert joined.stress == (None, None, None, None, 1)
    heard = replace(heard, stress=(None, 2, None, None, None))
    joined = join(text, heard, speaker.manner, speaker.notations)
    assert joined.stress == (None, 2, None, None, None)


def test_a_transcript_tells_them_in_its_data(performer):
    words = (SpokenWord("b", ("b", "ʌ")), SpokenWord("n", ("n", "æ"), stress=(None, 1)))
    told = performer.speaker.to_json(Transcript("b n", "english", "ipa", words))
    assert [one.get("stress") for word in told["words"] for one in word["labels"]] == [
        None, None, None, 1,
    ]  # fmt: skip


def test_json_reads_and_writes_it(performer, tmp_path):
    rows = [
        {"label": "B", "start": 0.0, "end": 0.1},
        {"label": "AA", "start": 0.1, "end": 0.3, "stress": 1},
        {"label": "B", "start": 0.3, "end": 0.4, "stress": None},
        {"label": "AA", "start": 0.4, "end": 0.6, "stress": 0},
    ]
    file, written = tmp_path / "line.json", tmp_path / "out.json"
    file.write_text(json.dumps({"notation": "arpabet", "phonemes": rows}), "utf-8")
    schedule = ll.read_schedule(file)
    assert schedule.stress == (None, 1, None, 0)
    performer.perform(schedule).save(written)
    assert ll.read_schedule(written).stress == schedule.stress


@pytest.mark.parametrize("wrong", [3, -1, True, "1", 0.5, [1]])
def test_a_stress_that_is_none_is_told_with_its_place(tmp_path, wrong):
    file = tmp_path / "line.json"
    file.write_text(json.dumps([{"label": "B", "start": 0, "end": 1, "stress": wrong}]), "utf-8")
    with pytest.raises(ScheduleError, match=r"line.json: phoneme 0: stress is .*; it is 0"):
        ll.read_schedule(file)


def test_one_stress_is_given_for_each_phoneme():
    with pytest.raises(ScheduleError, match="1 stresses for 2 phonemes"):
        Schedule(("B", "AA"), [0, 0.1, 0.3], stress=(1,))


def test_it_survives_moving_and_stretching():
    schedule = Schedule(("B", "AA"), [0, 0.1, 0.3], stress=(None, 1))
    assert schedule.moved(1).stress == schedule.stretched(2).stress == (None, 1)


# What it does

WEAK_STRONG = Schedule(("D", "AA0", "D", "AA1", "D", "AA2"), TIMES, notation="arpabet")
PLAIN = Schedule(("D", "AA", "D", "AA", "D", "AA"), TIMES, notation="arpabet")


def test_a_stressed_vowel_opens_a_little_more_and_an_unstressed_one_less(performer):
    shaped, plain = jaw(performer, WEAK_STRONG), jaw(performer, PLAIN)
    start = performer.performance(PLAIN, 100).frames.times()[0]
    weak, strong = (slice(*np.rint((np.array(s) - start) * 100).astype(int)) for s in
                    ((0.1, 0.3), (0.4, 0.6)))  # fmt: skip
    assert shaped[weak].max() / plain[weak].max() == pytest.approx(0.94, abs=0.03)
    assert shaped[strong].max() / plain[strong].max() == pytest.approx(1.08, abs=0.03)


def test_a_setting_turns_it_off_and_the_paper_has_none(performer):
    assert np.array_equal(jaw(performer, WEAK_STRONG, stress=0), jaw(performer, PLAIN))
    paper = {"preset": "paper"}
    assert np.array_equal(jaw(performer, WEAK_STRONG, **paper), jaw(performer, PLAIN, **paper))


def test_a_frame_is_explained_by_it(performer):
    told = performer.perform(WEAK_STRONG).explain(0.5)
    (step,) = [s for pose in told.poses for s in pose.stages if s.stage == "dial" and s.why]
    assert step.why == "scaled by stress x 1.08"


@given(
    st.lists(st.sampled_from([0, 1, 2, None]), min_size=8, max_size=8),
    st.floats(0, 4),
    st.floats(0.03, 0.3),
    st.sampled_from([24, 60, 120]),
)
def test_no_stress_opens_a_contact(marks, factor, seconds, fps):
    performer = ll.resolve("english", "facefx", motion={"stress": factor})
    labels = ("P", "AA", "B", "AA", "F", "AA", "M", "AA")
    times = np.arange(9) * seconds
    performance = performer.performance(Schedule(labels, times, stress=tuple(marks)), fps)
    assert_promises(performance)
