"""Scripts of game engines, read as the engines themselves read them."""

import time

import pytest
from lanes import swept

from lipsync_lang import LipsyncError
from lipsync_lang.text.lines import read_lines

RENPY = '''\
label start:
    e "Hello"
    voice "x.ogg"
    show e happy
    e "After show"
    voice "y.ogg"
    e "Voiced"
    d.e "dot"
    d["x"] "index"
    "Bo Li" happy "named"
    e r"raw \\n"
    e (what_color = "#fff") "hm"
    e "args" (what_color = "#fff")
    e "args" (a="x",b=True)
    e "args" (a="x",)
    e "args" ( *a , ** k )
    e happy -sad @ wave "x" with dissolve
menu named:
    e "choose"
    "Go":
        e "went"
label .local:
    e "local"
label two:
    call x from back
    e "afterback"
label .loc2:
    e "x"
    """
    One.

    Two two.
    """
'''
RENPY_IDS = """\
2 start_8d695913 e
5 start_d3643f9d e
7 start_090f7d77 e
8 start_7fffee00 d.e
9 start_a5adcc1b d["x"]
10 start_6e56c167 Bo Li
11 start_bebec520 e
12 start_1d19bc7f e
13 start_3551b43d e
14 start_d622fd12 e
15 start_d8193641 e
16 start_415eb578 e
17 start_0eee9edd e
19 named_8c433fb2 e
21 named_5fc44de6 e
23 named_local_4bd81ce5 e
26 back_640efeaf e
28 two_loc2_a8a343a3 e
30 two_loc2_bef6a526
32 two_loc2_94ab57a7
"""
"""Line, identifier and speaker of each statement, as Ren'Py 8.0.3 writes them."""


@pytest.fixture
def read(tmp_path):
    """Write a script, and read its lines."""

    def run(text, suffix):
        path = tmp_path / f"a{suffix}"
        path.write_text(text, "utf-8")
        return list(read_lines(path, remark=lambda _: None))

    return run


def test_identifiers_are_those_of_renpy(read):
    lines = [line for line in read(RENPY, ".rpy") if line.name]
    found = [(line.place.rpartition(":")[2], line.name, line.speaker) for line in lines]
    assert "".join(f"{' '.join(one).strip()}\n" for one in found) == RENPY_IDS
    assert lines[6].text == "raw"


@pytest.mark.parametrize(
    "statement",
    swept([
        'e "' + '\\"' * 100_000,
        'e """' + '\\"' * 100_000,
        "e " + "(" * 100_000 + '"x"',
        "e " + "(a)" * 50_000 + '"x',
        "e" + ".a" * 50_000,
        'e "x" (' + "a, " * 50_000 + ")",
        "e " + "happy " * 50_000,
    ], 2),
    ids=lambda value: value[:8],
)  # fmt: skip
def test_no_statement_of_renpy_takes_quadratic_time(read, statement):
    begun = time.process_time()
    read(f"label start:\n    {statement}\n", ".rpy")
    assert time.process_time() - begun < 5  # quadratic time would be minutes


INK = """\
{
- x == 1: One.
- else: Else said.
}
{x > 1:
    Anna: More.
- else:
    Less. {y:
    - 1: First.
    - 2: Second, -> knot
    }
}
{stopping:
- Stopped once.
- Stopped twice.
}
{shuffle once: - Shuffled. }
{met==1:Tight}
{ - x > 5: Large. }
It costs \\#5, or {~6|7}. #tag
* Hello[, Bo.] there.
+ [Bo: Go.]
* (leave) Leave
- (all) {cond: -> away | Or {a}{bee|c} stay.}
/* A comment
of rows. */
= stitch
<- thread
{x || y: Either.}
{x:
=== knot
- Bye{x: now}.
Then she read:
Old Bo:
"""
INK_LINES = """\
2: One.
3: Else said.
6:Anna More.
8: Less.
9: First.
10: Second,
14: Stopped once.
15: Stopped twice.
17: Shuffled.
18: Tight
19: Large.
20: It costs #5, or 6.
21: Hello, Bo.
21: Hello there.
22:Bo Go.
23:leave Leave
24:all Or bee stay.
29: Either.
32: Byenow.
33: Then she read:
"""


def test_blocks_and_choices_of_ink_are_spoken_apart(read):
    found = [(line.place.rpartition(":")[2], line) for line in read(INK, ".ink")]
    told = "".join(f"{at}:{one.name or one.speaker} {one.text}\n" for at, one in found)
    assert told == INK_LINES


def test_a_word_behind_an_escaped_hash_of_ink_is_no_tag(read):
    lines = read("Say \\# word\nAnna: We are \\#one \\#2 #tag\n", ".ink")
    assert [line.text for line in lines] == ["Say word", "We are one #2"]


@pytest.mark.parametrize(
    "row",
    swept(["{" * 100_000, "}" * 100_000, "{a|" * 50_000, "{a|b} " * 30_000], 1),
    ids=lambda value: value[:8],
)
def test_no_row_of_ink_takes_quadratic_time(read, row):
    begun = time.process_time()
    read(f"{row}\n", ".ink")
    assert time.process_time() - begun < 5


def test_brackets_and_characters_of_yarn(read):
    script = r"""title: Start
---
Anna: See \[this\], please.
[character name="Bo"]Hello.[/character]
[character name="Cy"]Boss: [/character]Go.
===
"""
    lines = read(script, ".yarn")
    assert [(line.speaker, line.text) for line in lines] == [
        ("Anna", "See [this], please."),
        ("Bo", "Hello."),
        ("Cy", "Go."),
    ]


def test_yarn_without_a_node_is_refused(read):
    with pytest.raises(LipsyncError, match="no Yarn node"):
        read("Anna: Hello.\n", ".yarn")


ROWS = {"<<" * 200_000: 1, "#a " * 200_000: 0, " " * 400_000 + "x": 1, "[[" * 99_999: 1}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.strip()[:2])
def test_yarn_of_any_form_is_read_in_one_pass(read, row):
    """Such rows would take hours if the time grew with the square of their length."""
    assert len(read(f"---\n{row}\n", ".yarn")) == ROWS[row]
