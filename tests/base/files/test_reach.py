"""A project reaches its own folder, and not one beside it whose name begins alike."""

import re
from pathlib import Path

import pytest

from lipsync_lang.base.errors import PackError
from lipsync_lang.base.files.reach import is_reached, refuse_outside


@pytest.mark.parametrize(
    ("path", "reached"),
    [
        ("game", True),
        ("game/lines/one.csv", True),
        ("game/../game/one.csv", True),
        ("games/one.csv", False),
        ("game.csv", False),
        ("gam", False),
        ("game/../one.csv", False),
        (".", False),
    ],
)
def test_a_project_reaches_its_own_folder_alone(tmp_path, path, reached):
    (tmp_path / "game").mkdir()
    assert is_reached(tmp_path / path, tmp_path / "game") == reached


def test_a_project_at_the_root_reaches_all(tmp_path):
    assert is_reached(tmp_path / "one.csv", Path(tmp_path.anchor))


def test_a_link_out_of_the_folder_is_followed(tmp_path):
    (tmp_path / "game").mkdir()
    (tmp_path / "games").mkdir()
    (tmp_path / "game" / "link").symlink_to(tmp_path / "games")
    assert not is_reached(tmp_path / "game" / "link" / "one.csv", tmp_path / "game")
    assert is_reached(tmp_path / "game" / "link", tmp_path / "game", [tmp_path / "games"])


def test_a_path_that_leads_outside_is_called_a_link_only_if_it_is_one(tmp_path):
    project, outside = tmp_path / "project", tmp_path / "outside.yaml"
    project.mkdir()
    outside.write_text("")
    (project / "linked.yaml").symlink_to(outside)
    for path, told in (("linked.yaml", " by a link; "), ("../outside.yaml", "; ")):
        with pytest.raises(PackError, match=f"leads outside {re.escape(str(project))}{told}copy"):
            refuse_outside(project / path, project)
