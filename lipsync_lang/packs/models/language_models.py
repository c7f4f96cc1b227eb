"""Models of the packs that linguists write: common phonemes and languages.

A validator here sees one file; `packs.checking` compares files. Times are in seconds.
"""

from collections.abc import Mapping, Sequence
from math import isclose
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lipsync_lang.packs.models.fields import (
    Common,
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
    labels_as_sounds,
    sound_forms,
)
from lipsync_lang.packs.models.gesture_models import GestureWords
from lipsync_lang.packs.models.motion_models import MotionFields, OrPreset
from lipsync_lang.packs.models.text_models import ContextText, LanguageText, SharedText, WordTable
from lipsync_lang.text.phonology.labels import Value

SoundClass = Literal[
    "vowel", "glide", "liquid", "nasal", "stop", "fricative", "affricate", "silence"
]
"""The manner of a sound, which gives its estimated duration."""

TAG_PATTERN = r"^[A-Za-z0-9]{1,8}(-[A-Za-z0-9]{1,8})*$"
"""Pattern of a language's tag."""

ALIAS_PATTERN = r"^[^\x00-/:-@\[-`{-\x7f\s]+([ -][^\x00-/:-@\[-`{-\x7f\s]+)*$"
"""Pattern of an alias: letters and digits of any script, in words joined by spaces or hyphens."""

SHARES_SLACK = 1e-3
"""Largest difference between the sum of shares and 1; 0.333 three times is accepted."""


class SoundMouth(Strict):
    """The mouth of a sound, as it is seen, in widths of the closed mouth."""

    aperture: Annotated[float, Field(ge=0, le=1)]
    """Gap between the lips in the middle."""
    width: Annotated[float, Field(ge=-1, le=1)]
    """Distance between the corners, less that at rest."""
    protrusion: Annotated[float, Field(ge=-1, le=1)] | None = None
    """Way of the lips to the front; unless stated, the sound leaves it to the jaw."""
    jaw: Annotated[float, Field(ge=0, le=1)] | None = None
    """Way of the chin downwards, where the teeth must be near each other; else it is free."""
    firm: Annotated[float, Field(gt=0, le=4)] | None = None
    """Firmness with which the aperture is held beside others, on a model: 1 unless stated."""


Mouths = Annotated[tuple[SoundMouth, ...], Field(min_length=1), OrOne]
"""The mouth of a sound, or several in a row for a sound that moves."""

MOUTH_MEASURES = ("aperture", "width", "protrusion", "jaw")
"""Names of the measures of a mouth, which those of a model share."""


class SoundFields(Strict):
    """Fields of a common phoneme and of a shade."""

    title: str = ""
    """The sound in words."""
    ipa: tuple[Text, ...] = ()
    """IPA letters that count as this phoneme."""
    example: str = ""
    """A word with the sound in it."""
    sound: SoundClass | None = Field(default=None, alias="class")
    """The manner of the sound, which gives its estimated duration."""
    mouth: Mouths = ()
    """The mouth in running speech, or several in a row for a sound that moves."""


class Phoneme(SoundFields):
    """A common phoneme: its sounds, and its fallback."""

    like: Common | None = None
    """The phoneme whose bigrams replace missing bigrams."""
    spelled: tuple[Text, ...] = ()
    """Labels of the phoneme in banks of other programs; case is ignored."""


class Shade(SoundFields):
    """A finer common phoneme: drafted from its own target, counted and drawn as its parent."""

    like: Common
    """The parent: the phoneme that the shade looks like."""
    contact: Literal["hold", "free"] = "hold"
    """`hold` demands the contacts of the parent; `free` demands none."""
    reason: Text
    """The visible difference from the parent."""


class Sounds(Strict):
    """The common phonemes of one label, and their shares of its time."""

    to: Annotated[tuple[Common, ...], OrOne]
    """Common phonemes in order; an empty list makes the label mute."""
    shares: tuple[Positive, ...] | None = None
    """Each phoneme's share of the time; the sum is 1. Equal unless stated."""

    @model_validator(mode="after")
    def _shares_fit(self) -> Self:
        if self.shares is None:
            return self
        if len(self.shares) != len(self.to):
            what = "{shares} shares for {to} phonemes; state one for each"
            told = {"shares": len(self.shares), "to": len(self.to), "field": "shares"}
            raise PydanticCustomError("P114", what, told)
        if not isclose(sum(self.shares), 1, abs_tol=SHARES_SLACK):
            what, total = "shares add up to {sum}, not to 1", f"{sum(self.shares):g}"
            raise PydanticCustomError("P114", what, {"sum": total, "field": "shares"})
        return self

    @property
    def value(self) -> Value:
        """The common phonemes, each with its share of the time."""
        # nothing is divided for a mute sound, which has no phonemes
        shares = self.shares or [1 / len(self.to) for _ in self.to]
        return tuple(zip(self.to, shares, strict=True))


