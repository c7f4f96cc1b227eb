"""Optional dependencies ("extras"): what each is for, which are installed, and how to install them.

`extras.json` lists them; a test compares it with the metadata of the distribution.
"""

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

PROGRAM = "lipsync-lang"

PIPX, UV_TOOL, UV = "pipx_metadata.json", "uv-receipt.toml", "uv ="
"""Marks of the installers: files in an environment, and a line of `pyvenv.cfg`."""


class Extra(NamedTuple):
    """A set of optional dependencies."""

    name: str
    purpose: str
    used_by: str
    """Commands that need it."""
    modules: tuple[str, ...]
    """Modules that it installs, by their import names."""
    provides: tuple[str, ...] = ()
    """Engines, formats and suffixes of files that need it."""
    system: str = ""
    """A part that the system must have where no package brings it."""

    def missing(self) -> list[str]:
        """List the modules that are not installed; none is imported."""
        return [module for module in self.modules if not importable(module)]


@cache
def extras() -> tuple[Extra, ...]:
    """Return all extras, in the order of their file."""
    text = Path(__file__).with_name("extras.json").read_text("utf-8")
    return tuple(
        Extra(name, **one | {"modules": tuple(one["modules"]), "provides": tuple(one["provides"])})
        for name, one in json.loads(text).items()
    )


def install_line(*names: str) -> str:
    """Return the command that installs extras, for the installer of this environment.

    `pipx` and `uv tool` make an environment anew, so that the line names the installed extras too.
    """
    tool = _installer()
    if tool == "pipx":
        return f'pipx install --force "{_requirement({*names, *_installed()})}"'
    whole = {*names, *_installed()} if tool == "uv tool" else set(names)
    return f'{tool} install "{_requirement(whole)}"'


@contextmanager
def needing(
    error: Callable[[str], Exception], what: str, extra: str, more: str = ""
) -> Iterator[None]:
    """Raise an error with the installation command of an extra if an import within fails."""
    try:
        yield
    except ImportError:
        raise error(f"{what} {install_line(extra)}{more}") from None


def package_line(name: str) -> str:
    """Return the command that installs a package of others, for the same installer."""
    tool = _installer()
    if tool == "pipx":
        return f"pipx inject {PROGRAM} {name}"
    if tool == "uv tool":
        return f'uv tool install "{_requirement(_installed())}" --with {name}'
    return f"{tool} install {name}"


def _installer() -> str:
    """Return the command of the installer; `pip` alone only in an activated environment."""
    home = Path(sys.prefix)
    if (home / PIPX).is_file():
        return "pipx"
    if (home / UV_TOOL).is_file():
        return "uv tool"
    with suppress(OSError, ValueError):
        if UV in (home / "pyvenv.cfg").read_text("utf-8"):
            return "uv pip"
    if os.environ.get("VIRTUAL_ENV") == sys.prefix:
        return "pip"
    python = sys.executable
    with suppress(OSError):  # the current folder may be gone
        python = os.path.relpath(python) if Path(python).is_relative_to(Path.cwd()) else python
    return f'"{python}" -m pip' if " " in python else f"{python} -m pip"


def _requirement(names: set[str]) -> str:
    return f"{PROGRAM}[{','.join(sorted(names))}]" if names else PROGRAM


def _installed() -> set[str]:
    return {one.name for one in extras() if not one.missing()}


def importable(module: str) -> bool:
    """Return True for a module that is installed; it is not imported."""
    try:
        # A module that was put into `sys.modules` by hand has no spec, a ValueError.
        return find_spec(module) is not None
    except (ImportError, ValueError):
        return False
