"""Changing packs in place."""

import difflib
from pathlib import Path

import pytest
from lanes import swept
from packs_tree import BANK, POSESET, TREE, put

from lipsync_lang.errors import PackError
from lipsync_lang.packs import editing
from lipsync_lang.packs.editing import add_entries, edit_pack, edited_text, flow
from lipsync_lang.packs.finding import built_in
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.packs.yaml.source import read_yaml

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


def changed(before: bytes, after: bytes) -> list[str]:
    rows = difflib.ndiff(before.decode().splitlines(), after.decode().splitlines())
    return [row for row in rows if row[0] in "+-"]


@pytest.mark.parametrize(
    "path", swept(FILES, quick=FILES[::80]), ids=lambda path: f"{path.parent.name}/{path.stem}"
)
def test_a_shipped_pack_comes_back_byte_for_byte(path):
    content = path.read_bytes()
    assert edited_text(path, content, nothing) == content


def one_status(document):
    document["bigrams"]["p-a"]["status"] = "approved"


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_only_the_touched_line_changes(newline):
    content = AUTHORED.replace("\n", newline).encode()
    after = edited_text(Path("odd.yaml"), content, one_status)
    assert changed(content, after) == [
        "-     p-a: {curves: {}}",
        "+     p-a: {curves: {}, status: approved}",
    ]
    assert after.count(b"\r\n") == content.count(b"\r\n")


def test_entries_are_added_where_they_are_put():
    def add(document):
        document["bigrams"]["f-f"] = flow({"curves": {"FV": [[0, 0.5], [1, 0]]}})

    after = edited_text(Path("odd.yaml"), AUTHORED.encode(), add)
    assert changed(AUTHORED.encode(), after) == ["+     f-f: {curves: {FV: [[0, 0.5], [1, 0]]}}"]


def test_entries_are_taken_away_with_nothing_else():
    def drop(document):
        del document["bigrams"]["p-a"]

    after = edited_text(Path("odd.yaml"), AUTHORED.encode(), drop)
    assert [row for row in changed(AUTHORED.encode(), after) if "#" not in row] == [
        "-     p-a: {curves: {}}"
    ]


def test_a_file_without_an_end_of_line_stays_so():
    content = BANK.rstrip().encode()
    assert edited_text(Path("common.yaml"), content, nothing) == content


def test_an_edit_is_written(tmp_path):
    path = put(tmp_path, "odd.yaml", AUTHORED)
    edit_pack(path, one_status)
    assert "status: approved}" in path.read_text()
    assert [p.name for p in tmp_path.iterdir()] == ["odd.yaml"]


def test_an_edit_that_would_break_the_pack_is_not_written(tmp_path):
    path = put(tmp_path, "odd.yaml", AUTHORED)

    def spoil(document):
        document["bigrams"]["p-a"]["boundary"] = 3

    with pytest.raises(PackFaults, match=r"odd\.yaml:19:33: P104 `boundary` must be below 1"):
        edit_pack(path, spoil)
    assert path.read_text() == AUTHORED


def test_a_broken_pack_is_not_edited(tmp_path):
    path = put(tmp_path, "odd.yaml", AUTHORED + "kind: bank\n")
    with pytest.raises(PackFaults, match="P015"):
        edit_pack(path, one_status)


def test_a_change_that_fails_leaves_the_file(tmp_path):
    path = put(tmp_path, "odd.yaml", AUTHORED)
    with pytest.raises(KeyError):
        edit_pack(path, lambda document: document["nothing"])
    assert path.read_text() == AUTHORED


def test_a_pack_can_be_created(tmp_path):
    path = tmp_path / "odd.yaml"
    edit_pack(path, one_status, create=AUTHORED)
    assert "status: approved}" in path.read_text()
    with pytest.raises(PackError, match="cannot be read"):
        edit_pack(tmp_path / "gone.yaml", nothing)


def test_a_pose_set_is_edited_under_its_folders_name(tmp_path):
    path = put(tmp_path, "face/poseset.yaml", POSESET)

    def add(document):
        document["targets"]["yu"] = flow({"open": 0.2})

    edit_pack(path, add)
    assert changed(POSESET.encode(), path.read_bytes()) == ["+   yu: {open: 0.2}"]


@pytest.mark.parametrize("name", sorted(TREE))
def test_every_kind_of_pack_takes_a_title(name, tmp_path):
    path = put(tmp_path, name, TREE[name])

    def entitle(document):
        document["title"] = "A title: with a colon"

    edit_pack(path, entitle)
    rows = changed(TREE[name].encode(), path.read_bytes())
    assert [row for row in rows if row[0] == "+"] == ["+ title: 'A title: with a colon'"]


# Entries put in as lines

ENTRY = {"f-f": ["f-f:", "  status: edited", "  curves: {FV: [[0, 0.5], [1, 0]]}"]}


def with_entry(text: str) -> bytes:
    source = read_yaml(Path("odd.yaml"), text.encode())
    return add_entries(source, text.encode(), "bigrams", ENTRY)


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("end", ["", "title: Odd\n", "# end\n\n\n# of it", "title: Odd"])
def test_added_entries_leave_every_other_byte(newline, end, monkeypatch):
    def refuse(*_):
        raise AssertionError("no YAML library is to write the file")

    monkeypatch.setattr(editing, "_dump", refuse)
    text = (AUTHORED + end).replace("\n", newline)
    after = with_entry(text)
    rows = changed(text.encode(), after)
    assert rows == [f"+     {line}" for line in ENTRY["f-f"]]
    assert after.replace(newline.encode(), b"").count(b"\n") == 0
    assert list(read_yaml(Path("odd.yaml"), after).data["bigrams"])[-2:] == ["p-a", "f-f"]


HEAD = "kind: bank\nformat: 1\nname: odd\nposeset: face\n"


@pytest.mark.parametrize(
    "bigrams",
    [
        "bigrams: {}", "bigrams: {}\n", "bigrams: { } # none yet\n", "bigrams:\n", "bigrams:", "",
        "bigrams: {}\ntitle: Odd\n", "bigrams: {f-a: {curves: {}}, a-f: {curves: {}}}\n",
        "bigrams: {f-a: {curves: {}}}", "bigrams: {\n  f-a: {curves: {}},\n  }\n",
        "bigrams:\n  f-a:\n    curves: {}\n    word: |\n      # no comment",
    ],
)  # fmt: skip
def test_entries_are_added_however_a_mapping_is_written(bigrams):
    before = read_yaml(Path("odd.yaml"), (HEAD + bigrams).encode()).data
    after = read_yaml(Path("odd.yaml"), with_entry(HEAD + bigrams)).data
    curves = {"FV": ((0, 0.5), (1, 0))}
    there = before.get("bigrams") or {}
    assert after == before | {"bigrams": there | {"f-f": {"status": "edited", "curves": curves}}}


def test_entries_that_would_break_the_pack_are_refused():
    source = read_yaml(Path("odd.yaml"), AUTHORED.encode())
    with pytest.raises(PackFaults, match="P101"):
        add_entries(source, AUTHORED.encode(), "bigrams", {"f-f": ["f-f: {curve: {}}"]})
