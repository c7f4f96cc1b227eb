"""Rooms that can be closed, the plug-ins: without their folders, the rest of the program works."""

import json
import os
import shutil
import subprocess
import sys

import pytest
from lanes import full
from pages import Ended
from places import ROOT

PLUG_INS = (
    *("archives", "capture", "cluster", "festival", "g2p", "heads", "htk", "mfa", "mouths"),
    *("phonemizer", "programs", "scripts", "smartbody", "study", "timings", "whisper"),
)

"""Rooms that register by entry points."""

CLOSABLE = (*(f"plugins/{room}" for room in (*PLUG_INS, "players")), "plugins")

ASKING = {
    "animations": ("test_read_animations",),
    "base": ("files/test_outputs", "presentation/test_output_escaping"),
    "docs": ("test_blender_panel", "test_docs", "test_the_paper"),
    "fuzz": ("test_fuzz",),
    "packs": ("test_checked_as_run",),
    "production/builds": (
        *("test_build", "test_new_project", "test_planning_faults", "test_project"),
        *("test_script", "test_takes_builds"),
    ),
    "reports/quality": ("test_articulography",),
    "resolver": ("test_posesets",),
    "sound/speech": (
        *("test_acoustic_models", "test_adaptation", "test_alignment", "test_lacking_words"),
        *("test_many_recordings", "test_many_texts", "test_recognition", "test_speaking"),
        "test_speech",
    ),
    "text/lines": ("test_independent_readings", "test_lines"),
    "text/phonology": ("test_g2p", "test_languages", "test_lips_of_letters"),
}
"""Modules of tests that ask a registry for names beyond the built-in ones, which plug-ins have.
Their room has such a registry, or one of their quick tests needs a plug-in."""

PARTS = (
    ("commands", "house"),
    [f"{room}/{module}.py" for room, modules in ASKING.items() for module in modules],
)
"""Tests that run without the wing: the commands, the rules of the house, and what asks. The rules
let no other room import a plug-in, so the others can only fail where a test itself needs one: all
modules of tests are imported."""


COMMANDS = """
import json, sys
from contextlib import redirect_stderr, redirect_stdout
from io import BytesIO, TextIOWrapper
from lipsync_lang.cli import main

def run(words):
    out, err = (TextIOWrapper(BytesIO(), "utf-8", write_through=True) for _ in range(2))
    with redirect_stdout(out), redirect_stderr(err):
        try:
            code = main(words)
        except SystemExit as ended:
            code = ended.code or 0
    return code, *(stream.buffer.getvalue().decode() for stream in (out, err))

print(json.dumps([run(words) for words in json.loads(sys.argv[1])]))
"""
"""Runs commands one after the other: to start the program for each takes longer."""

QUICK_TESTS = ("-m", "pytest", "-m", "not full", "-p", "no:cacheprovider")


@pytest.fixture
def without(tmp_path):
    """Copy the checkout, or the program alone, and remove some rooms or wings with their tests."""

    def remove(*rooms, alone=False):
        # Compiled modules go along, as times of files are kept: compiling takes 20 s.
        rubbish = (".git", ".venv", ".*_cache", "build", "node_modules")
        rubbish += ("tests", "docs") if alone else ()
        ignored = shutil.ignore_patterns(*rubbish)
        shutil.copytree(ROOT, tmp_path, ignore=ignored, dirs_exist_ok=True)
        for room in rooms:
            shutil.rmtree(tmp_path / "lipsync_lang" / room)
            shutil.rmtree(tmp_path / "tests" / room, ignore_errors=alone)

        def python(*arguments):
            environment = os.environ | {"PYTHONPATH": str(tmp_path)}
            options = {"cwd": tmp_path, "env": environment, "capture_output": True}
            return subprocess.run(
                [sys.executable, *arguments], encoding="utf-8", check=False, **options
            )

        return python

    return remove


@full
@pytest.mark.parametrize("room", CLOSABLE)
def test_the_program_works_without_a_room(without, room):
    python = without(room, alone=True)
    there = set(PLUG_INS) - ({*PLUG_INS} if room == "plugins" else {room.rpartition("/")[2]})
    line = ("run", "Hello", "-l", "english", "-c", "facefx", "--tts", "none", "-o", "csv:-")
    check = ("validate", "languages/finnish.yaml", "--no-tests")
    done = python("-c", COMMANDS, json.dumps([["--help"], line, check, ["bank", "--help"]]))
    assert (done.returncode, done.stderr) == (0, "")
    shown, ran, checked, told = map(Ended._make, json.loads(done.stdout))
    assert (shown.code, shown.err) == (0, "")
    assert ("study" in shown.out) == ("study" in there)
    assert ran.code == 0
    assert ran.out.startswith("time_s,")
    assert checked.code == 0
    assert ("SmartBody" in told.out, "captures of" in told.out) == (
        "smartbody" in there,
        "capture" in there,
    )


@full
def test_the_doctor_names_every_plug_in_that_was_removed(without):
    found = json.loads(without("plugins")("-m", "lipsync_lang", "doctor", "--json").stdout)
    lost = {one["part"]: one["told"] for one in found if "was removed" in one["told"]}
    assert lost.keys() == {f"plug-in {name}" for name in PLUG_INS}
    assert "no command 'bank fit'" in lost["plug-in capture"]
    assert "no command 'heads'" in lost["plug-in heads"]
    assert "no aligner 'mfa'" in lost["plug-in mfa"]
    assert "no acoustic model 'htk'" in lost["plug-in htk"]
    assert "no speech engine 'festival'" in lost["plug-in festival"]
    assert "no recogniser 'whisper'" in lost["plug-in whisper"]
    assert "no line reader 'renpy'" in lost["plug-in scripts"]


@full
@pytest.mark.parametrize("part", PARTS, ids=("rules", "asking"))
def test_quick_tests_pass_without_the_plug_ins(without, part):
    ran = without("plugins")(*QUICK_TESTS, *(f"tests/{one}" for one in part))
    assert ran.returncode == 0, ran.stdout[-3000:]


@full
def test_every_test_can_be_imported_without_the_plug_ins(without):
    ran = without("plugins")(*QUICK_TESTS, "--collect-only", "tests")
    assert ran.returncode == 0, ran.stdout[-3000:]
