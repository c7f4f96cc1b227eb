"""The form of what linguists write: common phonemes and languages.

A validator here sees one file; what needs two files or two places is in `checks`. Times are in
seconds.
"""

from math import isclose
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lipsync_lang.packs.models.fields import (
    Common,
    Data,
    Label,
    OrEmpty,
    OrNames,
    OrOne,
    PackModel,
    Parent,
    Positive,
    Short,
    Strict,
    Text,
)
from lipsync_lang.phonology.g2p.contexts import ContextError, compile_context

SoundClass = Literal[
    "vowel", "glide", "liquid", "nasal", "stop", "fricative", "affricate", "silence"
]
"""The manner of a sound, by which lengths are estimated."""

TAG = r"^[A-Za-z0-9]+(-[A-Za-z0-9]+)*$"
"""What a language's tag looks like."""

SHARES_SLACK = 1e-3
"""Shares may miss 1 by this much: 0.333 three times is a whole."""


class Phoneme(Strict):
    """A common phoneme: what it stands for, and how to show it."""

    title: str = ""
    """The sound in words."""
    ipa: tuple[Text, ...] = ()
    """IPA letters that count as this phoneme."""
    example: str = ""
    """A word with the sound in it."""
    sound: SoundClass | None = Field(default=None, alias="class")
    """The manner of the sound, by which lengths are estimated."""
    like: Common | None = None
    """The phoneme whose bigrams stand in for missing ones."""
    spelled: tuple[Text, ...] = ()
    """Other labels by which banks of other programs know it, in any case."""


class Sounds(Strict):
    """The common phonemes that one label becomes, and how they share its time."""

    to: Annotated[tuple[Common, ...], OrOne]
    """Common phonemes in order; none makes the label mute."""
    shares: tuple[Positive, ...] | None = None
    """The part of the time each gets, adding up to 1; equal unless stated."""

    @model_validator(mode="after")
    def _shares_fit(self) -> Self:
        if self.shares is None:
            return self
        if len(self.shares) != len(self.to):
            what = "{shares} shares for {to} phonemes; state one for each"
            raise PydanticCustomError(
                "P114", what, {"shares": len(self.shares), "to": len(self.to), "field": "shares"}
            )
        if not isclose(sum(self.shares), 1, abs_tol=SHARES_SLACK):
            what = "shares add up to {sum}, not to 1"
            raise PydanticCustomError(
                "P114", what, {"sum": f"{sum(self.shares):g}", "field": "shares"}
            )
        return self


def _sounds(value: Data) -> Data:
    """One label, or a list of them, is short for `to`."""
    if isinstance(value, (str, tuple, list)):
        return {"to": value}
    if not isinstance(value, (dict, Sounds)):
        raise PydanticCustomError(
            "P103", "must be a label, a list of labels, or a mapping with `to`"
        )
    return value


ShortSounds = Short(
    _sounds,
    forms=lambda full: [
        full,
        {"type": "string"},
        {"type": "array", "items": {"type": "string"}},
    ],
)


class Visemes(Strict):
    """A notation of mouth shapes, read in every language."""

    title: Text
    """Whose shapes they are."""
    labels: dict[Label, Annotated[Sounds, ShortSounds]]
    """What each shape becomes: of the sounds that look so, the most typical."""


class Phonemes(PackModel):
    """The common phonemes that all languages and pose sets speak of."""

    kind: Literal["phonemes"]
    """The kind of pack."""
    silence: Common = "_"
    """The label of silence."""
    silence_labels: tuple[str, ...] = ()
    """Other spellings of silence, in any notation."""
    phonemes: dict[Common, Annotated[Phoneme, OrEmpty]]
    """Every common phoneme, those that only some languages use included."""
    base: tuple[Common, ...]
    """The phonemes that every language has."""
    durations: dict[SoundClass, Positive] = Field(default={})
    """Seconds by class, where neither a voice nor the language gives any."""
    visemes: dict[Text, Visemes] = Field(default={})
    """Notations of mouth shapes, not sounds: lossy, and never guessed."""

    @model_validator(mode="after")
    def _spelled_once(self) -> Self:
        names = {label: label for label in (*self.phonemes, self.silence)}
        for label, phoneme in self.phonemes.items():
            for other in phoneme.spelled:
                known = names.setdefault(other.casefold(), label)
                if known != label:
                    what = "'{other}' is spelled for '{label}', but already means '{known}'"
                    context = {"other": other, "label": label, "known": known, "field": "phonemes"}
                    raise PydanticCustomError("P115", what, context)
        return self


