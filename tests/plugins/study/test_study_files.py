"""Study files and answers: reading, and faults that are listed and set aside."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from study_answers import submissions_in

from lipsync_lang import LipsyncError
from lipsync_lang.plugins.study.study_file import (
    MAX_SUBMISSION_BYTES,
    Study,
    Submission,
    as_text,
    faults_against,
    parse_document,
    parsed,
    read_study,
    study_digest,
    texts_of,
)

STUDY = {
    "kind": "study",
    "format": 1,
    "study": "0123456789abcdef",
    "title": "Which one speaks better?",
    "seed": 7,
    "questions": ["accuracy", "naturalness"],
    "methods": ["ours", "keyframes"],
    "raters_see": None,
    "pairs": [
        {"pair": "p001", "line": "a", "character": "c", "left": "ours", "right": "keyframes"},
        {"pair": "p002", "line": "b", "character": "c", "left": "keyframes", "right": "ours"},
        {"pair": "p003", "line": "b", "character": "c", "left": "ours", "right": "ours",
         "check": "left"},
    ],
    "asked": ["age_group"],
}  # fmt: skip
ANSWER = {
    "pair": "p001",
    "question": "accuracy",
    "choice": "left",
    "strength": 3,
    "seconds": 4.2,
    "plays": 2,
}
ANSWERS = {
    "kind": "answers",
    "format": 1,
    "study": STUDY["study"],
    "rater": "fedcba9876543210",
    "consent": True,
    "started": "2026-11-23T06:30:00.123Z",
    "finished": None,
    "asked": {"age_group": "18-30"},
    "answers": [ANSWER, ANSWER | {"question": "naturalness"}],
}


def _study(**changed):
    return parsed(Study, json.dumps(STUDY | changed).encode(), "study.json")


def _submission(**changed):
    return parsed(Submission, json.dumps(ANSWERS | changed).encode(), "answers.json")


def test_a_study_is_read_as_it_is_written(tmp_path):
    path = tmp_path / "study.json"
    path.write_text(as_text(_study()), "utf-8")
    assert read_study(path) == _study()


@pytest.mark.parametrize(("changed", "told"), [
    ({"kind": "answers"}, "kind: Input should be 'study'"),
    ({"format": 2}, "format: Input should be 1"),
    ({"study": "xyz"}, "study: String should match"),
    ({"methods": ["ours"]}, "methods: Tuple should have at least 2"),
    ({"methods": ["ours", "held"]}, "pairs.0: unknown method 'keyframes'"),
    ({"pairs": [STUDY["pairs"][0]] * 2}, "pairs.1: two pairs have the name 'p001'"),
    (
        {"pairs": [STUDY["pairs"][0] | {"right": STUDY["pairs"][0]["left"], "check": None}]},
        "pairs.0: 'ours' is on both sides, but is not an attention check",
    ),
    ({"methods": ["ours", "keyframes", "ours"]}, "methods: has 'ours' twice"),
    ({"questions": ["accuracy", "accuracy"]}, "questions: has 'accuracy' twice"),
    ({"more": 1}, "more: Extra inputs"),
])  # fmt: skip
def test_a_faulty_study_is_refused_with_the_place(tmp_path, changed, told):
    path = tmp_path / "study.json"
    path.write_text(json.dumps(STUDY | changed), "utf-8")
    with pytest.raises(LipsyncError) as error:
        read_study(path)
    assert str(error.value).startswith(f"{path}: {told}")


def test_answers_are_read_from_a_file_of_one_rater_and_from_lines_of_many(tmp_path):
    one, many = tmp_path / "one.json", tmp_path / "many.jsonl"
    one.write_text("\ufeff" + json.dumps(ANSWERS, indent=2), "utf-8")
    many.write_text(as_text(_submission()) * 3, "utf-8")
    assert [parse_document(text)[2] for _, text in texts_of([one])] == [ANSWERS]
    assert submissions_in(many) == [_submission()] * 3


def test_damaged_lines_are_named_and_the_others_read(tmp_path):
    path = tmp_path / "answers.jsonl"
    line = as_text(_submission())
    path.write_text(line + line[:100] + "\n\n" + "[" * 100_000 + "\n" + line[:-1], "utf-8")
    read = {place: parse_document(text) for place, text in texts_of([path])}
    assert [place for place, (reason, _, _) in read.items() if reason] == [f"{path}:2", f"{path}:4"]
    assert [found for reason, _, found in read.values() if not reason] == [json.loads(line)] * 2


def test_a_line_larger_than_any_answers_is_named(tmp_path):
    path = tmp_path / "answers.jsonl"
    path.write_text(json.dumps(ANSWERS | {"rater": "7" * MAX_SUBMISSION_BYTES}), "utf-8")
    ((_, text),) = texts_of([path])
    reason, words, found = parse_document(text)
    assert (reason, found) == ("unreadable", None)
    assert "larger" in words


@pytest.mark.parametrize("content", [b"", b"\n \n"])
def test_an_empty_file_is_unreadable(tmp_path, content):
    path = tmp_path / "answers.jsonl"
    path.write_bytes(content)
    ((_, text),) = texts_of([path])
    assert parse_document(text) == ("unreadable", "is empty", None)


@pytest.mark.parametrize(("field", "value"), [
    ("consent", False), ("rater", "anna"), ("started", "yesterday"), ("answers", [1]),
    ("answers", [ANSWER | {"strength": 6}]), ("answers", [ANSWER | {"choice": "both"}]),
    ("asked", {"age": "x" * 501}),
])  # fmt: skip
def test_answers_out_of_form_are_refused(field, value):
    with pytest.raises(LipsyncError, match=rf"answers.json: {field}"):
        _submission(**{field: value})


@pytest.mark.parametrize(("changed", "told"), [
    ({}, None),
    ({"study": "0" * 16}, "the answers are for study 0000000000000000"),
    ({"answers": [ANSWER | {"pair": "p009"}]}, "answers.0: the study has no pair 'p009'"),
    ({"answers": [ANSWER, ANSWER]}, "answers.1: p001 has two answers about accuracy"),
    ({"asked": {"name": "Anna"}}, "asked.name: the study does not ask this question"),
])  # fmt: skip
def test_answers_are_compared_with_their_study(changed, told):
    faults = faults_against(_submission(**changed), _study())
    assert [fault[: len(told or "")] for fault in faults] == ([told] if told else [])


def test_an_unasked_question_is_a_fault():
    study = _study(questions=["accuracy"])
    assert faults_against(_submission(), study) == (
        "answers.1: the study does not ask about naturalness",
    )


@given(st.text(), st.text())
def test_equal_digests_stand_for_equal_contents(one, other):
    assert (study_digest([one]) == study_digest([other])) == (one == other)
