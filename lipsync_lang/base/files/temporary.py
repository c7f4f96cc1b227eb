"""Name temporary files and folders, and delete those of dead processes.

A name contains the machine and the process. So the next output into a folder can delete the files
of a killed process, and leaves alone those of a running one.
"""

import os
import re
import shutil
import sys
import time
import zlib
from contextlib import suppress
from pathlib import Path

STALE_SECONDS = 86_400.0
"""Age at which a file is deleted even if its process is on another machine: a day."""

SWEEP_SECONDS = 60.0
"""Time after which a process looks into the same folder again."""

MAX_SWEPT = 1000
"""Maximum number of folders that a process remembers."""

MAX_NAME_CHARS = 40
"""Maximum length of the output's name in the name of its temporary file."""

MAY_WAIT, NO_SUCH_PROCESS = 0x100000, 87
"""Windows' right to wait for a process, and its error code for a process that is not there."""

_swept: dict[Path, float] = {}
"""Seconds of the monotonic clock at which each folder was last looked into."""

SUFFIX = ".lipsync-tmp"
"""Suffix of every temporary file or folder."""

_TEMPORARY = re.compile(
    rf"\..*\.(?P<host>[0-9a-f]{{8}})-(?P<process>\d+)-[0-9a-f]{{8}}{re.escape(SUFFIX)}"
)


def this_process() -> str:
    """Return the machine and the process, in the form of temporary names."""
    return f"{_host()}-{os.getpid()}"


def temporary_name(name: str, owner: str = "") -> str:
    """Return a unique hidden file name, with an ending by which `sweep` finds it.

    Parameters
    ----------
    name : of the output
    owner : the process that puts it in place, if it is another than this one
    """
    whose = owner or this_process()
    return f".{name[:MAX_NAME_CHARS]}.{whose}-{os.urandom(4).hex()}{SUFFIX}"


def sweep(folder: Path, *, again: bool = False, ended: str = "") -> None:
    """Delete the temporary files of dead processes in a folder, and of the owner `ended`.

    A process looks into the same folder once a minute at most, so that 10,000 outputs into one
    folder do not each list all others; `again` looks at once.
    """
    now = time.monotonic()
    # The monotonic clock may begin at 0: a folder never looked into must still count as old.
    if not again and now < _swept.get(folder, -SWEEP_SECONDS) + SWEEP_SECONDS:
        return
    if len(_swept) >= MAX_SWEPT:
        _swept.clear()
    _swept[folder] = now
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            # The ending comes first, because most files of a large folder fail it quickly.
            if found := entry.name.endswith(SUFFIX) and _TEMPORARY.fullmatch(entry.name):
                with suppress(OSError):
                    age = time.time() - entry.stat(follow_symlinks=False).st_mtime
                    host, process = found["host"], found["process"]
                    dead = host == _host() and _is_dead(int(process))
                    if age > STALE_SECONDS or dead or f"{host}-{process}" == ended:
                        if entry.is_dir(follow_symlinks=False):
                            shutil.rmtree(entry.path)
                        else:
                            Path(entry.path).unlink()


def _host() -> str:
    """Return a hash of this machine's name; the processes of another cannot be examined."""
    name = os.uname().nodename if hasattr(os, "uname") else os.environ.get("COMPUTERNAME", "")
    return f"{zlib.crc32(name.encode('utf-8', 'replace')):08x}"


def _is_dead(process: int) -> bool:
    """Return True if no such process runs."""
    if sys.platform == "win32":  # `os.kill` with signal 0 would end the process there
        import ctypes

        system = ctypes.WinDLL("kernel32", use_last_error=True)
        # ctypes takes a result for 32 bits, and would cut off half of a handle.
        system.OpenProcess.restype = ctypes.c_void_p
        handle = ctypes.c_void_p(system.OpenProcess(MAY_WAIT, 0, process & 0xFFFFFFFF))
        if not handle:
            return ctypes.get_last_error() == NO_SUCH_PROCESS
        ended: bool = system.WaitForSingleObject(handle, 0) == 0
        system.CloseHandle(handle)
        return ended
    try:
        # Signal 0 only asks. Other errors mean that the process runs as another user.
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except OSError:
        return False
    return False
