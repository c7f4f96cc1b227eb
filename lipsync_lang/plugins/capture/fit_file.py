"""Proposal files: the results of a fit as JSON, which a person accepts item by item.

The reader of packs reads proposals too, because YAML includes JSON: a fault has its line, column
and cure, and size and nesting are limited. Units are those of packs: weights and normalised times
are in [0, 1], other times in seconds.

The name of an item states the value that it replaces: ``targets.PHONEME``, ``softness.REGION``,
``anticipate.POSE``, ``motion.speed_limit`` and ``bigrams.PHONEME-PHONEME``.
"""

import json
import re
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Annotated, Literal, Self, TextIO

from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from lipsync_lang import PackError, PackFaults
from lipsync_lang.base.files import read_input
from lipsync_lang.packs.models.fields import (
    BigramKey,
    Common,
    Curves,
    Name,
    NotNegative,
    PoseName,
    Strict,
    Text,
    Unit,
)
from lipsync_lang.packs.models.pose_models import AnticipateSeconds, Softness, Targets
from lipsync_lang.packs.models.validation import validated_as
from lipsync_lang.packs.splicing import plain
from lipsync_lang.packs.yaml.building import read_yaml
from lipsync_lang.packs.yaml.pack_files import MAX_PACK_BYTES, shown
from lipsync_lang.packs.yaml.source import Data
from lipsync_lang.pipeline.motion import SLOW_SPEED

FIT_FORMAT = 1
"""The newest readable format of proposals, which is also the written one."""

MAX_FITTED_SPEED = 1000.0
"""Highest speed limit of a proposal, in weight per second; a face needs about 15."""

MAX_LISTED_FAULTS = 12
"""Maximum number of faults in an error message; faults of generated files often repeat."""

VALUE_DECIMALS = 4
FIT_FORM = '{"kind": "fit", "format": 1, "poseset": ..., "items": [{"item": "targets.a", ...}]}'
ItemCount = Annotated[int, Field(ge=0)]


class FittedCurves(Strict):
    """The fitted curves of a bigram, in its normalised time."""

    boundary: Annotated[float, Field(gt=0, lt=1)] = 0.5
    """The end of the first phoneme."""
    curves: Curves
    """Control points of each pose that moves."""


FITTED: dict[str, tuple[Data, Data]] = {
    "targets": (Common, Targets),
    "softness": (Text, Softness),
    "anticipate": (PoseName, AnticipateSeconds),
    "motion": (
        Literal["speed_limit"],
        Annotated[float, Field(ge=SLOW_SPEED, le=MAX_FITTED_SPEED)],
    ),
    "bigrams": (BigramKey, FittedCurves),
}
"""The types of the rest of the name and of the value, for each kind of item."""


@cache
def _adapters(kind: str) -> tuple[TypeAdapter[Data], TypeAdapter[Data]]:
    """Return validators of the name and of the value of a kind of item."""
    name, value = FITTED[kind]
    # Models state their own settings, and pydantic refuses others for them; bare types have none.
    strict = ConfigDict(strict=True, allow_inf_nan=False, hide_input_in_errors=True)
    bare = {"targets", "softness", "anticipate", "motion"}
    return (
        TypeAdapter(name, config=strict),
        TypeAdapter(value, config=strict) if kind in bare else TypeAdapter(value),
    )


def split_item(item: str) -> tuple[str, str]:
    """Return the kind of an item and the name within it: ``targets`` and ``a``."""
    kind, _, name = item.partition(".")
    return kind, name


def _item(item: str) -> str:
    """Check the kind and the rest of the name of an item."""
    kind, name = split_item(item)
    if kind not in FITTED or not name:
        what = "'{item}' is not an item of a fit: write one of {known}"
        known = ", ".join(f"{one}.NAME" for one in FITTED)
        raise PydanticCustomError("P106", what, {"item": item[:80], "known": known})
    _adapters(kind)[0].validate_python(name)
    return item


class FitItem(Strict):
    """A fitted value with the evidence for it."""

    item: Annotated[str, Field(max_length=160), AfterValidator(_item)]
    """The name of the value that it replaces."""
    value: Data
    """The fitted value, in the form of a pack."""
    was: Data = None
    """The value before the fit; None without one."""
    occurrences: ItemCount = 0
    """Occurrences in the captures."""
    residual_before: NotNegative | None = None
    """RMS difference between curves and captures with the value before."""
    residual_after: NotNegative | None = None
    """RMS difference with the fitted value."""
    confidence: Unit = 1.0
    """Certainty of the value, from 0 to 1."""

    @field_validator("value", "was", mode="plain")
    @classmethod
    def _fits(cls, value: Data, info: ValidationInfo) -> Data:
        """Check a value against its kind, and return it as plain data."""
        value = plain(value)
        if "item" in info.data and not (value is None and info.field_name == "was"):
            _adapters(split_item(info.data["item"])[0])[1].validate_python(value)
        return value

    @property
    def typed(self) -> Data:
        """The value as a part of a pack: targets, a number, or `FittedCurves`."""
        return _adapters(self.kind)[1].validate_python(self.value)

    @property
    def kind(self) -> str:
        """The kind of item."""
        return split_item(self.item)[0]

    @property
    def name(self) -> str:
        """The phoneme, region, pose, setting or bigram."""
        return split_item(self.item)[1]


