"""Coverage: what lines need, what a character has, and what to author next."""

import csv
import io
import json
from itertools import pairwise
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang import LipsyncError, Schedule
from lipsync_lang.coverage import coverage, plan
from lipsync_lang.coverage.changes import read_document, since
from lipsync_lang.coverage.forms import FORMS
from lipsync_lang.coverage.report import Coverage, authored
from lipsync_lang.coverage.schema import written
from lipsync_lang.lines import Line, read_lines

LANGUAGE = """\
kind: language
format: 1
name: toy
tag: art-x-toy
title: Toy
adds: [yu]
g2p: {engine: rules, notation: ipa, rules: [{from: q, to: t}]}
notations:
  ipa: {a: aa, i: ih, u: w, y: yu, t: d, m: bmp, s: s}
"""

BANK = """\
kind: bank
format: 1
name: common
poseset: facefx
bigrams:
  aa-d: {status: %s, curves: {open: [[0, 0], [0.5, 0.4], [1, 0]]}}
  w-d: {status: edited, curves: {open: [[0, 0], [0.5, 0.4], [1, 0]]}}
"""


@pytest.fixture
def packs(tmp_path, monkeypatch):
    """A language without a voice, a bank, and the folder they lie in."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "languages/toy.yaml", LANGUAGE)
    bank(tmp_path, "drafted")
    return tmp_path


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def bank(folder, status):
    return write(folder / "posesets/facefx/banks/common.yaml", BANK % status)


def lines(*texts):
    return [Line(text, f"a.txt:{number}") for number, text in enumerate(texts, 1)]


def report(*texts, **options):
    return coverage(lines(*texts), "toy", "facefx", **options).reports[0]


# Counting


@pytest.mark.usefixtures("packs")
def test_a_small_corpus_counted_by_hand():
    found = coverage(lines("tata mi", "ta, ta"), "toy", "facefx")
    told = found.reports[0]
    # d aa d aa bmp ih; d aa _ d aa
    assert told.phonemes | {"d": 4, "aa": 4, "bmp": 1, "ih": 1} == told.phonemes
    assert sum(told.phonemes.values()) == 10
    counts = {one.bigram: one.count for one in told.bigrams}
    assert counts == {"d-aa": 4, "aa-d": 1, "aa-bmp": 1, "bmp-ih": 1}
    assert {one.bigram: one.count for one in told.silence} == {"_-d": 3, "aa-_": 2, "ih-_": 1}
    assert told.occurrences == 7
    assert len(told.unused) == 22 * 22 - 4
    assert (told.lines, told.words) == (2, 4)
    assert (found.corpus.lines, found.corpus.words, found.corpus.files) == (2, 4, ("a.txt",))
    first = told.bigrams[0]
    assert (first.percent, first.running) == (57.1429, 57.1429)
    assert (first.example, first.places) == ("tata", ("a.txt:1", "a.txt:2"))
    across = next(one for one in told.bigrams if one.bigram == "aa-bmp")
    assert across.example == "", "it lies between two words"


@pytest.mark.usefixtures("packs")
def test_what_is_needed_and_what_is_left_by_hand():
    told = report("tata mi", "ta, ta")
    assert told.needed == {"90": 4, "95": 4, "99": 4, "100": 4}
    assert (told.left.bigrams, told.left.hours) == (4, 0.33)
    hour = report("tata mi", "ta, ta", minutes=30).next_hour
    assert (hour.bigrams, hour.percent) == (("d-aa", "aa-d"), 71.4286)
    assert report("ta", minutes=90).next_hour.bigrams == ()
    assert [(s.place, s.bigrams) for s in told.sentences] == [
        ("a.txt:1", ("aa-d", "aa-bmp", "d-aa", "bmp-ih"))
    ]


@pytest.mark.parametrize(("status", "counted"), [("drafted", 0), ("edited", 1), ("approved", 1)])
def test_a_draft_is_never_authored(packs, status, counted):
    bank(packs, status)
    told = report("tata")
    stated = next(one for one in told.bigrams if one.bigram == "aa-d")
    assert (stated.layer, stated.status) == ("shared", status)
    assert told.authored.bigrams == counted
    assert told.left.bigrams == 2 - counted
    assert told.authored.percent == pytest.approx(counted * 33.3333)
    assert ("aa-d" in told.next_hour.bigrams) is not counted
    tried = {name for sentence in told.sentences for name in sentence.bigrams}
    assert tried == {one.bigram for one in told.bigrams if not one.authored}


@pytest.mark.usefixtures("packs")
def test_what_is_borrowed_is_not_authored():
    told = report("yt ut")
    by_name = {one.bigram: one for one in told.bigrams}
    assert (by_name["yu-d"].layer, by_name["yu-d"].status) == ("like", "edited")
    assert not by_name["yu-d"].authored
    assert by_name["w-d"].authored
    assert not authored("gap", "")
    assert not authored("draft", "drafted")


@pytest.mark.usefixtures("packs")
def test_what_is_not_read_or_mapped_is_named_with_its_first_place():
    told = report("ta 7", "taq 7", "keks")
    found = [(one.what, one.count, one.place) for one in told.unread]
    assert found == [("7", 2, "a.txt:1"), ("keks", 1, "a.txt:3")]


@pytest.mark.usefixtures("packs")
def test_timed_phonemes_are_counted_as_they_are():
    schedule = Schedule(("t", "a", "_", "x"), [0, 0.1, 0.2, 0.3, 0.4], notation="ipa")
    found = coverage([Line("ta", "a.json:1", schedule=schedule)], "toy", "facefx")
    told = found.reports[0]
    assert {one.bigram: one.count for one in told.bigrams} == {"d-aa": 1}
    assert {one.bigram: one.count for one in told.silence} == {"_-d": 1, "aa-_": 1}
    assert [(one.what, one.count, one.place) for one in told.unmapped] == [("x", 1, "a.json:1")]


@pytest.mark.usefixtures("packs")
def test_lines_that_hold_nothing_cover_nothing():
    told = report("...", "", "7")
    assert (told.occurrences, told.bigrams, told.authored.percent) == (0, (), 0)
    assert told.needed == {"90": 0, "95": 0, "99": 0, "100": 0}


@pytest.mark.usefixtures("packs")
def test_no_lines_at_all_are_refused():
    with pytest.raises(LipsyncError, match="there are no lines"):
        coverage([], "toy", "facefx")


@pytest.mark.usefixtures("packs")
@pytest.mark.parametrize("minutes", [0, -1, float("nan"), float("inf")])
def test_minutes_are_a_number_above_zero(minutes):
    with pytest.raises(LipsyncError, match="above 0"):
        report("ta", minutes=minutes)


@pytest.mark.usefixtures("packs")
def test_many_lines_are_counted_as_few_are(monkeypatch):
    texts = ["tata mi", "ta, ta", "", "ut sa", "yt"] * 5
    whole = coverage(lines(*texts), "toy", "facefx")
    monkeypatch.setattr("lipsync_lang.coverage.corpus.BATCH", 3)
    monkeypatch.setattr("lipsync_lang.coverage.corpus.IN_MEMORY", 10)
    assert coverage(iter(lines(*texts)), "toy", "facefx") == whole


@pytest.mark.usefixtures("packs")
def test_several_languages_and_characters_and_what_they_share():
    found = coverage(lines("tyt"), ["toy", "toy"], ["facefx", "crab"])
    assert [(r.language, r.character) for r in found.reports] == [
        ("toy", "facefx"), ("toy", "crab")
    ]  # fmt: skip
    (shared,) = found.shared
    assert (shared.phonemes, shared.bigrams, shared.used) == (("yu",), 43, 2)


def test_words_of_a_character_are_its_own(packs):
    write(
        packs / "characters/ann.yaml",
        "kind: character\nformat: 1\nname: ann\nposeset: facefx\n"
        "pronunciations: {toy: {ta: [s, ih]}}\n",
    )
    plain, own = coverage(lines("ta"), "toy", ["facefx", "ann"]).reports
    assert [one.bigram for one in plain.bigrams] == ["d-aa"]
    assert [one.bigram for one in own.bigrams] == ["s-ih"]


# Plans


COUNTS = st.lists(st.integers(0, 50), min_size=1, max_size=30)


@given(COUNTS)
def test_running_totals_rise_to_all(counts):
    order = plan.ranked(np.array(counts))
    found = [counts[n] for n in order]
    assert found == sorted((c for c in counts if c), reverse=True)
    needed = list(plan.needed(found).values())
    assert needed == sorted(needed)
    assert needed[-1] == len(found)


@given(COUNTS)
def test_what_is_needed_is_enough_and_no_more(counts):
    found = sorted((c for c in counts if c), reverse=True)
    for share, number in plan.needed(found).items():
        wanted = int(share) * sum(found)
        assert 100 * sum(found[:number]) >= wanted
        assert not number or 100 * sum(found[: number - 1]) < wanted


SETS = st.lists(st.sets(st.integers(0, 20), max_size=8), max_size=25)


def packed(sets):
    starts = np.cumsum([0, *map(len, sets)])
    return np.array([m for s in sets for m in sorted(s)], np.uint16), starts


@given(SETS, st.sets(st.integers(0, 25)))
def test_a_cover_covers_all_that_can_be_and_nothing_twice(sets, wanted):
    members, starts = packed(sets)
    found = plan.cover(members, starts, np.array(sorted(wanted), np.int64))
    there = set().union(*sets) & wanted
    new = [member for _, members in found for member in members]
    assert sorted(new) == sorted(there)
    assert len({number for number, _ in found}) == len(found)
    for number, members in found:
        assert members, "each set has something new"
        assert set(members) <= sets[number]


@given(SETS, st.sets(st.integers(0, 25)))
def test_no_set_of_a_cover_can_be_spared(sets, wanted):
    members, starts = packed(sets)
    chosen = [n for n, _ in plan.cover(members, starts, np.array(sorted(wanted), np.int64))]
    there = set().union(*sets) & wanted
    for one in chosen:
        assert not there <= set().union(*(sets[n] for n in chosen if n != one))


def test_a_cover_takes_the_shorter_of_equals():
    members, starts = packed([{1, 2, 7, 8, 9}, {1, 2}, {3}])
    assert plan.cover(members, starts, np.array([1, 2, 3])) == [(1, [1, 2]), (2, [3])]


# The document


def test_the_schema_is_the_one_that_is_written(root):
    there = (root / "docs/reference/coverage.schema.json").read_text(encoding="utf-8")
    assert there == written(), "run python -m lipsync_lang.coverage.schema > that file"


SHAPE = {
    "": ["format", "corpus", "minutes", "reports", "shared"],
    "corpus": ["files", "lines", "words"],
    "reports": [
        "language", "language_title", "character", "poseset", "lines", "words", "phonemes",
        "occurrences", "bigrams", "silence", "unused", "needed", "authored", "left", "next_hour",
        "sentences", "unread", "unmapped",
    ],
    "bigrams": [
        "bigram", "count", "percent", "running", "layer", "status", "example", "places",
    ],
    "sentences": ["place", "text", "bigrams"],
    "shared": ["language", "phonemes", "bigrams"],
}  # fmt: skip
"""The keys that version 1 of the document has had from its start; others come after them."""


@pytest.mark.usefixtures("packs")
def test_the_document_has_the_keys_of_its_version():
    document = coverage(lines("tata"), "toy", "facefx").to_dict()
    told = document["reports"][0]
    parts = {
        "": document,
        "corpus": document["corpus"],
        "reports": told,
        "bigrams": told["bigrams"][0],
        "sentences": told["sentences"][0],
        "shared": document["shared"][0],
    }
    for name, keys in SHAPE.items():
        assert list(parts[name])[: len(keys)] == keys
    assert document["format"] == "lipsync-lang coverage 1"
    assert json.loads(json.dumps(document)) == document
    assert Coverage.model_validate(document).to_dict() == document
    assert document["minutes"] == 5
    assert isinstance(document["minutes"], int)


def test_real_sentences_are_counted_soundly(data):
    pytest.importorskip("phonemizer", reason="the speech extra is not installed")
    path = data / "text/harvard-sentences.txt"
    told = coverage(read_lines([path]), "english", "facefx").reports[0]
    running = [one.running for one in told.bigrams]
    assert running == sorted(running)
    assert running[-1] == 100
    assert sum(one.count for one in told.bigrams) == told.occurrences
    assert len(told.bigrams) + len(told.unused) == 441
    assert max(told.phonemes, key=told.phonemes.get) == "d"
    assert not told.unread
    assert not told.unmapped
    tried = [name for sentence in told.sentences for name in sentence.bigrams]
    assert sorted(tried) == sorted(one.bigram for one in told.bigrams)
    assert len(told.sentences) < 100
    assert all(a.count >= b.count for a, b in pairwise(told.bigrams))


# The command


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
        "lipsync-lang bank draft -l toy -c facefx --write d-aa aa-d aa-bmp bmp-ih"
    )
    assert "0 of 4 bigrams" in shown[6]
    assert "no map for" not in ended.out


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
    assert "toy on facefx: 0.0 % to 25.0 % authored, 4 to 2 left" in ended.out
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
    with pytest.raises(LipsyncError, match=r"old.json: is no 'lipsync-lang coverage 1' document"):
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


@pytest.mark.parametrize(
    ("more", "match"),
    [
        (["--fail-under", "101"], "give a percentage, 0 to 100"),
        (["--fail-under", "nan"], "give a percentage, 0 to 100"),
        (["--minutes", "0"], "above 0"),
        (["--against", "gone.json"], "gone.json: cannot be read"),
        (["--encoding", "klingon"], "no encoding has this name"),
        (["--column", "a", "--column", "b"], "there is --column a already"),
        (["-l", "klingonese"], "klingonese"),
        (["-c", "nobody"], "nobody"),
        (["-o", "./script.txt"], "is what is counted"),
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
    assert "a.png: left out: nothing reads lines from '.png'" in ended.err
    assert "there are no lines" in ended.err


def test_a_share_that_is_met_exactly_needs_no_more():
    assert plan.needed([90, 5, 4, 1]) == {"90": 1, "95": 2, "99": 3, "100": 4}
