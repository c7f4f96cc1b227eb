"""Ren'Py scripts: their lines, the identifiers of these, and remarks on statements without text."""

import csv
from hashlib import md5
from pathlib import Path

import pytest

from lipsync_lang.text.lines import Line, read_lines


def write(path: Path, text: str) -> Path:
    path.write_text(text, "utf-8")
    return path


def read(path: Path, **options) -> list[Line]:
    return list(read_lines(path, **options))


def _quiet(_):
    pass


@pytest.mark.parametrize(
    ("tail", "says"),
    [
        ("", True),
        (":", True),
        (" (a=(1)):", True),
        (" if a(1) and b:", True),
        (" (1) if a(1) and b:", True),
        (" (a=1) with Dissolve(0.5), x", True),
        (' with dissolve if a == "b":', True),
        (" nointeract", True),
        (" if a", False),
        (" (a", False),
        (".upper()", False),
        (' with "b"', False),
        (") with a if " * 20_000, False),
        (" (" + ") with a if " * 20_000 + '"b"', False),
    ],
    ids=lambda value: str(value)[:30],
)
def test_the_ends_of_statements_are_searched_once(tail, says, tmp_path):
    path = write(tmp_path / "a.rpy", f'e "Hello"{tail}\n')
    assert [line.text for line in read(path, remark=_quiet)][:1] == ["Hello"] * says


PYTHON = {
    "lists": 'default songs = [\n    "One",\n    {"a":\n        "Two"},\n    "Three"\n]',
    "calls": '$ renpy.notify(\n    "One"  # not )\n)',
    "lines that go on": '$ song = \\\n    "One"',
    "long lists": "define songs = [\n" + '    "One",\n' * 500 + '    "Two"\n]',
    "motion": 'show logo:\n    "one.png"\n    pause 1.0\nimage logo:\n    "two.png"',
    "styles": 'init -1 screen a():\n    "One"\ninit 2 python in b:\n    "Two"',
}


@pytest.mark.parametrize("case", PYTHON)
def test_python_and_motion_in_a_script_are_no_lines(case, tmp_path):
    block = PYTHON[case].replace("\n", "\n    ")
    path = write(tmp_path / "a.rpy", f'label start:\n    "Hi."\n    {block}\n    e "Bye."\n')
    assert [line.text for line in read(path)] == ["Hi.", "Bye."]


def test_an_open_bracket_of_a_script_is_named_and_loses_no_line(tmp_path):
    path = write(tmp_path / "a.rpy", 'e "a"\n$ x = [1\ne "b"\n$ y = (2\ne "c"\n')
    remarks = []
    assert [line.text for line in read(path, remark=remarks.append)] == ["a", "b", "c"]
    assert remarks == [f"{path}:2: a bracket is not closed here, so each line is read alone"]


def test_lines_of_a_real_script_have_the_identifiers_of_their_translations(data, tmp_path):
    with (data / "text" / "the_question_lines.tsv").open(encoding="utf-8", newline="") as stream:
        rows = [row[:3] for row in csv.reader(stream, delimiter="\t")][1:]
    written = []
    for name, speaker, text in rows:
        label = f"label {name.rpartition('_')[0]}:"
        written += [label] if label not in written else []
        written += ["menu:"] if text.endswith('\\"') else []  # the question of the game
        written.append(f'    {speaker} "{text}"')
    lines = read(write(tmp_path / "a.rpy", "\n".join(written)))
    assert [line.name for line in lines] == [name for name, *_ in rows]
    assert len(rows) == 70


SOURCE = """\
label start:
    voice "a.ogg"
    e "Hello." (what_size=3)
    e "Again."
    e "Again."
    e "Said." id mine
label .inner:
    "Well,  \\"you\\" [[1] 5\\% \\u0041\\ \\ b" nointeract
    call other from _call_other
    menu pick:
        "What {i}now{/i}?"
        "Tea":
            "Here."
        "Nothing" if here:
            pass
    menu:
        e "What else?"
        "Tea":
            pass
"""


def test_every_line_of_a_script_has_an_identifier_but_menus(tmp_path):
    """The digests are those of Ren'Py's own spelling of each statement."""
    assert [line.name for line in read(write(tmp_path / "a.rpy", SOURCE), remark=_quiet)] == [
        digested("start", 'voice "a.ogg"', 'e "Hello." (what_size=3)'),
        digested("start", 'e "Again."'),
        digested("start", 'e "Again."') + "_1",
        "mine",
        digested("start_inner", '"Well, \\"you\\" [[1] 5%% A \\ b" nointeract'),
        "",
        "",
        digested("pick", '"Here."'),
        "",
        digested("pick", 'e "What else?" nointeract'),
        "",
    ]


def digested(label, *statements):
    code = "".join(f"{statement}\r\n" for statement in statements)
    return f"{label}_{md5(code.encode()).hexdigest()[:8]}"  # noqa: S324 as Ren'Py does


def test_menus_and_their_translations_have_one_original(tmp_path):
    source = read(write(tmp_path / "a.rpy", SOURCE), remark=_quiet)
    old = "translate french strings:\n" + "".join(
        f'    old "{text}"\n    new "Fr"\n' for text in ("What {i}now{/i}?", "Tea", "Nothing")
    )
    translated = read(write(tmp_path / "b.rpy", old))
    assert {line.original for line in translated} == {x.original for x in source if not x.name}


def test_a_line_translated_in_two_has_two_identifiers(tmp_path):
    path = write(tmp_path / "a.rpy", 'translate french start_1:\n    e "Bon."\n    e "Jour."\n')
    assert [line.name for line in read(path)] == ["start_1", "start_1-1"]


def test_an_open_quote_of_a_script_is_named(tmp_path):
    path = write(tmp_path / "a.rpy", 'e "open\n' + 'e "closed"\n' * 400)
    remarks = []
    read(path, remark=remarks.append)
    assert any("quote" in remark for remark in remarks)
