"""What the models of packs share: strictness, names, numbers, and forms that are short for others.

A short form (a bare label for a list of one, a list of names for a mapping) becomes the full
one before validation, so that the models know one form only and a fault is reported once.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
)
from pydantic_core import CoreSchema, PydanticCustomError

from lipsync_lang.packs.models.attribute_docs import describe

FORMAT = 1
"""The format of packs this program reads and writes."""

Data = Any
"""A value as YAML holds it."""


class Strict(BaseModel):
    """A part of a pack: nothing unknown, nothing guessed, nothing changed afterwards."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        strict=True,
        json_schema_extra=describe,
        defer_build=True,  # a command uses few of the models, and pays for those alone
        allow_inf_nan=False,
        hide_input_in_errors=True,
        populate_by_name=True,
    )


def _plain(text: str) -> str:
    """Refuse names that nobody could see in full."""
    if text != text.strip() or not text.isprintable():
        raise PydanticCustomError(
            "P106",
            "'{text}' has spaces around it, or a character that does not show",
            {"text": text.strip()},
        )
    return text


_COMMON = r"^([a-z]+|_)$"
_SOUND = r"^[a-z]+$"
_BIGRAM = r"([a-z]+|_)-([a-z]+|_)"
_NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]*$"
_PARENT = r"^[A-Za-z0-9][A-Za-z0-9_-]*(:[A-Za-z0-9][A-Za-z0-9_+-]*)?$"

Name = Annotated[str, Field(pattern=_NAME, max_length=80)]
"""The name of a pack: letters, digits, `-` and `_`."""

Parent = Annotated[str, Field(pattern=_PARENT, max_length=80)]
"""The name of a language, or ENGINE:CODE for one without a pack."""

Text = Annotated[str, Field(min_length=1)]
"""Text that says something."""

Common = Annotated[str, Field(pattern=_COMMON)]
"""The label of a common phoneme: small letters, or `_` for silence."""

Sound = Annotated[str, Field(pattern=_SOUND)]
"""The label of a common phoneme that is not silence."""

Label = Annotated[str, Field(min_length=1, max_length=80)]
"""The label of a phoneme in some notation, as it is written there."""

PoseName = Annotated[str, Field(min_length=1, max_length=120), AfterValidator(_plain)]
"""The name of a pose, as the animator calls it."""

Unit = Annotated[float, Field(ge=0, le=1)]
"""A number from 0 to 1."""

Positive = Annotated[float, Field(gt=0)]
"""A number above 0."""

NotNegative = Annotated[float, Field(ge=0)]
"""A number that is 0 or more."""

Format = Literal[1]
"""The format of the pack."""


def _bigram(key: str) -> str:
    if re.fullmatch(_BIGRAM, key):
        return key
    if key.count("-") > 1:
        what = "'{key}' has three or more parts: these are reserved for longer units"
        raise PydanticCustomError("P112", what, {"key": key})
    what = "'{key}' is not a bigram: write two common phonemes joined by '-', such as 'l-ow'"
    raise PydanticCustomError("P106", what, {"key": key})


BigramKey = Annotated[str, AfterValidator(_bigram)]
"""Two common phonemes joined by `-`."""


def _rising(points: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    before = 0.0
    for index, (time, _) in enumerate(points):
        if time < before:
            what = "times fall from {before} to {time}; a curve runs from left to right"
            raise PydanticCustomError(
                "P113", what, {"before": f"{before:g}", "time": f"{time:g}", "at": index}
            )
        before = time
    return points


Curve = Annotated[
    tuple[tuple[Unit, Unit], ...],
    Field(min_length=2, description="Control points (t, v) in normalised time, t never falling."),
    AfterValidator(_rising),
]
"""Control points (t, v), both from 0 to 1; t never falls."""

Curves = dict[PoseName, Curve]
"""A curve for each pose that moves."""


def _empty(value: Data) -> Data:
    return {} if value is None else value


def _one(value: Data) -> Data:
    return (value,) if isinstance(value, (str, Mapping)) else value


def _names(value: Data) -> Data:
    """Turn a list of names into a mapping to nothing."""
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
    """Accepts short forms of a value, and says in JSON Schema which."""

    forms: Callable[[JsonSchema], list[JsonSchema]] = lambda full: [full]
    """The forms the file may have, from the schema of the full one."""

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchema:
        """Offer every form to editors."""
        forms = self.forms(handler(core))
        return forms[0] if len(forms) == 1 else {"anyOf": forms}


OrEmpty = Short(_empty, forms=lambda full: [full, {"type": "null"}])
"""Nothing stated is an empty mapping."""

OrOne = Short(_one, forms=lambda full: [full, full["items"]])
"""One alone is a list of one."""

OrNames = Short(_names, forms=lambda full: [full, {"type": "array", "items": {"type": "string"}}])
"""A list of names is a mapping to nothing."""


class PackModel(Strict):
    """What every pack starts with."""

    format: Format
    """The format of the file."""
    name: Name
    """The file's or folder's name."""
    title: str = ""
    """What to call the pack in lists."""
