"""The sentence view's routes: boundaries, emphasis, parts of a long line, and timings."""

import json
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("starlette", reason="the studio needs Starlette")

from studio_calls import Caller, unpacked

import lipsync_lang as ll
from lipsync_lang.schedules.schedule import Audio, Schedule, Word
from lipsync_lang.schedules.timing_readers import read_schedule
from lipsync_lang.studio.spoken_line import MAX_PART_FRAMES, MIN_SPAN_SECONDS, SpokenLine
from lipsync_lang.studio.workshop import Workshop

TIMES = [0, 0.1, 0.3, 0.4, 0.6]
LINE = Schedule(
    ("M", "AA", "B", "IY"), np.array(TIMES), words=(Word("ma", 0, 2), Word("be", 2, 4)),
    notation="arpabet",
)  # fmt: skip
HOURS = 2
MANY_PARTS = 1200
"""Seconds of a line of ten parts."""
CLOSE = 1e-3
"""Weights may differ by this much, since a point is kept to 0.0001 of a word."""


@pytest.fixture(scope="module")
def workshop(tmp_path_factory):
    made = Workshop(tmp_path_factory.mktemp("project"), engine="none")
    made.open("english", "crab")
    return made


@pytest.fixture
def caller(workshop):
    while workshop.desk.undo_title:
        workshop.desk.undo()
    workshop.take_up(LINE, "ma be")
    return Caller(workshop)


def curves(found):
    """Return the takes of an answer, and the bytes of its arrays."""
    length = int.from_bytes(found.content[:4], "little")
    return unpacked(found)[0]["takes"], found.content[4 + length :]


def spoken(found):
    assert found.status == 200, found.json
    return unpacked(found)[0]["takes"][0]["spoken"]


