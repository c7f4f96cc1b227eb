"""Archives put together, and patches of them."""

import json
import shutil

import pytest
from production.builds.build_project import ARCHIVE, SAID, archived_game

from lipsync_lang.cli import main
from lipsync_lang.production.builds.takes import read_takes

SHARDS = 3


@pytest.fixture
def game(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    return archived_game(tmp_path, capsys)


def test_shards_are_disjoint_and_merge_to_the_bytes_of_one_build(game):
    game.build()
    whole = (game.folder / ARCHIVE).read_bytes()
    counts = [len(game.build("--shard", f"{n}/{SHARDS}").built) for n in range(1, SHARDS + 1)]
    assert sum(counts) == len(SAID)
    assert not game.build("--shard", f"1/{SHARDS}").built
    parts = sorted(str(path) for path in (game.folder / "takes").glob("*-of-3.takes"))
    assert main(["archive", "merge", "merged.takes", *parts]) == 0
    assert (game.folder / "merged.takes").read_bytes() == whole
    assert main(["archive", "merge", "again.takes", *reversed(parts), ARCHIVE]) == 0
    assert (game.folder / "again.takes").read_bytes() == whole


def test_a_patch_after_one_bigram_holds_only_what_changed(game, capsys):
    game.build()
    shutil.copy(game.folder / ARCHIVE, "old.takes")
    game.bank(0.7)
    changed = game.build().built
    assert 0 < len(changed) < len(SAID)
    assert main(["archive", "diff", "old.takes", ARCHIVE, "crab.patch"]) == 0
    assert len(read_takes(game.folder / "crab.patch").takes) == len(changed)
    assert main(["archive", "apply", "old.takes", "crab.patch", "-o", "new.takes"]) == 0
    assert (game.folder / "new.takes").read_bytes() == (game.folder / ARCHIVE).read_bytes()
    assert main(["archive", "apply", ARCHIVE, "crab.patch"]) == 2
    assert "is not the archive that crab.patch was made for" in capsys.readouterr().err
    assert main(["archive", "merge", "x.takes", "old.takes", "new.takes"]) == 2
    assert "differs from that of old.takes" in capsys.readouterr().err
    assert main(["archive", "show", "--json", "crab.patch"]) == 0
    assert len(json.loads(capsys.readouterr().out)) == len(changed)
