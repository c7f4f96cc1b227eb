"""Documents, help, messages and docstrings keep the rules of `prose/vocabulary.yaml`."""

from operator import attrgetter
from pathlib import Path

import pytest
from prose.lint import LONGEST_WORDS, Rule, documents, faults, findings, main, modules, rules
from prose.texts import Sentence, sentences_of_module, sentences_of_page

RULES = rules()
ALL = [*documents(), *modules()]
assert len(ALL) > 500, "a sweep over nothing passes"


def sentence(text: str, *, running: bool = True, path: str = "page.md") -> Sentence:
    return Sentence(Path(path), 1, text, running)


def names(text: str, **place) -> list[str]:
    return [fault.name for fault in faults(sentence(text, **place), RULES)]


def test_no_text_breaks_a_rule():
    found = list(findings(ALL, RULES))
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


def test_modules_are_read_by_summaries_and_messages(tmp_path):
    module = tmp_path / "module.py"
    module.write_text(
        '''"""Words of a module.

The rest is not read.
"""

NAME = "one"


def fail(name):
    """Refuse a name."""
    raise ValueError(f"unknown name '{name}'; say `--name`")
''',
        encoding="utf-8",
    )
    assert [(each.line, each.text, each.running) for each in sentences_of_module(module)] == [
        (1, "Words of a module.", True),
        (10, "Refuse a name.", True),
        (11, "unknown name '\x00'; say \x00", False),
    ]


def test_the_command_prints_places_and_counts(tmp_path, capsys):
    page = tmp_path / "page.md"
    page.write_text("A line.\n\nWho shouts opens the mouth wider.\n", encoding="utf-8")
    assert main([str(page)]) == 1
    shown = capsys.readouterr().out
    assert f"{page}:3: subject-who: 'Who'" in shown
    assert shown.endswith("1 finding in 1 file\n")
    page.write_text("A louder voice opens the mouth wider.\n", encoding="utf-8")
    assert main([str(page)]) == 0
