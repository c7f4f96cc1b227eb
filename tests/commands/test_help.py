"""Help and reference of every command and option."""

import re
import shlex

import pytest
from command_line import COMMANDS, actions, refused

from lipsync_lang.base.version import __version__
from lipsync_lang.cli import parser
from lipsync_lang.commands.registry import leaves
from lipsync_lang.pipeline import kernel

every_command = pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
pytestmark = pytest.mark.usefixtures("folder")


@every_command
def test_every_command_has_help_with_an_example_that_can_be_parsed(words, cli):
    ended = cli(*words, "--help")
    assert ended.code == 0
    found = re.search(r"^  lipsync-lang (.+)$", ended.out, re.MULTILINE)
    assert found, "no example"
    example_ = shlex.split(found[1].partition(" > ")[0])
    parser().parse_args(example_)
    assert example_[0] == words[0]


@every_command
def test_every_option_says_what_it_does(words):
    for action in actions(COMMANDS[words]):
        named = action.option_strings or [action.dest]
        told = action.help or action.choices
        assert told, f"{' '.join(words)} {named[0]} says nothing"


@every_command
def test_every_command_is_in_the_reference(words, root):
    text = (root / "docs" / "reference" / "commands.md").read_text("utf-8")
    assert re.search(rf"lipsync-lang {' '.join(words)}\b", text), (
        "not in docs/reference/commands.md"
    )


@every_command
def test_every_option_is_in_the_reference(words, root):
    text = (root / "docs" / "reference" / "commands.md").read_text("utf-8")
    options = {o for a in actions(COMMANDS[words]) for o in a.option_strings if o[:2] == "--"}
    missing = {option for option in options if not re.search(rf"{option}\b", text)}
    assert not missing - {"--help"}


def test_the_version_is_printed(cli):
    assert cli("--version").out == f"lipsync-lang {__version__} ({kernel.summary()})\n"


@pytest.mark.parametrize("asked", ["-h", "--help"])
def test_the_help_of_titles_alone_is_the_help_of_the_whole_parser(asked):
    assert parser(asked).format_help() == parser().format_help()


def test_titles_and_the_version_need_no_options_of_commands():
    assert not [made for path, made in leaves(parser("--version")) if path]
    made = dict(leaves(parser("--help")))
    assert ("run",) in made
    assert [one.dest for one in made["run",]._actions] == ["help"]  # noqa: SLF001


@pytest.mark.parametrize("arguments", [["dance"], ["bank"], ["run", "--fps"]])
def test_misuse_is_told_with_the_usage(arguments, cli):
    refused(cli(*arguments), r"usage: lipsync-lang.*\n(.*\n)*lipsync-lang.*: error: ")
