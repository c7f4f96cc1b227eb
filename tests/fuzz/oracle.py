"""Judge of one input: only package errors, no warnings, and work within a budget.

Work is counted in Python's own calls, and memory in bytes that Python and numpy ask for. Both are
the same on every machine, and to count them takes five times as long as to read. So a file is first
read without a count, while the system lends no more memory than the budget. If the read ends before
any machine could use up the budgets, it kept them. Otherwise the file is read again, and counted.
"""

import gc
import signal
import sys
import tracemalloc
import warnings
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from cProfile import Profile
from pathlib import Path
from time import process_time
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

CALL_SECONDS = 10e-9
"""Less time than any machine takes for a call, or to fill a call's share of the memory."""

FOR_WANT_OF_MEMORY = (MemoryError, ImportError, OSError)
"""Errors of a read to which the system lends no more memory."""


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
    calls, memory = CALLS + CALLS_PER_BYTE * size, BYTES + BYTES_PER_BYTE * size
    if sys.platform == "linux":
        started = process_time()
        with _lent(memory), _looked_at(_give_up):
            told, error = _ended(read, path)
        short = process_time() - started < calls * CALL_SECONDS
        if (told or short) and not _is_doubtful(error):
            return told
    return _counted(read, path, calls, memory)


def _counted(read: Callable[[Path], object], path: Path, calls: int, memory: int) -> str | None:
    """Read a file and count; return the fault of the reader, or None."""
    work = _Work(calls)
    tracemalloc.start()
    try:
        with _looked_at(work.look):
            told, error = _ended(read, path, work.calls)
        where = "at its error" if error else "at its end"
        return told or work.fault(where) or _memory(memory)
    finally:
        tracemalloc.stop()


def _ended(
    read: Callable[[Path], object], path: Path, calls: AbstractContextManager[object] | None = None
) -> tuple[str | None, BaseException | None]:
    """Read a file; return the fault that ended the read, and the error, or None for each."""
    try:
        with warnings.catch_warnings(), calls or nullcontext():
            warnings.simplefilter("error")
            read(path)
    except LipsyncError as error:
        return _message(str(error)), error
    except Failure as failure:
        return str(failure), failure
    except Exception as error:  # noqa: BLE001 whatever escapes is the finding
        return f"{_where(error)}: {type(error).__name__}: {str(error)[:200]}", error
    return None, None


@contextmanager
def _looked_at(look: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Call a function each second."""
    previous = signal.signal(signal.SIGALRM, look)
    signal.setitimer(signal.ITIMER_REAL, 1, 1)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)


@contextmanager
def _lent(memory: int) -> Iterator[None]:
    """Let the process ask the system for so many more bytes, touched or not."""
    import resource  # not on Windows

    pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
    limits = resource.getrlimit(resource.RLIMIT_AS)
    least = min(one for one in (pages * resource.getpagesize() + memory, *limits) if one >= 0)
    resource.setrlimit(resource.RLIMIT_AS, (least, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)


def _give_up(number: int, frame: FrameType | None) -> None:
    """End a read that must be counted, unless the collector called: it would swallow the error."""
    del number
    collecting = {getattr(one, "__code__", None) for one in gc.callbacks}
    if frame is None or frame.f_code not in collecting:  # else in the next second
        raise Failure


def _is_doubtful(error: BaseException | None) -> bool:
    """Return whether a limit of the judge may have caused an error."""
    while error is not None:
        if isinstance(error, (Failure, *FOR_WANT_OF_MEMORY)):
            return True
        error = error.__context__
    return False


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


def _memory(most: int) -> str | None:
    _, peak = tracemalloc.get_traced_memory()
    if peak > most:
        return f"too much memory: {peak >> 20} MB of {most >> 20} MB"
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
