"""Progress of work on a long sound, for callers that ask for it.

Aligners and recognisers tell how much of a sound they have heard, by `tell`. The telling costs
nothing where nobody asked: in other threads, in processes of a build, and in Python.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_follower: ContextVar[Callable[[float], None] | None] = ContextVar("follower", default=None)


@contextmanager
def followed(follower: Callable[[float], None]) -> Iterator[None]:
    """Call a function with the share that has been heard, from 0 to 1, within the block."""
    token = _follower.set(follower)
    try:
        yield
    finally:
        _follower.reset(token)


def tell(done: float, of: float) -> None:
    """Report that a part of a sound has been heard, both in the same unit.

    >>> with followed(print):
    ...     tell(30, 120)
    0.25
    """
    follower = _follower.get()
    if follower is not None and of > 0:
        follower(min(done / of, 1.0))


@contextmanager
def part(first: float, stop: float, of: float) -> Iterator[None]:
    """Scale the shares told within the block to a part of the sound, from `first` to `stop`."""
    outer = _follower.get()
    if outer is None or of <= 0:
        yield
        return
    with followed(lambda share: outer(min((first + share * (stop - first)) / of, 1.0))):
        yield
