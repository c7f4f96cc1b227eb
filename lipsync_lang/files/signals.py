"""Signals that end the program: heard as an exception, so that nothing is left behind."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

ENDING = [
    found
    for found in (getattr(signal, name, None) for name in ("SIGINT", "SIGTERM", "SIGHUP"))
    if found is not None
]
"""Interrupted at the keyboard, asked to end, and the terminal closed; Windows lacks the last."""


class Terminated(BaseException):
    """The program was asked to end; `code` is what shells expect then."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.code = 128 + number


@contextmanager
def terminating() -> Iterator[None]:
    """Raise `Terminated` where a signal asks the program to end, so that it can clean up."""

    def end(number: int, _: object) -> None:
        raise Terminated(number)

    with _handled(end, [number for number in ENDING if number != signal.SIGINT]):
        yield


@contextmanager
def undisturbed() -> Iterator[None]:
    """Hold ending signals back until the block is through."""
    caught: list[int] = []
    try:
        with _handled(lambda number, _: caught.append(number), ENDING):
            yield
    finally:
        for number in caught:
            signal.raise_signal(number)


@contextmanager
def _handled(handler: Callable[[int, Any], None], numbers: list[signal.Signals]) -> Iterator[None]:
    """Handle signals otherwise for a while; only the main thread may, and an ignored one stays."""
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
