"""Mistakes of authors: each message alone tells where it is and how to mend it."""

import pytest
from packs_tree import plant, put

from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library

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

MISTAKES = [
    ("open double quote", LANGUAGE, "title: Ours", 'title: "Ours', "P008", 5, 'write " at its end'),
    ("curly quotes", LANGUAGE, "title: Ours", "title: “Ours”", "P106", 5, "write straight quotes"),
    (
        "title no",
        LANGUAGE,
        "title: Ours",
        "title: no",
        "P106",
        5,
        "write the name that readers see",
    ),
    ("title yes", LANGUAGE, "title: Ours", "title: true", "P103", 5, "put it in quotes"),
    (
        "boolean no",
        LANGUAGE,
        "tag: qab",
        "tag: qab\nautomatic: no",
        "P103",
        5,
        "write true or false",
    ),
    ("open single quote", LANGUAGE, "title: Ours", "title: 'Ours", "P008", 5, "write ' at its end"),
    (
        "open quote in a list",
        LANGUAGE,
        'before: "[ao]"}',
        'before: "[ao]}',
        "P008",
        11,
        'write " at its end',
    ),
    ("missing colon", LANGUAGE, "title: Ours", "title Ours", "P008", 5, "write `title: Ours`"),
    (
        "missing colon of a block",
        LANGUAGE,
        "notations:\n",
        "notations\n",
        "P008",
        12,
        "write `notations:`",
    ),
    ("missing colon inside", LANGUAGE, "    P: p\n", "    P p\n", "P008", 14, "write `P: p`"),
    (
        "no space after the colon",
        LANGUAGE,
        "title: Ours",
        "title:Ours",
        "P008",
        5,
        "write `title: ...`",
    ),
    ("no space inside", LANGUAGE, "    Y: yu", "    Y:yu", "P008", 15, "write `Y: ...`"),
    (
        "indented too far",
        LANGUAGE,
        "    Y: yu",
        "      Y: yu",
        "P008",
        15,
        "line 14 is indented by 4 spaces",
    ),
    (
        "indented too little",
        LANGUAGE,
        "    Y: yu",
        "   Y: yu",
        "P008",
        15,
        "line 14 is indented by 4 spaces",
    ),
    (
        "field indented",
        LANGUAGE,
        "title: Ours",
        "  title: Ours",
        "P008",
        5,
        "line 4 is indented by 0 spaces",
    ),
    (
        "item without indent",
        LANGUAGE,
        "    - {from: h",
        "   - {from: h",
        "P008",
        11,
        "line 10 is indented by 4 spaces",
    ),
    (
        "decimal comma in a list",
        LANGUAGE,
        "shares: [0.4, 0.6]",
        "shares: [0,4, 0,6]",
        "P104",
        17,
        "write a decimal point, not a comma: 0.5,",
    ),
    (
        "decimal comma",
        POSESET,
        "threshold: 0.5",
        "threshold: 0,5",
        "P104",
        13,
        "write a decimal point, not a comma: 0.5,",
    ),
    (
        "decimal comma in a mapping",
        POSESET,
        "floor: {PBM: 0.9}",
        "floor: {PBM: 0,9}",
        "P103",
        17,
        "write a decimal point, not a comma: 0.5,",
    ),
    (
        "decimal comma alone",
        POSESET,
        "f: {FV: 0.9}",
        'f: {FV: "0,9"}',
        "P103",
        22,
        "write a decimal point, not a comma: 0.5,",
    ),
    (
        "curly quotes with colon",
        LANGUAGE,
        "title: Ours",
        "title: “Ours: new”",
        "P008",
        5,
        'write straight quotes (") instead',
    ),
    (
        "curly quotes in a list",
        LANGUAGE,
        'before: "[ao]"',
        "before: “[ao]”",
        "P008",
        11,
        'write straight quotes (") instead',
    ),
    ("notatons", LANGUAGE, "notations:", "notatons:", "P101", 12, "did you mean 'notations'?"),
    (
        "bad shares",
        LANGUAGE,
        "shares: [0.4, 0.6]",
        "shares: [0.4, 0.9]",
        "P114",
        17,
        "shares add up to 1.3, not to 1",
    ),
    (
        "shares of another number",
        LANGUAGE,
        "shares: [0.4, 0.6]",
        "shares: [1]",
        "P114",
        17,
        "1 shares for 2 phonemes; state one for each",
    ),
    (
        "[b, m, p] in a contact",
        POSESET,
        "phonemes: [p], floor",
        "phonemes: [b, m, p], floor",
        "P202",
        17,
        "write 'p' for it",
    ),
    (
        "silent letter as text",
        LANGUAGE,
        "from: h, to: []",
        'from: h, to: ""',
        "P116",
        11,
        "write [] for a silent letter",
    ),
    (
        "missing base",
        LANGUAGE,
        "extends: parent",
        "extends: parnt",
        "P210",
        6,
        "did you mean 'parent'?",
    ),
    (
        "itself as base",
        LANGUAGE,
        "extends: parent",
        "extends: ours",
        "P210",
        6,
        "name another language, or leave `extends`",
    ),
    (
        "open bracket",
        LANGUAGE,
        "words:\n  moi: [p, a]",
        "words:\n  moi: [p, a",
        "P008",
        19,
        "write ']' at its end",
    ),
    (
        "open brace",
        LANGUAGE,
        "{from: m, to: P}",
        "{from: m, to: P",
        "P008",
        10,
        "write '}' at its end",
    ),
    ("wrong bracket", LANGUAGE, "[p, a]\ntests", "[p, a}\ntests", "P008", 19, "write ']' here"),
    ("extra bracket", LANGUAGE, "  moi: [p, a]\n", "  moi: [p, a]]\n", "P008", 19, "delete it"),
    ("tab", LANGUAGE, "    Y: yu", "\tY: yu", "P007", 15, "indent with spaces"),
    (
        "colon in text",
        LANGUAGE,
        "title: Ours",
        "title: Ours: the best",
        "P008",
        5,
        "put the text after the first colon into",
    ),
    (
        "hash in text",
        LANGUAGE,
        "title: Ours",
        "title: #1 of ours",
        "P103",
        5,
        "write a value, or delete the field; text",
    ),
    (
        "starts with a sign",
        LANGUAGE,
        "title: Ours",
        "title: @ours",
        "P008",
        5,
        "put the text into quotes",
    ),
    (
        "starts with percent",
        LANGUAGE,
        "title: Ours",
        "title: %ours",
        "P008",
        5,
        "put the text into quotes",
    ),
    (
        "starts with star",
        LANGUAGE,
        "title: Ours",
        "title: *ours*",
        "P012",
        5,
        "put text that begins with '*' into quotes,",
    ),
    ("backtick", LANGUAGE, "title: Ours", "title: `Ours`", "P008", 5, "put the text into quotes"),
    (
        "text after a quote",
        LANGUAGE,
        "title: Ours",
        'title: "Ours" new',
        "P008",
        5,
        "end it with the quote",
    ),
    (
        "bad escape",
        LANGUAGE,
        "title: Ours",
        'title: "Ou\\rs \\k"',
        "P008",
        5,
        "write `\\\\` for a backslash, `/` in paths,",
    ),
    ("pipe sign", LANGUAGE, "title: Ours", "title: |Ours", "P008", 5, "put the text into quotes"),
    ("unknown phoneme", LANGUAGE, "    P: p\n", "    P: q\n", "P202", 14, "known: _, a, f, p, yu"),
    (
        "unknown phoneme in a word",
        LANGUAGE,
        "moi: [p, a]\ntests",
        "moi: [p, aa]\ntests",
        "P202",
        19,
        "did you mean 'a'?",
    ),
    (
        "one text for a list",
        LANGUAGE,
        "phonemes: [p, a], source",
        "phonemes: p a, source",
        "P103",
        21,
        "write [p, a]",
    ),
    (
        "comma text for a list",
        LANGUAGE,
        "phonemes: [p, a], source",
        'phonemes: "p, a", source',
        "P103",
        21,
        "write [p, a]",
    ),
    (
        "a dash without space",
        LANGUAGE,
        "  - {text: moi, ph",
        "  -{text: moi, ph",
        "P008",
        21,
        "write `- ` before it",
    ),
    ("number for text", LANGUAGE, "title: Ours", "title: 2024", "P103", 5, "put it in quotes"),
    (
        "year tag",
        LANGUAGE,
        "tag: qab",
        "tag: Klingon!",
        "P106",
        4,
        "write a BCP 47 tag such as 'pt-BR'",
    ),
    (
        "name with space",
        LANGUAGE,
        "name: ours",
        "name: our s",
        "P106",
        3,
        "use letters, digits, '-' and '_'",
    ),
    ("name differs", LANGUAGE, "name: ours", "name: theirs", "P111", 3, "rename one of the two"),
    (
        "kind misspelled",
        LANGUAGE,
        "kind: language",
        "kind: langage",
        "P109",
        1,
        "did you mean 'language'?",
    ),
    (
        "kind missing",
        LANGUAGE,
        "kind: language\n",
        "",
        "P102",
        1,
        "start it with `kind: ...`, `format: 1` and",
    ),
    (
        "format missing",
        LANGUAGE,
        "format: 1\n",
        "",
        "P102",
        1,
        "add `format: 1`: The format of the file.",
    ),
    (
        "twice",
        LANGUAGE,
        "title: Ours",
        "title: Ours\ntitle: Yours",
        "P015",
        6,
        "it is also in line 5; keep one of the two",
    ),
    (
        "missing test phonemes",
        LANGUAGE,
        "phonemes: [p, a], source: nobody",
        "source: nobody",
        "P102",
        21,
        "add `phonemes: ...`: The expected common",
    ),
    (
        "test wrong",
        LANGUAGE,
        "ipa: ts, phonemes: [p, f]",
        "ipa: ts, phonemes: [p, a]",
        "P221",
        22,
        "correct the map or the test",
    ),
    (
        "engine misspelled",
        LANGUAGE,
        "engine: rules",
        "engine: rule",
        "P107",
        8,
        "did you mean 'rules'?",
    ),
    (
        "rule without from",
        LANGUAGE,
        "{from: m, to: P}",
        "{form: m, to: P}",
        "P102",
        10,
        "add `from: ...`: Letters of the word.",
    ),
    (
        "pose misspelled",
        POSESET,
        "f: {FV: 0.9}",
        "f: {FW: 0.9}",
        "P201",
        22,
        "known: FV, PBM, open, wide",
    ),
    (
        "above one",
        POSESET,
        "f: {FV: 0.9}",
        "f: {FV: 90}",
        "P104",
        22,
        "write a number that is at most 1",
    ),
    ("percent", POSESET, "f: {FV: 0.9}", "f: {FV: 90%}", "P103", 22, "write a number, such as 0.5"),
    (
        "priority unknown",
        POSESET,
        "priority: [open, FV, PBM]",
        "priority: [open, FV, BMP]",
        "P201",
        15,
        "did you mean 'PBM'?",
    ),
    (
        "contact phoneme unknown",
        POSESET,
        "phonemes: [f], floor",
        "phonemes: [v], floor",
        "P202",
        18,
        "known: _, a, f, p, yu",
    ),
    (
        "constraint of one",
        POSESET,
        "between: [open, PBM]",
        "between: [open]",
        "P108",
        13,
        "`between` must have more than 1 items, got",
    ),
    ("targets misspelled", POSESET, "targets:", "target:", "P101", 20, "did you mean 'targets'?"),
    (
        "motion misspelled",
        POSESET,
        "window: 0.13",
        "windw: 0.13",
        "P101",
        19,
        "did you mean 'window'?",
    ),
    (
        "open quote in a pose set",
        POSESET,
        "title: Face",
        'title: "Face',
        "P008",
        4,
        'write " at its end',
    ),
    ("missing colon in a pose set", POSESET, "  FV: {}", "  FV {}", "P008", 8, "write `FV: {}`"),
    (
        "bank curve runs back",
        BANK,
        "[[0, 0], [0.2, 1], [0.6, 0]]",
        "[[0, 0], [0.6, 1], [0.2, 0]]",
        "P113",
        7,
        "times fall from 0.6 to 0.2; the times of a",
    ),
    (
        "bank point of three",
        BANK,
        "[0.2, 1]",
        "[0.2, 1, 3]",
        "P108",
        7,
        "item 2 of `FV` must have at most 2 items,",
    ),
    (
        "bank decimal comma",
        BANK,
        "[0.2, 1]",
        "[0,2, 1]",
        "P108",
        7,
        "write a decimal point, not a comma: 0.5,",
    ),
    ("bank unknown phoneme", BANK, "f-a:", "f-e:", "P202", 7, "known: _, a, f, p, yu"),
    (
        "bank bigram without hyphen",
        BANK,
        "f-a:",
        "fa:",
        "P106",
        7,
        "'fa' is not a bigram: write two common",
    ),
    (
        "bank pose set",
        BANK,
        "poseset: face",
        "poseset: fase",
        "P204",
        4,
        "move the file, or correct its `poseset`",
    ),
    (
        "bank status",
        BANK,
        "status: approved",
        "status: aproved",
        "P107",
        9,
        "did you mean 'approved'?",
    ),
    (
        "bank open brace",
        BANK,
        "open: [[0.2, 0], [1, 0]]}}",
        "open: [[0.2, 0], [1, 0]]}",
        "P008",
        7,
        "write '}' at its end",
    ),
    ("character rig", CHARACTER, "rig: model", "rig: modell", "P212", 10, "did you mean 'model'?"),
    (
        "character bank file",
        CHARACTER,
        "banks: [anna-bank.yaml]",
        "banks: [anna.bank.yaml]",
        "P213",
        6,
        "it belongs beside the character",
    ),
    (
        "character bank as text",
        CHARACTER,
        "banks: [anna-bank.yaml]",
        "banks: anna-bank.yaml",
        "P103",
        6,
        "write [anna-bank.yaml]",
    ),
    (
        "character pose set",
        CHARACTER,
        "poseset: face",
        "poseset: faces",
        "P203",
        4,
        "did you mean 'face'?",
    ),
    (
        "character curly",
        CHARACTER,
        "rig: model",
        "rig: ‘model’",
        "P106",
        10,
        "use letters, digits, '-' and '_'",
    ),
    (
        "project language",
        PROJECT,
        "languages: [parent]",
        "languages: [parnt]",
        "P210",
        4,
        "did you mean 'parent'?",
    ),
    (
        "project languages as text",
        PROJECT,
        "languages: [parent]",
        "languages: parent",
        "P103",
        4,
        "`languages` must be a list of names, or a",
    ),
    ("project character", PROJECT, '"*": anna', '"*": ana', "P203", 5, "did you mean 'anna'?"),
    (
        "project star",
        PROJECT,
        '{"*": anna}',
        "{*: anna}",
        "P012",
        5,
        "put text that begins with '*' into quotes,",
    ),
    (
        "project output unquoted",
        PROJECT,
        '"takes/{character}/{id}.csv"',
        "{character}/{id}.csv",
        "P008",
        6,
        "put the text into quotes",
    ),
    (
        "project open quote",
        PROJECT,
        '"takes/{character}/{id}.csv"',
        '"takes/{character}/{id}.csv',
        "P008",
        6,
        'write " at its end',
    ),
    (
        "project windows path",
        PROJECT,
        '"takes/{character}/{id}.csv"',
        '"takes\\{character}\\{id}.csv"',
        "P008",
        6,
        "write `\\\\` for a backslash, `/` in paths,",
    ),
    ("rig pose", RIG, "gains: {open: 0.7}", "gains: {opn: 0.7}", "P201", 6, "did you mean 'open'?"),
]
"""Name, file, old and new text; code and line of the first fault, and words of its cure."""

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


@pytest.mark.parametrize("row", MISTAKES, ids=[row[0] for row in MISTAKES])
def test_a_mistake_is_told_where_it_is_with_its_cure(packs, row):
    _, file, old, new, code, line, cure = row
    text = (packs / file).read_text("utf-8")
    assert text.count(old) == 1
    put(packs, file, text.replace(old, new))
    first, *_ = faults = faults_of(packs, file)
    assert (first.code, first.line) == (code, line), faults
    assert cure in f"{first.what}; {first.hint}"
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
