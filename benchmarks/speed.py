"""Print how fast things are, beside their goals.

python benchmarks/speed.py [--only SECTION] [--lines N] [--json FILE] [--page FILE]
python benchmarks/speed.py --against REVISION [--lines N]

Each section runs in a process of its own, so that its peak memory is its own. Times are the least
of some runs. The column `no kernel` has them with LIPSYNC_LANG_KERNEL=off, `peak` the memory of the
largest process, and `loop` the time of an empty loop of 3,000,000, taken right after.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # every command would compile every module

import speed_against
import speed_builds
import speed_game
import speed_performing
import speed_script
from speed_table import HEAD, Figures, Row, read_rows

from lipsync_lang.base.version import __version__
from lipsync_lang.pipeline import kernel

Section = Callable[[Figures, argparse.Namespace], None]

SECTIONS: dict[str, Section] = {
    "utterance": speed_performing.utterance,
    "batch": speed_performing.batch,
    "stream": speed_performing.stream,
    "resolve": speed_performing.resolve,
    "start": speed_performing.start,
    "hour": speed_performing.hour,
    "build": speed_builds.build,
    "spoken": speed_builds.spoken,
    "aligned": speed_builds.aligned,
    "dask": speed_builds.dask,
}

LINES = 400
"""Lines of a build, unless others are asked for."""


def machine() -> dict[str, str | int]:
    """Return what the figures were measured on."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {
        "cores": cores or 1,
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "lipsync-lang": __version__,
        "stages": kernel.summary(),
    }


def measure(section: str, options: argparse.Namespace) -> int:
    """Measure a section in this process."""
    try:
        SECTIONS[section](Figures(section, options.rows), options)
    except speed_script.BuildError as error:
        print(f"{section}: {error}", file=sys.stderr)
        return 1
    return 0


def parsed() -> argparse.Namespace:
    """Parse the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", action="append", choices=SECTIONS, help="may be repeated [all]")
    parser.add_argument("--lines", type=int, default=LINES, help="lines of a build [%(default)s]")
    parser.add_argument("--json", type=Path, help="file for the figures")
    parser.add_argument("--page", type=Path, help="page whose first text block the figures replace")
    parser.add_argument("--against", metavar="REVISION", help="print ratios to another revision")
    parser.add_argument("--rows", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.lines < 2 * speed_script.EDITED:
        parser.error(f"--lines: at least {2 * speed_script.EDITED}")
    return options


def heading(section: str) -> str:
    """Return the line above the figures of a section."""
    return f"\n{section}: {(SECTIONS[section].__doc__ or '').rstrip('.')}"


def top(there: Mapping[str, str | int]) -> str:
    """Return the lines above all figures."""
    return ", ".join(f"{name} {value}" for name, value in there.items()) + f"\n{HEAD}"


def write_page(page: Path, there: Mapping[str, str | int], rows: Sequence[Row]) -> None:
    """Put the figures into the first text block of a page."""
    lines = [top(there)]
    for section in SECTIONS:
        own = [str(row) for row in rows if row.section == section]
        lines += [heading(section), *own] if own else []
    block = "\n".join([*lines, *speed_game.calculation(rows)])
    before, rest = page.read_text("utf-8").split("```text\n", 1)
    page.write_text(f"{before}```text\n{block}\n```{rest.partition('```')[2]}", "utf-8")


def main() -> int:
    """Measure each section in a process of its own; return 1 if one of them failed."""
    options = parsed()
    if options.rows:
        return measure(options.only[0], options)
    if options.against:
        for line in speed_against.compare(options.against, options.lines):
            print(line)
        return 0
    there = machine()
    print(top(there), flush=True)
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        os.environ["LIPSYNC_LANG_CACHE"] = str(Path(folder) / "cache")
        file = Path(folder) / "rows.jsonl"
        for section in options.only or SECTIONS:
            print(heading(section), flush=True)
            own = [__file__, "--only", section, "--lines", str(options.lines), "--rows", str(file)]
            failed |= bool(subprocess.call([sys.executable, *own]))  # noqa: S603 ourselves
        rows = read_rows(file)
    for line in speed_game.calculation(rows):
        print(line)
    if options.json:
        said = {"machine": there, "lines": options.lines, "rows": [asdict(row) for row in rows]}
        options.json.write_text(json.dumps(said, indent=1) + "\n", "utf-8")
    if options.page:
        write_page(options.page, there, rows)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
