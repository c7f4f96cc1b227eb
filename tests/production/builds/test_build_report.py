"""Reports of a build: causes of failure, the worst lines first, and small, safe pages."""

import json
import re
import xml.etree.ElementTree as ET
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.files.quoting import shell_command
from lipsync_lang.production.builds import build_tally
from lipsync_lang.production.builds.build_reports import write_report
from lipsync_lang.production.builds.build_tally import (
    BINS,
    BuildHeading,
    BuildTally,
    CountedLine,
    share_of_limit,
)
from lipsync_lang.production.builds.making import TIMING_DOUBT
from lipsync_lang.production.builds.planned_line import BuiltLine, JudgedFigure, PlannedLine
from lipsync_lang.schedules.schedule import DOUBTFUL

LANGUAGES, CHARACTERS = ("english", "german"), ("facefx", "crab", "arkit")
HEADING = BuildHeading("The Long Night", 3, 17, ("takes/kept.csv",), 12.5)


def made(number=0, *, lips=0.0, speed=10.0, confidence=None, failed=False, **plan):
    """Return a line of a build with two limited figures and one without a limit."""
    left_out = plan.pop("left_out", ())
    known = {
        "name": f"l{number}",
        "language": LANGUAGES[number % 2],
        "character": CHARACTERS[number % 3],
        "text": "Nobody moves.",
        "speaker": "anna",
        "place": f"script.csv:{number + 2}",
        "timings": Path("vo/l.TextGrid"),
        "audio": None,
        "outputs": (("csv", f"takes/{number}.csv"),),
    }
    line = PlannedLine(**(known | plan))
    if failed:
        return BuiltLine(line, "failed", f"{line.place}: no label 'Q'")
    figures = (
        JudgedFigure("contacts lips", lips, "of sounds", 0.0, (1.25,), "m stays open"),
        JudgedFigure("speed", speed, "per second", 12.0, (0.5,), "open moves fast"),
        JudgedFigure("turns", 7.0, "per second", None),
        JudgedFigure("lead_missing", None, "s", 0.05, (), "fewer than 3 sounds"),
    )
    return BuiltLine(line, "built", "", 3.0, confidence, figures, left_out)


def write(*paths_lines_heading, pages=None):
    """Count lines and write reports of them; return the counts."""
    *paths, lines, heading = paths_lines_heading
    counted = [*map(CountedLine.of, lines)]
    tally = BuildTally(counted)
    write_report(paths, counted, heading, tally, pages=pages)
    return tally


@pytest.fixture
def report(tmp_path):
    """Write a report of lines and return its text."""

    def written(lines, suffix=".html", heading=HEADING, pages=None):
        path = tmp_path / "build" / f"report{suffix}"
        write(path, lines, heading, pages=pages and (lambda _: pages))
        return path.read_text("utf-8")

    return written


# Counts


def test_a_build_fails_by_a_failed_line_or_a_limit():
    for lines, passed in (
        ([], True),
        ([made()], True),
        ([made(), made(1, speed=12.0)], True),
        ([made(), made(1, speed=12.5)], False),
        ([made(lips=0.1)], False),
        ([made(failed=True)], False),
    ):
        tally = BuildTally(map(CountedLine.of, lines))
        assert tally.passed() is passed


def badness(line):
    """Return the order of a line alone, which the tally computes for many at once."""
    confidence = 1.0 if line.confidence is None else line.confidence
    most = max(map(share_of_limit, line.failed or line.figures), default=0.0)
    if line.outcome == "failed":
        return 4.0, most, 1 - confidence
    if line.unsure:
        return 3.0, 1 - confidence, most
    return 2.0 if line.failed else float(bool(line.left_out)), most, 1 - confidence


