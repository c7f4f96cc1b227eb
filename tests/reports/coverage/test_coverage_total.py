"""The total of a coverage: shared work counts once, and the ranking serves all languages."""

import csv
import io
import json
import re
from collections import Counter
from xml.etree import ElementTree as ET

import pytest
from coverage_packs import LANGUAGE, bank, lines, write
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang import LipsyncError, Schedule
from lipsync_lang.packs.models import Project
from lipsync_lang.packs.speaker_faces import SpeakerFaces, stated_faces
from lipsync_lang.reports.coverage import coverage
from lipsync_lang.reports.coverage.changes import ScriptDigests, script_changes, since
from lipsync_lang.reports.coverage.forms import FORMS, FormOptions
from lipsync_lang.reports.coverage.forms.text import draft_calls
from lipsync_lang.reports.coverage.report import (
    AuthoredShare,
    BigramNeed,
    CoverageReport,
    NextHour,
    WorkItem,
    WorkLeft,
)
from lipsync_lang.reports.coverage.total import total_of
from lipsync_lang.text.lines import Line

STATES = [("draft", "drafted"), ("shared", "edited"), ("language", "drafted"), ("gap", "")]


def need(bigram, count, layer="draft", status="drafted"):
    return BigramNeed(
        bigram=bigram, count=count, percent=0, running=0, layer=layer, status=status,
        example="", places=(),
    )  # fmt: skip


def report(language, character, needs, poseset="crab"):
    return CoverageReport(
        language=language, language_title=language, character=character, poseset=poseset,
        lines=1, words=1, phonemes={}, occurrences=sum(one.count for one in needs),
        bigrams=tuple(needs), silence=(), unused=(), needed={},
        authored=AuthoredShare(bigrams=0, percent=0), left=WorkLeft(bigrams=0, hours=0),
        next_hour=NextHour(bigrams=(), percent=0), sentences=(), unread=(), unmapped=(),
    )  # fmt: skip


# The arithmetic


def test_a_bigram_that_two_languages_need_is_drawn_once():
    told = total_of(
        [
            report("one", "crab", [need("a-b", 3), need("b-a", 1)]),
            report("two", "crab", [need("a-b", 10), need("c-a", 10)]),
        ],
        minutes=30,
    )
    assert (told.needed, told.left, told.authored.bigrams) == (3, WorkLeft(bigrams=3, hours=1.5), 0)
    found = [(one.bigram, one.percent, one.reaches, one.languages) for one in told.ranking]
    assert found == [
        ("a-b", 62.5, 62.5, ("one", "two")),
        ("c-a", 25, 87.5, ("two",)),
        ("b-a", 12.5, 100, ("one",)),
    ]
    assert told.next_hour == NextHour(bigrams=("a-b", "c-a"), percent=87.5)


def test_faces_of_one_pose_set_share_their_work_and_others_do_not():
    rows = [need("a-b", 1)]
    told = total_of(
        [
            report("one", "anna", rows),
            report("one", "ben", rows),
            report("one", "vex", rows, poseset="arkit"),
        ],
        minutes=60,
    )
    assert told.left == WorkLeft(bigrams=2, hours=2)
    assert [face.left.bigrams for face in told.faces] == [1, 1, 1]
    assert [(one.poseset, one.characters) for one in told.ranking] == [
        ("crab", ("anna", "ben")), ("arkit", ("vex",))
    ]  # fmt: skip


def test_a_draft_in_the_bank_of_one_language_is_work_of_its_own():
    told = total_of(
        [
            report("one", "crab", [need("a-b", 1, "language")]),
            report("two", "crab", [need("a-b", 1)]),
            report("three", "crab", [need("a-b", 1, "shared", "edited")]),
        ],
        minutes=5,
    )
    assert [(one.bank, one.languages) for one in told.ranking] == [
        ("", ("two",)), ("one", ("one",))
    ]  # fmt: skip
    assert told.authored.percent == pytest.approx(33.3333)


