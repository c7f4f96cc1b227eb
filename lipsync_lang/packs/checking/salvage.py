"""Drop the faulty entries of a file, so that the others can be checked in the same run."""

from typing import Any

from pydantic import ValidationError

from lipsync_lang.packs.models import MODELS, PackModel
from lipsync_lang.packs.yaml.source import Loc, YamlSource

DEFINING = {"poses", "phonemes", "base", "adds", "channels", "features", "terms", "letters"}
"""Fields with names that other entries use: dropping one of theirs would cause false faults."""

ROUNDS = 5
"""Attempts: dropping one entry may make another faulty."""


def salvaged(source: YamlSource, kind: str | None = None) -> PackModel | None:
    """Return a file's pack without its faulty entries; None if too little is left."""
    data = source.data
    stated = data.get("kind") if isinstance(data, dict) else None
    if not isinstance(stated, str) or stated not in MODELS or kind not in (None, stated):
        return None
    for _ in range(ROUNDS):
        try:
            return MODELS[stated].model_validate(data)
        except ValidationError as error:
            reports = error.errors(include_url=False)
            faulty = {_entry(data, report["loc"]) for report in reports}
            if any(not entry or entry[0] in DEFINING for entry in faulty):
                return None
            for entry in faulty:
                data = _without(data, entry)
    return None


def _entry(data: Any, loc: Loc) -> tuple[Any, ...]:
    """Return the path of the innermost named entry that contains `loc`."""
    path: list[Any] = []
    for step in loc:
        if not isinstance(data, dict) or step not in data:
            break
        path.append(step)
        data = data[step]
    return tuple(path)


def _without(data: Any, entry: tuple[Any, ...]) -> Any:
    """Return a copy without an entry; the data itself if the entry is missing."""
    first, *rest = entry
    if not isinstance(data, dict) or first not in data:
        return data
    if rest:
        return {**data, first: _without(data[first], tuple(rest))}
    return {key: value for key, value in data.items() if key != first}
