"""Changes of values of packs in place."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import swept
from packs_tree import POSESET, TREE

from lipsync_lang.base.errors import PackError
from lipsync_lang.packs.finding import built_in
from lipsync_lang.packs.splicing import ABSENT, SplicedText, get, plain, put, spliced
from lipsync_lang.packs.yaml.building import read_yaml, scan
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.packs.yaml.value_text import PLAIN_SCALAR, as_scalar

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
            # over the "f"
            FV:     [[0, 0], [1, 1]]   # rises
            open:   [[0, 1.00], [0.5, 0.2], [1, 0]]
    # last
    p-a: {curves: {}}
# end
"""
ODD = Path("odd.yaml")


def changed(text, *changes, path=ODD):
    """Compare the data, and return the changed lines as `ndiff` marks them."""
    source = read_yaml(path, text.encode())
    expected = source.data
    for loc, value in changes:
        expected = put(expected, loc, plain(value))
    after = spliced(source, text.encode(), changes)
    assert scan(path, after).data == expected
    return rows(text, after.decode())


def rows(before, after):
    """Return the removed and the added lines; all others are in both texts, in order."""
    one, other = before.splitlines(), after.splitlines()
    head = next(
        (n for n, pair in enumerate(zip(one, other, strict=False)) if len({*pair}) > 1), None
    )
    if head is None:
        head = min(len(one), len(other))
    tail = 0
    while tail < min(len(one), len(other)) - head and one[-1 - tail] == other[-1 - tail]:
        tail += 1
    return [
        *(f"-{line}" for line in one[head : len(one) - tail]),
        *(f"+{line}" for line in other[head : len(other) - tail]),
    ]


CASES = {
    "a point": (
        ("bigrams", "a-f", "curves", "open"), [[0, 1], [0.5, 0.35], [1, 0]],
        ["-            open:   [[0, 1.00], [0.5, 0.2], [1, 0]]",
         "+            open:   [[0, 1.00], [0.5, 0.35], [1, 0]]"],
    ),
    "one point more": (
        ("bigrams", "a-f", "curves", "FV"), [[0, 0], [0.4, 0.9], [1, 1]],
        ["-            FV:     [[0, 0], [1, 1]]   # rises",
         "+            FV:     [[0, 0], [0.4, 0.9], [1, 1]]   # rises"],
    ),
    "a curve more": (
        ("bigrams", "a-f", "curves", "PBM"), [[0, 0], [1, 0.25]],
        ["+            PBM:    [[0, 0], [1, 0.25]]"],
    ),
    "a curve less": (
        ("bigrams", "a-f", "curves", "FV"), ABSENT,
        ["-            FV:     [[0, 0], [1, 1]]   # rises"],
    ),
    "one field of a whole entry": (
        ("bigrams", "a-f"),
        {"status": "edited",
         "curves": {"FV": [[0, 0], [1, 1]], "open": [[0, 1], [0.5, 0.2], [1, 0]]}},
        ["-        status:  approved", "+        status:  edited"],
    ),
    "quotes stay": (
        ("bigrams", "f-a", "word"), "don't",
        ["-    f-a: {word: 'no',   curves: {FV: [[0,0], [0.20, 1.0],[1,   0]] }}   # tight",
         "+    f-a: {word: 'don''t',   curves: {FV: [[0,0], [0.20, 1.0],[1,   0]] }}   # tight"],
    ),
    "a field in braces": (
        ("bigrams", "p-a", "status"), "approved",
        ["-    p-a: {curves: {}}", "+    p-a: {curves: {}, status: approved}"],
    ),
    "a bigram more": (
        ("bigrams", "f-f"),
        {"status": "edited", "curves": {"FV": [[0, 0.5], [1, 0]], "open": [[0, 0], [1, 0]]}},
        ["+    f-f:", "+      status: edited", "+      curves:",
         "+        FV:   [[0, 0.5], [1, 0]]", "+        open: [[0, 0], [1, 0]]"],
    ),
    "a bigram less": (("bigrams", "p-a"), ABSENT, ["-    p-a: {curves: {}}"]),
    "curves where there were none": (
        ("bigrams", "p-a", "curves", "FV"), [[0, 0], [1, 1]],
        ["-    p-a: {curves: {}}", "+    p-a: {curves: {FV: [[0, 0], [1, 1]]}}"],
    ),
    "a field of the root": (("style",), "sad", ["+style: sad"]),
    "a title": (("title",), "A title: with a colon", ['+title: "A title: with a colon"']),
    "nothing": (("bigrams", "a-f", "status"), "approved", []),
    "no such entry to delete": (("bigrams", "a-a"), ABSENT, []),
}  # fmt: skip


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("case", CASES)
def test_only_what_changes_is_touched(case, newline):
    loc, value, expected = CASES[case]
    text = AUTHORED.replace("\n", newline)
    assert changed(text, (loc, value)) == expected
    after = spliced(read_yaml(ODD, text.encode()), text.encode(), [(loc, value)]).decode()
    assert after.count(newline) == after.count("\n") == len(after.splitlines())


