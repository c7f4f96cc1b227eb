"""Emphasis: marked words open the mouth wider, and marks are not spoken."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full
from strategies import assert_promises

import lipsync_lang as ll
from lipsync_lang import Schedule, Word
from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.sound.speech.hearing.alignment import aligned
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.emphasis import as_marked, emphasised, touched, with_mark

LABELS = ("D", "AA", "B", "AA", "D", "AA", "P", "AA")
TIMES = np.arange(9) * 0.15


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "facefx")


def said(emphasis):
    words = (Word("dab", 0, 3), Word("add", 3, 5, emphasis), Word("app", 5, 8))
    return Schedule(LABELS, TIMES, words, "arpabet")


# In a text


@pytest.mark.parametrize(
    ("text", "plain", "marked"),
    [
        ("I *never* said so", "I never said so", ["never"]),
        ("I **never** said *this one*.", "I never said this one.", ["never", "this one"]),
        ("*One* and ***two***", "One and two", ["One", "two"]),
        ('say (*now*), "*here*!"', 'say (now), "here!"', ["now", "here"]),
        ("it is *un*believable", "it is unbelievable", ["un"]),
        ("私は*本当に*好き", "私は本当に好き", ["本当に"]),
        ("so *not\nyet* then", "so not\nyet then", ["not\nyet"]),
        ("*fire*", "fire", ["fire"]),
        ("**Run, Bob!**", "Run, Bob!", ["Run, Bob!"]),
        ("Now *get down* all", "Now get down all", ["get down"]),
        (r"\*not\* this", "not this", []),
        (r"my *a\* b* c", "my a b c", ["a b"]),
        (r"5\*\*6", "5 6", []),
        ("*open only", "open only", []),
        ("close only*", "close only", []),
        ("a * b * c", "a  b  c", []),
        ("2*3*4 is 24", "2 3 4 is 24", []),
        ("sh*t f**k", "sh t f k", []),
        ("wait *...* what", "wait ... what", []),
        ("no *one** here", "no one here", []),
        ("****four****", "four", []),
        ("* one\n* two", " one\n two", []),
        ("***", "", []),
        ("", "", []),
    ],
)
def test_pairs_of_asterisks_emphasise_what_they_enclose(text, plain, marked):
    found = emphasised(text)
    assert found.text == plain
    assert [found.text[slice(*span)] for span in found.spans] == marked


@given(st.text(st.sampled_from("ab1 *\\.本\n"), max_size=40))
def test_spans_lie_in_the_text_and_a_text_keeps_its_letters(text):
    found = emphasised(text)
    assert [c for c in found.text if c.isalnum()] == [c for c in text if c.isalnum()]
    assert all(0 <= low < high <= len(found.text) for low, high in found.spans)
    assert sorted(found.spans) == list(found.spans)
    assert "*" not in found.text


@full
def test_many_asterisks_are_read_in_linear_time():
    for text in ("*" * 100_000, "*a " * 30_000, "a *b* " * 20_000, "\\*" * 50_000):
        found = emphasised(text)
        assert len(found.text) <= len(text)


def test_words_are_found_in_order():
    text = emphasised("no, *no* no")
    assert touched(["no", "no", "no"], *text) == [False, True, False]
    assert touched(["other", "no", "no"], *text) == [False, False, True]


@given(
    st.lists(st.sampled_from(["a", "an", "cat", "il", "dog"]), min_size=1, unique=True), st.data()
)
def test_the_marked_word_is_one_that_is_left_out(words, data):
    lacking = data.draw(st.sets(st.sampled_from(range(len(words))), min_size=1))
    left_out = [words[at] for at in sorted(lacking)]
    others = [word for at, word in enumerate(words) if at not in lacking]
    number = data.draw(st.sampled_from(range(len(left_out))))
    text = " ".join(words)
    marked = with_mark(text, others, left_out, number)
    assert as_marked(text, marked) == marked
    assert marked.split() == [f"*{one}*" if one == left_out[number] else one for one in words]


def test_a_word_is_marked_in_a_text_without_spaces_and_beside_other_marks():
    assert with_mark("私は*本当に*好き", ["私", "は", "好き"], ["本当に", "好き"], 1) is None
    assert with_mark("私は本当に好き", ["私", "は", "好き"], ["本当に"], 0) == "私は*本当に*好き"
    assert (
        with_mark("the *big* dog ran", ["the", "big", "ran"], ["dog"], 0) == "the *big* *dog* ran"
    )
    assert with_mark("12 dogs", ["dogs"], ["twelve"], 0) is None
    assert as_marked("the dog", "the *cat*") == as_marked("the dog", None) == "the dog"


# In a schedule


def test_a_voice_speaks_no_asterisk_and_marks_the_word():
    speaker = Speaker.of("tagalog")
    schedule = speaker.speak("Hindi *ko* *alam kung* bakit", engine="none")
    assert [(w.text, w.emphasis) for w in schedule.words] == [
        ("Hindi", 0), ("ko", 1), ("alam", 1), ("kung", 1), ("bakit", 0),
    ]  # fmt: skip
    plain = speaker.speak("Hindi ko alam kung bakit", engine="none")
    assert schedule.labels == plain.labels
    assert not schedule.unread


def test_a_transcript_has_no_asterisk():
    (transcript,) = Speaker.of("tagalog").transcribe([r"alam *ko* \*"])
    assert transcript.text == "alam ko "
    assert [word.text for word in transcript.words if word.labels] == ["alam", "ko"]


def test_an_aligned_recording_has_it(monkeypatch):
    texts = []
    aligner = SimpleNamespace(align=lambda _, text, *__: texts.append(text) or said(0.0))
    monkeypatch.setattr(
        "lipsync_lang.sound.speech.hearing.align.aligners.ALIGNERS.find", lambda *_: aligner
    )
    sound = ll.Audio(np.zeros(100, np.int16), 100)
    schedule = aligned(Speaker.of("tagalog"), sound, "dab *add* app")
    assert [word.emphasis for word in schedule.words] == [0, 1, 0]
    assert texts == ["dab add app"]


@pytest.mark.parametrize(("stated", "read"), [(True, 1), (False, 0), (0.5, 0.5), (2, 2)])
def test_json_reads_and_writes_it(performer, tmp_path, stated, read):
    file, written = tmp_path / "line.json", tmp_path / "out.json"
    rows = [{"label": "B", "start": 0, "end": 0.1}, {"label": "AA", "start": 0.1, "end": 0.3}]
    words = [{"text": "ba", "start": 0, "end": 0.3, "emphasis": stated}]
    file.write_text(json.dumps({"phonemes": rows, "words": words}), "utf-8")
    schedule = ll.read_schedule(file)
    assert schedule.words[0].emphasis == read
    performer.perform(schedule).save(written)
    assert ll.read_schedule(written).words == schedule.words


@pytest.mark.parametrize("wrong", [-0.1, 2.1, "loud", None, float("nan"), [1]])
def test_an_emphasis_that_is_none_is_told_with_its_place(tmp_path, wrong):
    file = tmp_path / "line.json"
    rows = [{"label": "B", "start": 0, "end": 1}]
    words = [{"text": "ba", "start": 0, "end": 1, "emphasis": wrong}]
    file.write_text(json.dumps({"phonemes": rows, "words": words}), "utf-8")
    with pytest.raises(ScheduleError, match=r"line.json: word 'ba': emphasis is .*from 0 to 2"):
        ll.read_schedule(file)


# What it does


def test_a_word_opens_wider_by_what_the_pose_set_says_and_its_neighbours_do_not(performer):
    jaw = performer.poses.index("open")
    raised, plain = (performer.perform(said(e), 100) for e in (1.0, 0.0))
    times, change = raised.times, raised.weights[:, jaw] - plain.weights[:, jaw]
    inside = (times > TIMES[3]) & (times < TIMES[5])
    ratio = raised.weights[inside, jaw].max() / plain.weights[inside, jaw].max()
    assert ratio == pytest.approx(1.25, abs=0.05)
    assert np.abs(change[(times < TIMES[2]) | (times > TIMES[6])]).max() < 0.01


def test_a_line_that_is_emphasised_throughout_opens_wider_everywhere(performer):
    plain = said(0.0)
    whole = replace(plain, words=tuple(replace(word, emphasis=1.0) for word in plain.words))
    jaws = [performer.perform(one, 60).weights[:, performer.poses.index("open")].max()
            for one in (whole, plain)]  # fmt: skip
    assert jaws[0] > 1.15 * jaws[1]


def test_more_emphasis_opens_wider_and_a_frame_names_it(performer):
    jaw = performer.poses.index("open")
    peaks = [performer.perform(said(e)).weights[:, jaw].max() for e in (0.0, 0.5, 1.0, 2.0)]
    assert sorted(peaks) == peaks
    assert len(set(peaks)) == len(peaks)
    assert "scaled by emphasis x 1.25" in str(performer.perform(said(1.0)).explain(0.52))


def test_a_pose_set_without_amounts_shows_none():
    mouths = ll.resolve("english", "three-mouths")
    assert np.array_equal(mouths.perform(said(2.0)).weights, mouths.perform(said(0.0)).weights)


@given(
    st.lists(st.floats(0, 2), min_size=3, max_size=3),
    st.floats(0.02, 0.3),
    st.sampled_from([24, 60, 120]),
)
def test_no_emphasis_opens_a_contact(emphasis, seconds, fps):
    performer = ll.resolve("english", "facefx")
    words = tuple(
        Word("word", *span, one)
        for span, one in zip(((0, 3), (3, 5), (5, 8)), emphasis, strict=True)
    )
    performance = performer.performance(Schedule(LABELS, TIMES * seconds / 0.15, words), fps)
    assert_promises(performance)
