"""Reports of studies: counted answers, answers set aside with a reason, and formats."""

import json
import re
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st
from study_answers import crowd, model, placed, study_of, submission

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.plugins.study.answer_sorting import SortingRules, reasons, sort_answers
from lipsync_lang.plugins.study.comparisons import chi_square_tail
from lipsync_lang.plugins.study.preference_page import report_page
from lipsync_lang.plugins.study.study_file import answer_files
from lipsync_lang.plugins.study.study_report import report_study
from lipsync_lang.plugins.study.study_text import probability, report_text

REASONS = set(SortingRules().words)


def by_taste(pair, question):
    """Prefer `ours` except in every third pair, so that sides and methods vary."""
    del question
    return (pair["left"] == "ours") != (int(pair["pair"][1:]) % 3 == 0)


def sorted_from(folder, study, submissions, rules=None, name="answers.jsonl"):
    placed(folder, study, submissions, name)
    return sort_answers([folder / name], model(study), rules)


def changed(study, number=1, /, **changes):
    return submission(study, number, by_taste) | changes


def with_answers(study, change, number=1):
    """Return a submission after a function has changed its answers."""
    one = submission(study, number, by_taste)
    change(one["answers"])
    return one


def accounted(found):
    """Check that every submission and answer is counted exactly once."""
    whole = sum(one.submissions for one in found.set_aside)
    single = sum(one.answers for one in found.set_aside)
    assert found.submissions == found.raters + whole
    assert found.answers == len(found.choices) + found.checks + single
    assert {one.reason for one in found.set_aside} <= REASONS
    return reasons(found.set_aside)


SOUND = study_of(lines=12, checks=2)
PAIRS = len(SOUND["pairs"])


def test_sound_answers_all_count(tmp_path):
    found = sorted_from(tmp_path, SOUND, [changed(SOUND, n) for n in range(3)])
    assert accounted(found) == {}
    assert (found.raters, len(found.choices), found.checks) == (3, 36, 6)
    assert {one.line for one in found.choices} == {f"line_{n:02}" for n in range(12)}


def edit(place, **changes):
    def change(answers):
        answers[place].update(changes)

    return change


def wrong_check(answers):
    for pair, answer in zip(SOUND["pairs"], answers, strict=True):
        if pair["check"]:
            answer["choice"] = "right" if pair["check"] == "left" else "left"


ALL_LEFT = study_of(lines=12)


def fast(count):
    def change(answers):
        for answer in answers[:count]:
            answer["seconds"] = 1.5

    return change


SUBMISSIONS = {
    "another study's": (changed(SOUND, study="f" * 16), "other study", PAIRS),
    "no study's": (changed(SOUND, study=None), "other study", PAIRS),
    "without consent": (changed(SOUND, consent=False), "no consent", PAIRS),
    "with consent as a word": (changed(SOUND, consent="yes"), "no consent", PAIRS),
    "unfinished": (changed(SOUND, finished=None), "unfinished", PAIRS),
    "finished without all pairs": (
        with_answers(SOUND, lambda answers: answers.pop()),
        "unfinished",
        PAIRS - 1,
    ),
    "of another kind": (changed(SOUND, kind="study"), "no answers", PAIRS),
    "of a later format": (changed(SOUND, format=2), "no answers", PAIRS),
    "without a rater": (changed(SOUND, rater=7), "no answers", PAIRS),
    "without a list": (changed(SOUND, answers={"p001": "left"}), "no answers", 0),
    "wrong in a check": (with_answers(SOUND, wrong_check), "failed checks", PAIRS),
    "hurried": (with_answers(SOUND, fast(8)), "fast rater", PAIRS),
    "damaged in every answer": (
        with_answers(SOUND, lambda answers: [one.update(strength=9) for one in answers]),
        "nothing left",
        PAIRS,
    ),
    "of pairs that are not there": (
        with_answers(SOUND, lambda answers: [one.update(pair="x") for one in answers]),
        "unfinished",
        PAIRS,
    ),
    "a number": (7, "no answers", 0),
    "a list": ([], "no answers", 0),
}
"""Submissions that are set aside as a whole: the reason, and the number of answers."""


