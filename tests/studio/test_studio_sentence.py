"""The sentence view's routes: boundaries, emphasis, parts of a long line, and timings."""

import json
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("starlette", reason="the studio needs Starlette")

from studio_calls import Caller, unpacked

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


@pytest.fixture(scope="module")
def workshop(tmp_path_factory):
    made = Workshop(tmp_path_factory.mktemp("project"), engine="none")
    made.open("english", "crab")
    return made


@pytest.fixture
def caller(workshop):
    workshop.line = SpokenLine(LINE)
    return Caller(workshop)


def spoken(found):
    assert found.status == 200, found.json
    return unpacked(found)[0]["takes"][0]["spoken"]


def endless():
    """Return a line of two hours."""
    count = HOURS * 3600 * 10
    labels = ("M", "AA", "B", "IY", "_") * (count // 5)
    words = tuple(Word("w", at, at + 4) for at in range(0, count, 5))
    times = np.linspace(0, HOURS * 3600, count + 1)
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
    from lipsync_lang.speech.hearing import recognition

    monkeypatch.setattr(recognition, "recognised", lambda *_: LINE)
    assert spoken(caller.post("sound", b"", {"hear": "", "name": "a.wav"}))[
        "times"
    ] == pytest.approx(TIMES)


def test_moved_boundaries_are_heard_in_the_curves(caller):
    before = caller.api("line").content
    caller.post("boundary/2", {"seconds": 0.2})
    assert caller.api("line").content != before
    assert spoken(caller.post("original"))["times"] == pytest.approx(TIMES)
    assert caller.api("line").content == before


def test_words_are_emphasised(caller, workshop):
    plain = caller.api("line").content
    assert caller.post("emphasis/1", {"level": 2}).status == 200
    assert [word.emphasis for word in workshop.schedule.words] == [0, 2]
    assert caller.api("line").content != plain
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


def test_another_line_has_no_levels_of_the_seconds_before(caller, workshop):
    workshop.line.hear(Audio(np.zeros(20_000, np.int16), 20_000))
    levels = {"jaw": [[0, 1], [0.5, 2]], "lips": 0.5}
    asked = {"fps": 30, "dials": levels, "styles": {"happy": [[0, 0.5]]}, "intensity": 1.5}
    assert caller.post("take", {"settings": asked}).status == 200
    line = json.dumps({"notation": "arpabet", "phonemes": [{"label": "M", "start": 0, "end": 1}]})
    found = caller.post("timings", line.encode(), {"name": "m.json"})
    assert found.status == 200, "loudness waits for a line with sound"
    told = unpacked(found)[0]["settings"]
    assert told == {"fps": 30, "line": None, "dials": {"lips": 0.5}, "styles": {}, "intensity": 1.5}
    workshop.settings = replace(workshop.settings, fps=60, dials={}, intensity=None)


def test_times_are_put_back_together_or_refused(caller):
    wanted = [0, 0.2, 0.25, 0.5, 0.7]
    assert spoken(caller.post("times", {"times": wanted}))["times"] == wanted
    for times in ([0, 0.3, 0.2, 0.5, 0.7], wanted[:-1], [*wanted[:-1], "1"], "all", None):
        assert caller.post("times", {"times": times}).status == 422
    assert spoken(caller.api("line"))["times"] == wanted


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
    line = SpokenLine(endless())
    workshop.line, caller = line, Caller(workshop)
    cuts = line.cuts(workshop.part_seconds)
    assert (cuts[0], cuts[-1]) == (0, len(line.whole))
    assert np.diff(line.whole.times[cuts]).max() <= workshop.part_seconds
    last = spoken(caller.post(f"part/{len(cuts) - 2}"))
    assert last["times"][-1] == HOURS * 3600
    assert last["times"][0] == pytest.approx(line.whole.times[cuts[-2]])


def test_a_later_part_is_corrected_in_its_place(workshop):
    line = SpokenLine(endless())
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
    line = SpokenLine(endless())
    line.hear(Audio(np.arange(HOURS * 3600 * 10).astype(np.int16), 10))
    workshop.line, caller = line, Caller(workshop)
    document, _ = unpacked(caller.post("part/3"))
    begins = document["takes"][0]["spoken"]["times"][0]
    assert document["sound"]["start"] == pytest.approx(begins - 1, abs=0.11)
    count = document["arrays"][document["sound"]["samples"]["$array"]][1]
    assert count < 10 * (workshop.part_seconds + 3)
