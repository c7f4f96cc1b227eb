"""Imitate Windows on another system, and run the command line there.

    python tests/as_windows.py run "Hello" -l english -c facefx -o hello.csv

- Our modules see `sys.platform` and `os.name` of Windows, and none of the names of POSIX in `os`,
  `signal`, `socket` and `time`, nor modules such as `fcntl`; the standard library still does.
- `msvcrt` locks files by means of this system.
- A file that this process has open is neither deleted, renamed nor replaced; a rename does not
  replace; a folder is not opened; links are not made; a process is not forked.
- Files and folders have names that Windows can store.
- Pipes are in code page 1252 with CRLF until the program says otherwise.

Child processes of a pool run this module again, and are alike. It cannot imitate paths with drives
and backslashes, a file system that ignores case, nor what Windows' own console does.
"""

import asyncio  # noqa: F401 what asks for the system when it is imported has to be here before
import builtins
import concurrent.futures.process  # noqa: F401
import ctypes
import errno
import multiprocessing.popen_spawn_posix
import multiprocessing.resource_tracker
import os
import pathlib  # noqa: F401
import re
import shutil  # noqa: F401
import signal
import socket
import subprocess  # noqa: F401
import sys
import tempfile  # noqa: F401
import time
import types
import webbrowser  # noqa: F401
from pathlib import Path, PurePosixPath

OURS = "lipsync_lang"

MISSING = {
    os: """fork forkpty register_at_fork umask uname getuid geteuid getgid getegid getgroups setuid
    setgid getpgid getpgrp setpgid setsid getsid killpg nice getpriority sched_getaffinity
    sched_yield getloadavg sysconf confstr chown lchown fchown fchmod mkfifo mknod openpty ctermid
    pathconf fpathconf statvfs fstatvfs chroot fchdir pread pwrite readv writev sendfile
    posix_spawn posix_fallocate posix_fadvise memfd_create pipe2 wait wait3 wait4 waitid
    WIFSIGNALED WTERMSIG WEXITSTATUS WNOHANG getxattr setxattr lockf O_NOCTTY O_NONBLOCK O_CLOEXEC
    O_DIRECTORY O_NOFOLLOW O_SYNC O_TMPFILE tcgetpgrp sync fdatasync get_blocking set_blocking""",
    signal: """SIGALRM SIGHUP SIGKILL SIGQUIT SIGUSR1 SIGUSR2 SIGCHLD SIGPIPE SIGTSTP SIGCONT
    SIGSTOP SIGWINCH SIG_BLOCK SIG_UNBLOCK SIG_SETMASK ITIMER_REAL alarm setitimer getitimer pause
    sigwait sigpending pthread_kill pthread_sigmask siginterrupt""",
    socket: "AF_UNIX SCM_RIGHTS SO_REUSEPORT",
    time: "tzset clock_gettime",
}
"""Names that Python lacks on Windows, by module (its documentation: "Availability: Unix")."""

ABSENT = {"fcntl", "resource", "termios", "tty", "pty", "pwd", "grp", "syslog", "posix", "curses"}
"""Modules that Python lacks on Windows."""

UNFIT = re.compile(
    r'[<>:"|?*\\\x00-\x1f]|[ .]$|^(?:con|prn|aux|nul|com\d|lpt\d)(?:\..*)?$', re.IGNORECASE
)
"""Names that Windows cannot store; `.` and `..` are no names."""

SHARING_VIOLATION, ACCESS_DENIED, INVALID_NAME, NO_PRIVILEGE = 32, 5, 123, 1314


def asked_by_us(depth=2):
    """Return True if the caller is a module of the package or of the tests."""
    frame = sys._getframe(depth)  # noqa: SLF001
    return frame.f_globals.get("__name__", "").partition(".")[0] in (OURS, "__main__")


def refusal(number, winerror, path):
    """Return an error as Windows raises it."""
    error = OSError(number, os.strerror(number), str(path))
    error.winerror = winerror
    return error


def hide(module, names, **values):
    """Replace values of a module for the modules of the package only."""

    def shown(name):
        def get(self):
            if not asked_by_us():
                return vars(self)[name]
            if name in values:
                return values[name]
            raise AttributeError(f"module '{self.__name__}' has no attribute '{name}' on Windows")

        return property(get, lambda self, value: vars(self).__setitem__(name, value))

    there = [name for name in (*names, *values) if hasattr(module, name)]
    kind = type(f"Windows_{module.__name__}", (types.ModuleType,), {n: shown(n) for n in there})
    module.__class__ = kind