class FitFold(Strict):
    """A fold of a cross-validation: a fit without some lines, tested on them."""

    model_config = ConfigDict(extra="allow")

    held_out: str
    """The line or speaker left out of the fit."""
    by: Literal["line", "speaker"]
    """The unit that is left out."""
    before: NotNegative
    """RMS error on the held-out lines without the fit."""
    after: NotNegative
    """RMS error on the held-out lines with the fit."""


class FitVerdict(Strict):
    """The judgement of a fit by held-out lines and speakers."""

    accepted: bool
    """True if the fit generalises."""
    why: str = ""
    """The reason, with numbers."""
    folds: tuple[FitFold, ...] = ()
    """The cross-validation."""


class SetAside(Strict):
    """A captured line that the fit leaves out."""

    line: str
    """The line's name."""
    why: str
    """The reason."""


class FitProposal(Strict):
    """The result of a fit, for a person to accept."""

    kind: Literal["fit"] = "fit"
    """The kind of file."""
    format: Literal[1] = 1
    """The format of the file."""
    language: str
    """The language of the captures."""
    character: str
    """The character that was fitted, or a bare pose set."""
    poseset: Name
    """The pose set whose poses move."""
    lines: ItemCount = 0
    """Number of fitted lines."""
    seconds: NotNegative = 0
    """Seconds of fitted capture."""
    speakers: tuple[str, ...] = ()
    """The speakers of those lines."""
    verdict: FitVerdict
    """The judgement of the fit by held-out lines."""
    items: tuple[FitItem, ...]
    """The fitted values."""
    remarks: tuple[str, ...] = ()
    """Doubtful points, as sentences."""
    set_aside: tuple[SetAside, ...] = ()
    """Captured lines that the fit leaves out."""

    @model_validator(mode="after")
    def _once(self) -> Self:
        """Check that each item has one value."""
        for item, count in Counter(one.item for one in self.items).items():
            if count > 1:
                what = "'{item}' has two values; keep one of them"
                raise PydanticCustomError("P205", what, {"item": item, "field": "items"})
        return self


def read_fit(path: Path) -> FitProposal:
    """Read and check a proposal; ``-`` is standard input.

    Raises PackError if the file is unreadable or is not a proposal, and PackFaults, with the first
    `MAX_LISTED_FAULTS` and their places, if the proposal is invalid.
    """
    content = read_input(path, MAX_PACK_BYTES, error=PackError, mend="split the proposal")
    try:
        source = read_yaml(path, content)
    except PackFaults as error:
        raise PackFaults(error.faults[:MAX_LISTED_FAULTS]) from None
    data = source.data
    if not isinstance(data, dict) or data.get("kind") != "fit":
        raise PackError(f"{shown(path)}: is not a result of a fit; the form is {FIT_FORM}")
    number = data.get("format")
    # `isinstance` would take `true` for a number.
    if type(number) is int and number > FIT_FORMAT:
        what = f"the fit is in format {number}; this program reads format {FIT_FORMAT}"
        hint = "use a newer version of the program"
        raise PackFaults([source.fault(("format",), "P110", what, hint)])
    proposal, faults = validated_as(source, FitProposal)
    if proposal is None:
        raise PackFaults(faults[:MAX_LISTED_FAULTS])
    return proposal


def write_fit(stream: TextIO, proposal: FitProposal) -> None:
    """Write a proposal as JSON, one item a line."""
    data = proposal.model_dump(mode="json")
    items, rest = data.pop("items"), data
    # The items come last, one a line, so that a person can compare two files with a diff.
    head = json.dumps(rest, ensure_ascii=False, allow_nan=False, indent=1)
    rows = ",\n  ".join(
        json.dumps(rounded(row), ensure_ascii=False, allow_nan=False) for row in items
    )
    stream.write(re.sub(r"\n}\Z", "", head) + f',\n "items": [\n  {rows}\n ]\n}}\n')


def rounded(value: Data) -> Data:
    """Return plain data with floats of `VALUE_DECIMALS`."""
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(one) for one in value]
    return round(value, VALUE_DECIMALS) if isinstance(value, float) else value
