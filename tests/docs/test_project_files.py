"""Files of the project: forms for platforms, and a README for people."""

import re
import shlex
from datetime import date

import pytest
from places import ROOT

import lipsync_lang as ll
from lipsync_lang.packs.yaml.events import load_yaml

FORMS = sorted(ROOT.glob(".github/ISSUE_TEMPLATE/[!c]*.yml"))
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("findings/*.md")])
HOOKS = load_yaml((ROOT / ".pre-commit-config.yaml").read_text("utf-8"))["repos"][0]["hooks"]
assert FORMS, "a sweep over nothing passes"
assert PAGES, "a sweep over nothing passes"
assert HOOKS, "a sweep over nothing passes"

MOST_WORDS = 800
"""Maximum number of words of the README, counted as `wc` does."""

KINDS = {"input", "textarea", "dropdown", "checkboxes", "markdown"}
"""Kinds of fields in issue forms."""


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text("utf-8").split()) <= MOST_WORDS


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_picture_is_described(page):
    pictures = re.findall(r"!\[([^\]]*)\]\(([^)]+)\)", page.read_text("utf-8"))
    assert [path for text, path in pictures if len(text.split()) < 3] == []


def test_the_citation_names_this_version_and_the_paper():
    told = load_yaml((ROOT / "CITATION.cff").read_text("utf-8"))
    assert {"cff-version", "message", "title", "authors", "version", "license"} <= told.keys()
    assert told["version"] == ll.__version__
    paper = told["preferred-citation"]
    assert paper["title"] == "A Practical and Configurable Lip Sync Method for Games"
    assert [who["family-names"] for who in paper["authors"]] == [
        "Xu", "Feng", "Marsella", "Shapiro",
    ]  # fmt: skip
    assert paper["year"] == 2013


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.stem)
def test_issue_forms_are_forms(form):
    told = load_yaml(form.read_text("utf-8"))
    assert {"name", "description", "body"} <= told.keys()
    assert {field["type"] for field in told["body"]} <= KINDS
    names = [field["id"] for field in told["body"]]
    assert len(names) == len(set(names))
    assert all(field["attributes"]["label"] for field in told["body"])
    assert any(field.get("validations", {}).get("required") for field in told["body"])
    for command in re.findall(r"`(lipsync-lang [^`]+)`", form.read_text("utf-8")):
        assert_command(command)


def test_the_request_form_names_commands_that_exist():
    text = (ROOT / ".github/pull_request_template.md").read_text("utf-8")
    commands = re.findall(r"`(lipsync-lang [^`]+)`", text)
    assert commands
    for command in commands:
        assert_command(command)


def assert_command(command):
    """Check a command with its parser; words in capitals stand for the reader's own words."""
    from lipsync_lang.cli import parser

    parser().parse_args(shlex.split(command)[1:])


@pytest.mark.parametrize("hook", HOOKS, ids=lambda hook: hook["id"])
def test_hooks_run_what_there_is_on_files_that_there_are(hook):
    program, *arguments = shlex.split(hook["entry"])
    assert program in {".venv/bin/ruff", ".venv/bin/python", ".venv/bin/lipsync-lang"}
    if program.endswith("python"):
        assert (ROOT / arguments[0]).is_file()
    if program.endswith("lipsync-lang"):
        assert_command(" ".join(["lipsync-lang", *arguments]))
    pattern = re.compile(hook.get("files", r"\.py$"))
    folders = ("lipsync_lang", "languages", "posesets", "docs")
    paths = (p.relative_to(ROOT).as_posix() for f in folders for p in (ROOT / f).rglob("*.*"))
    assert any(pattern.search(path) for path in paths)


def test_the_changelog_begins_with_a_summary():
    text = (ROOT / "CHANGELOG.md").read_text("utf-8")
    newest = text.split("\n## ")[1]
    assert newest.startswith("[Unreleased]") or date.fromisoformat(newest.split("\n")[0][-10:])
    summary = newest.split("\n### ")[1]
    assert summary.startswith("In short\n")
    assert len(summary.split()) < 300


def test_every_finding_is_listed_with_its_version_and_date(root):
    rows = (root / "findings/README.md").read_text("utf-8").splitlines()
    scripts = sorted((root / "findings").glob("*.sh"))
    assert scripts, "a sweep over nothing passes"
    listed = [row.split("|")[1:-1] for row in rows if row.startswith("| [")]
    assert [cells[0].split("]")[0].strip(" [") for cells in listed] == [p.name for p in scripts]
    for script, (_, _, version, seen) in zip(scripts, listed, strict=True):
        head = script.read_text("utf-8").partition("set -euo pipefail")[0]
        assert version.split()[-1] in head, "the head names the version"
        assert f"seen on {seen.strip()}" in head


def test_a_clone_is_tried_by_the_commands_that_the_readme_shows(root):
    readme = (root / "README.md").read_text("utf-8")
    first = readme[: readme.index("\n## ")]
    shown = [line.removeprefix("$ ") for line in first.splitlines() if line.startswith("$ ")]
    script = (root / ".ci/run").read_text("utf-8")
    tried = re.findall(r"^make [\w-]+$", script, re.MULTILINE)
    assert shown == tried[: len(shown)] == ["make demo", "make test"]