@pytest.mark.parametrize("name", sorted(SUBMISSIONS))
def test_a_submission_that_does_not_count_is_named(name, tmp_path):
    bad, reason, answers = SUBMISSIONS[name]
    found = sorted_from(tmp_path, SOUND, [changed(SOUND, 2), bad, changed(SOUND, 3)])
    assert accounted(found) == {reason: (1, answers)}
    (told,) = found.set_aside
    assert told.place == f"{tmp_path / 'answers.jsonl'}:2"
    assert told.words
    assert found.raters == 2


ANSWERS = {
    "a strength of 0": (edit(0, strength=0), "out of range"),
    "a strength of 6": (edit(0, strength=6), "out of range"),
    "a strength in words": (edit(0, strength="5"), "out of range"),
    "a strength of half a point": (edit(0, strength=2.5), "out of range"),
    "no side": (edit(0, choice="both"), "out of range"),
    "no time": (edit(0, seconds=float("nan")), "out of range"),
    "a negative time": (edit(0, seconds=-1), "out of range"),
    "another field": (edit(0, note="hello"), "out of range"),
    "another pair": (
        lambda answers: answers.append(answers[0] | {"pair": "p999"}),
        "unknown pair",
    ),
    "another question": (edit(0, question="naturalness"), "unknown pair"),
    "a second answer": (lambda answers: answers.append(dict(answers[0])), "answered twice"),
    "no answer at all": (lambda answers: answers.append(None), "out of range"),
    "a glance": (edit(0, seconds=1.9), "too fast"),
}
"""Answers that are set aside individually, and the reason."""


@pytest.mark.parametrize("name", sorted(ANSWERS))
def test_an_answer_that_does_not_count_is_named(name, tmp_path):
    change, reason = ANSWERS[name]
    found = sorted_from(tmp_path, SOUND, [with_answers(SOUND, change)])
    assert accounted(found) == {reason: (0, 1)}
    assert found.raters == 1
    assert found.set_aside[0].rater == f"{1:016x}"


def test_every_reason_is_tried():
    tried = {reason for _, reason, *_ in SUBMISSIONS.values()}
    tried |= {reason for _, reason in ANSWERS.values()}
    assert REASONS - tried == {"unreadable", "repeated", "copied", "one side"}


def test_the_first_complete_submission_of_a_rater_counts(tmp_path):
    early = changed(SOUND, finished=None)
    complete = changed(SOUND)
    found = sorted_from(tmp_path, SOUND, [early, *[complete] * 100])
    assert accounted(found) == {"repeated": (100, 100 * PAIRS)}
    assert found.raters == 1
    assert all(":2 comes first" in one.words for one in found.set_aside)


def test_unfinished_raters_count_if_asked(tmp_path):
    part = with_answers(SOUND, lambda answers: answers.__delitem__(slice(5, None)))
    less = with_answers(SOUND, lambda answers: answers.__delitem__(slice(3, None)))
    rules = SortingRules(keep_unfinished=True)
    found = sorted_from(tmp_path, SOUND, [less | {"finished": None}, part], rules)
    assert accounted(found) == {"repeated": (1, 3)}
    assert (found.raters, found.unfinished, len(found.choices)) == (1, 1, 5)
    assert found.unchecked == 1, "the checks come last"


def test_the_page_of_a_rater_who_sees_fewer_pairs_is_complete(tmp_path):
    study = SOUND | {"raters_see": 5}
    part = with_answers(study, lambda answers: answers.__delitem__(slice(5, None)))
    found = sorted_from(tmp_path, study, [part])
    assert accounted(found) == {}
    assert found.raters == 1


def test_a_rater_who_takes_one_side_is_set_aside(tmp_path):
    taken = [submission(ALL_LEFT, 1, lambda *_: True)]
    found = sorted_from(tmp_path, ALL_LEFT, taken)
    assert accounted(found) == {"one side": (1, 12)}
    kept = sorted_from(tmp_path, ALL_LEFT, taken, SortingRules(one_side=13))
    assert kept.raters == 1
    assert sorted_from(tmp_path, ALL_LEFT, taken, SortingRules(one_side=0)).raters == 1


