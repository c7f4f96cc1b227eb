"""Temporary files beside an output: their names, and sweeping those of dead processes.

A name tells the machine and the process that made the file. So the next output into a folder
can delete what a killed process left there, and nothing that a living one still writes.
"""

import os
import re
import secrets
import time
import zlib
from contextlib import suppress
from pathlib import Path

STALE_SECONDS = 86_400.0
"""Age from which a file is swept although its process cannot be asked for: a day."""

MAX_NAME_CHARS = 40
"""Characters of the output's own name within that of its temporary file."""

_TEMPORARY = re.compile(r"\..*\.(?P<host>[0-9a-f]{8})-(?P<process>\d+)-[0-9a-f]{8}\.lipsync-tmp")


def temporary_name(name: str) -> str:
    """Return a name that nothing else has: hidden, and told by its ending."""
    owner = f"{_host()}-{os.getpid()}"
    return f".{name[:MAX_NAME_CHARS]}.{owner}-{secrets.token_hex(4)}.lipsync-tmp"


def sweep(folder: Path) -> None:
    """Delete the temporary files of dead processes in a folder."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            found = _TEMPORARY.fullmatch(entry.name)
            if found:
                with suppress(OSError):
                    age = time.time() - entry.stat(follow_symlinks=False).st_mtime
                    ours = found["host"] == _host()
                    if age > STALE_SECONDS or (ours and _is_dead(int(found["process"]))):
                        Path(entry.path).unlink()


def _host() -> str:
    """Return this machine in eight digits; processes of another cannot be asked for."""
    name = os.uname().nodename if hasattr(os, "uname") else os.environ.get("COMPUTERNAME", "")
    return f"{zlib.crc32(name.encode('utf-8', 'replace')):08x}"


def _is_dead(process: int) -> bool:
    """Tell whether no such process runs; on Windows, to ask a process is to end it."""
    if os.name != "posix":
        return False
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except OSError:
        return False
    return False
