"""Fitted values in a character's file: changes that set or remove them."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from lipsync_lang.capture.fit_file import FitItem, rounded, split_item
from lipsync_lang.packs.splicing import ABSENT, Change, get, put
from lipsync_lang.resolver.layers import FITTED

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Character

Data = Any
"""Plain data of a character's file."""


def fitted_items(model: "Character") -> Iterator[str]:
    """Yield the names of fitted values that have not been changed since."""
    for label, steps in model.targets.items():
        if any(step.status == FITTED for step in steps):
            yield f"targets.{label}"
    for item, value in model.fitted.items():
        if model.scalar(item) == value:
            yield item
    for key, bigram in model.bigrams.items():
        if bigram.status == FITTED:
            yield f"bigrams.{key}"


def settings(item: FitItem, data: Data) -> list[Change]:
    """Return the changes that set an item in a character's file with some data."""
    loc, value = split_item(item.item), rounded(item.value)
    if item.kind == "targets":
        steps = value if isinstance(value, list) else [value]
        steps = [{key: one for key, one in step.items() if key != "status"} for step in steps]
        steps[0]["status"] = FITTED
        return [(loc, steps if len(steps) > 1 else steps[0])]
    if item.kind == "bigrams":
        old = get(data, loc)
        kept = {} if old is ABSENT else {k: v for k, v in old.items() if k != "interpolation"}
        return [(loc, {**kept, "status": FITTED, **value})]
    return [(loc, value), (("fitted", item.item), value)]


def together(changes: Sequence[Change], data: Data) -> list[Change]:
    """Merge the changes of each missing field into one change of the whole field.

    A field that is too long for one line is written with one entry per line.
    """
    made: list[Change] = []
    fields: dict[str | int, dict[str | int, Data]] = {}
    for (field, name), value in changes:
        if field in data:
            made.append(((field, name), value))
        else:
            fields.setdefault(field, {})[name] = value
    return [*made, *(((field,), entries) for field, entries in fields.items())]


def removals(items: Sequence[str], data: Data) -> list[Change]:
    """Return the changes that remove items from a character's file with some data.

    A field is removed together with its last entry.
    """
    made: list[Change] = []
    for loc in (loc for item in items for loc in (split_item(item), ("fitted", item))):
        if get(data, loc) is not ABSENT:
            data = put(data, loc, ABSENT)
            last = not data[loc[0]]
            made.append((loc[:1] if last else loc, ABSENT))
    return made
