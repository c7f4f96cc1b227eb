"""Documents, help, messages and docstrings keep the rules of `prose/vocabulary.yaml`."""

from operator import attrgetter
from pathlib import Path

import pytest
from lanes import swept
from prose.lint import (
    LONGEST_WORDS,
    Rule,
    documents,
    everything,
    faults,
    findings,
    main,
    modules,
    other_files,
    rules,
    sentences,
)
from prose.texts import ROOT, Sentence, sentences_of_page

RULES = rules()
ALL = everything()
KINDS = {".md", ".py", ".js", ".mjs", ".html", ".jinja", ".yaml", ".yml", ".json", ".toml", ""}
assert len(ALL) > 900, "a sweep over nothing passes"
assert {path.suffix for path in ALL} == KINDS, "a sweep over nothing passes"


def sentence(text: str, *, running: bool = True, path: str = "page.md") -> Sentence:
    return Sentence(Path(path), 1, text, running)


def names(text: str, **place) -> list[str]:
    return [fault.name for fault in faults(sentence(text, **place), RULES)]


@pytest.mark.parametrize("listed", swept([documents, modules, other_files]))
def test_no_text_breaks_a_rule(listed):
    found = list(findings(listed(), RULES))
    assert not found, "\n".join(map(str, found))


@pytest.mark.parametrize("rule", RULES, ids=attrgetter("name"))
def test_each_rule_finds_its_bad_examples_and_no_good_one(rule: Rule):
    assert rule.bad
    assert rule.good
    assert all(rule.finds(sentence(text)) for text in rule.bad)
    assert not [name for text in rule.good for name in names(text)]


def test_a_rule_of_running_text_leaves_tables_and_headings_alone():
    assert names("What it costs") == ["subject-what"]
    assert names("What it costs", running=False) == []
    assert names("say nothing but errors", running=False) == ["nothing-but"]


def test_a_long_sentence_is_found_and_numbers_do_not_count():
    assert names("word " * LONGEST_WORDS) == []
    assert names("word " * (LONGEST_WORDS + 1)) == ["length"]
    assert names("word " * LONGEST_WORDS + "0.1 " * 9) == []


def test_pages_are_read_as_sentences_with_their_lines(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        """# A *heading*

First one, with `code. Not a
sentence`. The second
goes on: see [a page](folder/page.md). <!-- hidden. -->

<!-- lint: off -->
Who shouts opens the mouth.
<!-- lint: on -->

```console
$ lipsync-lang who. What.
```

- An item
  of two lines
- e.g. Another

| head | cell |
| --- | --- |
| a | b. C |
""",
        encoding="utf-8",
    )
    assert [(each.line, each.text, each.running) for each in sentences_of_page(page)] == [
        (1, "A *heading*", False),
        (3, "First one, with \x00.", True),
        (4, "The second goes on: see [a page].", True),
        (15, "An item of two lines", True),
        (17, "e.g. Another", True),
        (19, "head", False),
        (19, "cell", False),
        (21, "a", False),
        (21, "b.", False),
        (21, "C", False),
    ]


def test_releases_of_the_changelog_stay_as_they_were(tmp_path):
    text = "## [Unreleased]\n\n- New.\n\n## [0.1.0] - 2026-11-01\n\n- Old.\n"
    assert read(tmp_path, "CHANGELOG.md", text) == [
        (1, "[Unreleased]", False),
        (3, "New.", True),
    ]
    assert [each[1] for each in read(tmp_path, "page.md", text)][-1] == "Old."


def read(folder: Path, name: str, text: str) -> list[tuple[int, str, bool]]:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return [(each.line, each.text, each.running) for each in sentences(path)]


def test_modules_are_read_by_summaries_and_messages(tmp_path):
    text = '''"""Words of a module.

The rest is not read.
"""

NAME = "one"


def fail(name):
    """Refuse a name."""
    raise ValueError(f"unknown name '{name}'; say `--name`")
'''
    assert read(tmp_path, "module.py", text) == [
        (1, "Words of a module.", True),
        (10, "Refuse a name.", True),
        (11, "unknown name '\x00'; say \x00", False),
    ]


