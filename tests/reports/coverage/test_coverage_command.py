"""The command: forms of the document, changes since an older one, columns, and refusals."""

import csv
import io
import json
import re
from xml.etree import ElementTree as ET

import pytest
from coverage_packs import LANGUAGE, WRITTEN, bank, lines, write
from lanes import full

from lipsync_lang import LipsyncError
from lipsync_lang.reports.coverage import coverage
from lipsync_lang.reports.coverage.changes import read_document, since
from lipsync_lang.reports.coverage.forms import FORMS


@pytest.fixture
def script(packs):
    """A file of lines."""
    return write(packs / "script.txt", "tata <b>mi</b>\nta, ta\n")


def run(cli, *more):
    return cli("coverage", "script.txt", "-l", "toy", "-c", "facefx", *more)


@pytest.mark.usefixtures("script")
def test_text_says_first_what_to_do_next(cli):
    ended = run(cli)
    assert ended.code == 0
    assert ended.err == ""
    shown = ended.out.splitlines()
    assert shown[0] == "1 file, 2 lines, 4 words"
    assert "not spoken: </b> (1, script.txt:1)" in shown[1]
    assert "next: draw 4 bigrams" in shown[4]
    assert shown[5].strip() == (
        "lipsync-lang bank draft -l toy -c facefx --write d-aa aa-bmp bmp-ih"
    )
    assert re.fullmatch(r" *aa-d in posesets/facefx/banks/common.yaml:6:\d+", shown[6])
    assert "0 of 4 bigrams" in shown[7]
    assert "no mapping for" not in ended.out


@pytest.mark.usefixtures("script")
def test_what_is_suggested_can_be_typed(cli):
    command = next(x for x in run(cli).out.splitlines() if "lipsync-lang bank" in x)
    assert cli(*command.split()[1:]).code == 0


@pytest.mark.parametrize("form", FORMS)
def test_every_form_can_be_written_and_printed(cli, script, form):
    out = script.parent / "out" / f"a.{form}"
    out.parent.mkdir()
    assert run(cli, "--format", form, "-o", out).code == 0
    printed = run(cli, "--format", form)
    assert printed.code == 0
    assert out.read_text("utf-8") == printed.out


@pytest.mark.parametrize(
    ("name", "start"),
    [("a.json", '{\n  "format"'), ("a.csv", "language,"), ("a.xml", "<?xml"), ("a.txt", "1 file")],
)
def test_the_suffix_of_a_file_names_its_form(cli, script, name, start):
    assert run(cli, "-o", name).code == 0
    assert (script.parent / name).read_text("utf-8").startswith(start)


def test_every_named_file_is_written(cli, script):
    ended = run(cli, "-o", "a.html", "-o", "a.csv", "-o", "-")
    assert (ended.code, ended.err) == (0, "wrote a.html\nwrote a.csv\n")
    assert ended.out.startswith("1 file")
    for name, start in (("a.html", "<!DOCTYPE html>"), ("a.csv", "language,")):
        assert (script.parent / name).read_text("utf-8").startswith(start)


@pytest.mark.usefixtures("script")
def test_a_table_has_a_row_per_bigram(cli):
    rows = list(csv.DictReader(io.StringIO(run(cli, "--format", "csv").out)))
    assert [row["bigram"] for row in rows if row["silence"] == "no"] == [
        "d-aa", "aa-d", "aa-bmp", "bmp-ih"
    ]  # fmt: skip
    assert {row["authored"] for row in rows} == {"no"}


@pytest.mark.parametrize(("percent", "code"), [(0, 0), (14, 0), (15, 1)])
def test_too_little_authored_fails_a_build(cli, script, percent, code):
    bank(script.parent, "approved")
    ended = run(cli, "--format", "junit", "--fail-under", percent)
    assert ended.code == code
    (suite,) = ET.fromstring(ended.out)  # noqa: S314 our own
    cases = suite.findall("testcase")
    assert suite.get("tests") == str(len(cases)) == "5"
    assert suite.get("failures") == str(len(suite.findall("testcase/failure"))) == str(code)
    assert suite.get("skipped") == str(len(suite.findall("testcase/skipped"))) == "3"
    assert ("under 15 %" in ended.err) == bool(code)


def test_what_changed_since(cli, script):
    assert run(cli, "-o", "old.json").code == 0
    bank(script.parent, "edited")
    write(script, "tata\nsi\n")
    ended = run(cli, "--against", "old.json")
    assert "since old.json:" in ended.out
    assert "toy on facefx: 0 % to 25.0 % authored, 4 to 2 left" in ended.out
    assert "    authored: aa-d" in ended.out
    assert "    newly needed: s-ih" in ended.out
    assert "    no longer needed: aa-bmp, bmp-ih" in ended.out
    document = json.loads(run(cli, "--against", "old.json", "--format", "json").out)
    assert list(document)[-1] == "since"
    assert document["since"]["reports"][0]["authored"] == ["aa-d"]


@pytest.mark.usefixtures("packs")
def test_a_report_that_only_one_has_is_named():
    old = coverage(lines("ta"), "toy", "facefx")
    new = coverage(lines("ta"), "toy", "crab")
    assert set(since(old, new, "old").since.unmatched) == {"toy on facefx", "toy on crab"}


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": "lipsync-lang coverage 2"}', "\0"])
def test_an_older_document_must_be_one(packs, text):
    with pytest.raises(LipsyncError, match=r"is not a 'lipsync-lang coverage 1' document"):
        read_document(write(packs / "old.json", text))
    with pytest.raises(LipsyncError, match="cannot be read"):
        read_document(packs / "gone.json")


