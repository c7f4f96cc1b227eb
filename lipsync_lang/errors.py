"""What goes wrong, in words a user can act on.

Every error the library raises on purpose is a `LipsyncError`; the command line prints
its message and nothing else.
"""

from difflib import get_close_matches
from typing import TYPE_CHECKING, get_args

if TYPE_CHECKING:
    from collections.abc import Iterable


class LipsyncError(Exception):
    """Something the user can mend; the message says what, where and how."""


class PackError(LipsyncError):
    """One or more packs are unsound, or cannot be found."""


class ScheduleError(LipsyncError):
    """Timed phonemes that cannot be performed."""


class SpeechError(LipsyncError):
    """Text or audio that cannot become speech here."""


class ModelError(LipsyncError):
    """A 3D model that cannot be read, or that nothing here can drive."""


class AnimationError(LipsyncError):
    """An animation that cannot be read, or is of another face."""


class OutputError(LipsyncError):
    """A result that cannot be written where it was asked for."""


def did_you_mean(word: str, known: "Iterable[str]") -> str:
    """Return a hint naming the nearest known word, or the known words when none is near."""
    names = sorted(known)
    near = get_close_matches(word, names, n=1) or [n for n in names if n.lower() == word.lower()]
    if near:
        return f"did you mean '{near[0]}'?"
    shown = ", ".join(names[:24]) + (", ..." if len(names) > 24 else "")  # noqa: PLR2004 a line's worth
    return f"known: {shown}" if names else "none is known"


def refuse_other(name: str, value: object, choices: object) -> None:
    """Refuse a value of an argument that is none of a `Literal`'s."""
    known = get_args(choices)
    if value not in known:
        listed = ", ".join(map(repr, known))
        raise LipsyncError(f"`{name}` is {value!r}; it is one of {listed}")
