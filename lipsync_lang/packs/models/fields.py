"""Types shared by the models of packs: strict base class, names, numbers and short forms.

A short form is a bare label for a list of one, or a list of names for a mapping. It becomes the
full form before validation, so that a model has one form only and a fault is reported once.
"""

import ast
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from inspect import cleandoc, getsource
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    ValidationInfo,
)
from pydantic_core import CoreSchema, PydanticCustomError

from lipsync_lang.packs.yaml.source import Data
from lipsync_lang.packs.yaml.value_text import RESERVED_WORDS


def descriptions(model: type[BaseModel]) -> dict[str, str]:
    """Return what describes each field of a model, by the field's name in the class.

    A description that the field itself states goes before the docstring beneath it. A program
    without its source files has no docstrings to read.
    """
    found: dict[str, str] = {}
    # From the base on: a class may describe an inherited field anew.
    for kind in reversed(model.__mro__):
        # base classes of pydantic have docstrings of their own
        if kind.__module__.startswith(__package__):
            found |= _docstrings(kind.__module__).get(kind.__name__, {})
    fields = model.model_fields.items()
    stated = {name: field.description or found.get(name, "") for name, field in fields}
    return {name: text for name, text in stated.items() if text}


def describe(schema: dict[str, Any], model: type[BaseModel]) -> None:
    """Add the descriptions of a model's fields to its JSON Schema."""
    texts = descriptions(model)
    for name, field in model.model_fields.items():
        made = schema.get("properties", {}).get(field.alias or name)
        if made is not None and name in texts:
            made["description"] = texts[name]


# Pydantic can take docstrings while it makes a class, but then parses the source of each class at
# every start of the program, which takes longer than reading the packs.
@cache
def _docstrings(module: str) -> dict[str, dict[str, str]]:
    """Read the attribute docstrings of a module, by class and attribute."""
    try:
        tree = ast.parse(getsource(sys.modules[module]))
    except OSError:  # a frozen program has no sources
        return {}
    return {
        node.name: {
            stated.target.id: cleandoc(text.value.value)
            for stated, text in pairwise(node.body)
            if isinstance(stated, ast.AnnAssign)
            and isinstance(stated.target, ast.Name)
            and isinstance(text, ast.Expr)
            and isinstance(text.value, ast.Constant)
            and isinstance(text.value.value, str)
        }
        for node in tree.body
        if isinstance(node, ast.ClassDef)
    }


PACK_FORMAT = 1
"""The newest format of packs that this program reads, and the one it writes."""


class Strict(BaseModel):
    """A part of a pack: no unknown fields, no conversion of types, immutable."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        strict=True,
        json_schema_extra=describe,
        defer_build=True,  # a command uses few of the models, and pays for those alone
        allow_inf_nan=False,
        # messages quote the value themselves, and shorten it
        hide_input_in_errors=True,
        populate_by_name=True,
    )


def _plain(text: str) -> str:
    """Refuse names with surrounding spaces or unprintable characters."""
    if text != text.strip() or not text.isprintable():
        what = "'{text}' has spaces around it, or an invisible character"
        raise PydanticCustomError("P106", what, {"text": text.strip()})
    return text


def _pose(text: str, told: ValidationInfo) -> str:
    """Refuse the column of times in tables, and take a new name from the validation's context."""
    if text == "time_s":
        context = {"text": text, "hint": "choose another name"}
        raise PydanticCustomError("P106", "'{text}' is the column of times in tables", context)
    return (told.context or {}).get(text, _plain(text))


def _title(text: str) -> str:
    """Refuse curly quotes in place of straight ones, and words that YAML may read as booleans."""
    curly = text[:1] in {*"“”„‘"} and text[-1:] in {*"“”‘’"}
    if curly or text.casefold() in RESERVED_WORDS:
        word = "the title '{text}' may be read as true or false"
        hint = 'write straight quotes (") or none' if curly else "write the name that readers see"
        what = "{text} has curly quotes, which are no quotes" if curly else word
        raise PydanticCustomError("P106", what, {"text": text, "hint": hint})
    return text


_COMMON_PATTERN = r"^([a-z]+|_)$"
_SOUND_PATTERN = r"^[a-z]+$"
_BIGRAM_PATTERN = r"([a-z]+|_)-([a-z]+|_)"
_TRIGRAM_PATTERN = r"([a-z]+|_)-([a-z]+)-([a-z]+|_)"
_NAME_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9_-]*$"
_PARENT_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9_-]*(:[A-Za-z0-9][A-Za-z0-9_+-]*)?$"

Name = Annotated[str, Field(pattern=_NAME_PATTERN, max_length=80)]
"""The name of a pack: letters, digits, `-` and `_`."""

Parent = Annotated[str, Field(pattern=_PARENT_PATTERN, max_length=80)]
"""The name of a language, or ENGINE:CODE for one without a pack."""

Text = Annotated[str, Field(min_length=1)]
"""Text that is not empty."""

Title = Annotated[str, AfterValidator(_title)]
"""A name for readers."""

Common = Annotated[str, Field(pattern=_COMMON_PATTERN)]
"""The label of a common phoneme: small letters, or `_` for silence."""

Sound = Annotated[str, Field(pattern=_SOUND_PATTERN)]
"""The label of a common phoneme that is not silence."""

Label = Annotated[str, Field(min_length=1, max_length=80)]
"""The label of a phoneme in some notation."""

