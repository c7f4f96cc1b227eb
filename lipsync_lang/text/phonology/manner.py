"""The engines and voices of a language, taken from its pack as plain data."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from lipsync_lang.text.phonology.g2p.g2p_engines import Correction, Rule, Settings
from lipsync_lang.text.phonology.g2p.spoken_forms import SpokenForms


@dataclass(frozen=True)
class Hearing:
    """The aligners and the recogniser for recordings of a language: `audio` of its pack.

    `notation` is empty for that of the G2P. Labels without `phones` go by their sound, and
    those in `also` may have other ones. `code` is the language's in Whisper, or its tag.
    """

    align: tuple[str, ...] = ("pocketsphinx", "warp")
    recognise: str | None = None
    model: str | None = None
    notation: str = ""
    phones: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    also: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    code: str = ""


@dataclass(frozen=True)
class Manner:
    """Settings for reading and speaking a language's text: fields of its pack as plain data.

    `engine` is the G2P engine, and `voice` a speech engine with its voice; None where it has none.
    `kinds` has the class of each common phoneme. `words` are spelled plainly. `letters` are
    spellings that the engine reads in place of others.
    """

    language: str
    engine: str | None = None
    settings: Settings = field(default_factory=lambda: Settings(""))
    notation: str = ""
    voice: tuple[str, str] | None = None
    others: Mapping[str, str] = field(default_factory=dict)
    kinds: Mapping[str, str] = field(default_factory=dict)
    durations: Mapping[str, float] = field(default_factory=dict)
    words: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    audio: Hearing = field(default_factory=Hearing)
    stress_digits: tuple[str, ...] = ()
    forms: SpokenForms = field(default_factory=SpokenForms)
    asides: tuple[str, ...] = ()
    letters: Mapping[str, str] = field(default_factory=dict)
    weak: str = ""

    @property
    def direct(self) -> bool:
        """True if the voice also reads the text, so that nothing must be joined."""
        if self.engine is None or self.voice is None:
            return self.voice is not None
        apart = self.settings.respell or self.settings.corrections
        return (self.engine, self.settings.voice) == self.voice and not apart

    def plain(self) -> dict[str, Any]:
        """Return the settings as JSON data."""
        settings = vars(self.settings) | {
            "file": str(self.settings.file) if self.settings.file else None,
            "labels": list(self.settings.labels),
        }
        # not by `asdict`, which would copy the thousands of written forms one by one
        inner = {"settings": settings, "audio": {**vars(self.audio)}, "forms": {**vars(self.forms)}}
        return {**vars(self), **inner}

    @classmethod
    def from_plain(cls, data: Mapping[str, Any]) -> Self:
        """Make the settings from the result of `plain`."""
        settings = dict(data["settings"])
        for key in ("rules", "readings", "foreign"):
            rules = settings[key]
            settings[key] = tuple(Rule(text, tuple(to), *around) for text, to, *around in rules)
        settings["corrections"] = tuple(
            Correction(tuple(labels), tuple(to), *contexts)
            for labels, to, *contexts in settings["corrections"]
        )
        settings["file"] = Path(settings["file"]) if settings["file"] else None
        settings["labels"] = tuple(settings["labels"])
        settings["whole"] = tuple((word, say) for word, say in settings["whole"])
        audio = {**data["audio"]}
        audio |= {
            field: {label: tuple(names) for label, names in audio[field].items()}
            for field in ("phones", "also")
        }
        return cls(
            **{
                **data,
                "settings": Settings(**settings),
                "voice": tuple(data["voice"]) if data["voice"] else None,
                "words": {word: tuple(sounds) for word, sounds in data["words"].items()},
                "audio": Hearing(**{**audio, "align": tuple(audio["align"])}),
                "stress_digits": tuple(data["stress_digits"]),
                "forms": SpokenForms.from_plain(data["forms"]),
                "asides": tuple(data["asides"]),
            }
        )