def test_checks_may_be_failed_as_often_as_stated(tmp_path):
    failing = with_answers(SOUND, wrong_check)
    for allowed, raters in ((0, 0), (1, 0), (2, 1)):
        rules = SortingRules(failed_checks=allowed)
        assert sorted_from(tmp_path, SOUND, [failing], rules).raters == raters


def test_the_least_time_is_the_clips_or_stated(tmp_path):
    hurried = with_answers(SOUND, fast(PAIRS))
    assert sorted_from(tmp_path, SOUND, [hurried]).raters == 0
    assert sorted_from(tmp_path, SOUND, [hurried], SortingRules(least_seconds=1.5)).raters == 1
    unknown = study_of(lines=12, seconds=None)
    assert sorted_from(tmp_path, unknown, [with_answers(unknown, fast(12))]).raters == 1


@pytest.mark.parametrize("quick", ["accuracy", "naturalness"])
def test_the_time_of_a_pair_is_that_of_its_later_answer(quick, tmp_path):
    study = study_of(lines=6, questions=("accuracy", "naturalness"))
    one = submission(study, 1, by_taste)
    for answer in one["answers"]:
        answer["seconds"] = 0.5 if answer["question"] == quick else 4
    assert accounted(sorted_from(tmp_path, study, [one])) == {}


def test_copies_under_other_names_are_set_aside_and_likeness_is_suspicious(tmp_path):
    one = changed(SOUND)
    copies = [one | {"rater": f"{n:016x}"} for n in range(2, 40)]
    slower = with_answers(SOUND, lambda a: [x.update(seconds=x["seconds"] + 1) for x in a], 99)
    found = sorted_from(tmp_path, SOUND, [one, *copies, slower])
    assert accounted(found) == {"copied": (38, 38 * PAIRS)}
    assert found.raters == 2
    (suspicious,) = found.suspicious
    assert suspicious.startswith(f"2 raters gave the same {PAIRS} choices and strengths")


# Files