def test_weights_say_how_much_a_language_matters():
    reports = [report("one", "crab", [need("a-b", 9)]), report("two", "crab", [need("b-a", 1)])]
    even, uneven = total_of(reports, 5), total_of(reports, 5, {"two": 3})
    assert [one.percent for one in even.ranking] == [50, 50]
    assert [(one.bigram, one.percent) for one in uneven.ranking] == [("b-a", 75), ("a-b", 25)]
    assert uneven.weights == {"one": 1, "two": 3}


def test_what_is_drawn_already_is_no_gain():
    partly = need("b-a", 4).model_copy(update={"in_trigrams": 3})
    rows = [need("a-b", 4, "shared", "edited"), partly, need("c-a", 2)]
    told = total_of([report("one", "crab", rows)], minutes=60)
    assert told.authored == AuthoredShare(bigrams=1, percent=70)
    found = [(one.bigram, one.count, one.percent, one.reaches) for one in told.ranking]
    assert found == [("c-a", 2, 20, 90), ("b-a", 1, 10, 100)]
    assert told.next_hour == NextHour(bigrams=("c-a",), percent=20)


def test_nearly_all_is_not_all():
    rows = [need("a-b", 10**9, "shared", "edited"), need("b-a", 1)]
    told = total_of([report("one", "crab", rows)], minutes=5)
    assert (told.authored.percent, told.ranking[0].percent) == (99.9999, 0.0001)
    done = total_of([report("one", "crab", rows[:1])], minutes=5)
    assert (done.authored.percent, done.ranking) == (100, ())


NEEDS = st.dictionaries(
    st.sampled_from(["a-a", "a-b", "b-a", "b-b"]),
    st.tuples(st.integers(1, 9), st.sampled_from(STATES)),
    max_size=4,
)
REPORTS = st.lists(
    st.tuples(st.sampled_from("xyz"), st.sampled_from(["anna", "ben", "vex"]), NEEDS),
    min_size=1,
    max_size=6,
)


@given(REPORTS)
def test_the_total_is_never_more_than_its_reports_and_reaches_everything(drawn):
    reports = [
        report(
            language, character, [need(key, n, *state) for key, (n, state) in needs.items()],
            poseset="arkit" if character == "vex" else "crab",
        )
        for language, character, needs in drawn
    ]  # fmt: skip
    told = total_of(reports, 5)
    left = [sum(not one.authored for one in each.bigrams) for each in reports]
    assert max(left) <= told.left.bigrams <= sum(left)
    for face in told.faces:
        assert face.left.bigrams <= told.left.bigrams
    assert len({one.piece for one in told.ranking}) == told.left.bigrams
    assert told.authored.bigrams + told.left.bigrams == told.needed
    gains = [one.percent for one in told.ranking]
    assert gains == sorted(gains, reverse=True)
    if any(each.occurrences for each in reports):
        assert told.authored.percent + sum(gains) == pytest.approx(100, abs=0.01)
        assert told.ranking == () or told.ranking[-1].reaches == pytest.approx(100, abs=0.01)


ITEMS = st.lists(
    st.tuples(
        st.sampled_from(["crab", "arkit"]),
        st.sets(st.sampled_from("xyz"), min_size=1),
        st.sampled_from(["", "x"]),
    ),
    max_size=8,
)


@given(ITEMS)
def test_commands_draft_each_item_once_for_a_language_that_has_it(drawn):
    items = [
        WorkItem(
            bigram=f"b-{number}", poseset=poseset, bank=bank, count=1, percent=1, reaches=1,
            languages=tuple(sorted(languages)), characters=(),
        )
        for number, (poseset, languages, bank) in enumerate(drawn)
    ]  # fmt: skip
    met = Counter()
    for call in draft_calls(items):
        words = call.split()
        language, poseset = words[words.index("-l") + 1], words[words.index("-c") + 1]
        for name in words[words.index("--write") + 1 :]:
            item = items[int(name[2:])]
            assert (item.poseset, language in item.languages) == (poseset, True)
            met[name] += 1
    assert met == Counter(one.bigram for one in items if not one.bank)


