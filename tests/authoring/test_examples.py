"""Examples that `new --example` copies: every built-in pack, and whole folders."""

from pathlib import Path

import pytest

from lipsync_lang.authoring.copies import copy_example, examples
from lipsync_lang.packs.finding import FOLDERS, Finder
from lipsync_lang.packs.project import FILE

EXAMPLES = examples()
GAMES = [name for name, one in EXAMPLES.items() if (one.source / FILE).is_file()]


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_every_built_in_pack_and_a_game_are_examples():
    finder = Finder(project=None)
    packs = {
        one.name
        for kind in FOLDERS
        for one in finder.names(kind)
        if one.root.origin == "built-in"
    }  # fmt: skip
    assert packs <= EXAMPLES.keys()
    assert GAMES


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_copy_is_the_example_where_packs_are_found(name):
    source, place = EXAMPLES[name]
    copied = copy_example(name, None)
    assert all(path.is_file() for path in copied)
    if place is None:
        assert {path.parts[0] for path in copied} == {name}
        return
    kind = next(kind for kind, folder in FOLDERS.items() if Path(folder) == place)
    own = Finder().find(kind, name)
    assert own.is_relative_to(Path.cwd())
    shipped = source if source.is_file() else source / own.name
    assert own.read_bytes() == shipped.read_bytes()


def test_no_copy_changes_a_file(cli):
    name = next(name for name, one in EXAMPLES.items() if one.source.is_dir())
    path = copy_example(name, Path("mine"))[0]
    path.write_text("changed", "utf-8")
    ended = cli("new", "mine", "--example", name)
    assert (ended.code, path.read_text("utf-8")) == (2, "changed")
    assert "is there already; name another folder, or remove it first" in ended.err


def test_a_wrong_name_lists_the_examples(cli):
    ended = cli("new", "--example", f"{GAMES[0]}x")
    assert ended.code == 2
    assert f"did you mean '{GAMES[0]}'?" in ended.err
    assert "each built-in language and pose set" in ended.err
    assert not list(Path().iterdir())


def test_an_example_is_copied_as_it_is(cli):
    assert "leave out the other options" in cli("new", "--example", GAMES[0], "-l", "fi").err


@pytest.mark.parametrize("name", GAMES)
def test_a_game_can_be_built_at_once(cli, name, monkeypatch):
    ended = cli("new", "my game", "--example", name)
    assert ended.code == 0
    assert 'next: cd "my game", then: lipsync-lang build' in ended.err
    monkeypatch.chdir("my game")
    assert cli("build", "--dry-run").code == 0


def test_a_folder_that_cannot_be_written_is_named(cli):
    Path("posesets").write_text("", "utf-8")
    name = next(name for name, one in EXAMPLES.items() if one.place == Path("posesets"))
    assert "posesets" in cli("new", "--example", name).err
