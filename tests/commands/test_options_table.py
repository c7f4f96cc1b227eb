"""The table of options, `options.json`."""

import argparse
from pathlib import Path

import pytest

from lipsync_lang.commands.registry import COMMANDS
from lipsync_lang.commands.shared_options import add_options, option_sets
from lipsync_lang.reports.coverage.forms import FORMS


def named(rows):
    """Yield the sets that rows name."""
    for row in rows:
        if isinstance(row, str):
            yield row
        elif isinstance(row, dict):
            yield from named(row.get("options", ()))


def test_every_set_belongs_to_a_command_or_is_named_in_one():
    sets = option_sets()
    used = {name for rows in sets.values() for name in named(rows)}
    assert used <= sets.keys()
    # those that all commands have, and those of plug-ins alone
    assert {name for name in sets.keys() - used if name not in COMMANDS} == {"words"}


@pytest.mark.parametrize(("row", "given", "found"), [
    (["--loud", "in capitals"], ["--loud"], True),
    (["--loud", "in capitals"], [], False),
    (["-n, --loud N", "how often", {"type": "int"}], ["-n", "2"], 2),
    (["--loud FILE", "where", {"repeated": True, "type": "path"}], ["--loud", "a"], [Path("a")]),
    (["--loud FILE", "where", {"repeated": True}], [], []),
    (["--loud", "which", {"choices": ["a", "b"]}], ["--loud", "b"], "b"),
    (["--loud", "if", {"action": "yes or no"}], ["--no-loud"], False),
    (["--shout", "in capitals", {"dest": "loud"}], ["--shout"], True),
    (["loud TEXT", "what", {"nargs": "?"}], ["hi"], "hi"),
    ({"defaults": {"loud": 3}, "why": "as an example"}, [], 3),
    ({"group": "voice", "options": [["--loud", "in capitals"]]}, ["--loud"], True),
])  # fmt: skip
def test_a_row_becomes_an_option(row, given, found):
    made = argparse.ArgumentParser()
    add_options(made, [row])
    assert made.parse_args(given).loud == found


def test_lists_of_several_lines_are_not_shared():
    made = argparse.ArgumentParser()
    add_options(made, [["--loud X", "which", {"repeated": True}]])
    assert made.parse_args(["--loud", "a"]).loud == made.parse_args(["--loud", "a"]).loud == ["a"]


def test_the_help_of_coverage_names_its_formats():
    rows = [row for row in option_sets()["coverage"] if isinstance(row, list)]
    (told,) = [row[1] for row in rows if row[0] == "--format NAME"]
    assert ", ".join(FORMS.modules) in told