ShortSounds = Short(labels_as_sounds, forms=sound_forms)

USUAL = Sounds.model_construct(to=())
"""Stands for the usual mapping of a label, until `extending.with_usual` puts it in: this object is
meant, and not any that is equal to it, which is mute."""

OrUsual = Short(
    lambda value: USUAL if value is None else labels_as_sounds(value),
    forms=lambda full: [*sound_forms(full), {"type": "null"}],
)
"""Accepts null as the usual mapping of a label."""


class Visemes(Strict):
    """A notation of mouth shapes, available in every language."""

    title: Text
    """The program that uses these shapes."""
    labels: dict[Label, Annotated[Sounds, ShortSounds]]
    """For each shape, the most typical common phonemes that look like it."""


class Phonemes(PackModel):
    """The common phonemes, which all languages and pose sets share."""

    kind: Literal["phonemes"]
    """The kind of pack."""
    silence: Common = "_"
    """The label of silence."""
    silence_labels: tuple[str, ...] = ()
    """Other spellings of silence, in any notation."""
    noise_labels: tuple[str, ...] = ()
    """Labels of noise, and of speech that an aligner could not read; the mouth rests there."""
    phonemes: dict[Common, Annotated[Phoneme, OrEmpty]]
    """Every common phoneme, including those of some languages only."""
    base: tuple[Common, ...]
    """The phonemes of every language."""
    shades: dict[Common, Shade] = Field(default={})
    """Finer phonemes of every language that has their parent."""
    durations: dict[SoundClass, Positive] = Field(default={})
    """Default seconds by class, if neither a voice nor the language gives timings."""
    text: SharedText | None = None
    """Written forms that languages share: interjections, and letters of vowels."""
    usual: dict[Text, dict[Label, Annotated[Sounds, ShortSounds]]] = Field(default={})
    """For each notation, the usual mapping of labels; a language lists those that it has."""
    visemes: dict[Text, Visemes] = Field(default={})
    """Notations of mouth shapes instead of sounds. They lose information, and are never chosen
    automatically."""

    @property
    def rests(self) -> tuple[str, ...]:
        """Labels at which the mouth rests: of silence and of noise."""
        return (*self.silence_labels, *self.noise_labels)

    def mouths(
        self, adds: "Mapping[str, Phoneme | None] | None" = None
    ) -> dict[str, tuple[SoundMouth, ...]]:
        """Return the mouth of each phoneme and shade, and of a language's own, that states one."""
        sounds = [*self.phonemes.items(), *self.shades.items(), *(adds or {}).items()]
        return {name: sound.mouth for name, sound in sounds if sound and sound.mouth}

    @model_validator(mode="after")
    def _spelled_once(self) -> Self:
        names = {label: label for label in (*self.phonemes, self.silence, *self.shades)}
        for label, phoneme in self.phonemes.items():
            for other in phoneme.spelled:
                known = names.setdefault(other.casefold(), label)
                if known != label:
                    what = "'{other}' is spelled for '{label}', but already means '{known}'"
                    context = {"other": other, "label": label, "known": known, "field": "phonemes"}
                    raise PydanticCustomError("P115", what, context)
        return self


class Rewrite(Strict):
    """A rule that maps a spelling to labels, in a given context."""

    spelling: Text = Field(alias="from")
    """Letters of the word."""
    to: Annotated[tuple[Label, ...], OrOne]
    """Labels of the notation; an empty list for mute letters."""
    before: ContextText = ""
    """A regular expression, in small letters, that must match the text after the spelling."""
    after: ContextText = ""
    """A regular expression, in small letters, that must match the text before the spelling."""


class LabelCorrection(Strict):
    """A correction of labels that the engine gives, in a given context."""

    labels: Annotated[tuple[Label, ...], Field(min_length=1), OrOne] = Field(alias="from")
    """Labels of the engine, in order."""
    to: Annotated[tuple[Label, ...], OrOne]
    """Labels of the notation in their place; an empty list if the sound is not said."""
    before: ContextText = ""
    """A regular expression that must match the labels after them, joined without spaces."""
    after: ContextText = ""
    """A regular expression that must match the labels before them, joined without spaces."""
    spelled: ContextText = ""
    """A regular expression, in small letters, that must be found in the word as it is written."""
    capital: bool = False
    """True for words that begin with a capital letter alone, such as names."""
    next_word: ContextText = ""
    """A regular expression that must match the first label of the next word; none follows before a
    pause."""
    timings: bool = False
    """True to correct the labels of timings in this notation too, whoever wrote them. There are as
    many labels in `to` as in `from`, tones do not count, and all labels are one word."""

    @model_validator(mode="after")
    def _as_many(self) -> Self:
        of_words = self.spelled or self.capital or self.next_word
        if self.timings and (of_words or len(self.to) != len(self.labels)):
            what = "`timings` needs as many labels in `to` as in `from`, and no context of words"
            raise PydanticCustomError("P115", what, {"field": "timings"})
        return self


