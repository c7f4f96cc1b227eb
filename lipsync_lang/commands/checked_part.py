"""Parts of an installation in the report of `doctor`, and checks in separate processes."""

import subprocess
import sys
from typing import NamedTuple

OK, MISSING, BROKEN = "ok", "missing", "broken"
"""States. A missing part is optional; a broken one fails the check."""

IMPORT_SECONDS = 60.0
"""Time limit for the process of a check."""


class CheckedPart(NamedTuple):
    """The state of a part."""

    part: str
    state: str
    told: str
    """Details of the part, or the way to mend it."""


def fault_of(code: str, *arguments: str) -> str:
    """Run Python code in a separate process, and return its error; empty if it succeeds.

    Modules of the current folder are not found, so nothing of a stranger's project runs.
    """
    command = [sys.executable, "-P", "-c", code, *arguments]
    try:
        done = subprocess.run(  # noqa: S603 our own code
            command, capture_output=True, timeout=IMPORT_SECONDS, check=False,
            stdin=subprocess.DEVNULL,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return f"its import takes over {IMPORT_SECONDS:g} s"
    if not done.returncode:
        return ""
    words = done.stderr.decode("utf-8", "replace").strip().splitlines()
    return words[-1] if words else f"its import ended with code {done.returncode}"
