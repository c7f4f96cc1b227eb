# ruff: noqa: S603, T201 - a script, not a package, that runs pip and prints its progress
"""Measure the size of every extra, and write the table of `docs/how-to/install.md`.

    python docs/measure_extras.py [EXTRA ...]    measure all extras, or some of them
    python docs/measure_extras.py --table        write the table from the kept sizes

The script builds the wheel, and pip installs it without bytecode into empty folders: alone, and
then with one extra each. The size of an extra is the difference. `docs/extras_mb.json` keeps the
sizes. `lipsync_lang/base/extras.json` states the purpose of each extra.
"""

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PAGE, SIZES = ROOT / "docs/how-to/install.md", ROOT / "docs/extras_mb.json"
TABLE = re.compile(r"(<!-- made: extras -->\n).*?(<!-- end -->)", re.DOTALL)
MB_BYTES = 1_000_000

GATHERED = {
    "all": ("every extra above except `whisper`", ""),
    "docs": ("builds the documentation site", ""),
}
"""Extras that are no part of the program: the purpose of each, and the commands that use it."""


def names() -> list[str]:
    """Return the extras that users install, in the order of pyproject.toml."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    return [name for name in project["optional-dependencies"] if name != "dev"]


def table(kept: Mapping[str, Any]) -> str:
    """Return the table of all extras, with their kept sizes."""
    told = json.loads((ROOT / "lipsync_lang/base/extras.json").read_text("utf-8"))
    known = {name: (one["purpose"], one["used_by"]) for name, one in told.items()} | GATHERED
    sizes = kept["beyond_core_mb"]
    lines = ["| Extra | Purpose | Commands | MB |", "| --- | --- | --- | ---: |"]
    for name in [*(name for name in names() if name not in GATHERED), *GATHERED]:
        purpose, used_by = known[name]
        commands = ", ".join(f"`{one}`" for one in used_by.split(", ") if one)
        shown = f"{sizes[name]:.1f}" if name in sizes else "not measured"
        lines.append(f"| `{name}` | {purpose} | {commands} | {shown} |")
    system = f"{kept['python']} on {kept['system']}"
    lines += ["", f"The core takes {kept['core_mb']:.0f} MB. Measured on {kept['date']}, {system}."]
    return "\n".join(lines) + "\n"


def written(page: str, kept: Mapping[str, Any]) -> str:
    """Return the page with the table of the kept sizes."""
    return TABLE.sub(lambda found: found[1] + table(kept) + found[2], page)


def size_mb(wheel: Path, extra: str = "") -> float:
    """Install a wheel with an extra into an empty folder; return the size of its files in MB."""
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-compile"]
        named = f"{wheel}[{extra}]" if extra else str(wheel)
        options = ["--disable-pip-version-check", "--prefer-binary", "--target", folder]
        subprocess.run([*command, *options, named], check=True)
        files = [path for path in Path(folder).rglob("*") if path.is_file()]
        return sum(path.stat().st_size for path in files) / MB_BYTES


def measured(extras: list[str]) -> Iterator[dict[str, Any]]:
    """Yield the sizes after each extra that is measured; sizes of other extras are kept."""
    kept = json.loads(SIZES.read_text("utf-8")) if SIZES.is_file() else {"beyond_core_mb": {}}
    with TemporaryDirectory() as folder:
        build = [sys.executable, "-m", "build", "--wheel", "--outdir", folder, str(ROOT)]
        subprocess.run(build, check=True, capture_output=True)
        (wheel,) = Path(folder).glob("*.whl")
        kept["core_mb"] = round(size_mb(wheel), 1)
        kept["date"] = datetime.now(UTC).strftime("%Y-%m-%d")
        kept["python"] = f"Python {sys.version_info.major}.{sys.version_info.minor}"
        kept["system"] = sys.platform.capitalize()
        for extra in extras:
            beyond = round(size_mb(wheel, extra) - kept["core_mb"], 1)
            kept["beyond_core_mb"][extra] = beyond
            print(f"{extra:12} {beyond:7.1f} MB", flush=True)
            yield kept


if __name__ == "__main__":
    if sys.argv[1:] != ["--table"]:
        for found in measured(sys.argv[1:] or names()):
            SIZES.write_text(json.dumps(found, indent=2) + "\n", "utf-8")
    page = PAGE.read_text("utf-8")
    PAGE.write_text(written(page, json.loads(SIZES.read_text("utf-8"))), "utf-8")
