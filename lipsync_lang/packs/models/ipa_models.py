"""Models of the IPA pack, which describes the effect of each letter and mark on the mouth.

A validator here sees one entry. `ipa_checks` checks that words, features and letters exist.
"""

from typing import Annotated, Literal

from pydantic import Field

from lipsync_lang.packs.models.fields import (
    Common,
    Label,
    NotNegative,
    OrOne,
    PackModel,
    Positive,
    Short,
    Strict,
    Text,
    Unit,
)
from lipsync_lang.packs.yaml.source import Data

FeatureChange = Annotated[float, Field(ge=-1, le=1)]
"""A number from -1 to 1."""

Phrases = Annotated[tuple[Text, ...], OrOne]
"""Descriptions, one of which must fit. A description fits a letter that has all of its words."""


class Feature(Strict):
    """A visible property of sounds, as a number from 0 to 1."""

    weight: Positive
    """The distance between two sounds that differ in the feature by 1."""
    otherwise: Unit | None = None
    """The value of letters without the feature; if unstated, they are not compared in it."""
    title: str = ""
    """The feature in words."""


class Preference(Strict):
    """A replacement of one letter by another."""

    letter: Label = Field(alias="as")
    """The replacement, whose features are used."""
    why: Text
    """The reason."""


class Decision(Strict):
    """A mapping that several languages share against the features."""

    labels: Annotated[tuple[Label, ...], Field(min_length=1)]
    """The labels so mapped."""
    to: Annotated[tuple[Common, ...], OrOne]
    """The common phonemes."""
    why: Text
    """The reason."""


class JoinFields(Strict):
    """A rule for two adjacent letters: which of them are visible."""

    first: Phrases = ()
    """Descriptions of the first letter; any letter unless stated."""
    second: Phrases = ()
    """Descriptions of the second letter; any letter unless stated."""
    keep: Literal["first", "second", "both"]
    """The visible letters."""
    lost: str = ""
    """The property that is lost with the other letter."""
    why: str = ""
    """The reason."""


def _mark(value: Data) -> Data:
    """Expand the short form of a mark with no effect: the text of `lost` alone."""
    return {"lost": value} if isinstance(value, str) else value


def _cases(value: Data) -> Data:
    """Expand the short form of a list: a single case."""
    return value if isinstance(value, (tuple, list)) else (value,)


class MarkFields(Strict):
    """The effect of a mark on the letters that it fits."""

    on: Phrases = ()
    """Descriptions of the letters that the mark fits; any letter unless stated."""
    set: dict[Text, Unit] = Field(default={})
    """New values of features that the letter has."""
    add: dict[Text, FeatureChange] = Field(default={})
    """Changes of features that the letter has."""
    then: Label | None = None
    """A letter that follows in the same label."""
    time: Positive = 1.0
    """The letter's share of the label's time; a letter without marks has 1."""
    lost: str = ""
    """The property that is not visible."""


ShortMark = Short(_mark, forms=lambda full: [full, {"type": "string"}])
Cases = Annotated[
    tuple[Annotated[MarkFields, ShortMark], ...],
    Field(min_length=1),
    Short(_cases, forms=lambda full: [full, full["items"]]),
]
"""The effects of a mark; the first case that fits the letter applies."""


class HearingFields(Strict):
    """The similarity of sounds to the ear, for acoustic models of another language."""

    model: Text
    """The acoustic model."""
    weights: dict[Text, NotNegative]
    """The weight of each visible property in the similarity of sounds."""
    voice: NotNegative
    """The weight of voice."""
    voiceless: Text
    """The letters without voice, separated by spaces."""
    heard: str = ""
    """Marks, separated by spaces, that sound like the letter that `alone` gives them."""
    another: NotNegative
    """The cost of each further phone in a label."""
    later: Unit = 1.0
    """The weight of letters after the first, if several letters map to one phone."""
    neighbours: tuple[Text, ...] = ()
    """Groups of phones, separated by spaces, that change the sound of those beside them alike."""
    phones: dict[Label, Annotated[tuple[Label, ...], OrOne]]
    """The letters that each phone of the model sounds like."""
    between_vowels: dict[Label, Annotated[tuple[Label, ...], OrOne]] = Field(default={})
    """The letters that a phone sounds like between two vowels, though another one elsewhere."""


class Ipa(PackModel):
    """The effect of each letter and mark of the IPA on lips, jaw and tongue."""

    kind: Literal["ipa"]
    """The kind of pack."""
    features: dict[Text, Feature]
    """Visible properties of sounds."""
    fights_from: Positive = 5
    """Least weight of a feature for which a contradicting mapping gives a warning."""
    told_from: Unit = 0.25
    """Least difference in a feature that is reported as lost."""
    another: NotNegative
    """The cost of each further common phoneme in a label."""
    later: Unit = 1.0
    """The weight of letters after the first, if several letters map to one common phoneme."""
    hearing: HearingFields | None = None
    """The similarity of sounds to the ear."""
    terms: dict[Text, dict[Text, Unit]]
    """The features of each word that descriptions use."""
    letters: dict[Label, Text]
    """A description of each letter; a later word overrides an earlier one."""
    spellings: dict[Label, Text] = Field(default={})
    """Other ways to write letters and their marks."""
    prefer: dict[Label, Preference] = Field(default={})
    """Replacements for letters whose features alone give a wrong result."""
    aside: dict[Common, dict[Label, Text]] = Field(default={})
    """Per common phoneme, letters of its `ipa` that other languages do not map to it, and why."""
    decided: tuple[Decision, ...] = ()
    """Mappings that languages share against the features, with the reason that each of them has."""
    joins: tuple[JoinFields, ...] = ()
    """Visible letters of two adjacent ones; the first rule that fits applies."""
    marks: dict[Label, Cases] = Field(default={})
    """The effect of each mark; plain text states a property that is lost."""
    alone: dict[Label, Label] = Field(default={})
    """The letter for a mark that stands without one."""
    ignored: tuple[Text, ...] = ()
    """Signs without effect on the mouth."""
    notations: dict[Text, dict[Text, str]] = Field(default={})
    """Notations that spell the IPA in other signs: by name, the IPA of each sign. Every language
    that reads IPA reads these notations as well."""