def test_the_last_entry_leaves_braces():
    keys = ("f-a", "a-f", "p-a")
    source = read_yaml(ODD, AUTHORED.encode())
    gone = spliced(source, AUTHORED.encode(), [(("bigrams", key), ABSENT) for key in keys])
    assert gone.decode().endswith("\n\n\nbigrams: {}\n    # first\n\n    # last\n# end\n")


HEAD = "kind: bank\nformat: 1\nname: odd\nposeset: face\n"


@pytest.mark.parametrize(
    "bigrams",
    [
        "bigrams: {}", "bigrams: {}\n", "bigrams: { } # none yet\n", "bigrams:\n", "bigrams:", "",
        "bigrams: {}\ntitle: Odd\n", "bigrams: {f-a: {curves: {}}, a-f: {curves: {}}}\n",
        "bigrams: {f-a: {curves: {}}}", "bigrams: {\n  f-a: {curves: {}},\n  }\n",
        "bigrams:\n  f-a:\n    curves: {}\n    word: |\n      # no comment",
        "bigrams:\n  f-a: &a\n    curves: {}\n  a-f: *a\n",
        "bigrams: {f-a: &a {curves: {}}, a-f: *a}",
        "bigrams:\n    'f-a':\n        curves: {}\n# end\n\n\n# of it",
    ],
)  # fmt: skip
def test_entries_are_added_however_a_mapping_is_written(bigrams):
    new = {"status": "edited", "curves": {"FV": [[0, 0.5], [1, 0]]}}
    assert changed(HEAD + bigrams, (("bigrams", "f-f"), new))


def test_a_new_entry_may_stand_where_the_next_ones_are_deleted():
    text = HEAD + "bigrams:\n  f-a: {curves: {}}\n  a-f: {curves: {}}\n"
    assert changed(text, (("bigrams",), {"f-a": {"curves": {}}, "a-a": {"curves": {}}})) == [
        "-  a-f: {curves: {}}", "+  a-a:", "+    curves: {}",
    ]  # fmt: skip


def test_a_value_that_an_alias_repeats_is_not_changed_for_both():
    text = HEAD + "bigrams:\n  f-a: &a\n    curves: {}\n  a-f: *a\n"
    assert changed(text, (("bigrams", "a-f", "status"), "approved")) == [
        "-  a-f: *a", "+  a-f:", "+    curves: {}", "+    status: approved",
    ]  # fmt: skip
    with pytest.raises(PackError, match="cannot be changed here, perhaps because of an alias"):
        changed(text, (("bigrams", "f-a", "status"), "approved"))


