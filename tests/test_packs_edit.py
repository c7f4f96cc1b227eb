"""Changes of packs by a dump of the whole document."""

import difflib

import pytest
from lanes import swept
from packs_tree import BANK

from lipsync_lang.packs.editing import flow, redumped
from lipsync_lang.packs.finding import built_in

FILES = sorted([*built_in().glob("languages/*.yaml"), *built_in().glob("posesets/*/**/*.yaml")])
assert FILES, "a sweep over nothing passes"

AUTHORED = """\
# A bank with habits.
kind:   bank
format: 1
name: "odd"      # quoted, and
poseset:   face  # spaced out


bigrams:
    # first
    f-a: {word: 'no',   curves: {FV: [[0,0], [0.20, 1.0],[1,   0]] }}   # tight

    a-f:
        status:  approved
        curves:
            FV:
            - [0, 0]
            - [1, 1]
    # last
    p-a: {curves: {}}
# end
"""


def nothing(document):
    """Change nothing."""


def changed(before: str, after: str) -> list[str]:
    rows = difflib.ndiff(before.splitlines(), after.splitlines())
    return [row for row in rows if row[0] in "+-"]


@pytest.mark.parametrize(
    "path", swept(FILES, quick=FILES[::80]), ids=lambda path: f"{path.parent.name}/{path.stem}"
)
def test_a_shipped_pack_comes_back_byte_for_byte(path):
    text = path.read_bytes().decode()
    assert redumped(text, nothing) == text


def one_status(document):
    document["bigrams"]["p-a"]["status"] = "approved"


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_only_the_touched_line_changes(newline):
    text = AUTHORED.replace("\n", newline)
    after = redumped(text, one_status)
    assert changed(text, after) == [
        "-     p-a: {curves: {}}",
        "+     p-a: {curves: {}, status: approved}",
    ]
    assert after.count("\r\n") == text.count("\r\n")


def test_entries_are_added_where_they_are_put():
    def add(document):
        document["bigrams"]["f-f"] = flow({"curves": {"FV": [[0, 0.5], [1, 0]]}})

    after = redumped(AUTHORED, add)
    assert changed(AUTHORED, after) == ["+     f-f: {curves: {FV: [[0, 0.5], [1, 0]]}}"]


def test_entries_are_taken_away_with_nothing_else():
    def drop(document):
        del document["bigrams"]["p-a"]

    after = redumped(AUTHORED, drop)
    assert [row for row in changed(AUTHORED, after) if "#" not in row] == [
        "-     p-a: {curves: {}}"
    ]


def test_a_file_without_an_end_of_line_stays_so():
    assert redumped(BANK.rstrip(), nothing) == BANK.rstrip()
