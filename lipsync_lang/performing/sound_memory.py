"""Sound memory: results that a sound or a line decides, kept as long as it.

Edits of curves leave them.
"""

from collections.abc import Callable, Hashable
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from lipsync_lang.schedules.schedule import Audio, Schedule

Result = TypeVar("Result")

_known: "WeakKeyDictionary[Audio | Schedule, dict[str, tuple[Hashable, Any]]]" = WeakKeyDictionary()
"""The last result of each kind, with its other inputs."""


def kept_with(
    owner: Audio | Schedule, kind: str, given: Hashable, compute: Callable[[], Result]
) -> Result:
    """Return a result of a kind, computed again only if it is given something else."""
    results = _known.setdefault(owner, {})
    if kind not in results or results[kind][0] != given:
        results[kind] = given, compute()
    return results[kind][1]
