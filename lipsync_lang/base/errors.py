"""Errors whose messages tell the user how to mend the input.

Every error raised on purpose is a `LipsyncError`. The command line prints its message only.
"""

from collections.abc import Iterable
from typing import get_args

MAX_KNOWN = 24
"""Known words in a hint."""

MAX_TOLD = 8
"""Usual number of names in a message."""

MAX_MESSAGE_CHARS = 4_000
"""A name within a file may be of any length; the middle of a longer message is cut out."""


class LipsyncError(Exception):
    """An error that the user can mend; the message names the place and the cure."""

    def __str__(self) -> str:
        """Return the message, cut to `MAX_MESSAGE_CHARS`."""
        text, half = super().__str__(), MAX_MESSAGE_CHARS // 2
        return text if len(text) <= MAX_MESSAGE_CHARS else f"{text[:half]} ... {text[-half:]}"


class PackError(LipsyncError):
    """A pack is faulty, or cannot be found."""


class ScheduleError(LipsyncError):
    """Timed phonemes cannot be read or performed."""


class SpeechError(LipsyncError):
    """Text or audio cannot be converted to timed phonemes."""


class ModelError(LipsyncError):
    """A 3D model cannot be read, or has nothing to drive."""


class AnimationError(LipsyncError):
    """An animation cannot be read, or belongs to another pose set."""


class OutputError(LipsyncError):
    """An output cannot be written to the given path."""


def spelled(name: str, known: Iterable[str]) -> str:
    """Return the known name that a name is in other letters, or the name itself."""
    names = list(known)
    if name in names:
        return name
    same = [one for one in names if one.casefold() == name.casefold()]
    return same[0] if len(same) == 1 else name


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return a hint with the nearest known word, or with all known words if none is near."""
    from difflib import SequenceMatcher, get_close_matches

    names = sorted(known)
    near = get_close_matches(word, names, MAX_KNOWN)
    # It finds nothing alike in `ABC` and `abc`.
    near = near or [name for name in names if name.lower() == word.lower()]
    if near:
        likeness = {name: SequenceMatcher(None, name, word).ratio() for name in near}
        # of names equally near, typists keep the first letter more often than any other
        best = max(near, key=lambda name: (likeness[name], name[:1] == word[:1]))
        return f"did you mean '{best}'?"
    return f"known: {shortlist(names, MAX_KNOWN)}" if names else "there are none"


def shortlist(names: Iterable[str], most: int = MAX_TOLD) -> str:
    """List the first names, and the number of the others."""
    every = list(names)
    more = f" and {len(every) - most} more" if len(every) > most else ""
    return ", ".join(every[:most]) + more


def refuse_other(name: str, value: object, choices: object) -> None:
    """Refuse a value of an argument that is none of a `Literal`'s."""
    if value not in get_args(choices):
        listed = ", ".join(map(repr, get_args(choices)))
        raise LipsyncError(f"`{name}` is {value!r}; it is one of {listed}")


def count(number: int, noun: str, nouns: str = "", *, space: str = " ") -> str:
    """Return a number with its noun: `1 line`, `1,240 lines`."""
    return f"{number:,}{space}{noun if number == 1 else nouns or noun + 's'}"
