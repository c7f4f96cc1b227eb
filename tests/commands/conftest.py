"""Fixtures of the tests of commands."""

import json

import pytest
from command_line import PAIR, SCHEDULE, TEXTGRID


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Change to a folder with two schedules."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.json").write_text(json.dumps(SCHEDULE), "utf-8")
    (tmp_path / "line.TextGrid").write_text(TEXTGRID, "utf-8")
    return tmp_path


@pytest.fixture
def animate(cli, folder):  # noqa: ARG001 the schedule is in the folder
    """Run `run` on the schedule."""

    def run(*rest):
        return cli("run", *PAIR, "--schedule", "line.json", *rest)

    return run
