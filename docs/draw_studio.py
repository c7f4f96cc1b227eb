"""Draw the pictures of the studio, still and moving, into docs/images or another folder.

    python docs/draw_studio.py [FOLDER]

A headless browser uses the studio as the tests do (tests/browser/studio.mjs), so it needs what they
need: Chromium, and LIPSYNC_LANG_NODE_MODULES with playwright-core. Pillow writes the pictures.
"""  # noqa: INP001 a script, not a package

import argparse
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

ROOT = Path(__file__).parent
STORIES = ROOT.parent / "tests" / "browser" / "studio.mjs"

STILLS = ("sentence", "matrix", "bigram", "character", "words", "coverage", "language")
"""Pictures of the story `album`."""

COLOURS = 192
"""Colours of a picture; more make it larger, and look the same."""

FILM_MS, FILM_PIXELS = 90, (960, 540)


def tell(story: str, character: str, folder: Path) -> dict[str, object]:
    """Run a story in a new project; its pictures go to a folder."""
    with TemporaryDirectory() as project:
        command = [sys.executable, "-m", "lipsync_lang", "studio", "-l", "english", "-c", character]
        studio = subprocess.Popen(  # noqa: S603 our own program
            [*command, "--no-browser"], cwd=project, stdout=subprocess.PIPE, encoding="utf-8",
            env=os.environ | {"XDG_STATE_HOME": project},
        )  # fmt: skip
        assert studio.stdout is not None  # noqa: S101 it was asked for
        address = studio.stdout.readline().split()[-1]
        node, browser = shutil.which("node") or "node", shutil.which("chromium") or "chromium"
        modules = os.environ["LIPSYNC_LANG_NODE_MODULES"]
        done = subprocess.run(  # noqa: S603 as above
            [node, STORIES, modules, browser, address, story, folder],
            stdout=subprocess.PIPE, encoding="utf-8", check=True,
        )  # fmt: skip
        studio.terminate()
        studio.wait()
    told: dict[str, object] = json.loads(done.stdout.splitlines()[-1])
    return told


def moving(frames: list[Path], path: Path, size: tuple[int, int], milliseconds: int) -> None:
    """Write frames as an animated WebP."""
    pictures = [Image.open(frame).convert("RGB").resize(size, Image.LANCZOS) for frame in frames]
    pictures[0].save(
        path, save_all=True, append_images=pictures[1:], duration=milliseconds, loop=0,
        quality=70, method=6,
    )  # fmt: skip


def main() -> None:
    """Draw the pictures."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "images")
    folder = parser.parse_args().folder
    with TemporaryDirectory() as made:
        drawn = Path(made)
        tell("album", "crab", drawn)
        for name in STILLS:
            picture = Image.open(drawn / f"{name}.png").convert("RGB")
            picture.quantize(COLOURS).save(folder / f"studio-{name}.png", optimize=True)
        tell("film", "crab", drawn)
        moving(sorted(drawn.glob("film-*.png")), folder / "studio.webp", FILM_PIXELS, FILM_MS)


if __name__ == "__main__":
    main()
