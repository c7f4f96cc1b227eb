"""Child processes that leave Ctrl-C to their parent and end with it, on every system."""

import os
import signal
import sys
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from threading import Thread
from typing import Any

MOST_PROCESSES = 61 if sys.platform == "win32" else 10_000
"""Maximum number of processes of a pool, which is the limit on Windows."""


def child_pool(count: int) -> ProcessPoolExecutor:
    """Return a pool of some fresh processes, or fewer where the system allows no more.

    They start alike on every system.
    """
    return _ChildPool(min(count, MOST_PROCESSES), get_context("spawn"), _begin)


class _ChildPool(ProcessPoolExecutor):
    """Pool whose processes leave Ctrl-C to their parent from their start on."""

    def submit(self, *work: Any, **named: Any) -> Future[Any]:
        """Submit work; a process may start for it."""
        with deaf_to_interrupts():
            return super().submit(*work, **named)


def _begin() -> None:
    """Prepare a process: its parent alone answers to Ctrl-C, and it ends with its parent."""
    for name in ("SIGINT", "SIGBREAK"):  # Windows sends both to all processes of a console
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    parent = parent_process()
    if parent is not None:
        Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


@contextmanager
def deaf_to_interrupts() -> Iterator[None]:
    """Hold back Ctrl-C while a process starts: it inherits this, and leaves Ctrl-C to its parent.

    Otherwise a process that is importing modules would print a traceback.
    """
    mask = getattr(signal, "pthread_sigmask", None)
    # Windows has no masks of signals.
    if mask is None:
        yield
        return
    before = mask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        mask(signal.SIG_SETMASK, before)


def _end_with(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)
