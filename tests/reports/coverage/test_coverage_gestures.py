"""Gestures of a script: counted by the facts that draw them, for each pose set that has them."""

import io
import json

import numpy as np
import pytest
from coverage_packs import lines

import lipsync_lang as ll
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.cli import main
from lipsync_lang.reports.coverage import coverage
from lipsync_lang.reports.coverage.forms import FORMS, FormOptions
from lipsync_lang.schedules.schedule import Schedule, Word
from lipsync_lang.text.lines import Line

TEXTS = ("Who are you?", "No, I do not know that.", "Yes, we will go there tomorrow.")


def counted(*texts, character="arkit", gestures="all"):
    return coverage(lines(*texts), "english", character, gestures=gestures).reports


def test_facts_of_the_words_and_sounds_are_counted():
    (report,) = counted(*TEXTS)
    by = {one.gesture: one.facts for one in report.gestures}
    assert by["ask"] == {"question": 1}
    assert by["assent"] == {"agreement": 1}
    assert set(by["denial"]) == {"denial"}
    assert all(one.count == sum(one.facts.values()) for one in report.gestures)
    known = [shape.name for shape in ll.resolve("english", "arkit").gesture_set.shapes]
    found = [one.gesture for one in report.gestures]
    assert found == sorted(found, key=known.index)


def test_twice_the_lines_have_twice_the_gestures_and_the_same_rates():
    (once,), (twice,) = counted(*TEXTS), counted(*TEXTS, *TEXTS)
    assert [2 * one.count for one in once.gestures] == [one.count for one in twice.gestures]
    rates = [[one.a_minute for one in report.gestures] for report in (once, twice)]
    assert rates[0] == pytest.approx(rates[1], abs=0.1)


def test_gestures_are_chosen_and_a_set_without_them_has_none():
    arkit, oculus = counted(*TEXTS, character=("arkit", "oculus"))
    assert arkit.gestures
    assert oculus.gestures == ()
    assert {one.gesture for one in counted(*TEXTS, gestures="ask")[0].gestures} == {"ask"}
    assert counted(*TEXTS, gestures=None)[0].gestures == ()
    with pytest.raises(LipsyncError, match="unknown gesture 'nodd'"):
        counted(*TEXTS, gestures="nodd")


def test_timed_lines_are_counted_at_their_own_times():
    labels = ["_", *["M", "AA1"] * 20, "_"]
    words = tuple(Word("mama", 2 * n + 1, 2 * n + 3) for n in range(20))
    times = np.arange(len(labels) + 1) * 0.2
    timed = Line("", "a.json", schedule=Schedule(labels, times, words, notation="arpabet"))
    (report,) = coverage([timed], "english", "arkit", gestures="all").reports
    performer = ll.resolve("english", "arkit")
    nods = next(one.count for one in report.gestures if one.gesture == "nod")
    shown = performer.perform(timed.schedule, gestures="nod")["nod"] > 0
    assert nods == np.count_nonzero(shown[1:] & ~shown[:-1])


def test_text_and_json_tell_them(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.txt").write_text("\n".join(TEXTS))
    asked = ["coverage", "script.txt", "-l", "english", "-c", "arkit"]
    assert main([*asked, "--gestures", "ask,assent"]) == 0
    told = capsys.readouterr().out
    assert "gestures, at estimated times unless lines have their own:" in told
    rows = [line.split()[:2] for line in told.splitlines() if line.startswith("    a")]
    assert rows == [["ask", "1"], ["assent", "1"]]
    assert main([*asked, "--gestures", "ask", "--json"]) == 0
    (one,) = json.loads(capsys.readouterr().out)["reports"][0]["gestures"]
    assert (one["gesture"], one["count"], one["facts"]) == ("ask", 1, {"question": 1})
    assert main(asked) == 0
    assert "gestures" not in capsys.readouterr().out


def test_a_project_with_gestures_counts_them(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.txt").write_text("\n".join(TEXTS))
    (tmp_path / "lipsync.yaml").write_text("kind: project\nformat: 1\ngestures: ask\n")
    assert main(["coverage", "script.txt", "-l", "english", "-c", "arkit"]) == 0
    assert "    ask" in capsys.readouterr().out


def test_every_form_takes_a_report_with_gestures():
    found = coverage(lines(*TEXTS), "english", "arkit", gestures="all")
    for form in FORMS.modules:
        FORMS.find(form)(found, out := io.StringIO(), FormOptions())
        assert out.getvalue()
