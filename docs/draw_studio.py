"""Draw the pictures of the studio, of the page of a line and of that of a voice into docs/images.

    python docs/draw_studio.py [FOLDER] [--only studio|hour|line|voice]

A headless browser uses them by scripts of tests/browser, so it needs what the tests need: Chromium,
and LIPSYNC_LANG_NODE_MODULES with playwright-core. Pillow writes the pictures.
"""

import argparse
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

import lipsync_lang as ll

ROOT = Path(__file__).parent
BROWSING = ROOT.parent / "tests" / "browser"

STILLS = ("sentence", "matrix", "bigram", "character", "words", "coverage", "language")
"""Pictures of the story `album`."""

COLOURS = 192
"""Colours of a picture; more make it larger, and look the same."""

FILM_MS, FILM_PIXELS, VOICE_PIXELS = 90, (960, 540), (800, 368)
HOUR_MS, HOUR_PIXELS = 1600, (980, 630)

PAGED = "Please buy five more maps before Bob moves away."

SAID = "Bob may buy a map of Mali by now, or so my mother told me."


@contextmanager
def served(*command: str) -> Iterator[str]:
    """Run a command with a page in a new project, and yield its address."""
    with TemporaryDirectory() as project:
        program = subprocess.Popen(  # noqa: S603 our own program
            [sys.executable, "-m", "lipsync_lang", *command, "--no-browser"], cwd=project,
            stdout=subprocess.PIPE, encoding="utf-8", env=os.environ | {"XDG_STATE_HOME": project},
        )  # fmt: skip
        assert program.stdout is not None  # noqa: S101 it was asked for
        try:
            yield program.stdout.readline().split()[-1]
        finally:
            program.terminate()
            program.wait()


def browse(script: str, *arguments: str | Path) -> None:
    """Run a script of the browser tests."""
    node, browser = shutil.which("node") or "node", shutil.which("chromium") or "chromium"
    modules = os.environ["LIPSYNC_LANG_NODE_MODULES"]
    subprocess.run(  # noqa: S603 our own script
        [node, BROWSING / script, modules, browser, *arguments],
        stdout=subprocess.DEVNULL, check=True,
    )  # fmt: skip


def moving(
    frames: list[Path], path: Path, size: tuple[int, int], milliseconds: int | list[int]
) -> None:
    """Write frames as an animated WebP; each lasts as long as stated, or all as long."""
    pictures = [Image.open(frame).convert("RGB").resize(size, Image.LANCZOS) for frame in frames]
    pictures[0].save(
        path, save_all=True, append_images=pictures[1:], duration=milliseconds, loop=0,
        quality=70, method=6,
    )  # fmt: skip


def draw_studio(folder: Path) -> None:
    """Draw the views of the studio, and a line that changes."""
    with TemporaryDirectory() as made, served("studio", "-l", "english", "-c", "crab") as address:
        drawn = Path(made)
        browse("studio.mjs", address, "album", drawn)
        for name in STILLS:
            picture = Image.open(drawn / f"{name}.png").convert("RGB")
            picture.quantize(COLOURS).save(folder / f"studio-{name}.png", optimize=True)
    with TemporaryDirectory() as made, served("studio", "-l", "english", "-c", "crab") as address:
        browse("studio.mjs", address, "film", Path(made))
        moving(sorted(Path(made).glob("film-*.png")), folder / "studio.webp", FILM_PIXELS, FILM_MS)


def draw_hour(folder: Path) -> None:
    """Draw an hour of an animator, as the test of it goes by."""
    with TemporaryDirectory() as made:
        subprocess.run(  # noqa: S603 our own test
            [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "full",
             BROWSING / "test_hour_browser.py"],
            cwd=ROOT.parent, env=os.environ | {"LIPSYNC_LANG_STUDIO_PICTURES": made}, check=True,
        )  # fmt: skip
        moving(sorted(Path(made).glob("*.png")), folder / "studio-hour.webp", HOUR_PIXELS, HOUR_MS)


def draw_line(folder: Path) -> None:
    """Draw the page of a line on a desktop, and on a phone beside that of two takes."""
    with TemporaryDirectory() as made:
        drawn = Path(made)
        line, takes = drawn / "line.html", drawn / "takes.html"
        run = [sys.executable, "-m", "lipsync_lang", "run", PAGED, "-l", "english", "-c", "facefx"]
        for page, more in ((line, ()), (takes, ("--against", "keyframes"))):
            subprocess.run([*run, *more, "-o", page], check=True)  # noqa: S603 our own program
        browse("line_album.mjs", line, takes, drawn)
        files = [drawn / f"{name}.png" for name in ("desktop", "light", "dark")]
        desktop, light, dark = (Image.open(file).convert("RGB") for file in files)
        phones = Image.new("RGB", (light.width + dark.width, light.height))
        phones.paste(light, (0, 0))
        phones.paste(dark, (light.width, 0))
        for name, picture in (("line-page", desktop), ("line-page-phone", phones)):
            picture.quantize(COLOURS).save(folder / f"{name}.png", optimize=True)


def draw_voice(folder: Path) -> None:
    """Draw the page of a voice as somebody talks; the browser hears a recording."""
    with TemporaryDirectory() as made, served("live", "--page", "-c", "facefx") as address:
        drawn, recording = Path(made), Path(made) / "voice.wav"
        performer = ll.resolve("english", "facefx")
        performer.perform(ll.speak(SAID, "english")).save(recording)
        browse("voice.mjs", address, recording, drawn)
        frames = sorted(drawn.glob("*.png"))
        at = [round(1000 * float(frame.stem)) for frame in frames]
        lasts = [after - before for before, after in pairwise(at)]
        moving(frames[:-1], folder / "voice-page.webp", VOICE_PIXELS, lasts)


DRAWN = {"studio": draw_studio, "hour": draw_hour, "line": draw_line, "voice": draw_voice}


def main() -> None:
    """Draw the pictures."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "images")
    parser.add_argument("--only", choices=DRAWN)
    options = parser.parse_args()
    for name in [options.only] if options.only else DRAWN:
        DRAWN[name](options.folder)


if __name__ == "__main__":
    main()
