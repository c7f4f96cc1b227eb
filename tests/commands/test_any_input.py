"""No arguments, file or document end in a traceback."""

import json

import pytest
from command_line import COMMANDS, PAIR, actions
from hypothesis import example, given
from hypothesis import strategies as st
from lanes import costly

from lipsync_lang.cli import main

pytestmark = pytest.mark.usefixtures("folder")


WORDS = sorted({word for words in COMMANDS for word in words})
OPTIONS = sorted({o for c in COMMANDS.values() for a in actions(c) for o in a.option_strings})
VALUES = [*PAIR, "line.json", "a.csv", ".", "", "l-ow", "motion.window=0.1", "0.2", "json", "-"]
ARGUMENTS = st.lists(
    st.sampled_from([*WORDS, *OPTIONS, *VALUES])
    | st.text(st.characters(exclude_characters="\0/"), max_size=6),
    max_size=9,
)


def ends_well(arguments, capsys):
    """Run a command, and return its exit code; every error must have a message."""
    try:
        code = main(arguments)
    except SystemExit as exit_:
        code = exit_.code
    told = capsys.readouterr()
    assert code in (0, 1, 2)
    assert "Traceback" not in told.err
    assert code == 0 or told.err or told.out
    return code


@costly()
@given(arguments=ARGUMENTS)
@example(arguments=["run", "", *PAIR])
@example(arguments=["explain", "--at", "0.2", *PAIR, "--schedule", "line.json", "--cut"])
@example(arguments=["bank", "draft", *PAIR, "--write", "--to", ""])
@example(arguments=["run", *PAIR, "--schedule", ""])
@example(arguments=["run", *PAIR, "--schedule", "line.json", "-o", ""])
@example(arguments=["validate", ""])
@example(arguments=["languages", "--path", ""])
@example(arguments=["languages", "show", "\udc80"])
@example(arguments=["validate", "\udc80"])
@example(arguments=["run", *PAIR, "--schedule", "line.json", "-o", "\udc80.csv"])
@example(arguments=["run", *PAIR, "\udc80"])
def test_no_arguments_give_a_traceback(arguments, capsys):
    ends_well(arguments, capsys)


@given(content=st.binary(max_size=120), suffix=st.sampled_from(["json", "TextGrid"]))
def test_no_file_gives_a_traceback(content, suffix, capsys, folder):
    (folder / f"odd.{suffix}").write_bytes(content)
    ends_well(["run", *PAIR, "--schedule", f"odd.{suffix}", "-o", "a.json"], capsys)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=3),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["label", "start", "end", "phonemes", "words"]), inner)
    ),
    max_leaves=8,
)
TIME = st.floats(-1, 2) | st.integers(0, 2) | JSON
ROW = st.fixed_dictionaries(
    {"label": st.sampled_from(["HH", "_", "B"]) | st.text(max_size=2), "start": TIME, "end": TIME}
)
DOCUMENT = st.fixed_dictionaries(
    {"phonemes": st.lists(ROW, max_size=3) | JSON},
    optional={
        "words": JSON | st.lists(st.fixed_dictionaries({"text": JSON, "start": JSON, "end": JSON})),
        "notation": JSON,
        "language": st.just("english") | JSON,
    },
)


@given(document=DOCUMENT | JSON, rest=st.sampled_from([[], ["--unknown", "rest"]]))
@example(document=[{"label": "\ud800", "start": 0, "end": 1}], rest=["--unknown", "rest"])
@example(document=[{"label": "HH", "start": 0, "end": 10**400}], rest=[])
@example(
    document={
        "language": "english",
        "phonemes": [{"label": "HH", "start": 0, "end": 1}],
        "words": [{"text": "\udfff", "start": 0, "end": 1}],
    },
    rest=[],
)
def test_no_document_gives_a_traceback(document, rest, capsys, folder):
    (folder / "odd.json").write_text(json.dumps(document), "utf-8")
    command = ["run", *PAIR, "--schedule", "odd.json", "-o", "a.json", "--fps", "10"]
    if ends_well([*command, *rest], capsys) == 0:
        assert json.loads((folder / "a.json").read_bytes())["frames"]