def endless(seconds=HOURS * 3600):
    """Return a line of two hours, or of other seconds."""
    count = seconds * 10
    labels = ("M", "AA", "B", "IY", "_") * (count // 5)
    words = tuple(Word("w", at, at + 4) for at in range(0, count, 5))
    times = np.linspace(0, seconds, count + 1)
    return Schedule(labels, times, words=words, notation="arpabet")


@pytest.mark.parametrize(
    ("number", "asked", "found"),
    [(1, 0.15, 0.15), (1, -5, MIN_SPAN_SECONDS),
     (1, 9, 0.3 - MIN_SPAN_SECONDS), (2, 0.2, 0.2),
     (0, -5, 0), (0, 0.05, 0.05), (4, 0.2, 0.4 + MIN_SPAN_SECONDS), (4, 0.9, 0.9)],
)  # fmt: skip
def test_a_boundary_moves_and_stays_between_its_neighbours(caller, number, asked, found):
    times = spoken(caller.post(f"boundary/{number}", {"seconds": asked}))["times"]
    wanted = [*TIMES]
    wanted[number] = found
    assert times == pytest.approx(wanted)


def test_a_line_with_sound_ends_no_later_than_its_sound(caller, workshop):
    workshop.line.hear(Audio(np.zeros(14_000, np.int16), 20_000))
    assert spoken(caller.post("boundary/4", {"seconds": 3}))["times"][-1] == pytest.approx(0.7)


def test_a_recording_is_heard_without_a_text(caller, monkeypatch):
    from lipsync_lang.sound.speech.hearing import recognition

    monkeypatch.setattr(recognition, "recognised", lambda *_: LINE)
    assert spoken(caller.post("sound", b"", {"hear": "", "name": "a.wav"}))[
        "times"
    ] == pytest.approx(TIMES)


def test_moved_boundaries_are_heard_in_the_curves(caller):
    before = curves(caller.api("line"))
    caller.post("boundary/2", {"seconds": 0.2})
    assert curves(caller.api("line")) != before
    assert spoken(caller.post("original"))["times"] == pytest.approx(TIMES)
    assert curves(caller.api("line")) == before


def test_words_are_emphasised(caller, workshop):
    plain = curves(caller.api("line"))
    assert caller.post("emphasis/1", {"level": 2}).status == 200
    assert [word.emphasis for word in workshop.schedule.words] == [0, 2]
    assert curves(caller.api("line")) != plain
    caller.post("original")
    assert [word.emphasis for word in workshop.schedule.words] == [0, 2], "times alone come back"


@pytest.mark.parametrize(
    ("path", "body", "told"),
    [("boundary/5", {"seconds": 1}, "boundary 5"), ("boundary/x", {"seconds": 1}, "'x'"),
     ("boundary/²", {"seconds": 1}, "is not the number"), ("boundary/-1", {"seconds": 1}, "'-1'"),
     ("boundary/1", {"seconds": "1"}, "seconds"), ("boundary/1", {"seconds": 1e9}, "seconds"),
     ("emphasis/2", {"level": 1}, "word 2"), ("emphasis/0", {"level": 3}, "level"),
     ("emphasis/0", {}, "level"), ("part/1", {}, "1 parts"),
     ("boundary/99999999999", {"seconds": 1}, "is not the number")],
)  # fmt: skip
def test_a_change_that_cannot_be_is_told(caller, path, body, told):
    found = caller.post(path, body)
    assert found.status == 422
    assert told in found.json["error"]
    assert spoken(caller.api("line"))["times"] == pytest.approx(TIMES)


def test_nothing_of_a_line_is_asked_before_there_is_one(caller, workshop):
    workshop.line = None
    for path in ("boundary/1", "original", "emphasis/0", "part/0"):
        found = caller.post(path, {"seconds": 1, "level": 1})
        assert "there is no line" in found.json["error"]
    assert caller.api("timings/json").status == 422


def test_settings_that_cannot_be_performed_are_not_kept(caller, workshop):
    before = workshop.settings
    assert caller.post("take", {"settings": {"dials": {"nose": 1}}}).status == 422
    assert workshop.settings == before
    assert caller.post("boundary/1", {"seconds": 0.2}).status == 200


def test_another_line_has_nothing_of_the_line_before(caller, workshop):
    sound = Audio(np.zeros(20_000, np.int16), 20_000)
    workshop.line.hear(sound)
    levels = {"jaw": [[0, 1], [0.5, 2]], "lips": 0.5}
    asked = {"fps": 30, "dials": levels, "styles": {"happy": [[0, 0.5]]}, "intensity": 1.5}
    assert caller.post("take", {"settings": asked}).status == 200
    assert caller.post("boundary/1", {"seconds": 0.2}).status == 200
    assert caller.post("emphasis/1", {"level": 2}).status == 200
    line = json.dumps({"notation": "arpabet", "phonemes": [{"label": "M", "start": 0, "end": 1}]})
    found = caller.post("timings", line.encode(), {"name": "m.json"})
    told = unpacked(found)[0]["settings"]
    assert told == {
        "fps": 30,
        "line": None,
        "dials": {},
        "styles": {},
        "intensity": None,
        "bends": {},
        "placed": [],
    }
    workshop.take_up(replace(LINE, audio=sound), "ma be")
    jaw = workshop.settings.dials.pop("jaw")
    assert np.array(jaw) == pytest.approx(np.array(levels["jaw"]), abs=1e-4)
    assert workshop.settings.dials == {"lips": 0.5}
    assert (workshop.settings.styles, workshop.settings.intensity) == ({"happy": 0.5}, 1.5)
    assert workshop.schedule.times.tolist() == [0, 0.2, 0.3, 0.4, 0.6]
    assert [word.emphasis for word in workshop.schedule.words] == [0, 2]
    workshop.settings.fps = 60


def test_each_change_of_a_line_is_a_step_of_undo(caller, workshop):
    caller.post("boundary/1", {"seconds": 0.2, "title": "Move a boundary"})
    caller.post("emphasis/0", {"level": 1, "passing": True})
    assert workshop.desk.undo_title == "Move a boundary (ma-be)", (
        "a change that goes on is no step yet"
    )
    caller.post("emphasis/0", {"level": 2, "title": "Emphasis of ma"})
    found = unpacked(caller.post("take", {"settings": {"dials": {"jaw": 1.8}}, "title": "jaw"}))[0]
    assert found["state"]["undo"] == "jaw (ma-be)"
    assert {one["file"] for one in found["state"]["unsaved"]} == {"characters/crab.yaml"}
    titles = []
    while workshop.desk.undo_title:
        titles.append(workshop.desk.undo_title.removesuffix(" (ma-be)"))
        assert caller.post("undo").status == 200
    assert titles == ["jaw", "Emphasis of ma", "Move a boundary"]
    assert workshop.settings.dials == {}
    assert workshop.schedule.times.tolist() == TIMES
    assert [word.emphasis for word in workshop.schedule.words] == [0, 0]
    for _ in titles:
        caller.post("redo")
    assert workshop.settings.dials == {"jaw": 1.8}
    assert workshop.schedule.times[1] == 0.2
    assert workshop.schedule.words[0].emphasis == 2


def test_a_saved_line_is_opened_and_run_as_it_was_left(tmp_path):
    made = Workshop(tmp_path, engine="none")
    made.open("english", "crab")
    caller = Caller(made)
    caller.post("line", {"text": "Hello Bob"})
    caller.post("boundary/2", {"seconds": float(made.schedule.times[2]) + 0.01})
    points = [[0.1, 1], [0.4, 1.8]]
    caller.post("take", {"settings": {"dials": {"jaw": points}, "styles": {"happy": 0.9}}})
    shown = made.perform()
    caller.post("line", {"text": "Good night"})
    assert made.settings.dials == {}
    assert caller.post("save").json["saved"] == ["characters/crab.yaml"]
    fresh = Workshop(tmp_path, engine="none")
    fresh.open("english", "crab")
    assert fresh.state()["kept"] == ["Hello Bob"]
    fresh.speak("Hello Bob")
    assert fresh.name == "hello-bob"
    assert np.abs(fresh.perform().weights - shown.weights).max() < CLOSE
    performer = ll.resolve("english", "crab", paths=[tmp_path])
    said = performer.speaker.speak("Hello Bob", engine="none")
    ran = performer.perform(said, 60, line="hello-bob")
    assert ran.schedule.times == pytest.approx(shown.schedule.times, abs=1e-5)
    assert np.abs(ran.weights - shown.weights).max() < CLOSE
    slow = replace(said, times=said.times * 1.5)
    other = performer.perform(slow, 60, line="hello-bob")
    assert np.array_equal(other.schedule.times, slow.times)
    assert "moved in another recording" in other.schedule.remarks[0]


def test_another_character_starts_with_its_own_settings(tmp_path):
    made = Workshop(tmp_path, engine="none")
    made.open("english", "crab")
    made.settings = replace(made.settings, fps=30, dials={"jaw": 2})
    made.open("english", "crab")
    assert made.state()["settings"]["dials"] == {"jaw": 2}
    made.open("english", "facefx")
    assert (made.settings.fps, made.settings.dials) == (30, {})


@pytest.mark.parametrize("suffix", ["json", "TextGrid"])
def test_corrected_timings_are_written(caller, tmp_path, suffix):
    caller.post("boundary/2", {"seconds": 0.25})
    told = caller.api(f"timings/{suffix}").json
    path = tmp_path / told["name"]
    path.write_text(told["content"], "utf-8")
    found = read_schedule(path)
    assert (found.labels, [word.text for word in found.words]) == (LINE.labels, ["ma", "be"])
    assert found.times == pytest.approx([0, 0.1, 0.25, 0.4, 0.6])
    assert "timings 'exe'" in caller.api("timings/exe").json["error"]


def test_a_line_of_two_hours_is_shown_in_parts(workshop):
    workshop.line, caller = SpokenLine(endless()), Caller(workshop)
    document, size = unpacked(caller.api("line"))
    part, take = document["part"], document["takes"][0]
    assert part["count"] >= HOURS * 30
    assert (part["number"], part["seconds"]) == (0, HOURS * 3600)
    assert take["count"] <= MAX_PART_FRAMES * 1.02
    assert size < 10e6
    assert len(json.dumps(document)) < 2e6
    assert take["spoken"]["labels"][-1] == "_", "a part ends in a pause"


def test_the_parts_of_a_line_are_all_of_it(workshop):
    line = SpokenLine(endless(MANY_PARTS))
    workshop.line, caller = line, Caller(workshop)
    cuts = line.cuts(workshop.part_seconds)
    assert (cuts[0], cuts[-1]) == (0, len(line.whole))
    assert np.diff(line.whole.times[cuts]).max() <= workshop.part_seconds
    last = spoken(caller.post(f"part/{len(cuts) - 2}"))
    assert last["times"][-1] == MANY_PARTS
    assert last["times"][0] == pytest.approx(line.whole.times[cuts[-2]])


def test_a_later_part_is_corrected_in_its_place(workshop):
    line = SpokenLine(endless(MANY_PARTS))
    workshop.line, caller = line, Caller(workshop)
    shown = spoken(caller.post("part/7"))
    first = line.cuts(workshop.part_seconds)[7]
    for number in (0, 1):
        moved = shown["times"][number] + 0.02
        again = spoken(caller.post(f"boundary/{number}", {"seconds": moved}))
        assert again["times"][number] == pytest.approx(moved)
        assert line.whole.times[first + number] == pytest.approx(moved)
        assert again["labels"] == shown["labels"]
    caller.post("emphasis/0", {"level": 1})
    assert [n for n, one in enumerate(line.whole.words) if one.emphasis] == [first // 5]
    assert spoken(caller.post("original"))["times"] == pytest.approx(shown["times"])


def test_a_phoneme_longer_than_a_part_is_a_part():
    line = SpokenLine(Schedule(("M", "_", "M"), np.array([0, 1, 99, 100])))
    assert line.cuts(10) == [0, 1, 2, 3]


def test_the_sound_of_a_part_begins_with_it(workshop):
    line = SpokenLine(endless(MANY_PARTS))
    line.hear(Audio(np.arange(MANY_PARTS * 10).astype(np.int16), 10))
    workshop.line, caller = line, Caller(workshop)
    document, _ = unpacked(caller.post("part/3"))
    begins = document["takes"][0]["spoken"]["times"][0]
    assert document["sound"]["start"] == pytest.approx(begins - 1, abs=0.11)
    count = document["arrays"][document["sound"]["samples"]["$array"]][1]
    assert count < 10 * (workshop.part_seconds + 3)


def test_phonemes_are_relabelled_split_and_joined(caller, workshop):
    assert spoken(caller.post("phonemes/1", {"labels": ["AE"]}))["labels"] == ["M", "AE", "B", "IY"]
    split = spoken(caller.post("phonemes/1", {"labels": ["AE", "T"], "times": [0.25]}))
    assert (split["labels"], split["times"]) == (
        ["M", "AE", "T", "B", "IY"], [0, 0.1, 0.25, 0.3, 0.4, 0.6],
    )  # fmt: skip
    assert split["words"] == [["ma", 0, 3], ["be", 3, 5]]
    joined = spoken(caller.post("phonemes/2", {"count": 2, "labels": ["B"]}))
    assert (joined["labels"], joined["times"]) == (["M", "AE", "B", "IY"], [0, 0.1, 0.25, 0.4, 0.6])
    assert workshop.state()["undo"] == "Change phonemes (ma-be)"
    while workshop.desk.undo_title:
        caller.post("undo")
    assert spoken(caller.api("line"))["labels"] == list(LINE.labels)


def test_changed_phonemes_come_back_with_the_original_times(caller, workshop):
    caller.post("emphasis/1", {"level": 2})
    caller.post("phonemes/0", {"labels": ["B", "AH"]})
    found = spoken(caller.post("original"))
    assert (found["labels"], found["times"]) == (list(LINE.labels), TIMES)
    assert found["emphasis"] == [0, 2]
    assert workshop.line.changes == ()


@pytest.mark.parametrize(
    ("path", "body", "told"),
    [("phonemes/1", {"labels": ["IYY"]}, "phoneme 1 at 0.10 s: 'IYY' is no label of english"),
     ("phonemes/1", {"labels": ["IYY"]}, "did you mean 'IY'"),
     ("phonemes/9", {"labels": ["M"]}, "there are no phonemes 9 to 9"),
     ("phonemes/1", {"labels": []}, "labels"),
     ("phonemes/1", {"labels": ["M"], "count": "2"}, "count"),
     ("phonemes/1", {"labels": ["M"], "times": [0.2]}, "0 boundaries between"),
     ("phonemes/1", {"labels": ["M", "B"], "times": ["0.2"]}, "seconds"),
     ("phonemes/0", {"labels": ["B"], "count": 3}, "word 'ma'"),
     ("boundary/1", {"seconds": 0.1, "through": "2"}, "through"),
     ("boundary/1", {"seconds": 0.1, "through": 9}, "boundary 9")],
)  # fmt: skip
def test_phonemes_that_cannot_change_are_told(caller, path, body, told):
    if "word" in told:
        body = body | {"labels": ["B"], "count": 2}
        assert caller.post("phonemes/0", body).status == 200
        path, body = "phonemes/0", {"labels": ["B"], "count": 3}
    found = caller.post(path, body)
    assert found.status == 422
    assert told in found.json["error"]


def test_the_labels_of_the_line_are_listed(caller):
    rows = dict(caller.api("labels").json["labels"])
    assert (rows["M"], rows["_"]) == ("bmp", "")


def test_several_boundaries_move_together(caller):
    found = spoken(caller.post("boundary/1", {"seconds": 0.15, "through": 2}))
    assert found["times"] == pytest.approx([0, 0.15, 0.35, 0.4, 0.6])
    found = spoken(caller.post("boundary/1", {"seconds": 9, "through": 2}))
    assert found["times"] == pytest.approx([0, 0.195, 0.395, 0.4, 0.6])
    found = spoken(caller.post("boundary/2", {"seconds": 0.5, "through": 4}))
    assert found["times"] == pytest.approx([0, 0.195, 0.5, 0.505, 0.705])


def test_changed_phonemes_are_saved_and_run(tmp_path):
    made = Workshop(tmp_path, engine="none")
    made.open("english", "crab")
    caller = Caller(made)
    caller.post("line", {"text": "Hello Bob"})
    labels = made.schedule.labels
    at = float(made.schedule.times[2])
    caller.post("phonemes/1", {"labels": [labels[1], labels[1]], "times": [at - 0.02]})
    caller.post("boundary/4", {"seconds": float(made.schedule.times[4]) + 0.01})
    shown = made.perform()
    caller.post("save")
    fresh = Workshop(tmp_path, engine="none")
    fresh.open("english", "crab")
    fresh.speak("Hello Bob")
    assert fresh.schedule.labels == shown.schedule.labels
    performer = ll.resolve("english", "crab", paths=[tmp_path])
    said = performer.speaker.speak("Hello Bob", engine="none")
    ran = performer.perform(said, 60, line="hello-bob")
    assert ran.schedule.labels == shown.schedule.labels == (*labels[:2], *labels[1:])
    assert ran.schedule.times == pytest.approx(shown.schedule.times, abs=1e-5)
    assert np.abs(ran.weights - shown.weights).max() < CLOSE
    other = performer.speaker.speak("Good night", engine="none")
    ran = performer.perform(other, 60, line="hello-bob")
    assert ran.schedule.labels == other.labels
    assert "changed in another text" in ran.schedule.remarks[0]


def test_a_pose_of_the_line_is_bent_undone_and_kept(caller, workshop):
    bends = {"smile": [[0.2, 0.4], [0.25, 0]]}
    found = unpacked(caller.post("take", {"settings": {"bends": bends}, "title": "Bend smile"}))[0]
    assert found["state"]["undo"] == "Bend smile (ma-be)"
    making = found["takes"][0]["making"]
    assert "bend" in [stage["name"] for stage in making["stages"]]
    path = next(iter(workshop.desk.contents))
    assert "[[0.6667, 0.4], [0.8333, 0]]" in workshop.desk.contents[path].decode()
    workshop.take_up(LINE, "ma be")
    assert np.array(workshop.settings.bends["smile"]) == pytest.approx(
        np.array(bends["smile"]), abs=1e-4
    )
    steps = workshop.desk.revision
    caller.post("take", {"settings": {"bends": workshop.settings.bends}})
    assert workshop.desk.revision == steps, "the same keys are no step"
    caller.post("undo")
    assert workshop.settings.bends == {}
    assert caller.post("take", {"settings": {"bends": {"smile": [[0, 3]]}}}).status == 422


def test_doubtful_words_are_marked_where_they_are(caller, workshop):
    sure, doubtful = LINE.words
    words = (replace(sure, confidence=0.9), replace(doubtful, confidence=0.312))
    workshop.take_up(replace(LINE, words=words), "ma be")
    assert spoken(caller.api("line"))["doubts"] == {"1": 0.31}


def test_a_range_is_aligned_again_in_its_part_of_the_sound(tmp_path):
    made = Workshop(tmp_path)
    made.open("english", "crab")
    caller = Caller(made)
    caller.post("line", {"text": "Please buy five maps and go home"})
    if made.schedule.audio is None:
        pytest.skip("needs eSpeak NG, whose voice is aligned again")
    before, words = made.schedule.times.copy(), made.schedule.words
    first, stop = words[1].first, words[3].stop
    for number in range(first + 1, stop):
        caller.post(
            f"boundary/{number}", {"seconds": float(before[first]) + 0.01 * (number - first)}
        )
    spoilt = made.schedule.times.copy()
    assert np.abs(spoilt - before).max() > 0.3
    found = caller.post(f"align/{first}", {"count": stop - first, "title": "Align again"})
    assert found.status == 200, found.json
    now = made.schedule
    assert now.labels == tuple(spoken(found)["labels"])
    assert (np.diff(now.times) > 0).all()
    assert (now.times[: first + 1] == before[: first + 1]).all()
    after = words[4].first  # a pause is before it
    assert (now.times[after:] == before[after:]).all(), "the words outside stay"
    starts = [word.first for word in words[2:4]]
    assert np.abs(now.times[starts] - before[starts]).max() < 0.08
    assert made.desk.undo_title.startswith("Align again")
    caller.post("undo")
    made.state()
    assert made.schedule.times == pytest.approx(spoilt, abs=1e-4)


def test_a_range_that_cannot_be_aligned_is_told(caller, workshop):
    assert "no recording" in caller.post("align/0", {"count": 1}).json["error"]
    workshop.line.hear(Audio(np.zeros(20_000, np.int16), 20_000))
    assert "no word" in caller.post("align/90", {"count": 1}).json["error"]
    assert "`count`" in caller.post("align/0", {"count": 0}).json["error"]


BIG = replace(
    LINE, labels=("M", "AA", "D", "B", "IY"), times=np.array([0, 0.1, 0.25, 0.3, 0.4, 0.6]),
    words=(Word("ma", 0, 2), Word("d", 2, 3), Word("be", 3, 5)), confidence=0.9,
    audio=Audio(np.zeros(12_000, np.int16), 20_000),
)  # fmt: skip


@pytest.fixture
def aligner(monkeypatch):
    """Replace the aligner by one that leaves out a word unless it is emphasised."""
    from lipsync_lang.sound.speech.hearing import alignment

    lacking = replace(LINE, left_out=("d",), confidence=0.9, audio=BIG.audio)
    texts = []

    def aligned(_, __, text):
        texts.append(text)
        return BIG if "*d*" in text else lacking

    monkeypatch.setattr(alignment, "aligned", aligned)
    return texts


def test_a_word_that_is_left_out_is_shown_and_said(caller, workshop, aligner):
    before = spoken(caller.post("sound", b"", {"text": "ma d be", "name": "a.wav"}))
    assert before["left_out"] == ["d"]
    caller.post("emphasis/1", {"level": 2})
    found = caller.post("say/0", {"title": "Say 'd'"})
    assert (spoken(found)["left_out"], spoken(found)["words"]) == ([], [[*one] for one in (
        ("ma", 0, 2), ("d", 2, 3), ("be", 3, 5))])  # fmt: skip
    assert spoken(found)["emphasis"] == [0, 0, 2], "the emphasis stays with its word"
    state = unpacked(found)[0]["state"]
    assert state["text"] == workshop.text == "ma *d* be"
    assert state["undo"].startswith("Say 'd'")
    caller.post("undo")
    assert caller.api("state").json["text"] == "ma d be"
    assert spoken(caller.api("line")) == before | {"emphasis": [0, 2]}
    caller.post("redo")
    caller.api("state")
    assert spoken(caller.api("line"))["emphasis"] == [0, 0, 2]
    assert aligner == ["ma d be", "ma *d* be"], "each text is aligned once"


def test_a_word_that_cannot_be_said_is_told(caller, workshop, aligner):
    caller.post("sound", b"", {"text": "ma d be", "name": "a.wav"})
    assert "no word 1" in caller.post("say/1").json["error"]
    workshop.text = "ma be"
    assert "asterisks" in caller.post("say/0").json["error"]
    assert aligner == ["ma d be"]
