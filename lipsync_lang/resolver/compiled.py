"""The result of resolving: tables and names as plain data, with a report of their origins."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from lipsync_lang.base.errors import count
from lipsync_lang.base.grouping import grouped
from lipsync_lang.base.presentation.text_templates import filled
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.text.phonology.labels import Value

if TYPE_CHECKING:
    from lipsync_lang.pipeline.tables import Tables

LAYERS = ("character", "language", "shared", "like", "draft", "gap")
"""Origins of a bigram, in order of lookup; `gap` means no origin."""

Pair = tuple[str, str]

Triple = tuple[str, str, str]


class Origin(NamedTuple):
    """The source of the curves of a bigram, or of half a trigram."""

    pair: Pair
    """The two phonemes of the row; of half a trigram, two of its three."""
    layer: str
    status: str
    """Status: drafted, fitted, edited or approved. The first two are never called authored."""
    places: tuple[str, ...]
    """file:line:column of the bigram, or of the two targets of a draft."""
    word: str | None = None
    triple: Triple | None = None
    """The trigram that the row is half of."""

    @property
    def name(self) -> str:
        """The unit that was drawn, such as `l-ow` or `s-d-r`."""
        return "-".join(self.triple or self.pair)

    @property
    def source(self) -> str:
        """The layer and the status."""
        return ", ".join(filter(None, (self.layer, self.status)))


@dataclass(frozen=True)
class Report:
    """Coverage of a language-character pair: its phonemes, layers and gaps."""

    language: str
    character: str
    poseset: str
    phonemes: tuple[str, ...]
    """Common phonemes of the language, without silence."""
    added: tuple[str, ...]
    """Phonemes that the language adds to the base."""
    shades: tuple[str, ...]
    """Finer phonemes with curves of their own; their bigrams count as those of their parents."""
    layers: dict[str, dict[str, int]]
    """Number of bigrams by layer, then status, without silence."""
    silence_layers: dict[str, dict[str, int]]
    """Number of bigrams with silence, by layer, then status."""
    shared: int
    """Number of bigrams over the base phonemes, which every language has."""
    extra: int
    """Number of bigrams with at least one phoneme that the language adds."""
    gaps: tuple[str, ...]
    """Bigrams without curves in any layer."""
    automatic: bool = False
    """True if unmapped labels go to the nearest common phonemes by features."""
    warnings: tuple[str, ...] = ()
    idle: tuple[str, ...] = ()
    """Warnings of mouths of the character that have no effect, and of shapes of its model."""
    styles: dict[str, dict[str, int]] = field(default_factory=dict)
    """Bigrams of each style by status, with silence; all others are neutral's."""
    trigrams: dict[str, str] = field(default_factory=dict)
    """Layer of each trigram that this pair plays."""

    def __str__(self) -> str:
        pairs = (pair.partition("-") for pair in self.gaps)
        facts = {
            **vars(self),
            "silent": sum(sum(one.values()) for one in self.silence_layers.values()),
            "after": grouped((first, second) for first, _, second in pairs),
            "count": count,
        }
        return filled(__package__, "report", facts).removesuffix("\n")


@dataclass(frozen=True, eq=False, repr=False)
class CompiledPair:
    """Plain data and arrays that a performer needs; the cache stores exactly these."""

    language: str
    character: str
    poseset: str
    poses: tuple[str, ...]
    phonemes: tuple[str, ...]
    """Common phonemes, silence first, shades last; the index is a phoneme's number in the tables.

    A shade that nothing tells from its parent has no number of its own.
    """
    shades: dict[str, str]
    """Parent of each possible shade of the language, with or without a number of its own."""
    notations: dict[str, dict[str, Value]]
    visemes: dict[str, dict[str, Value]]
    """Notations of mouth shapes. Guessing the notation of labels never tries these."""
    spelling: dict[str, Any]
    """Other signs for IPA (`spelled`), and marks that are not seen (`unseen`)."""
    silences: tuple[str, ...]
    noises: tuple[str, ...]
    """Silences for noise, or for speech that an aligner could not read."""
    words: dict[str, tuple[str, ...]]
    word_edits: dict[str, dict[str, Any]]
    """The character's own curves of whole words: control points by word, then pose."""
    line_edits: dict[str, list[dict[str, Any]]]
    """By line, edits with `word`, `phoneme` and `curves`."""
    origins: tuple[Origin, ...]
    """Origin of each table row; row 0, rest, has an empty one."""
    contact_names: tuple[str, ...]
    style_origins: dict[str, dict[str, Origin]]
    """Origins of the rows that each style changes, in the order of the tables."""
    style_drafts: dict[str, dict[str, Any]]
    """`scale` and `offset` of each pose, and `place`, for the styles of the pose set.

    They hold for the bigrams that no bank of the style draws.
    `posture` goes on with the poses of postures; `speed` and `softness` scale the motion.
    """
    posture: dict[str, Any]
    """Poses of postures: other names, softness, sums with poses of speech, ceilings by contact."""
    regions: dict[str, list[int]]
    """Pose numbers by region."""
    intensity: dict[str, Any] | None
    """Effect of loudness and stress, as in the pose set; None if no pack states any."""
    delivery: dict[str, Any]
    """Manner of the character: points of `styles` and `dials`, factors of `gestures`, by name."""
    line_deliveries: dict[str, dict[str, Any]]
    """Manner of each line that has its own."""
    tables: "Tables"
    motion: Motion
    gestures: dict[str, Any]
    """`poses` of gestures, each with its channel and limits; `gestures` with their places; and
    `words` of the language by trigger."""
    mirrored: dict[str, list[str]]
    """Pairs of mirrored poses by a name for both."""
    measures: dict[str, dict[str, float]]
    checks: dict[str, Any]
    """Limits of a finished animation by name, `rules`, and, of phonemes, `apertures` at `reach` and
    the widths of `rounded` ones."""
    report: Report
    nearest: dict[str, Any] | None
    """Features of the IPA and names of each phoneme, as JSON; used for unmapped IPA."""
    manner: dict[str, Any]
    """Reading and speaking of the language's text: a `Manner`, as JSON."""
    rig: dict[str, Any] | None
    """Rig of the character's model as JSON: channels, with their targets."""
    pose_names: dict[str, list[str]]
    """Other spellings of each pose in models."""
    neutral: str | None
    """Name of the face at rest."""
    model: str | None
    """Absolute path of the model file."""

    @property
    def style_names(self) -> tuple[str, ...]:
        """Styles by the number of their bank: those of the tables, then those drafted alone."""
        return tuple(dict.fromkeys((*self.style_origins, *self.style_drafts)))

    @property
    def counted(self) -> tuple[str, ...]:
        """Common phonemes without shades, silence first; counts of banks use these."""
        return tuple(name for name in self.phonemes if name not in self.shades)

    def numbers(self, *, shades: bool) -> dict[str, int]:
        """Return the number of every phoneme in the tables.

        Shades without curves of their own have the number of their parent; all have it where
        `shades` is False. Nothing else folds shades to their parents.
        """
        names = self.phonemes if shades else self.counted
        own = {name: number for number, name in enumerate(names)}
        return {name: own[parent] for name, parent in self.shades.items()} | own

    def __repr__(self) -> str:
        return f"<CompiledPair {self.language} on {self.character}>"
