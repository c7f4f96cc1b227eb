"""Run a function in a process of its own, which begins as a copy of this one."""

import os
import subprocess
import sys
import traceback
import warnings
from tempfile import TemporaryFile

FORKS = hasattr(os, "fork")
"""False where a process is never a copy of another."""


def forked(function, *arguments, folder):
    """Call a function in a fork, in a folder, and return what `subprocess.run` would.

    A start takes a second, most of it for imports that this process has made. The function prints
    to its own outputs, and its result is the exit code.
    """
    with TemporaryFile() as out, TemporaryFile() as err:
        with warnings.catch_warnings():
            # Python 3.12 warns of threads, which a worker has for its messages alone.
            warnings.simplefilter("ignore", DeprecationWarning)
            child = os.fork()
        if not child:
            os._exit(_called(function, arguments, folder, out.fileno(), err.fileno()))
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        told = []
        for stream in (out, err):
            stream.seek(0)
            told.append(stream.read().decode("utf-8"))
    return subprocess.CompletedProcess(function, code, *told)


def _called(function, arguments, folder, out, err):
    """Call a function whose outputs are two files, and return the exit code of its process."""
    os.dup2(out, 1)
    os.dup2(err, 2)
    sys.stdout, sys.stderr = (
        open(number, "w", encoding="utf-8", closefd=False)  # noqa: SIM115 as at a start
        for number in (1, 2)
    )
    try:
        os.chdir(folder)
        code = function(*arguments)
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    except BaseException:  # noqa: BLE001 as an interpreter does at its end
        traceback.print_exc()
        code = 1
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):
            code = code or 120
    return code or 0
