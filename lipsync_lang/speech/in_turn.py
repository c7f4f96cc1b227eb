"""Work on many items in order; the error of a failed item takes its place.

Batches of lines go on past a line that fails: a `SpeechError` takes the place of its result.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import TypeVar

from lipsync_lang.errors import SpeechError

T = TypeVar("T")
R = TypeVar("R")


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


def refused(items: Iterable[object], error: SpeechError) -> Iterator[SpeechError]:
    """Yield an error for each item."""
    return (error for _ in items)


def batches(items: Iterable[T], size: int) -> Iterator[list[T]]:
    """Yield items in lists of a size; the last may be shorter."""
    source = iter(items)
    while batch := list(islice(source, size)):
        yield batch


def in_turn(
    items: Iterable[T | SpeechError], act: Callable[[Iterator[T]], Iterable[R | SpeechError]]
) -> Iterator[tuple[T, R] | SpeechError]:
    """Pass items that are not errors through `act`; pair each with its result, in order.

    `act` may take items ahead of its results, as many as it likes.

    >>> halves = in_turn([4, SpeechError("none"), 6], lambda good: (n / 2 for n in good))
    >>> list(halves)
    [(4, 2.0), SpeechError('none'), (6, 3.0)]
    """
    taken: deque[T | SpeechError] = deque()

    def good() -> Iterator[T]:
        for item in items:
            taken.append(item)
            if not isinstance(item, SpeechError):
                yield item

    source = good()
    for result in act(source):
        while taken:
            item = taken.popleft()
            if not isinstance(item, SpeechError):
                yield result if isinstance(result, SpeechError) else (item, result)
                break
            yield item
    short = SpeechError("the engine gave fewer answers than it got texts; report it to its author")
    deque(source, maxlen=0)  # what it did not take
    for item in taken:
        yield item if isinstance(item, SpeechError) else short


def each(results: Iterable[T | SpeechError], act: Callable[[T], R]) -> Iterator[R | SpeechError]:
    """Yield `act(result)` or its error for each result, and pass on existing errors.

    >>> list(each([4, SpeechError("none")], str))
    ['4', SpeechError('none')]
    """
    attempt = tried(act)
    for one in results:
        yield one if isinstance(one, SpeechError) else attempt(one)