def test_sequences_keep_their_other_items():
    text = POSESET
    pair = {"between": ["open", "FV"], "threshold": 0.7}
    path = Path("face/poseset.yaml")
    assert changed(text, (("constraints", "pairs", 2), pair), path=path) == [
        "+    - {between: [open, FV], threshold: 0.7}"
    ]
    assert changed(text, (("constraints", "pairs", 0, "threshold"), 0.75), path=path) == [
        "-    - {between: [open, PBM], threshold: 0.5}",
        "+    - {between: [open, PBM], threshold: 0.75}",
    ]
    assert changed(text, (("constraints", "pairs", 0), ABSENT), path=path) == [
        "-    - {between: [open, PBM], threshold: 0.5}"
    ]
    assert changed(text, (("targets", "yu"), {"open": 0.2}), path=path) == ["+  yu: {open: 0.2}"]
    assert changed(text, (("priority",), ["FV", "open", "PBM"]), path=path) == [
        "-priority: [open, FV, PBM]", "+priority: [FV, open, PBM]",
    ]  # fmt: skip


BLOCKS = """\
kind: poseset
format: 1
name: face
poses: {open: {}, wide: {}, PBM: {}}
constraints:
  # in pairs
  pairs:
    - between: [open, PBM]  # both
      threshold: 0.5
    - {between: [open, wide],  # kept
       threshold: 0.7}
# end
"""


@pytest.mark.parametrize(
    ("loc", "value", "expected"),
    [
        (("constraints", "pairs", 0), {"pose": "open", "at_most": "PBM"},
         ["-    - between: [open, PBM]  # both", "-      threshold: 0.5",
          "+    - {pose: open, at_most: PBM}"]),
        (("constraints", "pairs", 1), {"pose": "open", "at_most": "wide"},
         ["-    - {between: [open, wide],  # kept", "-       threshold: 0.7}",
          "+    - {pose: open, at_most: wide}"]),
        (("constraints", "pairs", 0), ABSENT,
         ["-    - between: [open, PBM]  # both", "-      threshold: 0.5"]),
    ],
)  # fmt: skip
def test_a_value_of_other_fields_is_written_anew_alone(loc, value, expected):
    assert changed(BLOCKS, (loc, value), path=Path("face/poseset.yaml")) == expected


SPREAD = """\
kind: poseset
format: 1
name: face
poses: {open: {}, wide: {},   # of the jaw
  PBM: {},
  # below
  FV: {},
}
priority: [open, FV,
  PBM]  # lips last
"""


@pytest.mark.parametrize(
    ("loc", "value", "expected"),
    [
        (("poses", "flat"), {}, ["+  flat: {},"]),
        (("poses", "PBM"), ABSENT, ["-  PBM: {},"]),
        (("poses", "FV"), ABSENT, ["-  FV: {},"]),
        (("poses", "open"), ABSENT, ["-poses: {open: {}, wide: {},   # of the jaw",
                                     "+poses: {wide: {},   # of the jaw"]),
        (("priority",), ["wide", "open", "PBM"],
         ["-priority: [open, FV,", "+priority: [wide, open,"]),
        (("priority",), ["PBM", "FV", "open"],
         ["-priority: [open, FV,", "-  PBM]  # lips last",
          "+priority: [PBM, FV,", "+  open]  # lips last"]),
        (("priority", 2), ABSENT, ["-  PBM]  # lips last", "+  ]  # lips last"]),
        (("priority", 3), "wide", ["-  PBM]  # lips last", "+  PBM, wide]  # lips last"]),
        (("priority",), ["wide", "open", "FV", "PBM"],
         ["-priority: [open, FV,", "+priority: [wide, open, FV,"]),
    ],
)  # fmt: skip
def test_brackets_over_several_lines_keep_their_lines(loc, value, expected):
    assert changed(SPREAD, (loc, value), path=Path("face/poseset.yaml")) == expected


