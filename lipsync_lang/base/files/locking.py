"""Locks between processes, by files.

The system releases a lock when its process ends, however it ends.
"""

import os
from importlib import import_module
from pathlib import Path


def claim(path: Path) -> int | None:
    """Return a descriptor that holds a lock file for this process; None if another has it.

    The lock lasts until the descriptor is closed.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    held = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        _lock(held)
    except OSError:
        os.close(held)
        return None
    return held


def _lock(held: int) -> None:
    """Lock a file that is open, or raise an `OSError` at once."""
    try:
        import fcntl
    except ImportError:
        windows = import_module("msvcrt")
        windows.locking(held, windows.LK_NBLCK, 1)
    else:
        fcntl.lockf(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