@given(
    st.lists(
        st.builds(
            made,
            st.integers(0, 5),
            lips=st.sampled_from([0.0, 0.0, 0.25, 1.0]),
            speed=st.floats(0, 40),
            confidence=st.none() | st.floats(0, 1),
            failed=st.booleans(),
            left_out=st.sampled_from([(), ("big",)]),
        ),
        max_size=40,
    ),
    st.integers(0, 8),
)
@pytest.mark.parametrize("counted_at_once", [4096, 3])
def test_every_line_is_counted_and_the_worst_are_the_worst(counted_at_once, lines, most):
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(build_tally, "MAX_COUNTED_LINES", counted_at_once)
        tally = BuildTally(map(CountedLine.of, lines), most)
    assert tally.lines == len(lines) == sum(pair.lines for pair in tally.pairs.values())
    assert tally.failed == sum(line.outcome == "failed" for line in lines)
    assert tally.over == sum(bool(line.failed) for line in lines)
    assert tally.lacking == sum(bool(line.left_out) for line in lines)
    for figure in tally.figures.values():
        counts = figure.bars
        assert sum(counts) == figure.judged
        assert sum(counts[figure.within :]) == figure.over
    assert sum(tally.confidence) == tally.aligned
    expected = sorted(lines, key=badness, reverse=True)[:most]
    assert list(map(badness, tally.worst)) == list(map(badness, expected))
    assert [*tally.past_limits] == [one for one in tally.worst if one.failed or one.unsure]


def test_failed_lines_come_first_then_those_farthest_over_a_limit():
    lines = [
        made(0), made(1, speed=13.0), made(2, lips=0.5), made(3, failed=True), made(4, speed=30.0),
    ]  # fmt: skip
    tally = BuildTally(map(CountedLine.of, lines), 5)
    assert [line.line.name for line in tally.worst] == ["l3", "l2", "l4", "l1", "l0"]


def test_limits_of_different_faces_share_a_chart():
    lines = [made(0), made(1)]
    slower = lines[1].figures[1]._replace(limit=6.0)
    lines[1] = replace(lines[1], figures=(slower,))
    tally = BuildTally(map(CountedLine.of, lines))
    speed = tally.figures["speed", False]
    assert (speed.limit, speed.judged, speed.over) == (None, 2, 1)


# JUnit


def test_junit_has_a_suite_for_each_language_on_each_character(report):
    lines = [made(n) for n in range(12)] + [made(12, failed=True), made(13, speed=20.0)]
    root = ET.fromstring(report(lines, ".xml"))  # noqa: S314 our own
    assert {suite.get("name") for suite in root} == {
        f"{language} on {character}" for language in LANGUAGES for character in CHARACTERS
    }
    counts = {name: int(root.get(name)) for name in ("tests", "errors", "failures", "skipped")}
    assert counts == {"tests": 14, "errors": 1, "failures": 1, "skipped": 0}
    for name, number in counts.items():
        assert sum(int(suite.get(name)) for suite in root) == number
    assert root.find(".//error").get("message") == "script.csv:14: no label 'Q'"
    failure = root.find(".//failure")
    assert failure.get("message") == "speed 20 per second, at most 12"
    assert failure.text == "script.csv:15\nspeed: 0.500 s: open moves fast"
    assert {case.get("file") for case in root.iter("testcase")} == {"script.csv"}


def test_junit_skips_lines_whose_outputs_were_kept(report):
    kept = made(1, outputs=(("csv", "takes/kept.csv"),))
    root = ET.fromstring(report([made(0), kept], ".xml"))  # noqa: S314 our own
    (skipped,) = root.iter("skipped")
    assert skipped.get("message") == "kept, because it was changed: takes/kept.csv"


def test_junit_holds_any_text(report):
    odd = "\x00\x1b[31m<&>\"'\ud800\uffff ]]> ü"
    lines = [made(0, name=odd, language=odd), made(1, failed=True, place=odd + ":3")]
    lines.append(replace(made(2, lips=1.0), line=made(2, character=odd).line))
    root = ET.fromstring(report(lines, ".xml", replace(HEADING, project=odd)))  # noqa: S314 our own
    assert len([*root.iter("testcase")]) == len(lines)


