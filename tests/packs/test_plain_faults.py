"""Mistakes of authors: each message alone tells where it is and how to mend it."""

from pathlib import Path

import pytest
from packs_tree import plant, put

from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.events import load_yaml

LANGUAGE = "languages/ours.yaml"
POSESET = "posesets/face/poseset.yaml"
BANK = "posesets/face/banks/common.yaml"
CHARACTER = "characters/anna.yaml"
PROJECT = "lipsync.yaml"
RIG = "posesets/face/rigs/model.yaml"

LANGUAGE_TEXT = """\
kind: language
format: 1
name: ours
tag: qab
title: Ours
extends: parent
g2p:
  engine: rules
  rules:
    - {from: m, to: P}
    - {from: h, to: [], before: "[ao]"}
notations:
  first:
    P: p
    Y: yu
  ipa:
    ts: {to: [p, f], shares: [0.4, 0.6]}
words:
  moi: [p, a]
tests:
  - {text: moi, phonemes: [p, a], source: nobody}
  - {text: moi moi, ipa: ts, phonemes: [p, f]}
"""

PROJECT_TEXT = """\
kind: project
format: 1
lines: script.csv
languages: [parent]
cast: {"*": anna}
outputs: "takes/{character}/{id}.csv"
limits: {contacts: 0}
"""

MISTAKES = load_yaml(Path(__file__).with_name("mistakes.yaml").read_text("utf-8"))
assert MISTAKES, "a sweep over nothing passes"

JARGON = ("while parsing", "while scanning", "<block", "mapping values", "could not find", "token")
"""Words of a parser, which no author knows."""


@pytest.fixture
def packs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    plant(tmp_path)
    put(tmp_path, LANGUAGE, LANGUAGE_TEXT)
    put(tmp_path, PROJECT, PROJECT_TEXT)
    put(tmp_path, "script.csv", "id,parent\na,b\n")
    return tmp_path


def faults_of(packs, file):
    found = validate(Library([packs], project=packs), [packs / file])
    return [fault for fault in found if fault.severity == "fault"]


def test_the_unbroken_packs_are_sound(packs):
    for file in (LANGUAGE, POSESET, BANK, CHARACTER, PROJECT, RIG):
        assert faults_of(packs, file) == []


@pytest.mark.parametrize("row", MISTAKES, ids=[row["mistake"] for row in MISTAKES])
def test_a_mistake_is_told_where_it_is_with_its_cure(packs, row):
    file = row["file"]
    text = (packs / file).read_text("utf-8")
    assert text.count(row["old"]) == 1
    put(packs, file, text.replace(row["old"], row["new"]))
    first, *_ = faults = faults_of(packs, file)
    assert (first.code, first.line) == (row["code"], row["line"]), faults
    assert row["cure"] in f"{first.what}; {first.hint}"
    for fault in faults:
        assert not any(word in str(fault) for word in JARGON)


ROOTS = {
    "notations": ("notations:", "notatons:", "P101"),
    "shares": ("shares: [0.4, 0.6]", "shares: [0.4, 0.9]", "P114"),
}


@pytest.mark.parametrize("name", ROOTS)
def test_a_root_cause_is_told_without_what_follows_from_it(packs, name):
    old, new, code = ROOTS[name]
    text = LANGUAGE_TEXT.replace("extends: parent\n", "adds: [yu]\n")
    put(packs, LANGUAGE, text.replace(old, new))
    assert [fault.code for fault in faults_of(packs, LANGUAGE)] == [code]


def test_a_comma_is_a_decimal_comma_only_in_a_fault(packs):
    text = (packs / BANK).read_text("utf-8")
    put(packs, BANK, text.replace("[0, 0], [0.2, 1]", "[0,0],[0.2,1]"))
    assert faults_of(packs, BANK) == []