G2PEngineName = Literal[
    "espeak", "pypinyin", "epitran", "ipa", "lexicon", "rules", "thaiphon", "phonemizer"
]
"""The engines that convert text to labels."""


class G2P(Strict):
    """The conversion of text to phonemes."""

    engine: G2PEngineName
    """The engine that converts text to labels."""
    replace: bool = False
    """True to leave out what the parent states. Otherwise a child with the engine and the voice of
    its parent adds to it."""
    otherwise: G2PEngineName | None = None
    """The engine that reads where the library of the first is not installed."""
    voice: Text | None = None
    """The engine's voice, if it has voices."""
    code: Text | None = None
    """The engine's code of the language, if it has codes."""
    file: Text | None = None
    """A lexicon or an orthography profile beside the pack."""
    backend: Literal["segments", "festival", "espeak"] = "segments"
    """The backend of `phonemizer`: `segments` reads by an orthography profile."""
    column: Text = "IPA"
    """The column of an orthography profile with the sounds of each `Grapheme`."""
    notation: Text | None = None
    """The notation of the engine's labels; the first of the pack unless stated."""
    respell: Text | None = None
    """The respeller that rewrites the text by its sounds before the engine reads it."""
    letters: tuple[Text, ...] = ()
    """Letters that the engine reads as one character, although Unicode composes them of two."""
    rules: tuple[Rewrite, ...] = ()
    """Rewrites, tried in order at each place of a word; the first that fits wins."""
    readings: tuple[Rewrite, ...] = ()
    """Readings of words and letters in the engine's own spelling, such as pinyin with tone digits,
    or kana for syllables; the first that fits wins."""
    foreign: tuple[Rewrite, ...] = ()
    """Rewrites of the sounds of words in Latin letters that the engine does not read, as the shared
    `foreign_voice` says them: to labels, or to the letters of `readings`."""
    native: ContextText = ""
    """A regular expression, in small letters, of the words of a language in Latin letters; with
    `foreign`, other words are said by the voice."""
    corrections: tuple[LabelCorrection, ...] = ()
    """Corrections of the engine's labels, tried in order at each label; the first to fit wins."""

    @property
    def reading_backend(self) -> str:
        """The backend of phonemizer; empty for other engines."""
        return self.backend if self.engine == "phonemizer" else ""


class TTS(Strict):
    """The voice that speaks text."""

    engine: Text
    """The speech engine."""
    voice: Text | None = None
    """The engine's voice."""
    others: dict[Text, Text] = Field(default={})
    """Voices of other speech engines, by engine."""


class AudioFields(Strict):
    """The conversion of recordings to phonemes."""

    align: Annotated[tuple[Text, ...], OrOne] = ()
    """The aligner, which finds the times of a text in a recording, or several: where the first is
    not sure, the next is asked. The more confident result is kept. `NAME:MODEL` names its model
    as well.
    Unless stated, `[pocketsphinx, warp]`."""
    recognise: Text | None = None
    """The recogniser, which finds the words of a recording without a text; `NAME:MODEL` names its
    model as well."""
    model: Text | None = None
    """The name of the language's model, for both aligner and recogniser, or its folder, from the
    folder of the pack."""
    notation: Text | None = None
    """The notation of the resulting labels."""
    phones: dict[Label, Annotated[tuple[Label, ...], OrOne]] = Field(default={})
    """The model's phones for labels written by `g2p`; other labels go to the phones that sound most
    like them (`hearing` in the pack of the IPA)."""
    also: dict[Label, Annotated[tuple[Label, ...], OrOne]] = Field(default={})
    """Other phones of labels that are said in two ways, such as whispered vowels."""
    code: Text | None = None
    """The language's code in Whisper, where it is not the first part of the tag."""


