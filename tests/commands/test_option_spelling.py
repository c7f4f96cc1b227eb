"""Messages name arguments in Python, and options on the command line."""

import re

import pytest
from lanes import full, needs_plug_ins
from syntax_trees import modules
from test_house import texts, wing

import lipsync_lang as ll
from lipsync_lang.commands.output import OPTIONS, as_options
from lipsync_lang.commands.parser import parser

AT_HOME = {"cli", "commands", "authoring", "plugins", "production"}
"""Wings with commands of their own, of drafts, and of `build` and `live`."""

ELSEWHERE = {
    "animations/keys.py": "reads what an option of the command line was given",
    "animations/rates.py": "reads what an option of the command line was given",
    "reports/coverage/changes.py": "names the command that writes a report",
    "reports/coverage/forms/text.py": "the command's own report",
    "base/extras.py": "an option of another program",
    "base/files/reach.py": "names the option by which a user permits a folder",
    "packs/banks/write.py": "names the option that keeps bigrams for one character",
    "packs/finding.py": "names the option by which a user permits a folder",
    "sound/speech/hearing/sphinx/folder.py": "names the option by which a user permits a folder",
    "packs/project.py": "names the option by which a user permits a folder",
    "render/fonts.py": "an option of another program",
    "schedules/tiers.py": "names the option that chooses a tier",
}
"""Modules whose strings may name options, with the reason."""


@pytest.mark.parametrize(("message", "told"), [
    ("ask for rest (`unknown='rest'`)", "ask for rest (--unknown rest)"),
    ('say which (`tier="Ann - phones"`)', 'say which (--tier "Ann - phones")'),
    ("say which (`read_as='htk'`) or `rate=1000`", "say which (--read-as htk) or --rate 1000"),
    ("give timed phonemes (`schedule`)", "give timed phonemes (--schedule)"),
    ("give its pack a `tts`, or `audio: {align: warp}`", None),
    ("`other=1` stays", None),
])  # fmt: skip
def test_arguments_become_options(message, told):
    assert as_options(message) == (told or message)


@needs_plug_ins
def test_every_option_that_stands_for_an_argument_is_there():
    (commands,) = (a.choices for a in parser()._actions if a.choices)  # noqa: SLF001
    known = {o for c in commands.values() for a in every_action(c) for o in a.option_strings}
    assert set(OPTIONS.values()) <= known


def every_action(command):
    for action in command._actions:  # noqa: SLF001 argparse has no other way
        yield action
        for inner in (action.choices or {}).values() if isinstance(action.choices, dict) else ():
            yield from every_action(inner)


@full
def test_messages_of_the_library_name_no_options():
    found = {
        name
        for name, tree in modules().items()
        if wing(name) not in AT_HOME
        for text in texts(tree)
        if re.search(r"(^|[\s(])--[a-z]", text)
    }
    assert found == ELSEWHERE.keys()


def test_one_message_is_spelled_both_ways(cli, tmp_path):
    line = tmp_path / "odd.json"
    line.write_text('[{"label": "QZ", "start": 0, "end": 0.2}]')
    with pytest.raises(ll.ScheduleError, match=r"as rest \(`unknown='rest'`\)"):
        ll.resolve("english", "facefx").perform(ll.read_schedule(line))
    told = cli("run", "-l", "english", "-c", "facefx", "--schedule", line).err
    assert "as rest (--unknown rest)" in told
    assert "`" not in told
