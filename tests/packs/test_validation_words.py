"""Words for pydantic's errors in `validation.yaml`: each names the cure."""

from pathlib import Path
from typing import Annotated

import pytest
from pydantic import Field

from lipsync_lang.packs.describe import kinds, schema
from lipsync_lang.packs.models.fields import Strict
from lipsync_lang.packs.models.validation import _words, validated_as
from lipsync_lang.packs.yaml.building import read_yaml


class Inner(Strict):
    """A part of a file."""


class Everything(Strict):
    """A value of each type, and a number within each bound."""

    text: str = ""
    number: float = 0
    whole: int = 0
    flag: bool = False
    several: tuple[int, ...] = ()
    listed: list[int] = Field(default=[])
    named: dict[str, int] = Field(default={})
    inner: Inner = Inner()
    above: Annotated[float, Field(gt=1)] = 2
    least: Annotated[float, Field(ge=1)] = 1
    below: Annotated[float, Field(lt=1)] = 0
    most: Annotated[float, Field(le=1)] = 1


TYPES = {
    "text: 1": "`text` must be text, got number 1",
    "number: a": "`number` must be a number, got text 'a'",
    "whole: a": "`whole` must be a whole number, got text 'a'",
    "flag: a": "`flag` must be true or false, got text 'a'",
    "several: a": "`several` must be a list, got text 'a'",
    "listed: a": "`listed` must be a list, got text 'a'",
    "named: a": "`named` must be a mapping, got text 'a'",
    "inner: a": "`inner` must be a mapping, got text 'a'",
}
RANGES = {
    "above: 1": ("`above` must be above 1, got 1", "write a number that is above 1"),
    "least: 0": ("`least` must be at least 1, got 0", "write a number that is at least 1"),
    "below: 1": ("`below` must be below 1, got 1", "write a number that is below 1"),
    "most: 2": ("`most` must be at most 1, got 2", "write a number that is at most 1"),
}
CURES = {
    "23.976": "write a number such as 23.976, or a fraction such as 24000/1001",
    "ab": "name a phoneme in small letters a to z; silence has no contact",
    "_": "name a common phoneme in small letters a to z, or '_'",
    "a-1_B": "use letters, digits, '-' and '_'",
    "espeak:pt-br": "name a language, or an engine and its code as in ENGINE:CODE",
    "and so on": "write the words alone, without braces and |",
    "A": "write one capital from A to Z",
    "100": "write a number of digits alone",
    ".json": "write a suffix in small letters, such as .json",
}
"""Cures of the patterns, in their order, by a text that fits the pattern."""


def fault(content, model=Everything):
    _, (found,) = validated_as(read_yaml(Path("pack.yaml"), content.encode()), model)
    return found


@pytest.mark.parametrize("content", TYPES)
def test_a_value_of_another_type_is_told(content):
    assert (fault(content).code, fault(content).what) == ("P103", TYPES[content])


@pytest.mark.parametrize("content", RANGES)
def test_a_number_out_of_range_is_told_with_its_bound(content):
    assert (fault(content).code, fault(content).what, fault(content).hint) == (
        "P104", *RANGES[content],
    )  # fmt: skip


def test_every_pattern_has_its_cure():
    cured = zip(_words()["patterns"], CURES.items(), strict=True)
    for pattern, (fitting, cure) in cured:

        class Stated(Strict):
            name: Annotated[str, Field(pattern=pattern)]

        sound, _ = validated_as(read_yaml(Path("a.yaml"), f"name: '{fitting}'".encode()), Stated)
        assert sound is not None, pattern
        assert fault("name: '{}|'", Stated).hint == cure


def test_every_word_is_said():
    stated = str([schema(kind) for kind in kinds()])
    words = _words()
    assert len(words["types"]) == len(TYPES) + 1  # a mapping has two names in pydantic
    assert len(words["ranges"]) == len(RANGES)
    assert [one for one in words["patterns"] if repr(one)[1:-1] not in stated] == []
