"""Builds of archives of takes: whole and in shards."""

import struct

import pytest
from build_project import ARCHIVE, PROJECT, SAID, archived_game

from lipsync_lang.base.errors import LipsyncError, OutputError
from lipsync_lang.cli import main
from lipsync_lang.production.builds.archives import members
from lipsync_lang.production.builds.project_build import Shard
from lipsync_lang.production.builds.takes import (
    HEAD_CRC_AT,
    INDEX_SLOT,
    TAKES_HEADER,
    _head_crc,
    read_takes,
)

SHARDS = 3


@pytest.fixture
def game(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    return archived_game(tmp_path, capsys)


def test_a_build_fills_an_archive_and_then_changes_nothing(game):
    assert len(game.build().built) == len(SAID)
    first = (game.folder / ARCHIVE).read_bytes()
    names = [f"english/line{number}" for number in range(len(SAID))]
    assert [*read_takes(game.folder / ARCHIVE).takes] == names
    assert not game.build().built
    assert (game.folder / ARCHIVE).read_bytes() == first


def test_a_lost_or_damaged_archive_is_noticed(game, capsys):
    game.build()
    (game.folder / ARCHIVE).unlink()
    assert len(game.build().built) == len(SAID)
    (game.folder / ARCHIVE).write_bytes(b"LLTAKES\0 damaged")
    assert main(["build"]) == 2
    assert "facefx.takes: is a damaged archive (its header ends early)" in capsys.readouterr().err


def forged(content, change):
    """Return an archive whose index is changed, with the checksum that fits."""
    head = TAKES_HEADER.unpack_from(content)
    index, takes = head[6], head[7]
    data = bytearray(content)
    change(data, index, (takes - index) // INDEX_SLOT.size)
    struct.pack_into("<I", data, HEAD_CRC_AT, _head_crc(bytes(data[:takes])))
    return bytes(data)


def test_an_archive_whose_takes_share_bytes_is_refused(game):
    """One record behind a million names would be a million takes in memory."""
    game.build()

    def share(data, index, slots):
        places = [index + number * INDEX_SLOT.size for number in range(slots)]
        used = [place for place in places if INDEX_SLOT.unpack_from(data, place)[0]]
        for place in used:
            data[place : place + INDEX_SLOT.size] = data[used[0] : used[0] + INDEX_SLOT.size]

    path = game.folder / ARCHIVE
    path.write_bytes(forged(path.read_bytes(), share))
    with pytest.raises(OutputError, match=r"is a damaged archive \(its takes overlap\)"):
        read_takes(path)


def test_prune_removes_takes(game):
    game.build()
    game.script([f"line{number}" for number in range(2)])
    game.build("--prune")
    assert [*members(game.folder / ARCHIVE)] == ["english/line0.keys", "english/line1.keys"]


def test_shards_are_disjoint(game):
    counts = [len(game.build("--shard", f"{n}/{SHARDS}").built) for n in range(1, SHARDS + 1)]
    assert sum(counts) == len(SAID)
    assert not game.build("--shard", f"1/{SHARDS}").built


def test_shards_of_lines_do_not_move():
    shards = [Shard(number, 16) for number in range(1, 17)]
    homes = [[s.number for s in shards if s.has("english", f"l{n}")] for n in range(500)]
    assert all(len(home) == 1 for home in homes)
    assert len({home[0] for home in homes}) == 16
    assert homes[7] == [next(s.number for s in shards if s.has("english", "l7"))]
    for bad in ("0/3", "4/3", "3", "a/b", "-1/3"):
        with pytest.raises(LipsyncError, match="such as 3/16"):
            Shard.parse(bad)


def records(path):
    """Return the bytes of each take as they stand in an archive."""
    players = pytest.importorskip(
        "lipsync_lang.plugins.players.takes", reason="the players are removed"
    )
    names = read_takes(path).takes
    with players.Archive(path) as opened:
        return {name: opened.data[slice(*opened.find(name))] for name in names}


def test_a_build_after_one_bigram_performs_what_changed_and_copies_the_rest(game):
    game.build()
    before = records(game.folder / ARCHIVE)
    game.bank(0.7)
    built = game.build().built
    after = records(game.folder / ARCHIVE)
    changed = [name for name in after if after[name] != before[name]]
    assert 0 < len(built) < len(SAID)
    assert changed == [f"english/{one}" for one in built]


def test_only_takes_go_into_an_archive(game, capsys):
    game.write("lipsync.yaml", PROJECT.replace("takes/{id}.csv", "crab.takes/{id}.csv"))
    assert main(["build"]) == 2
    assert "holds takes only" in capsys.readouterr().err
