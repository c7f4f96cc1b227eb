"""Quote the parts of a command for the shell of this system."""

import shlex
import sys
from collections.abc import Iterable


def shell_command(parts: Iterable[str]) -> str:
    """Join the parts of a command, quoted for cmd and PowerShell on Windows, else for sh."""
    if sys.platform != "win32":
        return shlex.join(parts)
    from subprocess import list2cmdline

    return list2cmdline(parts)