# The command


@pytest.fixture
def two(packs, cli):
    """Two languages in one table, with more options."""
    write(packs / "languages/other.yaml", LANGUAGE.replace("toy", "other").replace("Toy", "Other"))
    write(packs / "a.csv", "id,speaker,toy,Other (x)\n1,Ann,ta ta,ta mi\n2,Bob,mi,sa\n")
    return lambda *more: cli("coverage", "a.csv", "-l", "toy", "-l", "other", *more)


def test_the_total_stands_first(two):
    shown = two("-c", "facefx").out.splitlines()
    assert shown[0] == ("5 bigrams, 0.42 hours for all 2 languages; the first hour gives 100 %")
    assert "0 of 5 bigrams, 0 % of the speech" in two("-c", "facefx").out


def test_the_commands_of_the_total_can_be_typed(two, cli):
    shown = two("-c", "facefx").out.partition("\nlanguage ")[0].splitlines()
    calls = [line.split() for line in shown if "lipsync-lang bank" in line]
    assert calls
    for call in calls:
        assert cli(*call[1:]).code == 0


def test_a_build_server_sees_the_total_once(two):
    both = ("-c", "facefx", "-c", "crab")
    top = ET.fromstring(two(*both, "--format", "junit").out)  # noqa: S314 our own
    document = json.loads(two(*both, "--format", "json").out)
    assert [suite.get("name") for suite in top][:2] == ["all reports together", "toy on facefx"]
    for suite, told in zip(top, (document["total"], *document["reports"]), strict=True):
        figures = {one.get("name"): one.get("value") for one in suite.iter("property")}
        assert figures == {
            "authored_percent": str(told["authored"]["percent"]),
            "authored_bigrams": str(told["authored"]["bigrams"]),
            "left_bigrams": str(told["left"]["bigrams"]),
            "left_hours": str(told["left"]["hours"]),
            "next_hour_percent": str(told["next_hour"]["percent"]),
            "next_hour_bigrams": " ".join(told["next_hour"]["bigrams"]),
        }
        assert int(suite.get("tests")) == len(suite.findall("testcase"))
    assert int(top.get("tests")) == len(list(top.iter("testcase")))
    assert int(top.get("skipped")) == len(list(top.iter("skipped")))
    assert (top.get("failures"), top.get("errors")) == ("0", "0")
    ended = two(*both, "--format", "junit", "--fail-under", "1")
    failing = ET.fromstring(ended.out)  # noqa: S314 our own
    assert failing.get("failures") == str(len(document["reports"]))
    assert not list(failing[0].iter("failure"))


def test_hours_of_a_spreadsheet_add_up_to_the_total(two):
    rows = list(csv.DictReader(io.StringIO(two("-c", "facefx", "--format", "csv").out)))
    document = json.loads(two("-c", "facefx", "--format", "json").out)
    hours = sum(float(row["hours"] or 0) for row in rows)
    assert hours == pytest.approx(document["total"]["left"]["hours"], abs=0.01)
    ranks = {row["rank_for_all"] for row in rows} - {""}
    assert len(ranks) == document["total"]["left"]["bigrams"]
    (first,) = [row for row in rows if row["hours"] not in ("", "0") and row["bigram"] == "d-aa"]
    assert first["serves"] == "toy other"


def test_weights_are_given_by_any_name_of_a_language(two):
    told = two("-c", "facefx", "--weight", "art-x-toy=3", "--format", "json")
    assert json.loads(told.out)["total"]["weights"] == {"toy": 3, "other": 1}


