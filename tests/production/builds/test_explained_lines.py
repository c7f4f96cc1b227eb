"""A line of the script, explained by its id alone."""

import json
from pathlib import Path

import pytest
from build_project import Game


@pytest.fixture
def game(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    return Game(tmp_path, capsys)


def weights_of(line, frame):
    """Return the weights that a build has written for a frame of a line."""
    (path,) = [one for one in Path().rglob(f"{line}.csv") if one.name != "script.csv"]
    names, *rows = (row.split(",") for row in path.read_text("utf-8").splitlines())
    return dict(zip(names[1:], map(float, rows[frame][1:]), strict=True))


def test_a_line_is_explained_as_it_was_built(game, cli):
    assert game.build().code == 0
    ended = cli("explain", "--line", "low", "--at", "0.15", "--json")
    assert ended.code == 0
    assert ended.err.startswith("script.csv:2: english on facefx\n")
    found = json.loads(ended.out)
    shown = {one["pose"]: one["weight"] for one in found["poses"]}
    assert shown
    built = weights_of("low", found["frame"])
    assert {name: weight for name, weight in built.items() if name in shown} == pytest.approx(
        shown, abs=1e-3
    )


@pytest.mark.usefixtures("game")
def test_a_pair_chooses_among_those_of_a_line(cli):
    ended = cli("explain", "--line", "low", "--at", "0.1", "-c", "facefx", "-l", "english")
    assert ended.code == 0
    ended = cli("explain", "--line", "low", "--at", "0.1", "-c", "arkit")
    assert (ended.code, ended.out) == (2, "")
    assert "the script has 'low' on other pairs: -l english -c facefx" in ended.err


@pytest.mark.usefixtures("game")
def test_an_unknown_line_is_refused_with_the_nearest(cli):
    ended = cli("explain", "--line", "maip", "--at", "0.1")
    assert ended.code == 2
    assert "the script has no line 'maip'; did you mean 'map'?" in ended.err


def test_a_folder_without_a_project_has_no_lines(tmp_path, monkeypatch, cli):
    monkeypatch.chdir(tmp_path)
    ended = cli("explain", "--line", "low", "--at", "0.1")
    assert ended.code == 2
    assert "--line alone names a line of a script, but this folder has no lipsync.yaml" in ended.err
