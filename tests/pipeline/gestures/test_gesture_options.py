"""Gestures by option and project: in pages by default, in other files on request."""

import json
from pathlib import Path

import pytest

from lipsync_lang.cli import main

LABELS = ["_", "M", "AA1", "M", "AH0", "T", "IY1", "S", "OW1", "D", "AH0", "K", "AA1", "R", "_"]
TIMINGS = {
    "notation": "arpabet",
    "phonemes": [
        {"label": label, "start": 0.2 * n, "end": 0.2 * (n + 1)} for n, label in enumerate(LABELS)
    ],
}
PAIR = ["-l", "english", "-c", "arkit"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.json").write_text(json.dumps(TIMINGS))
    return tmp_path


def columns(*options):
    assert main(["run", "--schedule", "line.json", *PAIR, "-o", "a.csv", *options]) == 0
    return Path("a.csv").read_text(encoding="utf-8").splitlines()[0].split(",")


def test_files_have_gestures_on_request_alone(capsys):
    assert "eyeBlinkLeft" not in columns()
    assert "17 poses" in capsys.readouterr().err
    assert "eyeBlinkLeft" in columns("--gestures", "blink")


def test_a_page_has_gestures_beside_a_file_without(folder):
    assert "eyeBlinkLeft" not in columns("-o", "a.html")
    assert "eyeBlinkLeft" in (folder / "a.html").read_text(encoding="utf-8")
    columns("-o", "a.html", "--gestures", "none")
    assert "eyeBlinkLeft" not in (folder / "a.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("word", ["all", "true", "blink"])
def test_one_word_in_the_project_turns_them_on(folder, word):
    (folder / "lipsync.yaml").write_text(f"kind: project\nformat: 1\ngestures: {word}\n")
    assert "eyeBlinkLeft" in columns()
    assert "eyeBlinkLeft" not in columns("--gestures", "none")


def test_a_build_has_the_gestures_of_its_project(folder):
    (folder / "lipsync.yaml").write_text(
        "kind: project\nformat: 1\nlanguage: english\ncharacter: arkit\nlines: lines.csv\n"
        "timings: '{id}.json'\ngestures: all\noutputs: out/{id}.csv\n"
    )
    (folder / "lines.csv").write_text("id,text\nline,mama tea soda car\n")
    assert main(["build"]) == 0
    assert "eyeBlinkLeft" in (folder / "out/line.csv").read_text(encoding="utf-8")


def test_explain_names_a_gesture(capsys):
    asked = ["explain", "--schedule", "line.json", *PAIR, "--gestures", "all"]
    told = ""
    for at in (0.5, 1.0, 1.5, 2.0, 2.5):
        assert main([*asked, "--at", str(at)]) == 0
        told += capsys.readouterr().out
    assert "  gesture " in told
    assert "arkit/poseset.yaml:" in told


def test_check_counts_gestures(capsys):
    assert main(["check", "--schedule", "line.json", *PAIR, "--gestures", "all"]) in {0, 1}
    told = capsys.readouterr().out
    assert "gestures a minute: blink " in told
    assert "(26 in speech, 17 in silence)" in told
    assert "degrees (2 standard deviations)" in told
    assert main(["check", "--schedule", "line.json", *PAIR]) in {0, 1}
    assert "gestures" not in capsys.readouterr().out
    run = ["run", "--schedule", "line.json", *PAIR, "--check", "-o", "line.csv"]
    assert main([*run, "--gestures", "all"]) == 0
    assert "gestures a minute: blink " in capsys.readouterr().err
    assert main(run) == 0
    assert "gestures" not in capsys.readouterr().err


def test_a_line_idles_by_option_and_by_project(folder):
    def last():
        return float(Path("a.csv").read_text(encoding="utf-8").splitlines()[-1].split(",")[0])

    columns()
    end = last()
    columns("--idle", "2")
    assert last() == pytest.approx(end + 2, abs=0.1)
    (folder / "lipsync.yaml").write_text("kind: project\nformat: 1\nidle: 1\n")
    columns()
    assert last() == pytest.approx(end + 1, abs=0.1)


def test_an_unknown_gesture_of_a_line_is_refused_at_its_place(folder, capsys):
    (folder / "characters").mkdir()
    (folder / "characters/ann.yaml").write_text(
        "kind: character\nformat: 1\nname: ann\nposeset: arkit\nlines:\n  hi:\n    placed:\n"
        "      - {gesture: nodd, at: 0.5}\n      - {gesture: nod}\n"
    )
    assert main(["validate", "characters"]) == 1
    assert "characters/ann.yaml:9:" in capsys.readouterr().out
    (folder / "characters/ann.yaml").write_text(
        "kind: character\nformat: 1\nname: ann\nposeset: arkit\nlines:\n  hi:\n    placed:\n"
        "      - {gesture: nodd, at: 0.5}\n"
    )
    assert main(["validate", "characters"]) == 1
    assert "characters/ann.yaml:8:19: P234 unknown gesture 'nodd'" in capsys.readouterr().out
