"""Words that a dictionary lacks: found by an aligner, and read by the language."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lipsync_lang as ll
from lipsync_lang.schedules.timed_words import words_without_phonemes

TEXTGRID = """File type = "ooTextFile"
Object class = "TextGrid"

xmin = 0
xmax = 1.5
tiers? <exists>
size = 2
item []:
    item [1]:
        class = "IntervalTier"
        name = "words"
        xmin = 0
        xmax = 1.5
        intervals: size = 3
        intervals [1]:
            xmin = 0
            xmax = 0.3
            text = "hi"
        intervals [2]:
            xmin = 0.3
            xmax = 1.2
            text = "babapomo"
        intervals [3]:
            xmin = 1.2
            xmax = 1.5
            text = ""
    item [2]:
        class = "IntervalTier"
        name = "phones"
        xmin = 0
        xmax = 1.5
        intervals: size = 4
        intervals [1]:
            xmin = 0
            xmax = 0.1
            text = "HH"
        intervals [2]:
            xmin = 0.1
            xmax = 0.3
            text = "AY1"
        intervals [3]:
            xmin = 0.3
            xmax = 1.2
            text = "spn"
        intervals [4]:
            xmin = 1.2
            xmax = 1.5
            text = ""
"""


def gentle(*words):
    return {"words": [*words]}


def found(word, start, *phones):
    given = [{"phone": phone, "duration": seconds} for phone, seconds in phones]
    return {"word": word, "case": "success", "start": start, "end": 9, "phones": given}


HI = found("hi", 0.0, ("hh_B", 0.1), ("ay_E", 0.2))
LOST = {"word": "mama", "case": "not-found-in-audio"}
FILES = {
    "line.TextGrid": TEXTGRID,
    "line.json": json.dumps(gentle(HI, found("babapomo", 0.3, ("oov_S", 0.9)))),
    "line.ctm.csv": "label,start,end,word\nHH,0,.1,hi\nAY1,.1,.3,hi\n<unk>,.3,1.2,babapomo\n",
}


@pytest.mark.parametrize("name", FILES)
def test_the_lips_move_in_a_word_that_the_dictionary_lacks(name, tmp_path):
    path = tmp_path / name
    path.write_text(FILES[name])
    read = ll.read_timings(path)
    (number,) = words_without_phonemes(read)
    assert read.words[number].text == "babapomo"
    schedule = ll.fill_words(read, "english")
    word = schedule.words[number]
    assert schedule.times[[word.first, word.stop]] == pytest.approx([0.3, 1.2])
    assert len(schedule.labels[word.first : word.stop]) == 8
    (remark,) = [told for told in schedule.remarks if "lacks" in told]
    assert "lacks babapomo: the language reads them instead" in remark
    performer = ll.resolve("english", "facefx")
    animation = performer.perform(schedule)
    inside = (animation.times > 0.3) & (animation.times < 1.2)
    lips = animation["PBM"][inside] > 0.5
    assert np.count_nonzero(np.diff(lips.astype(int)) > 0) >= 3, "b, b, p and m"
    assert animation["open"][inside].max() > 0.2


def test_the_rest_of_a_schedule_stays_as_it_is(tmp_path):
    path = tmp_path / "line.TextGrid"
    path.write_text(TEXTGRID)
    read = ll.read_schedule(path)
    stressed = replace(read, stress=(None, 1, *(None,) * (len(read) - 2)))
    schedule = ll.fill_words(stressed, "english")
    assert schedule.labels[:2] == ("HH", "AY1")
    assert schedule.labels[-1] == ll.read_schedule(path).labels[-1]
    assert schedule.times[:3].tolist() == read.times[:3].tolist()
    assert schedule.stress[:2] == (None, 1)
    assert len(schedule.stress) == len(schedule)
    none = replace(read, labels=("HH", "AY1", "AA1", read.labels[-1]))
    assert ll.fill_words(none, "english") is none


def test_noise_beside_words_stays_noise(tmp_path):
    path = tmp_path / "line.json"
    path.write_text(json.dumps(gentle(HI, found("<unk>", 0.3, ("oov_S", 0.9)))))
    assert words_without_phonemes(ll.read_schedule(path)) == []


def test_words_that_gentle_lost_between_two_others_are_said_there(tmp_path):
    path = tmp_path / "line.json"
    late = found("hi", 0.9, ("hh_B", 0.1), ("ay_E", 0.2))
    path.write_text(json.dumps(gentle(LOST, HI, LOST, LOST, late, LOST)))
    read = ll.read_schedule(path)
    assert [word.text for word in read.words] == ["hi", "mama mama", "hi"]
    rests, doubtful = read.remarks
    assert rests.endswith("not found in the recording, so the mouth rests: mama, mama")
    assert doubtful.endswith("they are doubtful where they fill a gap: mama, mama")
    schedule = ll.fill_words(read, "english")
    word = schedule.words[1]
    assert schedule.times[[word.first, word.stop]] == pytest.approx([0.3, 0.9])
    path.write_text(json.dumps(gentle(HI, LOST, LOST, found("hi", 0.4, ("ay_S", 0.2)))))
    assert [word.text for word in ll.read_schedule(path).words] == ["hi", "hi"]
