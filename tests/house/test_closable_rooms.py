"""Rooms that can be closed: without their folders, the rest of the program works."""

import os
import shutil
import subprocess
import sys

import pytest
from lanes import full
from places import ROOT

CLOSABLE = (
    *(f"plugins/{room}" for room in ("capture", "cluster", "mfa", "smartbody", "study")),
    "faces/players",
)
"""Rooms that register by entry points, and that no other room imports."""

REST = ("production/builds", "packs", "performing", "resolver", "schedules")
"""Rooms whose quick tests run without all of them."""


@pytest.fixture
def without(tmp_path):
    """Copy the checkout, and remove some rooms with their tests."""

    def remove(*rooms):
        for name in ("lipsync_lang", "languages", "posesets", "tests"):
            shutil.copytree(ROOT / name, tmp_path / name)
        shutil.copy(ROOT / "pyproject.toml", tmp_path)
        for room in rooms:
            shutil.rmtree(tmp_path / "lipsync_lang" / room)
            shutil.rmtree(tmp_path / "tests" / room)

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
    python = without(room)
    shown = python("-m", "lipsync_lang", "--help")
    assert (shown.returncode, shown.stderr) == (0, "")
    assert ("study" in shown.stdout) == (room != "study")
    line = ("run", "Hello", "-l", "english", "-c", "facefx", "--tts", "none", "-o", "csv:-")
    ran = python("-m", "lipsync_lang", *line)
    assert ran.returncode == 0
    assert ran.stdout.startswith("time_s,")
    checked = python("-m", "lipsync_lang", "validate", "languages/finnish.yaml", "--no-tests")
    assert checked.returncode == 0
    told = python("-m", "lipsync_lang", "bank", "--help")
    assert ("SmartBody" in told.stdout, "captures of" in told.stdout) == (
        room != "smartbody",
        room != "capture",
    )


@full
def test_quick_tests_pass_without_all_these_rooms(without):
    python = without(*CLOSABLE)
    folders = [f"tests/{room}" for room in REST]
    ran = python("-m", "pytest", "-m", "not full", "-p", "no:cacheprovider", *folders)
    assert ran.returncode == 0, ran.stdout[-3000:]
