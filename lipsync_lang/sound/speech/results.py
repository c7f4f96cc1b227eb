"""Results of work on many items, where a `SpeechError` takes the place of a result that failed.

Batches of lines go on past a line that fails. Engines take items ahead of their results, so a
caller reads its items twice, by `itertools.tee`: one copy for the engine, one beside the results.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import TypeVar

from lipsync_lang.base.errors import SpeechError

T = TypeVar("T")
R = TypeVar("R")

BATCH_TEXTS = 500
"""Maximum number of texts that an engine reads at once."""


class WrongTextError(SpeechError):
    """A text that is not said in its recording."""


def tried(act: Callable[[T], R]) -> Callable[[T], R | SpeechError]:
    """Return a function that returns its error in place of raising it."""

    def result(item: T) -> R | SpeechError:
        try:
            return act(item)
        except SpeechError as error:
            return error

    return result


def raised(result: R | SpeechError) -> R:
    """Return a result; raise it if it is an error."""
    if isinstance(result, SpeechError):
        raise result
    return result


def next_result(results: Iterator[R | SpeechError]) -> R | SpeechError:
    """Return the next result of an engine, or an error that blames the engine for a missing one."""
    short = "the engine gave fewer answers than it got texts; report it to its author"
    return next(results, SpeechError(short))


def exhaust(results: Iterator[object]) -> None:
    """Run an engine on past its last result: only then it ends its processes and deletes files."""
    deque(results, maxlen=0)


def batches(items: Iterable[T], size: int = BATCH_TEXTS) -> Iterator[list[T]]:
    """Yield items in lists of a size; the last may be shorter."""
    source = iter(items)
    while batch := list(islice(source, size)):
        yield batch


def each(results: Iterable[T | SpeechError], act: Callable[[T], R]) -> Iterator[R | SpeechError]:
    """Yield `act(result)` or its error for each result, and pass on existing errors.

    >>> list(each([4, SpeechError("none")], str))
    ['4', SpeechError('none')]
    """
    attempt = tried(act)
    for one in results:
        yield one if isinstance(one, SpeechError) else attempt(one)
