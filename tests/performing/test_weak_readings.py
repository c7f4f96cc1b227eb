"""A language with unreliable readings of text gives one warning for every use."""

import pytest

WEAK = "Orkish is written without vowels."

PACK = """\
kind: language
format: 1
name: orkish
tag: art-x-orkish
title: Orkish
weak: Orkish is written without vowels.
g2p: {engine: rules, notation: ipa}
notations:
  ipa: {m: bmp, a: aa}
tests:
  - {text: ma, phonemes: [bmp, aa], source: the script}
"""

PROJECT = """\
kind: project
format: 1
language: orkish
character: crab
lines: script.csv
outputs: ["takes/{id}.csv"]
"""


@pytest.fixture(autouse=True)
def game(tmp_path, monkeypatch):
    """A project of two lines in the language."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "languages").mkdir()
    (tmp_path / "languages/orkish.yaml").write_text(PACK, encoding="utf-8")
    (tmp_path / "lipsync.yaml").write_text(PROJECT, encoding="utf-8")
    (tmp_path / "script.csv").write_text("id,text\na,ma\nb,mama\n", encoding="utf-8")


@pytest.mark.parametrize(
    "command",
    [
        ("transcribe", "ma mama", "-l", "orkish"),
        ("run", "ma mama", "-l", "orkish", "-c", "crab", "-o", "line.csv"),
        ("build",),
    ],
    ids=lambda command: command[0],
)
def test_a_weak_reading_is_said_once_where_text_is_read(cli, command):
    ended = cli(*command)
    assert (ended.code, ended.err.count(WEAK)) == (0, 1), ended


def test_lines_with_timings_hear_nothing_of_it(cli, tmp_path):
    (tmp_path / "line.json").write_text(
        '{"phonemes": [{"label": "m", "start": 0, "end": 0.2}]}', encoding="utf-8"
    )
    ended = cli("run", "--schedule", "line.json", "-l", "orkish", "-c", "crab", "-o", "line.csv")
    assert (ended.code, ended.err.count(WEAK)) == (0, 0), ended