def test_a_faulty_result_is_refused_with_its_place():
    with pytest.raises(PackFaults, match=r"odd\.yaml:19:33: P104 `boundary` must be below 1"):
        changed(AUTHORED, (("bigrams", "p-a", "boundary"), 3))
    with pytest.raises(PackFaults, match="P101"):
        changed(AUTHORED, (("bigrams", "f-f"), {"curve": {}}))
    with pytest.raises(PackFaults, match="P015"):
        changed(AUTHORED + "kind: bank\n", (("style",), "sad"))
    with pytest.raises(PackError, match="`FV` cannot be set within"):
        changed(AUTHORED, (("bigrams", "a-f", "status", "FV"), 1))


def test_a_faulty_pack_is_mended_but_not_half():
    text = AUTHORED.replace("'no'", "[]").replace("status:  approved", "status: seen")
    source = read_yaml(ODD, text.encode())
    with pytest.raises(PackFaults, match="P107"):
        spliced(source, text.encode(), [(("bigrams", "f-a", "word"), "no")])
    mend = [(("bigrams", "f-a", "word"), "no"), (("bigrams", "a-f", "status"), "edited")]
    assert b"status: edited" in spliced(source, text.encode(), mend)


@pytest.mark.parametrize("name", sorted(TREE))
def test_every_kind_of_pack_takes_a_title(name):
    text = TREE[name]
    taken = changed(text, (("title",), "A new one"), path=Path("x") / name)
    assert [row for row in taken if row[0] == "+"] == ["+title: A new one"]


@pytest.mark.parametrize(
    "path", swept(FILES, quick=FILES[::40]), ids=lambda path: f"{path.parent.name}/{path.stem}"
)
def test_shipped_packs_are_cut_and_joined_byte_for_byte(path):
    content = path.read_bytes()
    pack = SplicedText.read(path, content)
    assert pack.content == content
    assert pack.data == read_yaml(path, content).data
    assert pack.sound
    assert list(pack.data) == list(read_yaml(path, content).data)


def test_parts_know_their_places():
    pack = SplicedText.read(ODD, AUTHORED.encode())
    source = read_yaml(ODD, AUTHORED.encode())
    for key in ("f-a", "a-f", "p-a"):
        assert pack.place(("bigrams", key)) == source.where(("bigrams", key), key=True)


# Any text, any change

KEYS = ["f-a", "a-f", "p-a", "f-f", "a-a", "yu-p"]
POSES = ["open", "FV", "PBM", "wide"]
NUMBERS = st.sampled_from([0, 1, 0.5, 0.25, 0.3, 0.123456789, 1e-7])
CURVES = st.dictionaries(
    st.sampled_from(POSES),
    st.lists(NUMBERS, min_size=2, max_size=4).map(
        lambda values: [[t / 4, value] for t, value in enumerate(values)]
    ),
    max_size=3,
)
WORDS = st.sampled_from(
    ["no", "moi", "go on", "yes: no", "# no", "it's", '"', "鱼", "12", "", " x"]
)
ENTRIES = st.fixed_dictionaries(
    {"curves": CURVES},
    optional={
        "word": WORDS,
        "status": st.sampled_from(["drafted", "edited", "approved"]),
        "boundary": st.sampled_from([0.4, 0.5]),
    },
)


@st.composite
def banks(draw):
    """Text of a bank with comments, blank lines, both styles and both line ends."""
    lines = ["kind: bank  # c0", "format: 1", "name: odd", "poseset: face"]
    entries = draw(st.dictionaries(st.sampled_from(KEYS), ENTRIES, min_size=1, max_size=4))
    lines += [*draw(st.sampled_from([[], ["", "# c1"]])), "bigrams:   # c2"]
    comments = (f"# n{number}" for number in range(10**6))
    indent = draw(st.sampled_from(["  ", "    "]))
    for key, entry in entries.items():
        if draw(st.booleans()):
            lines.append(f"{indent}{next(comments)}")
        if draw(st.booleans()) or not entry["curves"]:
            lines.append(f"{indent}{key}: {flow(entry)}   {next(comments)}")
            continue
        lines.append(f"{indent}{key}:  {next(comments)}")
        for field, value in entry.items():
            if field != "curves":
                lines.append(f"{indent * 2}{field}: {flow(value)} {next(comments)}")
                continue
            lines.append(f"{indent * 2}curves:")
            for pose, points in value.items():
                lines.append(f"{indent * 3}{next(comments)}")
                lines.append(f"{indent * 3}{pose}:  {flow(points)} {next(comments)}")
    lines += draw(st.sampled_from([[], ["# end"], ["", "title: Odd  # c3"]]))
    newline = draw(st.sampled_from(["\n", "\r\n"]))
    return newline.join(lines) + draw(st.sampled_from(["", newline]))