@pytest.mark.parametrize(
    ("weight", "match"),
    [
        ("toy", "write LANGUAGE=NUMBER"),
        ("toy=x", "write LANGUAGE=NUMBER"),
        ("toy=-1", "write LANGUAGE=NUMBER"),
        ("toy=inf", "write LANGUAGE=NUMBER"),
        ("nope=2", "nope is not a language of this report; these are toy, other"),
    ],
)
def test_weights_are_numbers_of_counted_languages(two, weight, match):
    ended = two("-c", "facefx", "--weight", weight)
    assert ended.code == 2
    assert match in ended.err


def test_a_document_is_the_same_whether_columns_are_found_or_stated(two):
    stated = two("-c", "facefx", "--column", "toy=toy", "--column", "other=4", "--format", "json")
    found = two("-c", "facefx", "--format", "json")
    a, b = json.loads(stated.out), json.loads(found.out)
    assert a["reports"] == b["reports"]
    assert a["total"] == b["total"]


def test_a_language_without_a_column_is_named(two):
    ended = two("-l", "german", "-c", "facefx")
    assert ended.code == 2
    assert "a.csv:1: which column is the text in german? Say --column german=NAME" in ended.err
    assert "Its columns: id, speaker, toy, Other (x)" in ended.err


def test_the_only_text_is_not_taken_from_another_language(cli, packs):
    write(packs / "a.csv", "id,en\n1,Hello\n")
    ended = cli("coverage", "a.csv", "-l", "toy", "-c", "facefx")
    assert ended.code == 2
    assert "which column is the text in toy?" in ended.err


# Speakers


@pytest.fixture
def game(packs):
    """A project with a cast."""
    write(packs / "a.csv", "id,speaker,toy\n1,Ann,ta\n2,Bob,mi\n3,,sa\n4,ann,ti\n")
    write(
        packs / "lipsync.yaml",
        "kind: project\nformat: 1\nname: game\nlanguages: [toy]\nlines: a.csv\n"
        'cast: {Ann: arkit, "*": crab}\n',
    )
    return packs


@pytest.mark.usefixtures("game")
def test_the_speaker_chooses_the_face(cli):
    ended = cli("coverage", "--format", "json")
    document = json.loads(ended.out)
    found = {r["character"]: (r["lines"], r["occurrences"]) for r in document["reports"]}
    assert found == {"arkit": (2, 2), "crab": (2, 2)}
    needs = {r["character"]: {b["bigram"] for b in r["bigrams"]} for r in document["reports"]}
    assert needs == {"arkit": {"d-aa", "d-ih"}, "crab": {"bmp-ih", "s-aa"}}
    assert document["corpus"]["other_speakers"] == [{"what": "Bob", "count": 1, "place": "a.csv:3"}]
    assert ended.err == "speakers that `cast` does not name get crab: Bob (1)\n"
    sentences = {s["place"] for r in document["reports"] for s in r["sentences"]}
    assert sentences == {"a.csv:2", "a.csv:3", "a.csv:4", "a.csv:5"}


@pytest.mark.usefixtures("game")
def test_a_named_character_speaks_every_line(cli):
    document = json.loads(cli("coverage", "-c", "facefx", "--format", "json").out)
    assert [(r["character"], r["lines"]) for r in document["reports"]] == [("facefx", 4)]


def test_a_cast_without_others_names_the_speaker_that_lacks(cli, game):
    project = (game / "lipsync.yaml").read_text("utf-8").replace(', "*": crab', "")
    write(game / "lipsync.yaml", project)
    ended = cli("coverage")
    assert ended.code == 2
    assert "a.csv:3: no character for 'Bob'; add the speaker or '*' to `cast`" in ended.err


def test_the_project_states_columns_and_speakers(cli, game):
    write(game / "a.csv", "id,rolle,words toy\n1,Ann,ta\n2,Bob,mi\n")
    project = (game / "lipsync.yaml").read_text("utf-8")
    write(game / "lipsync.yaml", project + 'columns: {text: "words {language}", speaker: rolle}\n')
    document = json.loads(cli("coverage", "--format", "json").out)
    assert [r["lines"] for r in document["reports"]] == [1, 1]


