"""Judge of one input: only package errors, no warnings, and work within a budget.

Work is counted in Python's own calls, and memory in bytes that Python and numpy ask for. Both are
the same on every machine. A clock only says when the count of a long read is looked at.
"""

import signal
import tracemalloc
import warnings
from collections.abc import Callable
from cProfile import Profile
from pathlib import Path
from types import FrameType

from lipsync_lang import LipsyncError

CALLS, CALLS_PER_BYTE = 200_000, 500
"""Maximum number of calls of a reader: a constant, and an amount for each byte."""

BYTES, BYTES_PER_BYTE = 64 * 2**20, 1_000
"""Maximum memory of a reader: a constant, and an amount for each byte."""

MOST_CHARS = 5_000
"""Longest message."""

HANG_SECONDS = 300
"""Time limit of an input; a safeguard, not a measurement."""


class Failure(BaseException):
    """A fault that the input caused; readers do not catch it."""


def judge(read: Callable[[Path], object], path: Path) -> str | None:
    """Read a file, and return the fault of the reader, or None.

    Parameters
    ----------
    read : the reader
    path : the input
    """
    size = path.stat().st_size
    work = _Work(CALLS + CALLS_PER_BYTE * size)
    previous = signal.signal(signal.SIGALRM, work.look)
    signal.setitimer(signal.ITIMER_REAL, 1, 1)
    tracemalloc.start()
    try:
        with warnings.catch_warnings(), work.calls:
            warnings.simplefilter("error")
            read(path)
        return work.fault("at its end") or _memory(size)
    except LipsyncError as error:
        return _message(str(error)) or work.fault("at its error") or _memory(size)
    except Failure as failure:
        return str(failure)
    except Exception as error:  # noqa: BLE001 whatever escapes is the finding
        return f"{_where(error)}: {type(error).__name__}: {str(error)[:200]}"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)
        tracemalloc.stop()


class _Work:
    """Calls of a reader: counted in C, which is quicker, and compared with a budget."""

    def __init__(self, budget: int) -> None:
        self.calls, self.budget, self.seconds = Profile(), budget, 0

    def fault(self, where: str) -> str | None:
        """Return a fault if the budget is exceeded."""
        many = sum(entry.callcount for entry in self.calls.getstats())
        return f"{where}: too much work ({many} calls)" if many > self.budget else None

    def look(self, number: int, frame: FrameType | None) -> None:
        """End a reader that exceeds its budget, or hangs; called each second."""
        del number
        self.seconds += 1
        if told := self.fault(_line(frame)):
            raise Failure(told)
        if self.seconds >= HANG_SECONDS:
            raise Failure(f"{_line(frame)}: hangs")


def _memory(size: int) -> str | None:
    _, peak = tracemalloc.get_traced_memory()
    if peak > BYTES + BYTES_PER_BYTE * size:
        return f"too much memory: {peak >> 20} MB for {size} bytes"
    return None


def _message(text: str) -> str | None:
    if not text.strip():
        return "an error without a message"
    if len(text) > MOST_CHARS:
        return f"a message of {len(text)} characters: {text[:80]}"
    return None


def _line(frame: FrameType | None) -> str:
    """Return the line of the package in which a frame is, or from which it was called."""
    while frame is not None and "lipsync_lang" not in frame.f_code.co_filename:
        frame = frame.f_back
    if frame is None:
        return "outside"
    return f"{frame.f_code.co_filename.rpartition('lipsync_lang/')[2]}:{frame.f_lineno}"


def _where(error: BaseException) -> str:
    """Return the last line of the package in a traceback."""
    found, at = "outside", error.__traceback__
    while at is not None:
        if "/lipsync_lang/" in at.tb_frame.f_code.co_filename:
            name = at.tb_frame.f_code.co_filename.rpartition("lipsync_lang/")[2]
            found = f"{name}:{at.tb_lineno}"
        at = at.tb_next
    return found