def test_words_that_a_recording_lacks_are_listed(report):
    lines = [made(0, speed=11.0), made(1, left_out=("big", "dog")), made(2, speed=12.0)]
    told = ET.fromstring(report(lines, ".xml")).findall(".//system-out")  # noqa: S314 our own
    assert [one.text for one in told] == ["script.csv:3: l1 lacks big, dog"]
    document = json.loads(report(lines, ".json"))
    assert [row["left_out"] for row in document["rows"]] == [[], ["big", "dog"], []]
    assert document["lacking"] == 1
    assert "lack words" in report(lines)
    assert "lack words" not in report(lines[::2])
    assert BuildTally(map(CountedLine.of, lines), 1).worst == [lines[1]]


# JSON


def test_json_has_every_line(report):
    lines = [made(n, confidence=0.5) for n in range(4)] + [made(4, failed=True)]
    document = json.loads(report(lines, ".json"))
    rows = document.pop("rows")
    assert [row["line"] for row in rows] == [f"l{n}" for n in range(5)]
    assert rows[0]["figures"]["speed"] == {"value": 10.0, "limit": 12.0}
    assert rows[4]["message"] == "script.csv:6: no label 'Q'"
    assert (document["passed"], document["lines"], document["failed"]) == (False, 5, 1)
    assert document["confidence"] == pytest.approx(0.5)
    assert json.loads(report([], ".json"))["rows"] == []


# HTML


class Read(HTMLParser):
    """Elements of a page, and whether each is closed."""

    VOID = frozenset(("input", "link", "meta", "br"))

    def __init__(self, text):
        super().__init__()
        self.found, self.open, self.texts = [], [], []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)

    def every(self, tag):
        return [attributes for name, attributes in self.found if name == tag]


LINES = [made(n, confidence=n / 40) for n in range(30)] + [
    made(30, lips=0.5), made(31, speed=13.0), made(32, failed=True),
]  # fmt: skip


def test_a_page_is_whole_and_asks_for_nothing(report):
    text = report(LINES)
    page = Read(text)
    assert not re.search(r"https?://|@import|url\(|<img|<iframe", text)
    (policy,) = [m["content"] for m in page.every("meta") if "http-equiv" in m]
    script = re.search(r"<script>(.*?)</script>", text, re.DOTALL)[1]
    digest = b64encode(sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy
    assert text == report(LINES), "the same each time"


def test_a_page_says_what_its_charts_show(report):
    charts = Read(report(LINES)).every("svg")
    assert len(charts) == 3
    assert all(chart["role"] == "img" for chart in charts)
    names = [chart["aria-label"] for chart in charts]
    assert any(
        name.startswith("contacts lips. 31\N{NO-BREAK SPACE}lines within the limit, 1 over")
        for name in names
    )


def test_a_page_leads_to_the_pages_of_lines_or_gives_their_commands(report, tmp_path):
    worst = made(32, failed=True)
    pages = {worst.line.key: tmp_path / "build/report/german/l ü.html"}
    said = made(1, timings=None, text="It's -o; rm -rf")
    page = Read(report([worst, said], pages=pages))
    assert [link["href"] for link in page.every("a")] == ["report/german/l%20%C3%BC.html"]
    (command,) = [one["data-command"] for one in page.every("span") if "data-command" in one]
    parts = ["lipsync-lang", "run", "-l", "german", "-c", "crab", "-o", "l1.html", "--"]
    parts.append("It's -o; rm -rf")
    assert command == shell_command(parts)


def test_a_page_does_not_grow_with_its_lines(report, monkeypatch):
    monkeypatch.setattr(build_tally, "MAX_WORST", 5)
    monkeypatch.setattr(BuildTally.__init__, "__defaults__", (5,))
    few = report([made(n, speed=11.0) for n in range(50)])
    many = report([made(n % 50, speed=11.0) for n in range(3000)])
    assert few.count("<tr data-figures") == many.count("<tr data-figures") == 5
    assert abs(len(few) - len(many)) < 500
    assert "The worst 5 of 3,000 lines" in many


@pytest.mark.parametrize("field", ["name", "text", "speaker", "place", "language", "character"])
def test_no_text_of_a_script_becomes_markup(report, field):
    hostile = "<script>alert(1)</script>\"'><b>"
    page = Read(report([made(1, **{field: hostile}), made(2, failed=True)]))
    assert len(page.every("script")) == 1
    assert not any("onerror" in attributes for _, attributes in page.found)
    assert hostile in "".join(page.texts)


def test_a_page_of_no_lines_and_of_sound_lines_says_so(report):
    assert "The project has no lines." in report([], heading=BuildHeading("x", 0, 0))
    text = report([made()])
    assert "Every line is made and within its limits. The build passes." in text


def test_what_only_the_face_advises_fails_nothing(report):
    line = made(1, speed=20.0)
    advice = tuple(figure._replace(binding=False) for figure in line.figures)
    text = report([replace(line, figures=advice)])
    assert "The build fails." not in text
    assert "it exceeds the recommended limits of the pose set" in text


# Files


def test_every_form_is_written_in_one_pass(tmp_path):
    paths = [tmp_path / "a" / "b" / name for name in ("r.html", "r.xml", "r.json")]
    tally = write(*paths, LINES, HEADING)
    assert all(path.stat().st_size for path in paths)
    assert (tally.lines, tally.failed, tally.over) == (33, 1, 2)


def test_a_suffix_that_no_report_has_is_named_before_anything_is_written(tmp_path):
    paths = [tmp_path / "r.html", tmp_path / "r.pdf"]
    with pytest.raises(OutputError, match=r"a report cannot be written as '.pdf'; use .html"):
        write(*paths, [made()], HEADING)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="file: cannot be written: "):
        write(tmp_path / "file" / "r.xml", [made()], HEADING)