PoseName = Annotated[str, Field(min_length=1, max_length=120), AfterValidator(_pose)]
"""The animator's name of a pose."""

Unit = Annotated[float, Field(ge=0, le=1)]
"""A number from 0 to 1."""

Positive = Annotated[float, Field(gt=0)]
"""A number above 0."""

NotNegative = Annotated[float, Field(ge=0)]
"""A number that is 0 or more."""

Vector = tuple[float, float, float]
"""Numbers along x, y and z."""


def _direction(axis: Vector) -> Vector:
    """Refuse an axis without a direction."""
    if not any(axis):
        what = "an axis of (0, 0, 0) turns nothing; write one such as [1, 0, 0]"
        raise PydanticCustomError("P104", what)
    return axis


Axis = Annotated[Vector, AfterValidator(_direction)]
"""An axis of a turn, of any length."""

FormatNumber = Literal[1]
"""The format of the pack."""


def _bigram(key: str) -> str:
    if re.fullmatch(_BIGRAM_PATTERN, key):
        return key
    if re.fullmatch(_TRIGRAM_PATTERN, key):
        what, hint = "'{key}' is a trigram, not a bigram", "put it under `trigrams`"
        raise PydanticCustomError("P112", what, {"key": key, "hint": hint})
    if key.count("-") > 1:
        what = "'{key}' has three or more parts, which are reserved for longer units"
        raise PydanticCustomError("P112", what, {"key": key})
    what = "'{key}' is not a bigram: write two common phonemes joined by '-', such as 'l-ow'"
    raise PydanticCustomError("P106", what, {"key": key})


BigramKey = Annotated[str, AfterValidator(_bigram)]
"""Two common phonemes joined by `-`."""


def _trigram(key: str) -> str:
    if re.fullmatch(_TRIGRAM_PATTERN, key):
        return key
    what = "'{key}' is not a trigram"
    hint = "write three common phonemes joined by '-', such as 's-d-r'"
    if key.split("-")[1:-1] == ["_"]:
        what = "'{key}' has silence in its middle"
        hint = "silence can only begin or end a trigram; draw the two bigrams instead"
    raise PydanticCustomError("P106", what, {"key": key, "hint": hint})


TrigramKey = Annotated[str, AfterValidator(_trigram)]
"""Three common phonemes joined by `-`; silence at either end only."""


def _rising(points: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    before = 0.0  # two points of one time are a step, as in drawings that do not blend
    for index, (time, _) in enumerate(points):
        if time < before:
            what = "times fall from {before} to {time}; the times of a curve must not fall"
            told = {"before": f"{before:g}", "time": f"{time:g}", "at": index}
            raise PydanticCustomError("P113", what, told)
        before = time
    return points


Curve = Annotated[
    tuple[tuple[Unit, Unit], ...],
    Field(min_length=2, description="Control points (t, v) in normalised time, t never falling."),
    AfterValidator(_rising),
]
"""Control points (t, v), both in [0, 1]; t never decreases."""

Curves = dict[PoseName, Curve]
"""A curve for each pose that moves."""


def _names(value: Data) -> Data:
    """Turn a list of names into a mapping from each name to None."""
    if isinstance(value, Mapping):
        return value
    if not isinstance(value, (tuple, list)):
        raise PydanticCustomError("P103", "must be a list of names, or a mapping")
    for index, item in enumerate(value):
        if not isinstance(item, str):
            raise PydanticCustomError("P103", "must be a name", {"at": index, "got": item})
    return dict.fromkeys(value)


JsonSchema = dict[str, Any]


@dataclass(frozen=True)
class Short(BeforeValidator):
    """A validator that accepts short forms of a value and lists them in the JSON Schema."""

    forms: Callable[[JsonSchema], list[JsonSchema]] = lambda full: [full]
    """Maps the schema of the full form to the schemas of all accepted forms."""

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchema:
        """Return a schema with every accepted form, for editors."""
        forms = self.forms(handler(core))
        return forms[0] if len(forms) == 1 else {"anyOf": forms}


OrEmpty = Short(
    lambda value: {} if value is None else value, forms=lambda full: [full, {"type": "null"}]
)
"""Accepts null as an empty mapping."""

OrOne = Short(
    lambda value: (value,) if isinstance(value, (str, Mapping)) else value,
    forms=lambda full: [full, full["items"]],
)
"""Accepts a single value as a list of one."""

OrNames = Short(_names, forms=lambda full: [full, {"type": "array", "items": {"type": "string"}}])
"""Accepts a list of names as a mapping from each name to null."""


def labels_as_sounds(value: Data) -> Data:
    """Expand the short form of sounds: `to` alone, as a label or a list of labels."""
    # the reader of YAML gives tuples for lists; Python code gives lists
    if isinstance(value, (str, tuple, list)):
        return {"to": value}
    if not isinstance(value, (dict, Strict)):
        what = "must be a label, a list of labels, or a mapping with `to`"
        raise PydanticCustomError("P103", what)
    return value


def sound_forms(full: JsonSchema) -> list[JsonSchema]:
    """Return the schemas of sounds: in full, a label, and a list of labels."""
    return [full, {"type": "string"}, {"type": "array", "items": {"type": "string"}}]


class PackModel(Strict):
    """The fields of every pack."""

    format: FormatNumber
    """The format of the file."""
    name: Name
    """The pack's name: that of its file or folder."""
    title: Title = ""
    """The pack's name in lists."""
