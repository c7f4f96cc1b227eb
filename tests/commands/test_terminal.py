"""Texts of files are harmless in terminals and spreadsheets, for all commands."""

import csv
import io
import json
import re
import sys

import pytest
from lanes import full, swept

from lipsync_lang.base.terminal import progress, safe_streams, spelled_out, wipe

PAIR = ("-l", "english", "-c", "facefx")
EVIL = "\x1b]0;title\x07\x1b[2J\x9b31m\x7f\u202egnp\u2066.exe\r"
"""Text that sets a title, clears the screen, recolours, deletes, reverses and returns."""

COMMANDING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


def harmless(*texts):
    for text in texts:
        assert not COMMANDING.search(text), ascii(text)
    assert "x1b[2J" in "".join(texts), "it has been printed, spelled out"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Change to a folder with a schedule whose names contain terminal commands."""
    monkeypatch.chdir(tmp_path)
    rows = [("HH", 0, 0.08), ("AH0", 0.08, 0.25)]
    phonemes = [{"label": label, "start": a, "end": b} for label, a, b in rows]
    words = [{"text": EVIL, "start": 0, "end": 0.25}]
    (tmp_path / "line.json").write_text(json.dumps({"phonemes": phonemes, "words": words}))
    return tmp_path


def test_nothing_commands_but_newlines_tabs_and_scripts_stay():
    kept = "two\nlines\tand\u200c\u200d \u200eשלום\u200f 口 é \U0001f600"
    assert spelled_out(kept) == kept
    assert spelled_out("\x1b[1m\x9b\u202e\r") == r"\x1b[1m\u009b\u202e\x0d"


def test_an_explanation_prints_the_words_of_a_file_as_text(cli):
    ended = cli("explain", *PAIR, "--schedule", "line.json", "--at", "0.1")
    assert ended.code == 0
    harmless(ended.out)


def test_printed_json_stays_json(cli):
    ended = cli("explain", *PAIR, "--schedule", "line.json", "--at", "0.1", "--json")
    assert EVIL in json.dumps(json.loads(ended.out), ensure_ascii=False).replace(
        json.dumps(EVIL, ensure_ascii=False)[1:-1], EVIL
    )
    assert not COMMANDING.search(ended.out)


def test_a_speaker_whom_nobody_knows_is_named_as_text(folder, cli):
    rows = "".join(f"HH,0.1,0.2,{speaker}\n" for speaker in ("1", f"2{EVIL[:-1]}"))
    (folder / "line.csv").write_text(f"label,start,end,speaker\n{rows}")
    ended = cli("run", *PAIR, "--schedule", "line.csv")
    assert ended.code == 2
    harmless(ended.err)


def test_a_column_is_named_as_text(folder, cli):
    (folder / "script.csv").write_text(f"a{EVIL[:-1]},b\n1,2\n")
    ended = cli("coverage", "script.csv", *PAIR)
    assert ended.code == 2
    harmless(ended.err)


def test_a_pack_and_its_faults_are_named_as_text(folder, cli):
    (folder / "evil.yaml").write_text('kind: language\nformat: 1\nname: "\\e[2J"\ntag: "\\u202e"\n')
    ended = cli("validate", "evil.yaml")
    assert ended.code == 1
    assert not COMMANDING.search(ended.out + ended.err)


def test_what_the_command_line_itself_complains_of_is_text(cli):
    ended = cli("run", f"--{EVIL}", *PAIR)
    assert ended.code == 2
    harmless(ended.err)


def test_a_name_cannot_command_through_progress(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(stream, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(sys, "stderr", stream)
    with safe_streams():
        progress(f"reading {EVIL}")
        wipe()
    assert stream.getvalue() == f"\x1b[2Kreading {spelled_out(EVIL)}\r\x1b[2K\r"


def test_the_streams_come_back(capsys):
    before = sys.stdout, sys.stderr
    with safe_streams():
        sys.stdout.writelines(["a\x1b", "b\n"])
        sys.stderr.write("c\x1b\n")
    assert (sys.stdout, sys.stderr) == before
    assert capsys.readouterr() == ("a\\x1bb\n", "c\\x1b\n")


# Spreadsheets


@full
@pytest.mark.parametrize("start", swept(["=", "+", "-", "@"]))
def test_a_cell_that_begins_like_a_formula_is_text_and_numbers_are_numbers(folder, cli, start):
    name = f"{start}cmd|'x'!A0.txt"
    (folder / name).write_text("hello\n")
    ended = cli("coverage", f"./{name}", *PAIR, "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(ended.out)))
    assert rows
    for row in rows:
        assert row["places"].startswith(f"'{start}cmd|'x'!A0.txt:1")
        assert float(row["percent"]) > 0


def test_curves_keep_their_names_and_negative_numbers(folder, cli):
    assert cli("run", *PAIR, "--schedule", "line.json", "-o", "a.csv").code == 0
    rows = list(csv.reader((folder / "a.csv").read_text().splitlines()))
    assert float(rows[1][0]) < 0
