"""Locks between processes, by files.

The system releases a lock when its process ends, however it ends.
"""

import os
from pathlib import Path


def claim(path: Path) -> int | None:
    """Return a descriptor that holds a lock file for this process; None if another has it.

    The lock lasts until the descriptor is closed. Where the system has no such locks (Windows),
    every process gets one.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    held = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        import fcntl
    except ImportError:
        return held
    try:
        fcntl.lockf(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(held)
        return None
    return held
