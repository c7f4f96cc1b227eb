"""Builds as processes: killed, resumed, two at once, over several workers."""

import json
import os
import sqlite3
import subprocess
import sys
from hashlib import blake2b
from pathlib import Path
from shutil import rmtree

import numpy as np
import pytest
from build_project import BANK, PROJECT, Game
from lanes import full

from lipsync_lang.production.builds.records import NEED, Records

pytestmark = full

LINES = 210


def command(*options):
    return [sys.executable, "-m", "lipsync_lang", "build", "--json", *options]


@pytest.fixture
def game(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    made = Game(tmp_path, capsys)
    names = [f"line{number}" for number in range(LINES)]
    for number, name in enumerate(names):
        made.say(name, ["L OW", "M AE P", "M EY L", "HH OW M"][number % 4] + " AH" * (number % 7))
    made.script(names)
    made.write(
        "lipsync.yaml", PROJECT.replace('"takes/{id}.csv"]', '"takes/{id}.csv", "glb/{id}.glb"]')
    )
    return made


def contents(folder):
    """Return the digest of each output, since pytest compares long bytes slowly."""
    return {
        str(path.relative_to(folder)): blake2b(path.read_bytes()).hexdigest()
        for part in ("takes", "glb")
        for path in (folder / part).rglob("*")
        if path.is_file()
    }


def unbuilt(folder):
    """Delete the results of builds."""
    for part in ("takes", "glb", ".lipsync_lang"):
        rmtree(folder / part)


def test_workers_write_the_same_bytes(game):
    assert len(game.build("--workers", "1").built) == LINES
    one = contents(game.folder)
    assert len(one) == 2 * LINES
    assert len(game.build("--workers", "2", "--force").built) == LINES
    assert contents(game.folder) == one


def test_a_killed_build_resumes_and_leaves_nothing_behind(game):
    whole = subprocess.run(command("--workers", "2"), capture_output=True, text=True, check=True)
    expected = contents(game.folder)
    unbuilt(game.folder)
    assert json.loads(whole.stdout.splitlines()[-1])["built"] == LINES
    for kills in range(3):
        running = subprocess.Popen(
            command("--workers", "2"), stdout=subprocess.PIPE, text=True, start_new_session=True
        )
        for _ in range(2 + kills):
            assert running.stdout is not None
            running.stdout.readline()
        os.killpg(running.pid, 9)
        running.communicate()
        for path in game.folder.glob("glb/*.glb"):
            name = f"glb/{path.name}"
            assert contents(game.folder)[name] == expected[name], "what stands is whole"
    told = game.build("--workers", "2")
    assert told.code == 0
    assert 0 < len(told.built) < LINES, "something was made before"
    assert told.end["kept"] == []
    assert contents(game.folder) == expected, "and nothing else lies there"


COLUMNS = {
    "english": "en",
    "mandarin": "schinese",
    "cantonese": "tchinese",
    **{
        name: name
        for name in (
            "czech", "danish", "french", "italian", "japanese", "korean", "malay", "russian",
            "spanish", "ukrainian",
        )
    },
}  # fmt: skip
"""Languages of a game's script by their columns."""

GAME = """\
kind: project
format: 1
lines: script.tsv
columns: {{id: line_id}}
languages: {languages}
cast: {{"*": [facefx, crab, arkit]}}
outputs: ["takes/{{language}}/{{character}}/{{id}}.csv"]
reports: [build/report.html, build/junit.xml]
"""


@pytest.fixture
def real(tmp_path, monkeypatch, data, capsys):
    """A game's script in 13 languages on three characters; a few of its lines."""
    monkeypatch.chdir(tmp_path)
    script = (data / "text/the_question_lines.tsv").read_text("utf-8").splitlines(keepends=True)
    made = Game(tmp_path, capsys)
    made.write("script.tsv", "".join([script[0], *script[12:15]]))
    made.write("lipsync.yaml", GAME.format(languages=json.dumps(COLUMNS)))
    return made


def test_a_real_script_in_13_languages_is_built_killed_and_resumed(real):
    every = 3 * 3 * len(COLUMNS)
    whole = subprocess.run(command(), capture_output=True, text=True, check=True)
    assert json.loads(whole.stdout.splitlines()[-1])["built"] == every == 117
    expected = contents(real.folder)
    assert len({name for name in expected if name.endswith(".csv")}) == every
    for part in ("takes", ".lipsync_lang", "build"):
        rmtree(real.folder / part)
    running = subprocess.Popen(command(), stdout=subprocess.PIPE, text=True, start_new_session=True)
    assert running.stdout is not None
    for _ in range(every // 3):
        running.stdout.readline()
    os.killpg(running.pid, 9)
    running.communicate()
    told = real.build("--workers", "1")
    assert told.code == 0
    assert 0 < len(told.built) < every
    assert contents(real.folder) == expected
    assert {path.name for path in (real.folder / "build").glob("*.*")} == {
        "report.html",
        "junit.xml",
    }


def test_an_edited_bigram_of_a_real_script_remakes_exactly_its_lines(real):
    only = ("-l", "english", "-c", "facefx", "--workers", "1")
    assert len(real.build(*only).built) == 3
    with Records.open(real.folder, write=False) as records:
        needs = {
            name: {records.names[n] for n in np.frombuffer(one.needs, NEED)["number"].tolist()}
            for block in records.blocks()
            for (_, _, name), one in block
        }
    bigrams = sorted({one for some in needs.values() for one in some if one.startswith("bigram ")})
    counts = {one: [name for name in needs if one in needs[name]] for one in bigrams}
    rare, holders = next(
        (one, lines) for one, lines in counts.items() if len(lines) == 1 and "_" not in one
    )
    before = contents(real.folder)
    own = "-".join(rare.split()[1:])
    real.write("posesets/facefx/banks/common.yaml", BANK.format(level=0.9).replace("l-ow", own))
    assert real.build(*only).built == holders
    after = contents(real.folder)
    changed = [name for name in after if before[name] != after[name]]
    assert [Path(name).stem for name in changed] == holders
    assert len(real.build(*only, "--force").built) == 3
    assert contents(real.folder) == after, "no other line had to be made"


def test_two_builds_at_once_share_the_work(game):
    both = [
        subprocess.Popen(command("--workers", "1"), stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    ends = [json.loads(one.communicate()[0].splitlines()[-1]) for one in both]
    assert [one.returncode for one in both] == [0, 0]
    assert sorted(end["built"] for end in ends) == [0, LINES]
    assert len(contents(game.folder)) == 2 * LINES


@pytest.mark.usefixtures("game")
def test_ctrl_c_ends_a_build_quietly():
    running = subprocess.Popen(
        command("--workers", "2"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert running.stdout is not None
    running.stdout.readline()
    running.send_signal(2)
    _, err = running.communicate()
    assert running.returncode == 130
    assert "Traceback" not in err


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_folder_is_named(game):
    Path(game.folder).chmod(0o500)
    told = game.build()
    Path(game.folder).chmod(0o700)
    assert told.code == 2
    assert "writable" in told.err


@pytest.mark.parametrize("writable", [True, False])
def test_a_dry_run_reads_the_record_and_leaves_it(game, monkeypatch, writable):
    game.build()
    record = Path(game.folder) / ".lipsync_lang" / "build.sqlite"
    before = record.read_bytes()
    asked = []
    connect = sqlite3.connect
    monkeypatch.setattr(
        sqlite3, "connect", lambda to, **how: asked.append(to) or connect(to, **how)
    )
    if not writable:
        monkeypatch.setattr(os, "access", lambda *_: False)
    told = game.build("--dry-run")
    assert (told.code, told.stale) == (0, {})
    assert [str(one).endswith("?immutable=1") for one in asked] == [not writable]
    assert record.read_bytes() == before
    assert [one.name for one in record.parent.glob("build.sqlite*")] == [record.name]
