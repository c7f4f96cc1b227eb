"""The form of the IPA as data: what every letter and mark of it does to the mouth.

A validator here sees one entry; that words, features and letters exist is checked in
`ipa_checks`.
"""

from typing import Annotated, Literal

from pydantic import Field

from lipsync_lang.packs.models.fields import (
    Common,
    Data,
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

Change = Annotated[float, Field(ge=-1, le=1)]
"""A number from -1 to 1."""

Phrases = Annotated[tuple[Text, ...], OrOne]
"""Descriptions, one of which must fit: every word of it stands in that of the letter."""


class Feature(Strict):
    """One thing that can be seen of a sound, as a number from 0 to 1."""

    weight: Positive
    """How far apart two sounds are that differ in it by 1."""
    otherwise: Unit | None = None
    """The value of letters that say nothing of it; unless stated, they are not compared in it."""
    title: str = ""
    """The feature in words."""


class Preference(Strict):
    """A letter that is taken instead of another."""

    letter: Label = Field(alias="as")
    """The letter whose features are taken."""
    why: Text
    """The reason."""


class Neighbour(Strict):
    """A letter beside which another counts as a common phoneme."""

    of: Label
    """The letter that the language must have too."""
    why: Text
    """The reason."""


class JoinFields(Strict):
    """Which of two letters side by side are seen."""

    first: Phrases = ()
    """Descriptions of the first letter; any letter unless stated."""
    second: Phrases = ()
    """Descriptions of the second letter; any letter unless stated."""
    keep: Literal["first", "second", "both"]
    """Which of them are seen."""
    lost: str = ""
    """What goes with the other."""
    why: str = ""
    """The reason."""


def _mark(value: Data) -> Data:
    """What is lost is short for a mark that does nothing else."""
    return {"lost": value} if isinstance(value, str) else value


def _cases(value: Data) -> Data:
    """One case is short for a list of one."""
    return value if isinstance(value, (tuple, list)) else (value,)


class MarkFields(Strict):
    """What a mark does to a letter that fits."""

    on: Phrases = ()
    """Descriptions of the letters that it fits; any letter unless stated."""
    set: dict[Text, Unit] = Field(default={})
    """Features that become this, where the letter has them."""
    add: dict[Text, Change] = Field(default={})
    """What is added to features, where the letter has them."""
    then: Label | None = None
    """A letter that follows in the same label."""
    time: Positive = 1.0
    """The share of the label's time, against 1 of a letter without marks."""
    lost: str = ""
    """What is not shown."""


ShortMark = Short(_mark, forms=lambda full: [full, {"type": "string"}])
Cases = Annotated[
    tuple[Annotated[MarkFields, ShortMark], ...],
    Field(min_length=1),
    Short(_cases, forms=lambda full: [full, full["items"]]),
]
"""What a mark does; of several cases, the first that fits the letter holds."""


class Ipa(PackModel):
    """What every letter and mark of the IPA does to lips, jaw and tongue."""

    kind: Literal["ipa"]
    """The kind of pack."""
    features: dict[Text, Feature]
    """What can be seen of a sound."""
    fights_from: Positive = 5
    """The weight of a feature from which a pack that shows it otherwise is warned."""
    told_from: Unit = 0.25
    """The difference in a feature from which it is told as lost."""
    another: NotNegative
    """What one more common phoneme in a label costs."""
    later: Unit = 1.0
    """How much letters after the first count where several are one common phoneme."""
    terms: dict[Text, dict[Text, Unit]]
    """What each word of a description means, in features."""
    letters: dict[Label, Text]
    """Every letter, described in these words; a later word overrides an earlier one."""
    spellings: dict[Label, Text] = Field(default={})
    """Other ways to write letters and their marks."""
    prefer: dict[Label, Preference] = Field(default={})
    """Letters taken instead, where features alone go astray."""
    aside: dict[Common, dict[Label, Text]] = Field(default={})
    """For a common phoneme, letters it names that are not for other languages, and why."""
    beside: dict[Common, dict[Label, Neighbour]] = Field(default={})
    """For a common phoneme, letters that count as it where the language has their neighbour."""
    joins: tuple[JoinFields, ...] = ()
    """Which letters are seen beside which; the first rule that fits holds."""
    marks: dict[Label, Cases] = Field(default={})
    """What each mark does, a word alone being what is lost."""
    alone: dict[Label, Label] = Field(default={})
    """The letter that a mark stands for where there is no letter."""
    ignored: tuple[Text, ...] = ()
    """Signs that say nothing of the mouth."""
    notations: dict[Text, dict[Text, str]] = Field(default={})
    """Notations that spell the IPA in other signs: by name, what each sign stands for. Every
    language that reads IPA reads them too."""
