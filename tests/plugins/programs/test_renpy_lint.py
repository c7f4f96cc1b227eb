"""Ren'Py itself finds no fault in the scripts for it, and finds the drawings and the sounds."""

import os
import shutil
import subprocess
import wave
from base64 import b64decode
from pathlib import Path

import pytest
from lanes import full

import lipsync_lang as ll

pytestmark = full

SOUNDS = ("HH", "AH0", "L", "OW1", "_", "P", "AA1", "F", "UW1", "M")
TEXTS = ('say "50% [off]" {now} \\', "c'est déjà l'été", "ラーメン", "hello\nbig friend")

PIXEL = b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNgAAAAAgABSK+kcQAAAABJRU5ErkJggg=="
)
"""A picture."""

MENDED = """
import ast, builtins, runpy, sys
compiled = builtins.compile

def compile(source, *rest, **named):
    for node in ast.walk(source) if isinstance(source, ast.AST) else ():
        if hasattr(node, "lineno"):
            node.end_lineno = max(node.lineno, node.end_lineno or 0)
    return compiled(source, *rest, **named)

builtins.compile = compile
del sys.argv[0]
runpy.run_path(sys.argv[0], run_name="__main__")
"""
"""Start of Ren'Py 8.0 under Python 3.11, which refuses its lines that end before they start."""


@pytest.fixture
def lint(tmp_path):
    """Return what `lint` of Ren'Py says of a project."""
    found = shutil.which("renpy", path=f"{os.environ.get('PATH', '')}:/usr/games")
    program = Path(found or pytest.skip("no renpy (Debian: renpy)")).resolve()
    python = program.read_text("utf-8").partition("\n")[0].removeprefix("#!").strip()
    hidden = {"SDL_VIDEODRIVER": "dummy", "SDL_AUDIODRIVER": "dummy", "HOME": str(tmp_path)}
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}

    def told(project):
        done = subprocess.run(
            [python, "-c", MENDED, str(program), str(project), "lint"],
            capture_output=True, encoding="utf-8", env=kept | hidden, timeout=300, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return told


def test_renpy_finds_no_fault(tmp_path, lint):
    game = tmp_path / "project" / "game"
    mouth = game / "images" / "mouth"
    for folder in (mouth, game / "audio"):
        folder.mkdir(parents=True)
    calls = ["label start:"]
    for number, text in enumerate(TEXTS):
        schedule = ll.Schedule(
            SOUNDS, [n / 10 for n in range(11)], words=(ll.Word(text, 0, 10),), notation="arpabet"
        )
        path = game / f"line{number}.rpy"
        animation = ll.resolve("english", "rhubarb").perform(schedule)
        animation.save(path)
        for name in (*animation.poses, animation.neutral):
            (mouth / f"{name}.png").write_bytes(PIXEL)
        rows = path.read_text("utf-8").splitlines()
        [label] = (row.split()[1].strip(":") for row in rows if row.startswith("label "))
        [sound] = (row.split('"')[1] for row in rows if row.startswith("    voice "))
        with wave.open(str(game / sound), "wb") as out:
            out.setparams((1, 2, 8000, 0, "NONE", ""))
            out.writeframes(bytes(1600))
        calls.append(f"    call {label}")
    (game / "script.rpy").write_text("\n".join([*calls, "    return", ""]), "utf-8")
    told = lint(game.parent)
    assert f"contains {len(TEXTS)} dialogue blocks" in told
    assert "game/" not in told  # no fault, which would name its place
    (mouth / "A.png").unlink()
    assert "uses file 'images/mouth/A.png', which is not loadable" in lint(game.parent)
