"""What resolving gives: tables and names as plain data, and a report of where they came from."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from lipsync_lang.phonology.labels import Value
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.tables import Tables

LAYERS = ("character", "language", "shared", "like", "draft", "gap")
"""Where a bigram can come from, in the order of looking."""

Pair = tuple[str, str]


class Origin(NamedTuple):
    """Where a bigram's curves came from."""

    pair: Pair
    layer: str
    status: str
    """drafted, edited or approved; a draft is never called authored."""
    places: tuple[str, ...]
    """file:line:column of the bigram, or of the two targets it was drafted from."""
    word: str | None = None


@dataclass(frozen=True)
class Report:
    """What a language-character pair has, and what it lacks."""

    language: str
    character: str
    poseset: str
    phonemes: tuple[str, ...]
    """Common phonemes of the language, silence aside."""
    added: tuple[str, ...]
    """Those beyond the base."""
    layers: dict[str, dict[str, int]]
    """Bigrams by layer, then status; silence aside."""
    silence_layers: dict[str, dict[str, int]]
    """Bigrams into and out of silence, likewise."""
    shared: int
    """Bigrams over the base phonemes, which every language has."""
    extra: int
    """Bigrams that only this language's own phonemes need."""
    gaps: tuple[str, ...]
    """Bigrams that nothing answers."""
    automatic: bool = False
    """Whether labels that no notation maps go to the nearest common phonemes by features."""
    warnings: tuple[str, ...] = ()
    styles: dict[str, dict[str, int]] = field(default_factory=dict)
    """Bigrams of each style by status, silence included; all others are neutral's."""

    def __str__(self) -> str:
        total = self.shared + self.extra
        counted = f"{self.shared} shared"
        if self.added:
            counted += f", {self.extra} added by {', '.join(self.added)}"
        lines = [
            f"{self.language} on {self.character} (pose set {self.poseset})",
            f"{len(self.phonemes)} common phonemes: {' '.join(self.phonemes)}",
            f"{total} bigrams: {counted}",
            *_layer_lines(self.layers),
            f"{sum(sum(s.values()) for s in self.silence_layers.values())} more with silence",
            *_layer_lines(self.silence_layers),
        ]
        if self.automatic:
            lines.insert(1, "automatic: IPA that no pack maps goes to the nearest by features")
        for style, statuses in self.styles.items():
            told = ", ".join(f"{number} {status}" for status, number in statuses.items())
            lines.append(f"style {style}: {told}; the rest is neutral")
        if self.gaps:
            lines.append(f"gaps: {', '.join(self.gaps)}")
        return "\n".join([*lines, *self.warnings])


def _layer_lines(layers: dict[str, dict[str, int]]) -> list[str]:
    return [
        f"  {layer:<10}{sum(statuses.values()):>5}  "
        + ", ".join(f"{count} {status or 'unanswered'}" for status, count in statuses.items())
        for layer, statuses in layers.items()
    ]


@dataclass(frozen=True, eq=False)
class Compiled:
    """Everything a performer needs, as plain data and arrays; this is what the cache keeps."""

    language: str
    character: str
    poseset: str
    poses: tuple[str, ...]
    phonemes: tuple[str, ...]
    """Common phonemes, silence first; their index is their number in the tables."""
    notations: dict[str, dict[str, Value]]
    visemes: dict[str, dict[str, Value]]
    """Notations of mouth shapes, which labels are never guessed to be in."""
    spelling: dict[str, Any]
    """How the language's IPA is `spelled` in other signs, and marks of it that are `unseen`."""
    silences: tuple[str, ...]
    words: dict[str, tuple[str, ...]]
    word_edits: dict[str, dict[str, Any]]
    """The character's own curves of whole words: control points by word, then pose."""
    line_edits: dict[str, list[dict[str, Any]]]
    """By line, edits with `word`, `phoneme` and `curves`."""
    origins: tuple[Origin, ...]
    """One for each table row; that of row 0, rest, is empty."""
    contact_names: tuple[str, ...]
    style_origins: dict[str, dict[str, Origin]]
    """For each style, in the order of the tables, where the rows come from that it changes."""
    regions: dict[str, list[int]]
    """The numbers of the poses of each region."""
    intensity: dict[str, Any] | None
    """What loudness moves: `regions`, `least` and `most`; None where nothing is stated."""
    delivery: dict[str, Any]
    """How the character speaks: points of `styles` and `dials`, by name."""
    line_deliveries: dict[str, dict[str, Any]]
    """Likewise for each line that has a manner of its own."""
    tables: Tables
    motion: Motion
    measures: dict[str, dict[str, float]]
    checks: dict[str, Any]
    """What a finished animation is held against: stated limits by name, and `rules`."""
    report: Report
    nearest: dict[str, Any] | None
    """Where unmapped IPA goes to the nearest common phonemes: the features of the IPA and what
    each phoneme names, as JSON holds them."""
    manner: dict[str, Any]
    """How the language's text is read and spoken: a `Manner`, as JSON holds it."""
    rig: dict[str, Any] | None
    """What drives the character's model: channels and what each is, as JSON holds them."""
    pose_names: dict[str, list[str]]
    """How models spell each pose otherwise."""
    neutral: str | None
    """What the face at rest is called."""
    model: str | None
    """The model file, in full."""

    def __repr__(self) -> str:
        return f"<Compiled {self.language} on {self.character}>"