def flow(value):
    """Write a value in another form than that of the program."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key}:  {flow(one)}" for key, one in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ",".join(map(flow, value)) + "]"
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'" if value != "approved" else value
    return f"{value:.9f}"


LOCS = st.one_of(
    st.tuples(st.just("bigrams"), st.sampled_from(KEYS)),
    st.tuples(st.just("bigrams"), st.sampled_from(KEYS), st.sampled_from(["status", "word"])),
    st.tuples(st.just("bigrams"), st.sampled_from(KEYS), st.just("curves"), st.sampled_from(POSES)),
    st.sampled_from([("title",), ("style",), ("bigrams",)]),
)


@given(st.data(), banks())
def test_any_change_of_any_bank(data, text):
    pack = SplicedText.read(ODD, text.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        loc = data.draw(LOCS)
        value = data.draw(st.sampled_from([ABSENT, "new"]))
        if value == "new":
            made = {
                1: st.dictionaries(st.sampled_from(KEYS), ENTRIES, max_size=3),
                2: ENTRIES,
                3: st.sampled_from(["edited", "approved"]),
                4: CURVES.map(lambda some: next(iter(some.values()), [[0, 0], [1, 1]])),
            }
            value = "sad" if loc in {("title",), ("style",)} else data.draw(made[len(loc)])
        if len(loc) > 2 and get(pack.data, loc[:2]) is ABSENT:
            continue
        there = pack.at(loc) is not ABSENT or value is not ABSENT
        expected = put(pack.data, loc, plain(value)) if there else pack.data
        after = pack.changed([(loc, value)])
        assert after.data == expected
        assert scan(ODD, after.content).data == expected
        assert list(after.data) == list(scan(ODD, after.content).data)
        assert untouched(pack.content, loc) <= lines_of(after.content)
        pack = after


def lines_of(content):
    """The lines of a text without spaces at their ends."""
    return {line.rstrip() for line in content.decode().splitlines()}


def untouched(content, loc):
    """Return the lines outside the value at `loc`, which differ by numbers in comments."""
    source = scan(ODD, content)
    lines = content.decode().splitlines()
    while len(loc) > 1 and (source.known(loc) < len(loc) or len(source.at(loc[:-1])) == 1):
        loc = loc[:-1]  # an entry more or less may rewrite the key of an empty mapping
    if source.known(loc) < len(loc):
        return {line.rstrip() for line in lines}
    first = source.where(loc, key=True).line
    indent = len(lines[first - 1]) - len(lines[first - 1].lstrip())
    last = first
    while last < len(lines) and (
        not lines[last].strip() or len(lines[last]) - len(lines[last].lstrip()) > indent
    ):
        last += 1
    return {line.rstrip() for n, line in enumerate(lines) if not first - 1 <= n < last}


@given(
    st.one_of(st.text(st.characters(codec="utf-8")), st.from_regex(PLAIN_SCALAR, fullmatch=True))
)
def test_text_reads_back_as_itself_in_brackets(text):
    read = scan(ODD, f"a: [{as_scalar(text)}, {{{as_scalar(text)}: 1}}]".encode())
    assert read.faults or read.data == {"a": (text, {text: 1})}
    assert not read.faults or not PLAIN_SCALAR.fullmatch(text)
