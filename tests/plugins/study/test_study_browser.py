"""The page of a study, answered in a browser from its file, and from its server."""

import json
import threading

import numpy as np
import pytest
from lanes import full
from places import TESTS
from study_answers import submissions_in
from test_consumers import chromium, found, run

import lipsync_lang as ll
from lipsync_lang.plugins.study import study_clips
from lipsync_lang.plugins.study.answer_server import AnswerServer
from lipsync_lang.plugins.study.answer_sorting import SortingRules, sort_answers
from lipsync_lang.plugins.study.methods import StudyCharacter, parse_methods
from lipsync_lang.plugins.study.study_file import Submission, faults_against, parsed
from lipsync_lang.plugins.study.study_lines import StudyLine
from lipsync_lang.plugins.study.study_maker import StudyPlan, make_study
from lipsync_lang.plugins.study.study_page import PageTexts, parse_asked

pytestmark = full

TITLE = "Which <b>face</b> speaks better?"


@pytest.fixture
def study(tmp_path, monkeypatch):
    monkeypatch.setattr(study_clips, "CLIP_SIDE", 96)
    performer = ll.resolve("english", "facefx")
    sound = ll.Audio((np.sin(np.arange(8000) / 3) * 9000).astype(np.int16), 8000)
    lines = tuple(
        StudyLine(
            name,
            name,
            ll.Schedule(("M", name, "_"), [0, 0.2, 0.5, 0.7], notation="arpabet", audio=sound),
        )
        for name in ("AA", "IY")
    )
    plan = StudyPlan(
        lines,
        (StudyCharacter(performer, performer.model, lambda _: performer),),
        parse_methods(["ours", "held"]),
        TITLE,
        PageTexts(asked=(parse_asked("Age group: 18-30|31-50|51+"),)),
    )
    return make_study(plan, tmp_path / "study", workers=1)


def answered(study, address, folder):
    """Answer a study's page, and check its export against the study."""
    node, modules = found("playwright-core")
    shown = run(node, TESTS / "browser" / "study.mjs", modules, chromium(), address, folder)
    assert shown["said"] == []
    assert shown["nameless"] == []
    assert shown["overflow"] <= 0
    for key in ("saved", "stopped", "others"):
        content = json.dumps(shown[key]).encode()
        assert not faults_against(parsed(Submission, content, key), study.study)
    return shown


def test_a_rater_answers_reloads_and_exports(study, tmp_path):
    shown = answered(study, study.folder / "page.html", tmp_path)
    pairs = [pair.pair for pair in study.study.pairs]
    assert shown["asked"] == [], "the page asks nobody for anything"
    assert shown["title"] == TITLE
    assert shown["refused"], "no answer without consent"
    assert shown["opened"] == [False, False, True], "both clips are played first"
    assert shown["early"]
    assert (shown["first"], shown["second"]) == ("Pair 1 of 3", "Pair 2 of 3")
    assert shown["reloaded"] == shown["resumed"] == "Pair 2 of 3"
    saved = shown["saved"]
    assert json.loads(shown["shown"]) == saved
    assert shown["file"] == f"answers-{study.study.study[:8]}-{saved['rater'][:8]}.json"
    assert saved["asked"] == {"age_group": "18-30"}
    assert saved["finished"] > saved["started"]
    assert len(saved["answers"]) == 6
    assert sorted({one["pair"] for one in saved["answers"]}) == pairs
    assert [(one["choice"], one["strength"]) for one in saved["answers"][:2]] == [("left", 4)] * 2
    assert {(one["choice"], one["strength"]) for one in saved["answers"][2:]} == {("right", 2)}
    assert all(one["plays"] == 2 and one["seconds"] > 0.5 for one in saved["answers"])
    assert shown["stopped"]["finished"] is None
    assert shown["stopped"]["answers"] == saved["answers"][:2]
    assert shown["stays"] == shown["end"] == "Thank you. All pairs are answered."
    assert shown["asks"].startswith("Press again")
    assert shown["anew"] == [True, False], "the next person begins with consent"
    assert shown["others"]["rater"] != saved["rater"]
    assert shown["warned"].startswith("This browser does not store answers")
    assert shown["storeless"], "a browser without a store keeps the answers over a reload"
    assert len(submissions_in(tmp_path / "answers.json")) == 1
    rules = SortingRules(failed_checks=1, least_seconds=0.5)
    counted = sort_answers([tmp_path / "answers.json"], study.study, rules)
    assert (counted.raters, len(counted.choices), counted.checks) == (1, 4, 2)
    assert counted.set_aside == []


def test_a_served_page_sends_its_answers(study, tmp_path):
    with AnswerServer(study.folder, "127.0.0.1", 0) as server:
        thread = threading.Thread(target=server.run)
        thread.start()
        try:
            shown = answered(study, f"http://127.0.0.1:{server.port}/", tmp_path)
        finally:
            server.stop()
            thread.join()
    assert shown["sent"] == "The answers were sent. You can close this page."
    assert set(shown["asked"]) == {"GET /", "POST /answers"}
    taken = submissions_in(study.folder / "answers.jsonl")
    assert [one.model_dump(mode="json") for one in taken] == [shown["saved"]]
