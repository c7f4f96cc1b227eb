"""Each act on files fails once: a message, and no damaged or forgotten file."""

import errno
import subprocess
import sys
from pathlib import Path

import pytest
from build_project import Game
from lanes import swept

MOST_FAULTS = 6

SCRIPT = Path(__file__).with_name("injected_faults.py")

COMMANDS = {
    "run": ("run", "--schedule", "vo/map.json", "-l", "english", "-c", "facefx", "-o", "a.csv",
            "-o", "a.json"),
    "bank": ("bank", "draft", "-l", "english", "-c", "facefx", "--write", "l-ow"),
}  # fmt: skip


def ran(folder, number, code, command):
    """Run a command with a fault, and return its process and the number of its acts."""
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(number), str(code), str(folder), *command], check=False,
        cwd=folder, capture_output=True, encoding="utf-8", timeout=120,
    )  # fmt: skip
    return done, int(done.stdout.splitlines()[-1].split()[0])


def contents(folder):
    """Return the outputs of a folder; a record of a build states times."""
    files = (path for path in folder.rglob("*") if path.is_file() and ".lipsync" not in str(path))
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


@pytest.mark.parametrize("name", swept(COMMANDS, quick=["run"]))
def test_one_fault_of_files_is_told_and_leaves_whole_files(tmp_path, name):
    whole = tmp_path / "whole"
    whole.mkdir()
    Game(whole, None)
    before = contents(whole)
    done, acts = ran(whole, 0, 0, COMMANDS[name])
    assert done.returncode == 0, done.stderr
    after = contents(whole)
    assert acts >= 3
    for number in range(1, acts + 1, max(1, acts // MOST_FAULTS)):
        code = (errno.ENOSPC, errno.EACCES, errno.EIO)[number % 3]
        folder = tmp_path / str(number)
        folder.mkdir()
        Game(folder, None)
        done, _ = ran(folder, number, code, COMMANDS[name])
        assert done.returncode in (0, 1, 2), done.stderr
        assert "Traceback" not in done.stderr
        assert done.returncode == 0 or done.stderr.strip()
        for path, content in contents(folder).items():
            assert content in (before.get(path), after.get(path)), f"act {number}: {path}"
        left = [path.name for path in folder.rglob("*.lipsync-tmp")]
        assert len(left) <= 1, f"act {number}: a file that could not be deleted may stay"