def test_modules_of_tests_are_read_by_summaries_alone():
    found = list(sentences(Path(__file__)))
    assert found[0].text.startswith("Documents, help, messages")
    assert all(each.running for each in found)


def test_scripts_are_read_by_summaries_and_texts(tmp_path):
    text = r"""/**
 * Words of a script.
 * @param {string} one the rest is not read
 */
// Not read.
const pattern = text.replace(/["'`{]+/g, "a pair"), half = 1 / 2;
const shown = `${count} lines ${left ? "that are left" : `and ${more} of them`} here.`;
const code = `#version 300
  here = there; there = here;
`;
f("one", 'It\'s a line', {a: "two words"});
"""
    assert read(tmp_path, "script.js", text) == [
        (2, "Words of a script.", True),
        (6, "a pair", False),
        (7, "\x00 lines \x00 here.", True),
        (7, "that are left", False),
        (7, "and \x00 of them", False),
        (11, "It s a line", False),
        (11, "two words", False),
    ]


@pytest.mark.parametrize("text", ["const a = 1; }", "function f() {"])
def test_a_script_whose_texts_cannot_be_told_from_its_code_is_named(tmp_path, text: str):
    with pytest.raises(ValueError, match=r"script\.js: braces do not match"):
        read(tmp_path, "script.js", text)


def test_pages_and_templates_are_read_by_visible_words(tmp_path):
    text = """<title>A title</title>
<script>const a = "not read";</script>
<p class="not read">Some <b>bold</b> words
  and <code>code here</code>.</p>
<input aria-label="A line" placeholder="Type it" value="not read">
{% if found == 1 %}<td>one line{% else %}no line{% endif %} of {{ name }}</td>
{{ fact("not", "values found") }}
"""
    assert read(tmp_path, "page.html", text) == [
        (1, "A title", False),
        (3, "Some bold words and \x00.", True),
        (5, "A line", False),
        (5, "Type it", False),
        (6, "one line.", False),
        (6, "no line of \x00", False),
        (7, "values found", False),
    ]


def test_packs_are_read_by_comments_and_fields_of_prose(tmp_path):
    text = """# A pack of
# two lines. Second.
#   field  a row
kind: "# not read"   # an aside
url: https://example.org/#not-read

title: A title
caveats:
  - >-
    Digits are
    not read.
tests: [{text: not read}]
"""
    assert read(tmp_path, "pack.yaml", text) == [
        (1, "A pack of two lines.", True),
        (2, "Second.", True),
        (3, "field a row", False),
        (4, "an aside", False),
        (7, "A title", False),
        (10, "Digits are not read.", True),
    ]


def test_tours_are_read_by_their_titles_and_texts(tmp_path):
    text = """{"line": "not read", "steps": [
{"at": "#not read", "title": "A title", "text": "One. Two."}]}
"""
    assert [each[:2] for each in read(tmp_path, "tour.json", text)] == [
        (2, "A title"),
        (2, "One."),
        (2, "Two."),
    ]


def test_settings_and_templates_of_packs_are_read_by_their_comments(tmp_path):
    text = "# A remark.\n\nname = 'two words'  # an aside\n"
    expected = [(1, "A remark.", True), (3, "an aside", False)]
    for name in ("pyproject.toml", "Makefile", "lipsync.yaml.jinja"):
        assert read(tmp_path, name, text) == expected


def test_every_script_of_the_package_is_read_to_its_end():
    for path in ROOT.glob("lipsync_lang/**/*.js"):
        assert any(each.running for each in sentences(path)), path


def test_the_command_prints_places_and_counts(tmp_path, capsys):
    page = tmp_path / "page.md"
    page.write_text("A line.\n\nWho shouts opens the mouth wider.\n", encoding="utf-8")
    assert main([str(page)]) == 1
    shown = capsys.readouterr().out
    assert f"{page}:3: subject-who: 'Who'" in shown
    assert shown.endswith("1 finding in 1 file\n")
    page.write_text("A louder voice opens the mouth wider.\n", encoding="utf-8")
    assert main([str(page)]) == 0