def hide_modules():
    """Hide the modules that Windows lacks from the package, and provide `msvcrt`."""
    real = builtins.__import__

    def imported(name, values=None, *rest, **options):
        by_us = (values or {}).get("__name__", "").partition(".")[0] == OURS
        if by_us and name.partition(".")[0] in ABSENT:
            raise ModuleNotFoundError(f"No module named '{name}' on Windows", name=name)
        return real(name, values, *rest, **options)

    builtins.__import__ = imported
    sys.modules["msvcrt"] = msvcrt = types.ModuleType("msvcrt")
    msvcrt.LK_NBLCK = 2
    import fcntl

    def locking(descriptor, mode, count):
        assert (mode, count) == (msvcrt.LK_NBLCK, 1)
        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, count)

    msvcrt.locking = locking


class WinDLL:
    """The functions of `kernel32` that ask for a process; its handle is its number."""

    def __init__(self, name, use_last_error):
        assert (name, use_last_error) == ("kernel32", True)

        def open_process(rights, inherited, number):
            assert (rights, inherited) == (0x100000, 0)
            try:
                os.kill(number, 0)
            except ProcessLookupError:
                return None
            return number

        self.OpenProcess = open_process

    def WaitForSingleObject(self, handle, milliseconds):  # noqa: N802 Windows' name
        assert milliseconds == 0
        state = Path(f"/proc/{handle.value}/stat").read_text("utf-8").rpartition(")")[2].split()[0]
        return 0 if state in "ZX" else 258

    def CloseHandle(self, handle):  # noqa: N802 Windows' name
        assert handle.value


def opened(path):
    """Return True if this process has a file open."""
    for number in os.listdir("/proc/self/fd"):  # noqa: PTH208
        try:
            if os.path.samefile(f"/proc/self/fd/{number}", path):  # noqa: PTH121
                return True
        except OSError:
            continue
    return False


def refuse_open(path):
    """Refuse to delete or replace an open file."""
    if os.path.isfile(path) and opened(path):  # noqa: PTH113
        raise refusal(errno.EACCES, SHARING_VIOLATION, path)


def refuse_name(path):
    """Refuse a name that Windows cannot store."""
    if not isinstance(path, (str, os.PathLike)) or str(path).startswith(("/dev", "/proc")):
        return
    for part in PurePosixPath(path).parts[1 if str(path).startswith("/") else 0 :]:
        if part not in (".", "..") and UNFIT.search(part):
            raise refusal(errno.EINVAL, INVALID_NAME, path)


def heed(event, values):
    """Raise the errors of Windows before this system acts."""
    match event:
        case "open" if isinstance(values[0], (str, os.PathLike)):
            path, mode, flags = values
            if mode is None and os.path.isdir(path) and asked_by_us():  # noqa: PTH112
                raise refusal(errno.EACCES, ACCESS_DENIED, path)
            if (mode and set(mode) & set("wax+")) or (flags or 0) & (os.O_CREAT | os.O_WRONLY):
                refuse_name(path)
        case "os.mkdir":
            refuse_name(values[0])
        case "os.remove" if sys._getframe(1).f_globals.get("__name__") != "tempfile":  # noqa: SLF001
            if values[1] == -1:
                refuse_open(values[0])
        case "os.rename":
            refuse_name(values[1])
            refuse_open(values[0])
            refuse_open(values[1])
        case "os.symlink" | "os.link" | "os.fork":
            raise refusal(errno.EPERM, NO_PRIVILEGE, event)
        case "os.kill" if values[1] == 0 and asked_by_us():
            raise AssertionError("on Windows, signal 0 ends the process")


def become_windows(*, pipes=True):
    """Make this process behave like Windows until it ends; with `pipes`, its streams as well."""
    assert Path("/proc/self/fd").is_dir(), "it tells which files are open"
    multiprocessing.resource_tracker._HAVE_SIGMASK = False  # noqa: SLF001
    hide_modules()
    for module, names in MISSING.items():
        hide(module, names.split(), **({"name": "nt"} if module is os else {}))
    hide(sys, [], platform="win32")
    ctypes.WinDLL, ctypes.get_last_error = WinDLL, lambda: 87
    sys.addaudithook(heed)
    rename = os.rename

    def renamed(source, target, **options):
        if os.path.exists(target):  # noqa: PTH110
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(target))
        rename(source, target, **options)

    os.rename = renamed
    for stream in (sys.stdin, sys.stdout, sys.stderr) if pipes else ():
        if not stream.isatty():
            stream.reconfigure(encoding="cp1252", newline="\r\n" if stream is not sys.stdin else "")


if __name__ in {"__main__", "__mp_main__"}:  # children of a pool are the latter
    become_windows()

if __name__ == "__main__":
    from lipsync_lang.cli import main

    sys.exit(main())
