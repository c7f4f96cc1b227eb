"""Turn signals that end the program into an exception, so that temporary files are deleted."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

ENDING = [
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
    if hasattr(signal, name)
]
"""Signals of Ctrl-C, `kill`, and a closed terminal, which on Windows is the last one."""


class Terminated(BaseException):
    """A signal asked the program to end; `code` is the exit code that shells expect."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.code = 128 + number


@contextmanager
def terminating() -> Iterator[None]:
    """Raise `Terminated` in the block when a signal asks the program to end."""

    def end(number: int, _: object) -> None:
        raise Terminated(number)

    with _handled(end, [number for number in ENDING if number != signal.SIGINT]):
        yield


@contextmanager
def undisturbed() -> Iterator[None]:
    """Delay ending signals until the block has finished."""
    caught: list[int] = []
    try:
        with _handled(lambda number, _: caught.append(number), ENDING):
            yield
    finally:
        for number in caught:
            signal.raise_signal(number)


@contextmanager
def _handled(handler: Callable[[int, Any], None], numbers: list[signal.Signals]) -> Iterator[None]:
    """Replace signal handlers within the block.

    Python allows this in the main thread only. Ignored signals stay ignored: `nohup` relies on it.
    """
    old = {}
    if threading.current_thread() is threading.main_thread():
        old = {number: signal.getsignal(number) for number in numbers}
    old = {number: was for number, was in old.items() if was not in (None, signal.SIG_IGN)}
    for number in old:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number, was in old.items():
            signal.signal(number, was)