@pytest.mark.usefixtures("packs")
def test_two_characters_of_one_speaker_have_all_of_the_lines():
    spoken = [
        Line("ta", "a.txt:1", speaker="Ann"), Line("mi", "a.txt:2", speaker="Bob"),
        Line("sa", "a.txt:3", speaker="Ann"),
    ]  # fmt: skip
    told = coverage(spoken, "toy", "facefx", cast={"Ann": ("crab", "arkit")})
    assert {r.character: r.lines for r in told.reports} == {"facefx": 1, "crab": 2, "arkit": 2}
    own = coverage(spoken[::2], "toy", "crab").reports[0]
    (crab,) = [r for r in told.reports if r.character == "crab"]
    assert crab == own


def test_speakers_are_found_in_any_letters_and_all_others_have_a_face():
    faces = SpeakerFaces({"Anna": ["a", "b"], "anna": ["c"], "*": ["b", "d"]})
    assert faces.characters == ("a", "b", "c", "d")
    assert (faces.of("Anna"), faces.of("anna"), faces.of("ANNA")) == (("a", "b"), ("c",), ("c",))
    assert (faces.own("Ben"), faces.of("Ben"), faces.of("")) == ((), ("b", "d"), ("b", "d"))
    assert SpeakerFaces({"Anna": ["a"]}).of("Ben") == ()


@pytest.mark.parametrize(
    ("character", "cast", "stated"),
    [
        ("crab", {}, {"*": ("crab",)}),
        ("crab", {"Anna": "arkit"}, {"Anna": ("arkit",), "*": ("crab",)}),
        ("crab", {"*": "arkit"}, {"*": ("arkit",)}),
        (None, {"Anna": ("arkit", "crab")}, {"Anna": ("arkit", "crab")}),
    ],
)
def test_the_character_of_a_project_speaks_for_all_that_its_cast_leaves_out(
    character, cast, stated
):
    project = Project.model_validate(
        {"kind": "project", "format": 1, "character": character, "cast": cast}
    )
    assert stated_faces(project) == stated


# File names


