"""What is sound of an unsound file, so that the rest of it can be checked in the same run."""

from typing import Any

from pydantic import ValidationError

from lipsync_lang.packs.models import MODELS, Pack
from lipsync_lang.packs.source import Loc, Source

DEFINING = {"poses", "phonemes", "base", "adds", "channels"}
"""Fields that others speak of: without one of their entries, sound ones would look faulty."""

ROUNDS = 5
"""Times that faulty entries are left out before giving up."""


def salvaged(source: Source, kind: str | None = None) -> Pack | None:
    """Return a file's pack without its faulty entries; None where too little is left."""
    data = source.data
    stated = data.get("kind") if isinstance(data, dict) else None
    if not isinstance(stated, str) or stated not in MODELS or kind not in (None, stated):
        return None
    for _ in range(ROUNDS):
        try:
            return MODELS[stated].model_validate(data)
        except ValidationError as error:
            for loc in {report["loc"] for report in error.errors(include_url=False)}:
                data = _without(data, loc)
                if data is None:
                    return None
    return None


def _without(data: Any, loc: Loc) -> Any:
    """Return a copy without the smallest named entry that holds a place; None if that defines."""
    path: list[str | int] = []
    inner = data
    for step in loc:
        if not isinstance(inner, dict) or step not in inner:
            break
        path.append(step)
        inner = inner[step]
    if not path or path[0] in DEFINING:
        return None
    return _dropped(data, path)


def _dropped(data: dict[Any, Any], path: list[str | int]) -> dict[Any, Any]:
    first, *rest = path
    if not rest:
        return {key: value for key, value in data.items() if key != first}
    return {**data, first: _dropped(data[first], rest)}
