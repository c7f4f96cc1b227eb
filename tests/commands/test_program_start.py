"""The program in a process of its own: pipes, full disks, terminals and folders that are gone."""

import gc
import json
import os
import subprocess
import sys

import pytest
from command_line import PAIR
from lanes import full, swept

from lipsync_lang.__main__ import main as program
from lipsync_lang.cli import main

pytestmark = pytest.mark.usefixtures("folder")


def start(*arguments, **rest):
    rest = {"capture_output": True, "encoding": "utf-8", "check": False, "timeout": 60} | rest
    return subprocess.run(arguments, **rest)  # noqa: PLW1510 it is in rest


def script():
    name = "lipsync-lang.exe" if sys.platform == "win32" else "lipsync-lang"
    return os.path.join(os.path.dirname(sys.executable), name)  # noqa: PTH118, PTH120 a string


@pytest.mark.parametrize("program", swept([[sys.executable, "-m", "lipsync_lang"], [script()]]))
def test_the_program_starts_in_both_ways(program):
    done = start(*program, "run", *PAIR, "--schedule", "line.json", "-o", "line.csv")
    assert (done.returncode, done.stdout) == (0, "")
    assert "wrote line.csv" in done.stderr
    done = start(*program, "run", *PAIR, "--schedule", "lien.json")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "lipsync-lang: lien.json: cannot be read: No such file or directory; check the path\n"
    )


def test_only_the_program_changes_how_python_collects(monkeypatch, capsys):
    usual = gc.get_threshold()
    try:
        gc.set_threshold(700)  # as Python does; the tests collect more rarely
        monkeypatch.setattr(sys, "argv", ["lipsync-lang", "voices"])
        assert main() == 0
        assert gc.get_threshold()[0] == 700
        assert program() == 0
        assert gc.get_threshold()[0] > 700
    finally:
        gc.set_threshold(*usual)
    capsys.readouterr()


def test_the_program_collects_rarely_before_it_imports():
    code = (
        "import gc, sys\n"
        "from lipsync_lang.__main__ import main\n"
        "before = gc.get_stats()[0]['collections']\n"
        "sys.argv = ['lipsync-lang', '--version']\n"
        "try: main()\n"
        "except SystemExit: print(gc.get_stats()[0]['collections'] - before)"
    )
    assert start(sys.executable, "-c", code).stdout.split()[-1] == "0"


@full
@pytest.mark.skipif(sys.platform == "win32", reason="pipes end otherwise there")
@pytest.mark.parametrize("arguments", [["--help"], ["bank", "draft", *PAIR], ["schema", "bank"]])
def test_a_reader_who_has_seen_enough_is_no_error(arguments):
    command = [sys.executable, "-m", "lipsync_lang", *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0


@full
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")  # noqa: PTH110
def test_a_full_disk_is_told():
    with open("/dev/full", "wb") as full:  # noqa: PTH123 a device
        command = [sys.executable, "-m", "lipsync_lang", "schema", "bank"]
        done = start(*command, capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 2
    assert done.stderr == "lipsync-lang: No space left on device\n"


@full
def test_a_terminal_that_knows_few_letters_still_gets_everything():
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    command = [sys.executable, "-m", "lipsync_lang", "languages", "show", "english"]
    done = start(*command, env=environment)
    assert (done.returncode, done.stderr) == (0, "")
    done = start(*command, "--json", env=environment)
    assert "ʃ" in [row["label"] for row in json.loads(done.stdout)["notations"]["ipa"]]


@pytest.mark.skipif(sys.platform == "win32", reason="a folder in use stays there")
def test_a_folder_that_is_gone_is_told(tmp_path):
    gone = tmp_path / "gone"
    command = f"mkdir '{gone}' && cd '{gone}' && rmdir '{gone}' && exec {sys.executable} -m "
    done = start("sh", "-c", f"{command} lipsync_lang languages")
    assert done.returncode == 2
    assert done.stderr == ("lipsync-lang: the current folder no longer exists; change to another\n")