def test_reports_name_files_from_the_project(cli, game, monkeypatch, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere") / "deep"
    write(elsewhere / "b.csv", "id,toy\n1,ta\n")
    write(game / "acts/c.csv", "id,toy\n1,mi\n")
    for form in ("text", "json", "csv", "html", "junit"):
        out = cli(
            "coverage", game / "acts", elsewhere / "b.csv", "-c", "crab", "--format", form
        ).out
        assert "acts/c.csv" in out
        assert "b.csv" in out
        assert str(game) not in out
        assert "elsewhere" not in out
    monkeypatch.chdir(game / "acts")
    assert cli("coverage", "c.csv", "-l", "toy", "-c", "crab", "--path", game).code == 0


@pytest.mark.usefixtures("packs")
def test_files_elsewhere_of_one_name_stay_apart(cli, tmp_path_factory):
    folder = tmp_path_factory.mktemp("two")
    files = [write(folder / name / "a.txt", "ta\n") for name in ("x", "y")]
    told = json.loads(cli("coverage", *files, "-l", "toy", "-c", "crab", "--format", "json").out)
    assert told["corpus"]["files"] == ["x/a.txt", "y/a.txt"]


# Changes of the script


def changes(old, new):
    a, b = (coverage(spoken, "toy", "crab") for spoken in (old, new))
    return since(a, b, "old.json").since


@pytest.mark.usefixtures("packs")
def test_lines_that_came_went_or_changed_are_named():
    def line(name, text, speaker=""):
        return Line(text, f"a.csv:{name}", name, speaker)

    found = changes(
        [line("1", "ta"), line("2", "mi"), line("3", "sa"), line("4", "ta", "Ann")],
        [line("0", "su"), line("2", "mi"), line("3", "ti"), line("4", "ta", "Bob")],
    )
    (script,) = found.script
    assert script.lines == (4, 4)
    assert (script.added, script.removed, script.changed) == (("0",), ("1",), ("3", "4"))
    assert found.left == (WorkLeft(bigrams=3, hours=0.25), WorkLeft(bigrams=3, hours=0.25))


@pytest.mark.usefixtures("packs")
def test_lines_without_a_name_are_told_apart_by_their_text():
    (script,) = changes(lines("ta", "mi", "ta"), lines("su", "ta", "mi")).script
    assert (script.added, script.removed, script.changed) == (("a.txt:1",), ("a.txt:3",), ())


def digests(read, column=""):
    """Return the digests of some lines in a column."""
    found = ScriptDigests()
    for line in read:
        found.add(line)
    return [one.model_copy(update={"column": column}) for one in found.lines(["toy"])]


def test_a_name_of_several_lines_names_none():
    old = [Line("ta", "a.csv:2", "x"), Line("mi", "a.csv:3", "x"), Line("sa", "a.csv:4", "y")]
    new = [Line("ta", "a.csv:2", "x"), Line("tu", "a.csv:3", "x"), Line("si", "a.csv:4", "y")]
    (found,) = script_changes(digests(old), digests(new))
    assert (found.lines, found.changed) == ((3, 3), ("y",))
    assert (found.added, found.removed) == (("a.csv:3",), ("a.csv:3",))


def test_columns_are_compared_with_their_own():
    one, other = [Line("ta", "a.csv:2", "x")], [Line("mi", "a.csv:2", "x")]
    old = [*digests(one, "a"), *digests(other, "b")]
    assert [two.changed for two in script_changes(old, digests(one, "b"))] == [("x",)]
    assert [two.changed for two in script_changes(old, digests(one, "a"))] == [()]
    assert list(script_changes(old, digests(one, "c"))) == []


def test_timed_phonemes_are_compared_by_their_labels():
    said = [Schedule(labels, [0, 0.1, 0.2], notation="ipa") for labels in (("t", "a"), ("m", "i"))]
    old, new = ([Line("", "a.json", "x", schedule=one)] for one in said)
    (found,) = script_changes(digests(old), digests(new))
    assert (found.changed, found.added) == (("x",), ())


TEXTS = st.lists(st.sampled_from(["ta", "mi", "sa", "tu"]), min_size=1, max_size=6)


@given(TEXTS, TEXTS)
def test_changes_of_nameless_lines_add_up(old, new):
    (found,) = script_changes(digests(lines(*old)), digests(lines(*new)))
    assert len(new) - len(old) == len(found.added) - len(found.removed)
    assert len(found.added) == (Counter(new) - Counter(old)).total()
    assert len(found.removed) == (Counter(old) - Counter(new)).total()


@pytest.mark.usefixtures("packs")
def test_a_script_that_is_too_large_is_not_compared(monkeypatch):
    monkeypatch.setattr("lipsync_lang.reports.coverage.changes.MAX_COMPARED_LINES", 2)
    assert changes(lines("ta", "mi"), lines("ta", "mi", "sa")).script == ()
    assert len(changes(lines("ta"), lines("mi")).script) == 1


def test_the_text_tells_of_the_script_in_all_languages(two, packs):
    assert two("-c", "facefx", "-o", "old.json").code == 0
    bank(packs, "edited")
    write(packs / "a.csv", "id,speaker,toy,Other (x)\n1,Ann,ta ta,ta\n3,Bob,mi,sa\n")
    told = two("-c", "facefx", "--against", "old.json").out.partition("since old.json:")[2]
    assert "in all: 5 to 3 left, 0.42 to 0.25 hours" in told
    assert "script in toy: 2 lines, 2 before; 1 added, 1 removed" in told
    assert "script in other: 2 lines, 2 before; 1 added, 1 removed, 1 changed" in told
    assert "changed: 1" in told


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.usefixtures("packs")
def test_a_document_without_a_total_is_still_written(form):
    old = coverage(lines("ta"), "toy", ["crab", "facefx"]).model_copy(update={"total": None})
    out = io.StringIO()
    FORMS.find(form)(old, out, FormOptions())
    assert "toy" in out.getvalue().lower()


@pytest.mark.usefixtures("packs")
def test_digests_of_documents_hold_no_text():
    document = coverage(lines("ta mi"), "toy", "crab").to_dict()
    assert "ta mi" not in json.dumps(document["corpus"])


def test_a_cast_needs_known_characters(cli, game):
    project = (game / "lipsync.yaml").read_text("utf-8").replace("arkit", "nobody")
    write(game / "lipsync.yaml", project)
    ended = cli("coverage")
    assert ended.code == 2
    assert "nobody" in ended.err


@pytest.mark.usefixtures("packs")
def test_nothing_named_is_nothing_counted(cli):
    ended = cli("coverage", "-l", "toy", "-c", "crab")
    assert ended.code == 2
    assert "there is no script to count; name a file, or state `lines`" in ended.err


def test_weights_that_are_all_zero_are_refused(two):
    ended = two("-c", "facefx", "--weight", "toy=0", "--weight", "other=0")
    assert ended.code == 2
    assert "all weights are 0" in ended.err
    with pytest.raises(LipsyncError):
        coverage([], "toy", "facefx")


def test_the_page_begins_with_the_total(two):
    page = two("-c", "facefx", "--format", "html").out
    lead = page.partition('<p class="lead">')[2]
    assert lead.startswith("<strong>5\N{NO-BREAK SPACE}bigrams, 25\N{NO-BREAK SPACE}min</strong>")
    assert "The first hour gives <strong>100\N{NO-BREAK SPACE}%</strong>" in lead


def test_the_page_ranks_the_work_of_all_languages_and_each_face(two):
    shown = two("-c", "facefx", "-c", "crab", "--format", "html").out
    told = json.loads(two("-c", "facefx", "-c", "crab", "--json").out)["total"]
    section = shown.partition('<section id="total">')[2].partition("</section>")[0]
    ranked = re.findall(r"<tr><td>(\d+)</td><td><b>([^<]+)</b></td>", section)
    assert ranked == [(str(n), item["bigram"]) for n, item in enumerate(told["ranking"], 1)]
    assert len(ranked) > 1
    assert re.findall(r'<th scope="row">([^<]+)</th>', section) == ["facefx", "crab"]


def test_bigrams_of_the_first_hour_are_the_first_rows_and_name_their_pose_set(two):
    for faces, several in ((("facefx",), False), (("facefx", "crab"), True)):
        pairs = [word for face in faces for word in ("-c", face)]
        page = two(*pairs, "--format", "html").out
        lead = page.partition('<p class="lead">')[2].partition("</ul>")[0]
        chips = re.findall(r"<li>([^<]+)(?: <small>([^<]+)</small>)?</li>", lead)
        rows = re.findall(
            r"<tr><td>\d+</td><td><b>([^<]+)</b></td>(?:<td>[^<]*</td>){3}<td>([^<]+)", page
        )
        assert chips == [(name, face if several else "") for name, face in rows[: len(chips)]]
        assert f"the first {len(chips)}\N{NO-BREAK SPACE}row" in lead
        assert len(set(chips)) == len(chips)


def test_the_page_tells_what_changed(two, packs):
    assert two("-c", "facefx", "-o", "old.json").code == 0
    bank(packs, "edited")
    write(packs / "a.csv", "id,speaker,toy,Other (x)\n1,Ann,ta ta,ta\n3,Bob,mi,sa\n")
    shown = two("-c", "facefx", "--against", "old.json", "--format", "html").out
    section = shown.partition('<section id="since">')[2].partition("</section>")[0]
    assert "Since old.json" in section
    assert "1 added, 1 removed, 0 changed" in section
    assert "and 3 are left now" in section
    assert '<section id="since">' not in two("-c", "facefx", "--format", "html").out