class Rewrite(Strict):
    """A spelling and what it sounds like, where it stands in a given context."""

    spelling: Text = Field(alias="from")
    """Letters of the word."""
    to: Annotated[tuple[Label, ...], OrOne]
    """Labels of the notation; an empty list for mute letters."""
    before: str = ""
    """A regular expression that must match what follows, in small letters."""
    after: str = ""
    """A regular expression that must match what precedes, in small letters."""

    @model_validator(mode="after")
    def _contexts_are_usable(self) -> Self:
        for field in ("before", "after"):
            text = getattr(self, field)
            try:
                if text:
                    compile_context(text, precedes=field == "after")
            except ContextError as error:
                raise PydanticCustomError(
                    "P118" if error.slow else "P117",
                    "`{field}` {what}",
                    {"what": error.what, "hint": error.cure, "field": field},
                ) from None
        return self


class G2P(Strict):
    """How text becomes phonemes."""

    engine: Literal["espeak", "pypinyin", "epitran", "lexicon", "rules"]
    """What turns text into labels."""
    voice: Text | None = None
    """The engine's voice, where it has voices."""
    code: Text | None = None
    """The engine's code of the language, where it has codes."""
    file: Text | None = None
    """A lexicon beside the pack."""
    notation: Text | None = None
    """The notation that comes out; the first of the pack unless stated."""
    respell: Text | None = None
    """What spells the text anew before the engine reads it, where writing hides the sounds."""
    rules: tuple[Rewrite, ...] = ()
    """Rewrites, tried in order at each place of a word; the first that fits wins."""


class TTS(Strict):
    """Which voice speaks text."""

    engine: Text
    """The speech engine."""
    voice: Text | None = None
    """The engine's voice."""
    others: dict[Text, Text] = Field(default={})
    """Voices of other speech engines, by engine."""


class AudioFields(Strict):
    """How recordings of the language become phonemes."""

    align: Text | None = None
    """What finds the times of a text in a recording of it; `warp` unless stated."""
    recognise: Text | None = None
    """What finds words where there is no text."""
    model: Text | None = None
    """What both call their model of the language."""
    notation: Text | None = None
    """The notation that comes out."""
    phones: dict[Label, Annotated[tuple[Label, ...], OrOne]] = Field(default={})
    """For labels that `g2p` writes, how the model says them."""


class Test(Strict):
    """Text, and the common phonemes it must become."""

    __test__ = False  # not one of pytest's

    text: Text
    """What is said."""
    phonemes: tuple[Common, ...] = Field(min_length=1)
    """What is heard."""
    ipa: str = ""
    """The segments as the source writes them, in IPA with spaces between them."""
    source: str = ""
    """Who says so."""


class StatedInventory(Strict):
    """The phonemes that the language is said to have, by somebody else."""

    source: Text
    """Who says so, and where."""
    segments: tuple[Label, ...] = Field(min_length=1)
    """Every segment, in IPA."""
    spelled: dict[Label, Label] = Field(default={})
    """How the pack's tests write a segment, where they write it otherwise."""
    absent: dict[Label, Text] = Field(default={})
    """Segments the pack does not map, and why."""


class Language(PackModel):
    """How one language is spoken with the common phonemes."""

    kind: Literal["language"]
    """The kind of pack."""
    tag: Annotated[str, Field(pattern=TAG)]
    """The language as BCP 47 writes it."""
    aliases: tuple[Annotated[str, Field(pattern=TAG)], ...] = ()
    """Other tags and names that it answers to."""
    adds: Annotated[dict[Common, Phoneme | None], OrNames] = Field(default={})
    """Phonemes beyond the base: names of common ones, or new ones in full."""
    extends: Parent | None = None
    """The language of which this one states only the differences; its own name is the one it
    shadows, and ENGINE:CODE one without a pack."""
    g2p: G2P | None = None
    """How text becomes phonemes."""
    tts: TTS | None = None
    """Which voice speaks text."""
    audio: AudioFields | None = None
    """How recordings become phonemes."""
    durations: dict[SoundClass, Positive] = Field(default={})
    """Seconds by class, where no voice gives timings."""
    silence: tuple[str, ...] = ()
    """Labels that mean silence, beyond those of the common pack."""
    notations: dict[Text, dict[Label, Annotated[Sounds, ShortSounds]]] = Field(default={})
    """For each notation, what its labels become."""
    words: dict[Text, Annotated[tuple[Common, ...], Field(min_length=1)]] = Field(default={})
    """Pronunciations that override the engine."""
    examples: dict[Label, str] = Field(default={})
    """A word for each label of the first notation."""
    reasons: dict[Label, str] = Field(default={})
    """Why a label becomes what it does, where that is not obvious."""
    automatic: bool = False
    """Whether IPA that no notation maps goes to the nearest common phonemes by its features."""
    inventory: StatedInventory | None = None
    """The phonemes of the language, each of which the pack maps or lists as absent."""
    caveats: tuple[str, ...] = ()
    """What the pack is known to get wrong."""
    tests: tuple[Test, ...] = ()
    """Texts the pack must get right."""