DAMAGE = {
    "cut off": (lambda text: text[: len(text) // 2], 1),
    "empty": (lambda _: "", 1),
    "not JSON": (lambda _: "rater,choice\n1,left\n", 1),
    "no text": (lambda _: b"\xff\xfe\x00\x01", 1),
    "deep": (lambda _: "[" * 100_000, 1),
}


@pytest.mark.parametrize("name", sorted(DAMAGE))
@pytest.mark.parametrize("indent", [None, 1])
def test_a_damaged_file_is_one_that_is_not_read(name, indent, tmp_path):
    damage, count = DAMAGE[name]
    placed(tmp_path, SOUND, [])
    content = damage(json.dumps(changed(SOUND), indent=indent))
    file = tmp_path / "damaged.json"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    found = sort_answers([file], model(SOUND))
    assert accounted(found) == {"unreadable": (count, 0)}
    assert found.set_aside[0].place == str(file)


def test_a_file_of_one_submission_is_named_without_a_line(tmp_path):
    found = sorted_from(tmp_path, SOUND, [changed(SOUND, consent=False)])
    assert [one.place for one in found.set_aside] == [str(tmp_path / "answers.jsonl")]


def test_a_damaged_line_leaves_the_others(tmp_path):
    placed(tmp_path, SOUND, [changed(SOUND, n) for n in range(4)])
    file = tmp_path / "answers.jsonl"
    lines = file.read_text().splitlines()
    file.write_text("\n".join([lines[0][:90], lines[1], "", lines[2], lines[3][:400]]))
    found = sort_answers([file], model(SOUND))
    assert accounted(found) == {"unreadable": (2, 0)}
    assert [one.place.rpartition(":")[2] for one in found.set_aside] == ["1", "5"]
    assert found.raters == 2


def test_files_of_both_kinds_and_folders_are_read(tmp_path):
    placed(tmp_path, SOUND, [changed(SOUND, n) for n in range(3)])
    (tmp_path / "answers").mkdir()
    for n, indent in ((7, 1), (8, None)):
        text = json.dumps(changed(SOUND, n), indent=indent)
        (tmp_path / "answers" / f"{n}.json").write_text(f"\ufeff{text}\r\n", "utf-8")
    (tmp_path / "answers" / "read.me").write_text("not one of them")
    assert report_study(tmp_path).answers.raters == 5
    assert report_study(tmp_path / "study.json").answers.raters == 5
    assert report_study(tmp_path, [tmp_path / "answers"]).answers.raters == 2
    twice = [tmp_path / "answers", tmp_path / "answers" / "7.json"]
    assert len(answer_files(twice)) == 2, "each file is read once"


def test_a_file_that_is_missing_is_named_and_a_folder_without_answers_refused(tmp_path):
    placed(tmp_path, SOUND, [changed(SOUND)])
    found = sort_answers([tmp_path / "gone.json", tmp_path / "answers.jsonl"], model(SOUND))
    assert accounted(found) == {"unreadable": (1, 0)}
    (tmp_path / "empty").mkdir()
    with pytest.raises(LipsyncError, match=r"contains no \.json or \.jsonl file"):
        report_study(tmp_path, [tmp_path / "empty"])


@given(st.lists(st.sampled_from(sorted({*SUBMISSIONS, *ANSWERS, "sound", "cut"})), max_size=8))
def test_whatever_is_wrong_everything_is_counted_once(tmp_path_factory, kinds):
    lines = []
    for number, kind in enumerate(kinds):
        if kind in SUBMISSIONS:
            lines.append(json.dumps(SUBMISSIONS[kind][0]))
        elif kind in ANSWERS:
            lines.append(json.dumps(with_answers(SOUND, ANSWERS[kind][0], number)))
        else:
            text = json.dumps(changed(SOUND, number))
            lines.append(text[:80] if kind == "cut" else text)
    file = tmp_path_factory.mktemp("answers") / "answers.jsonl"
    file.write_text("\n".join(lines), "utf-8")
    found = sort_answers([file], model(SOUND))
    accounted(found)
    if any(kind in SUBMISSIONS or kind in ANSWERS or kind == "sound" for kind in kinds):
        assert found.submissions == len(kinds)


# The paper

PAPER = {"cartoon": 147, "high": 134, "male": 123, "female": 139}
"""Choices of 200 for the paper's method: differences of 47, 34, 23 and 39 % (section 4.2)."""

PRINTED = {"cartoon": 44.14, "high": 23.12, "male": 10.58, "female": 30.42}
"""Its chi-squares, "on 2 degrees of freedom"."""

STRENGTHS = {"cartoon": (4.03, 3.70), "high": (3.97, 3.80), "male": (3.54, 3.60)}
STRENGTHS["female"] = (3.62, 3.7)


@pytest.fixture(scope="module")
def paper(tmp_path_factory):
    """A study of the paper's size and counts: 4 characters, 10 lines, 20 raters for each."""
    study = study_of(("ours", "facefx"), sorted(PAPER), 10)
    submissions = []
    for place, character in enumerate(sorted(PAPER)):
        seen = [pair for pair in study["pairs"] if pair["character"] == character]
        for rater in range(20):
            one = submission({**study, "pairs": seen}, 100 * place + rater, by_taste)
            for n, (pair, answer) in enumerate(zip(seen, one["answers"], strict=True)):
                # the 200 choices are spread over raters as evenly as can be
                ours = (20 * n + (rater + 7 * n) % 20) % 200 < PAPER[character]
                ours_left = pair["left"] == "ours"
                answer["choice"] = "left" if ours == ours_left else "right"
            submissions.append(one)
    study["raters_see"] = 10
    folder = placed(tmp_path_factory.mktemp("paper"), study, submissions)
    report = report_study(folder, rules=SortingRules(one_side=0))
    return {one.character: one for one in report.comparisons if one.character}


def test_three_of_the_papers_results_are_those_of_two_categories(paper):
    found = {name: (one.choices, one.for_first) for name, one in paper.items()}
    assert found == {name: (200, count) for name, count in PAPER.items()}
    same = {name for name, one in paper.items() if round(one.chi_square, 2) == PRINTED[name]}
    assert same == {"high", "male", "female"}
    assert paper["cartoon"].chi_square == pytest.approx(44.18)
    differences = {name: round(100 * one.difference) for name, one in paper.items()}
    assert differences == {"cartoon": 47, "high": 34, "male": 23, "female": 39}


def two_categories(statistic, number):
    """Return the counts of two categories that give a printed chi-square."""
    return [
        (wins, number - wins)
        for wins in range((number + 1) // 2, number + 1)
        if abs((2 * wins - number) ** 2 / number - statistic) <= 0.005 + 1e-9
    ]


def three_categories(statistic, number):
    """Return the counts of two methods and "no preference" that give a printed chi-square."""
    return [
        (first, second, number - first - second)
        for first in range(number + 1)
        for second in range(min(first, number - first) + 1)
        if abs(
            3 / number * (first**2 + second**2 + (number - first - second) ** 2)
            - number
            - statistic
        )
        <= 0.005 + 1e-9
    ]


def test_no_counts_of_200_give_the_papers_first_result():
    for name, statistic in PRINTED.items():
        found = two_categories(statistic, 200)
        assert found == ([] if name == "cartoon" else [(PAPER[name], 200 - PAPER[name])])
        assert three_categories(statistic, 200) == [], "nor of three categories, for any of them"


def test_no_other_number_of_choices_gives_the_papers_first_result():
    near = [
        (wins, losses)
        for number in range(2, 1001)
        for wins, losses in two_categories(44.14, number)
        if abs(100 * (wins - losses) / number - 47) <= 1
    ]
    assert near == []


def test_one_of_the_papers_probabilities_holds_for_one_degree_of_freedom_only():
    one, two = ({n: chi_square_tail(x, f) for n, x in PRINTED.items()} for f in (1, 2))
    assert all(p < 0.005 for p in one.values())
    assert {name for name, p in two.items() if p >= 0.005} == {"male"}
    assert two["male"] == pytest.approx(0.00504, abs=1e-5)
    assert one["male"] == pytest.approx(0.00114, abs=1e-5)


def test_the_papers_mean_strengths_fit_its_counts():
    for name, means in STRENGTHS.items():
        for count, mean in zip((PAPER[name], 200 - PAPER[name]), means, strict=True):
            digits = 1 if mean == 3.7 and name == "female" else 2
            assert any(
                round(total / count, digits) == mean
                for total in range(int(count * mean) - 5, int(count * mean) + 6)
            )


def test_likeness_of_a_raters_choices_could_undo_the_papers_third_result():
    def p(correlation):
        return chi_square_tail(10.58 / (1 + 9 * correlation), 1)

    assert p(0.1) == pytest.approx(0.018, abs=5e-4)
    assert p(0.19) < 0.05 < p(0.2)


# Forms


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study of three methods, in which some answers are set aside."""
    study = study_of(("ours", "theirs", "keys"), ("anna", "ben"), 4, checks=2)
    study["title"] = "<b>A & B</b>"
    study["methods"][2] = "<i>keys"
    for pair in study["pairs"]:
        for side in ("left", "right"):
            pair[side] = pair[side].replace("keys", "<i>keys")
    people = crowd(study, 12, 0.7, spread=0.1)
    people[3]["study"] = "<script>alert(1)</script>"
    people[4]["answers"][0]["strength"] = 9
    return placed(tmp_path_factory.mktemp("study") / "study", study, people)


def test_the_report_says_what_was_set_aside_in_every_form(folder):
    report = report_study(folder)
    data = report.to_dict()
    assert {one["reason"] for one in data["set_aside"]} == {"other study", "out of range"}
    for text in (report_text(report), report_page(report)):
        for one in data["set_aside"]:
            assert one["reason"] in text
            assert one["rule"] in text
    assert data["counted"]["raters"] == 11
    assert data["read"] == {"submissions": 12, "answers": 12 * 26}


def test_a_report_of_three_methods_compares_and_ranks_them(folder):
    data = report_study(folder).to_dict()
    assert len(data["comparisons"]) == 3 * 3, "each two methods, by anna, ben and both"
    assert len(data["rankings"]) == 3
    assert {one["method"] for one in data["rankings"][0]["methods"]} == set(data["methods"])


def test_json_holds_plain_values_and_the_reference_names_each(folder, root):
    data = json.loads(json.dumps(report_study(folder).to_dict(), allow_nan=False))
    told = (root / "docs/reference/study-report.md").read_text("utf-8")

    def keys(value):
        if isinstance(value, dict):
            for key, inner in value.items():
                yield key
                yield from keys(inner)
        for inner in value if isinstance(value, list) else ():
            yield from keys(inner)

    assert {key for key in keys(data) if f"`{key}`" not in told} == set()


class Page(HTMLParser):
    """Elements of a page, and their references."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.links = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.links += [value for name, value in attributes if name in ("src", "href", "action")]


def test_few_raters_are_told_what_they_can_never_show(tmp_path):
    placed(tmp_path, SOUND, [changed(SOUND, n) for n in range(5)])
    notes = " ".join(report_study(tmp_path).notes)
    assert "with 5 raters or lines, p cannot be below 0.062" in notes
    placed(tmp_path, SOUND, [changed(SOUND, 0)])
    assert "with 1 rater or line, p cannot be below 1;" in " ".join(report_study(tmp_path).notes)
    placed(tmp_path, SOUND, [changed(SOUND, n) for n in range(6)])
    assert "never below" not in " ".join(report_study(tmp_path).notes)


@pytest.mark.parametrize(("value", "told"), [
    (0.5, "0.500"),
    (0.0123, "0.012"),
    (0.0051, "0.0051"),
    (0.00009, "< 0.0001"),
])  # fmt: skip
def test_probabilities_have_the_digits_that_matter(value, told):
    assert probability(value) == told


def test_the_page_asks_for_nothing_and_runs_nothing(folder):
    text = report_page(report_study(folder))
    page = Page(text)
    assert page.links == ["data:,"]
    assert "script" not in page.tags
    assert "default-src 'none'" in text
    assert page.tags.count("svg") == 2 * 9 + 3 * 3


def test_no_text_of_answers_becomes_markup_of_a_studys_report(folder):
    text = report_page(report_study(folder))
    assert "<b>A" not in text
    assert "<i>keys" not in text
    assert "alert(1)&lt;/script&gt;" in text


def test_the_page_of_a_studys_report_is_for_phones_and_the_dark(folder):
    text = report_page(report_study(folder))
    assert 'name="viewport"' in text
    assert "prefers-color-scheme: dark" in text
    assert "max-width: 40rem" in text


def test_the_text_of_a_report(tmp_path, root):
    study = study_of(lines=10, checks=1)
    people = [submission(study, n, by_taste, strength=n % 5 + 1) for n in range(8)]
    people[1]["answers"][2]["choice"] = "right"
    people[1]["answers"][3]["choice"] = "left"
    people[2]["consent"] = False
    placed(tmp_path, study, people)
    text = report_text(report_study(tmp_path)).replace(str(tmp_path), "study")
    golden = root / "tests/plugins/study/study_report.txt"
    assert text == golden.read_text("utf-8")


# The commands


def test_a_report_is_printed_or_written_by_its_suffix(folder, cli, tmp_path):
    shown = cli("study", "report", folder)
    assert shown.code == 0
    assert "accuracy: ours against theirs" in shown.out
    for suffix, start in ((".html", "<!DOCTYPE html>"), (".json", "{"), (".txt", "<b>A & B</b>")):
        out = tmp_path / f"report{suffix}"
        ended = cli("study", "report", folder, "-o", out)
        assert (ended.code, ended.out) == (0, "")
        assert ended.err == f"wrote {out}\n"
        assert out.read_text("utf-8").lstrip().startswith(start)
    assert json.loads(cli("study", "report", folder, "--json").out)["format"]
    assert cli("study", "report", folder, "--format", "html", "-o", "-").out.lstrip()[:2] == "<!"


def test_a_report_in_the_folder_of_its_study_is_no_answer(cli, tmp_path):
    placed(tmp_path, SOUND, [changed(SOUND)])
    for _ in range(2):
        assert cli("study", "report", tmp_path, "-o", tmp_path / "report.json").code == 0
    data = json.loads((tmp_path / "report.json").read_text("utf-8"))
    assert data["read"]["submissions"] == 1
    assert data["set_aside"] == []


def test_the_options_of_a_report_reach_its_rules(folder, cli):
    options = ("--failed-checks", "2", "--least-seconds", "0.5", "--one-side", "0")
    ended = cli("study", "report", folder, "--json", "--keep-unfinished", *options)
    assert json.loads(ended.out)["rules"] == {
        "failed_checks": 2,
        "keep_unfinished": True,
        "least_seconds": 0.5,
        "one_side": 0,
    }


def test_a_study_without_choices_is_a_fault(cli, tmp_path):
    placed(tmp_path, SOUND, [changed(SOUND, consent=False)])
    ended = cli("study", "report", tmp_path)
    assert ended.code == 1
    assert "no consent" in ended.out
    assert "no choice counts" in ended.err
    assert cli("study", "report", tmp_path, "--format", "html").code == 1


WRONG = {
    "no study": (("nowhere",), "nowhere: cannot be read"),
    "another form": (("{}", "--format", "pdf"), "--format pdf: known: html, json, text"),
    "a negative number": (("{}", "--one-side", "-1"), "--one-side -1: give 0 or more"),
    "no number": (("{}", "--least-seconds", "nan"), "--least-seconds nan: give 0 or more"),
    "its own answers": (("{}", "-o", "{}/answers.jsonl"), "is a file of the study"),
    "its own key": (("{}", "-o", "{}/study.json"), "is a file of the study"),
}


@pytest.mark.parametrize("name", sorted(WRONG))
def test_a_report_that_cannot_be_is_told(name, folder, cli):
    arguments, told = WRONG[name]
    before = [path.read_bytes() for path in sorted(folder.iterdir())]
    ended = cli("study", "report", *(one.format(folder) for one in arguments))
    assert ended.code == 2
    assert told in ended.err
    assert [path.read_bytes() for path in sorted(folder.iterdir())] == before


def test_answers_may_come_from_standard_input(folder, cli, monkeypatch):
    stream = type("Stream", (), {"buffer": (folder / "answers.jsonl").open("rb")})
    with stream.buffer:
        monkeypatch.setattr("sys.stdin", stream)
        ended = cli("study", "report", folder, "-", "--json")
    assert json.loads(ended.out)["counted"]["raters"] == 11
    assert json.loads(ended.out)["files"] == ["-"]


def test_power_is_told_in_text_and_json(cli):
    shown = cli("study", "power", "--share", "0.6", "--pairs", "20")
    assert re.search(r"^ +20 +31 +620 +213 +81\.1 %$", shown.out, re.MULTILINE)
    data = json.loads(cli("study", "power", "--share", "0.6", "--pairs", "20", "--json").out)
    assert data["choices"] == 210
    assert data["rows"][0]["raters"] == 31
    options = ("--raters", "9", "--power", "0.9", "--alpha", "0.01", "--correlation", "0.01")
    asked = json.loads(cli("study", "power", "--share", "0.8", *options, "--json").out)["question"]
    assert asked == {
        "share": 0.8,
        "raters": 9,
        "pairs": None,
        "power": 0.9,
        "alpha": 0.01,
        "correlation": 0.01,
    }


def test_a_question_of_power_without_an_answer_names_the_option(cli):
    ended = cli("study", "power", "--share", "0.5")
    assert ended.code == 2
    assert "--share 0.5: give a share" in ended.err