def test_languages_may_have_columns_of_their_own(cli, packs):
    write(packs / "a.csv", "id,one,two\n1,ta,mi\n")
    write(packs / "languages/other.yaml", LANGUAGE.replace("toy", "other"))
    ended = cli(
        "coverage", "a.csv", "-l", "toy", "-l", "other", "-c", "facefx", "--column", "one",
        "--column", "other=two", "--format", "json",
    )  # fmt: skip
    document = json.loads(ended.out)
    assert [r["bigrams"][0]["bigram"] for r in document["reports"]] == ["d-aa", "bmp-ih"]
    assert document["corpus"]["lines"] == 2
    assert len(document["shared"]) == 2


@pytest.fixture
def both(packs, cli):
    """Count a language in two columns, with more options."""
    write(packs / "a.csv", "id,one,two\n1,tyt,mi\n2,,uta\n")
    columns = ("--column", "toy=one", "--column", "toy=two")
    return lambda *more: cli("coverage", "a.csv", "-l", "toy", "-c", "facefx", *columns, *more)


def test_a_language_may_have_several_columns(both):
    document = json.loads(both("--format", "json").out)
    assert [(r["language"], r["column"], r["lines"]) for r in document["reports"]] == [
        ("toy", "one", 1), ("toy", "two", 2)
    ]  # fmt: skip
    (shared,) = document["shared"]
    assert shared["used"] == 2, "of both columns together"


def test_every_form_tells_the_columns_of_a_language_apart(both):
    text = both().out.splitlines()
    for label in ("toy (one)", "toy (two)"):
        assert (
            sum(line.startswith((f"{label} on facefx:", f"{label}  facefx")) for line in text) == 2
        )
    rows = csv.DictReader(io.StringIO(both("--format", "csv").out))
    assert {row["column"] for row in rows} == {"one", "two"}
    suites = ET.fromstring(both("--format", "junit").out)  # noqa: S314 our own
    names = [suite.get("name") for suite in suites]
    assert names == ["all reports together", "toy (one) on facefx", "toy (two) on facefx"]
    page = both("--format", "html").out
    assert page.count("<th>Toy (one)</th>") == page.count("<th>Toy (two)</th>") == 1
    failed = both("--fail-under", "100").err
    assert "toy (one) on facefx: 0 % are authored" in failed


@full
def test_what_changed_is_told_for_each_column(both, packs):
    assert both("-o", "old.json").code == 0
    bank(packs, "edited")
    write(packs / "a.csv", "id,one,two\n1,tyt,mi\n2,ta,uta\n")
    ended = both("--against", "old.json")
    assert "toy (one) on facefx:" in ended.out.partition("since")[2]
    assert "toy (two) on facefx:" in ended.out.partition("since")[2]
    assert "in only one of the documents" not in ended.out
    document = json.loads(both("--against", "old.json", "--format", "json").out)
    assert [change["column"] for change in document["since"]["reports"]] == ["one", "two"]
    assert document["since"]["reports"][0]["new"] == ["d-aa"]


@pytest.mark.usefixtures("script")
def test_a_column_that_nothing_has_is_told(cli):
    ended = run(cli, "--column", "en")
    assert ended.code == 0
    assert ended.err == "--column en: not used, because no file is a table\n"


@pytest.mark.parametrize("form", ["text", "junit", "html"])
def test_words_in_another_script_are_told_in_every_form_for_people(cli, packs, form):
    write(packs / "languages/toy.yaml", WRITTEN)
    write(packs / "script.txt", "ta да mi\nta ми\n")
    shown = run(cli, "--format", form).out
    assert "да" in shown
    assert "not counted" in shown
    if form == "text":
        assert "in another script, read by the voice: да (1, script.txt:1)" in shown
        assert "in another script, not counted: ми (1, script.txt:2)" in shown


@pytest.mark.parametrize(
    ("more", "match"),
    [
        (["--fail-under", "101"], "give a percentage, 0 to 100"),
        (["--fail-under", "nan"], "give a percentage, 0 to 100"),
        (["--minutes", "0"], "above 0"),
        (["--against", "gone.json"], "gone.json: cannot be read"),
        (["--encoding", "klingon"], "unknown encoding"),
        (["--column", "a", "--column", "b"], "there is already --column a"),
        (["-l", "klingonese"], "klingonese"),
        (["-c", "nobody"], "nobody"),
        (["-o", "./script.txt"], "is an input"),
        (["-o", "gone/a.json"], "the folder gone does not exist"),
    ],
)
@pytest.mark.usefixtures("script")
def test_what_cannot_be_done_says_why(cli, more, match):
    ended = run(cli, *more)
    assert ended.code == 2
    assert match in ended.err
    assert ended.out == ""


@pytest.mark.usefixtures("script")
def test_a_terminal_is_told_how_far_it_is(cli, monkeypatch):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    ended = run(cli)
    assert ended.err == "\x1b[2K0 lines, script.txt\r\x1b[2K\r"


def test_lines_of_one_phoneme_have_no_bigram_but_are_read(cli, packs):
    write(packs / "script.txt", "a\nu\n")
    ended = run(cli)
    assert "no bigram is in these lines" in ended.out
    assert "reads nothing" not in ended.out


def test_a_language_that_does_not_read_says_so(cli, packs):
    silent = "".join(x for x in LANGUAGE.splitlines(keepends=True) if "g2p" not in x)
    write(packs / "languages/toy.yaml", silent)
    write(packs / "script.txt", "ta\n")
    ended = run(cli)
    assert ended.code == 2
    assert "toy does not read text" in ended.err


def test_an_empty_folder_says_so(cli, packs):
    (packs / "script.txt").mkdir()
    write(packs / "script.txt/a.png", "x")
    ended = run(cli)
    assert ended.code == 2
    assert "a.png: left out: no reader for '.png'" in ended.err
    assert "there are no lines" in ended.err