class Test(Strict):
    """A text, and the common phonemes expected for it."""

    __test__ = False  # not one of pytest's

    text: Text
    """The text to convert."""
    phonemes: tuple[Common, ...] = Field(min_length=1)
    """The expected common phonemes."""
    ipa: str = ""
    """The segments given by the source, in IPA, separated by spaces."""
    read: tuple[Common, ...] = ()
    """The common phonemes that the pack's engine gives, where they differ from the source's."""
    source: str = ""
    """The source of the transcription."""

    def accepts(
        self, said: Sequence[str], shades: Mapping[str, Shade], *, read: bool = False
    ) -> bool:
        """Return True for the phonemes of the source, or with `read` for those of the engine.

        A shade passes where its parent is expected: a voice and its source may differ by a shade.
        """
        expected = (self.read if read else ()) or self.phonemes
        # sources transcribe phonemes, and shades are finer than those
        coarse = (shades[name].like if name in shades else name for name in said)
        accepted = zip(expected, said, coarse, strict=False)
        return len(said) == len(expected) and all(one in (name, up) for one, name, up in accepted)


class StatedInventory(Strict):
    """The phonemes of the language according to a published source."""

    source: Text
    """The publication."""
    segments: tuple[Label, ...] = Field(min_length=1)
    """Every segment, in IPA."""
    spelled: dict[Label, Label] = Field(default={})
    """Spellings of segments in the pack's tests, if they differ from the source's."""
    absent: dict[Label, Text] = Field(default={})
    """Segments that the pack does not map, and why."""


class Language(PackModel):
    """A language: its notations, mapped to the common phonemes, and its engines."""

    kind: Literal["language"]
    """The kind of pack."""
    tag: Annotated[str, Field(pattern=TAG_PATTERN)]
    """The language's BCP 47 tag."""
    aliases: tuple[Annotated[str, Field(pattern=ALIAS_PATTERN, max_length=60)], ...] = ()
    """Other tags and names of the language, such as its name in its own writing. The likeliest name
    of a column comes first."""
    adds: Annotated[dict[Common, Phoneme | None], OrNames] = Field(default={})
    """Phonemes beyond the base: names of common ones, or new ones in full."""
    extends: Parent | None = None
    """The parent language; this pack states only the differences. Its own name means the pack that
    it shadows; ENGINE:CODE means a language without a pack."""
    g2p: G2P | None = None
    """The conversion of text to phonemes."""
    tts: TTS | None = None
    """The voice that speaks text."""
    audio: AudioFields | None = None
    """The conversion of recordings to phonemes."""
    motion: Annotated[MotionFields, OrPreset] = MotionFields()
    """Differences from the pose set's motion; a preset's name alone is short for it."""
    durations: dict[SoundClass, Annotated[float, Field(gt=0, le=5)]] = Field(default={})
    """Seconds by class, if no voice gives timings."""
    silence: tuple[str, ...] = ()
    """Labels of silence, beyond those of the common pack."""
    notations: dict[Text, dict[Label, Annotated[Sounds, OrUsual]]] = Field(default={})
    """For each notation, the common phonemes of each label. A label without any has its `usual`
    mapping in the common pack."""
    stress_digits: tuple[Text, ...] = ()
    """Notations whose labels may end in a digit of stress: 0 none, 1 primary, 2 secondary."""
    words: WordTable = Field(default={})
    """Readings of words, which override the engine: a list of common phonemes, another spelling, or
    a mapping. A word that is respelled or in IPA takes the `endings` of `text`, too."""
    text: LanguageText | None = None
    """Written forms that the engine would misread: interjections, abbreviations, numerals."""
    asides: tuple[Text, ...] = ()
    """Words of notes such as `(laughs)` and `*sighs*`, which are not spoken; `laugh...` stands for
    all words that begin so."""
    gesture_words: GestureWords = GestureWords()
    """Words that ask, deny or agree, at which pose sets place gestures."""
    examples: dict[Label, str] = Field(default={})
    """A word for each label of the first notation."""
    reasons: dict[Label, str] = Field(default={})
    """The reason for a mapping that is not obvious, by label."""
    automatic: bool = False
    """If true, unmapped IPA goes to the nearest common phonemes by its features."""
    inventory: StatedInventory | None = None
    """The phonemes of the language; the pack maps each or lists it as absent."""
    caveats: tuple[str, ...] = ()
    """Known mistakes of the pack."""
    weak: Text | None = None
    """If its text is often read wrongly: why, and what helps. Said once wherever text is read."""
    tests: tuple[Test, ...] = ()
    """Texts with their expected phonemes."""

    @property
    def g2p_notation(self) -> str:
        """The notation that the pack's engine writes; empty for a pack without notations."""
        stated = self.g2p.notation if self.g2p else None
        return stated or next(iter(self.notations), "")
