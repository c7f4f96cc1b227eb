"""A short line, and the commands of the program, for tests of the command line."""

import re

from lipsync_lang.cli import parser

PAIR = ("-l", "english", "-c", "facefx")
ROWS = [("HH", 0, 0.08), ("AH0", 0.08, 0.15), ("L", 0.15, 0.25), ("OW1", 0.25, 0.5)]
SCHEDULE = {
    "phonemes": [{"label": p, "start": a, "end": b} for p, a, b in ROWS],
    "words": [{"text": "hello", "start": 0, "end": 0.5}],
}
TEXTGRID = """\
File type = "ooTextFile"
Object class = "TextGrid"

0
0.5
<exists>
1
"IntervalTier"
"phones"
0
0.5
4
""" + "".join(f'{start}\n{end}\n"{label}"\n' for label, start, end in ROWS)


def actions(made):
    """List the actions of a parser."""
    return made._actions  # noqa: SLF001 it tells no other way


def commands(made, *names):
    """Yield the words and the parser of every command and action."""
    for action in actions(made):
        if isinstance(action.choices, dict):
            for name, inner in action.choices.items():
                yield (*names, name), inner
                yield from commands(inner, *names, name)


COMMANDS = dict(commands(parser()))
assert COMMANDS, "a sweep over nothing passes"


def refused(ended, message, code=2):
    assert ended.code == code
    assert ended.out == ""
    assert re.search(message, ended.err), ended.err


def listed(folder):
    return {p.name for p in folder.iterdir()} - {"line.json", "line.TextGrid"}
