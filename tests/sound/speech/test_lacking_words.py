"""Words that a dictionary lacks: found by an aligner, and read by the language."""

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


FILES = {
    "line.TextGrid": TEXTGRID,
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