def test_bars_of_few_lines_are_seen():
    from lipsync_lang.production.builds.build_reports import LEAST_BAR, figure_bars

    lines = [*map(made, range(2000)), made(1, speed=13.0)]
    tally = BuildTally(map(CountedLine.of, lines))
    bars = figure_bars(tally.figures["speed", False])
    assert f"v-{LEAST_BAR}h8" in bars.over
    assert bars.within.count("M") + bars.over.count("M") <= BINS


# Doubtful lines


def aligned(number, confidence, **figures):
    """Return a line as it is made from a recording, without a limit of confidence."""
    line = made(number, confidence=confidence, **figures)
    doubt = JudgedFigure(TIMING_DOUBT, 1 - confidence, "", 1 - DOUBTFUL, binding=False)
    return replace(line, figures=(*line.figures, doubt))


def test_lines_unlike_their_recordings_come_first_by_confidence(report):
    lines = [aligned(1, 0.9, speed=12.6), aligned(2, 0.4), aligned(3, 0.0), aligned(4, 0.02)]
    tally = BuildTally(map(CountedLine.of, [*lines, made(5, lips=0.9), made(6, failed=True)]))
    assert [one.line.name for one in tally.worst] == ["l6", "l3", "l4", "l2", "l5", "l1"]
    assert tally.unsure == 3
    rows = re.findall(r'<span class="name"[^>]*>(\w+)<', report(lines))
    assert rows == ["l3", "l4", "l2", "l1"]


def test_no_headline_says_that_a_build_with_doubtful_lines_passes(report):
    sound = aligned(1, 0.9)
    assert "The build passes." in report([sound])
    text = report([sound, aligned(2, 0.1)])
    assert "passes" not in text.split("<script>")[0].split("</header>")[0]
    assert "1\N{NO-BREAK SPACE}recording may not hold the text of the line." in text
    assert "1\N{NO-BREAK SPACE}recording" in text.split('<strong class="bad">')[1]
    advised = JudgedFigure("speed", 13.0, "per second", 12.0, binding=False)
    text = report([sound, replace(sound, figures=(advised,))])
    assert "it exceeds the recommended limits of the pose set" in text
    many = [replace(made(number), figures=(advised,)) for number in range(3, 145)]
    text = report([*many, aligned(1, 0.0), aligned(2, 0.11)]).split("</header>")[0]
    first, second = text.split("2\N{NO-BREAK SPACE}recordings may not hold the text of the lines.")
    assert "142" not in first.split('class="lead"')[1]
    assert "142\N{NO-BREAK SPACE}other lines are doubtful" in second
    assert json.loads(report([sound, aligned(2, 0.1)], ".json"))["doubtful"] == 1
