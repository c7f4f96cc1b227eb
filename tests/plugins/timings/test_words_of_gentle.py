"""Words that Gentle has not found, or that its dictionary lacks."""

import json

import pytest

import lipsync_lang as ll
from lipsync_lang.schedules.timed_words import words_without_phonemes


def gentle(*words):
    return {"words": [*words]}


def found(word, start, *phones):
    given = [{"phone": phone, "duration": seconds} for phone, seconds in phones]
    return {"word": word, "case": "success", "start": start, "end": 9, "phones": given}


HI = found("hi", 0.0, ("hh_B", 0.1), ("ay_E", 0.2))
LOST = {"word": "mama", "case": "not-found-in-audio"}


def test_a_word_that_the_dictionary_of_gentle_lacks_is_read_by_the_language(tmp_path):
    path = tmp_path / "line.json"
    path.write_text(json.dumps(gentle(HI, found("babapomo", 0.3, ("oov_S", 0.9)))))
    read = ll.read_timings(path)
    assert words_without_phonemes(read) == [1]
    schedule = ll.fill_words(read, "english")
    word = schedule.words[1]
    assert schedule.times[[word.first, word.stop]] == pytest.approx([0.3, 1.2])
    assert len(schedule.labels[word.first : word.stop]) == 8


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
