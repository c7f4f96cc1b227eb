"""Draw eight sounds on a head as a revision of the program shows them, and as it does today.

    python docs/draw_before.py REVISION HEAD [-o PICTURE]

The head is a model with the shapes of ARKit, such as one of `lipsync-lang heads`. Needs git and the
extra `video`.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tarfile
from datetime import UTC, datetime
from io import BytesIO
from pathlib import Path
from shutil import copy
from tempfile import TemporaryDirectory

from lipsync_lang.render.sheet import stacked

ROOT = Path(__file__).resolve().parents[1]

SOUNDS = ["AA", "IY", "UW", "M", "F", "TH", "SH", "K"]

CHARACTER = "kind: character\nformat: 1\nname: shown\nposeset: arkit\nmodel: head.glb\n"


def git(*arguments: str) -> bytes:
    """Return the output of a git command in the repository."""
    command = ["git", "-C", str(ROOT), *arguments]
    return subprocess.run(command, check=True, capture_output=True).stdout  # noqa: S603 no shell


def drawn(program: Path, folder: Path) -> bytes:
    """Return a PNG of the sounds by the program in a folder."""
    middles = ",".join(str(1.5 * number + 0.75) for number in range(len(SOUNDS)))
    line = ["-l", "english", "-c", "shown", "--schedule", "sounds.tsv", "--at", middles, "--close"]
    command = [sys.executable, "-m", "lipsync_lang", "stills", *line, "-o", "sounds.png"]
    environment = os.environ | {"PYTHONPATH": str(program)}
    subprocess.run(command, check=True, cwd=folder, env=environment)  # noqa: S603 no shell
    return (folder / "sounds.png").read_bytes()


def main() -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("revision")
    parser.add_argument("head", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("before.png"))
    options = parser.parse_args()
    with TemporaryDirectory() as made:
        folder, program = Path(made), Path(made) / "program"
        (folder / "characters").mkdir()
        (folder / "characters" / "shown.yaml").write_text(CHARACTER, "utf-8")
        copy(options.head, folder / "characters" / "head.glb")
        rows = [f"{1.5 * n + 0.5}\t{1.5 * n + 1}\t{one}\n" for n, one in enumerate(SOUNDS)]
        (folder / "sounds.tsv").write_text("".join(rows), "utf-8")
        with tarfile.open(fileobj=BytesIO(git("archive", options.revision))) as files:
            files.extractall(program, filter="data")
        day = git("log", "-1", "--format=%cs", options.revision).decode().strip()
        today = f"today, {datetime.now(UTC).date()}"
        sheets = {day: drawn(program, folder), today: drawn(ROOT, folder)}
        with options.output.open("wb") as stream:
            stacked(sheets, stream)


if __name__ == "__main__":
    main()
