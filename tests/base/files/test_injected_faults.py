"""Each act on files fails once: a message, and no damaged or forgotten file."""

import errno

import injected_faults
import pytest
from build_project import Game
from forked import FORKS, forked
from lanes import swept

MOST_FAULTS = 6

BANKS = ("posesets/facefx/banks/common.yaml", "posesets/facefx/banks/more.yaml")

COMMANDS = {
    "run": ("run", "--schedule", "vo/map.json", "-l", "english", "-c", "facefx", "-o", "a.csv",
            "-o", "a.json"),
    "build": ("build",),
    "save": ("save", *BANKS),
    "bank": ("bank", "draft", "-l", "english", "-c", "facefx", "--write", "l-ow"),
}  # fmt: skip


def made(folder, name):
    """Make a project that is built, performed or drafted in, or whose two banks are edited."""
    folder.mkdir()
    game = Game(folder, None)
    if name == "save":
        game.bank(0.5)
        common, more = (folder / bank for bank in BANKS)
        more.write_text(common.read_text("utf-8").replace("name: common", "name: more"), "utf-8")
    return folder


def ran(folder, number, code, command):
    """Run a command with a fault, and return its process and the number of its acts."""
    done = forked(injected_faults.main, number, code, str(folder), *command, folder=folder)
    # After some errors the command line closes its output; then the number of acts is not told.
    told = done.stdout.splitlines() or ["0"]
    return done, int(told[-1].split()[0])


def contents(folder):
    """Return the outputs of a folder; a record of a build states times."""
    files = (path for path in folder.rglob("*") if path.is_file() and ".lipsync" not in str(path))
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


@pytest.mark.skipif(not FORKS, reason="no processes to copy")
@pytest.mark.parametrize("name", swept(COMMANDS, quick=["run"]))
def test_one_fault_of_files_is_told_and_leaves_whole_files(tmp_path, name):
    whole = made(tmp_path / "whole", name)
    before = contents(whole)
    done, acts = ran(whole, 0, 0, COMMANDS[name])
    assert done.returncode == 0, done.stderr
    after = contents(whole)
    assert after != before
    assert acts >= 3
    for number in range(1, acts + 1, max(1, acts // MOST_FAULTS)):
        code = (errno.ENOSPC, errno.EACCES, errno.EIO)[number % 3]
        folder = made(tmp_path / str(number), name)
        done, _ = ran(folder, number, code, COMMANDS[name])
        assert done.returncode in (0, 1, 2), done.stderr
        assert "Traceback" not in done.stderr
        assert done.returncode == 0 or done.stderr.strip()
        for path, content in contents(folder).items():
            assert content in (before.get(path), after.get(path)), f"act {number}: {path}"
        left = [path.name for path in folder.rglob("*.lipsync-tmp")]
        assert len(left) <= 1, f"act {number}: a file that could not be deleted may stay"
        ran(folder, 0, 0, COMMANDS[name])
        assert contents(folder) == after, f"after act {number}, the next start"
        assert not [*folder.rglob("*.lipsync-tmp")], f"act {number}"
