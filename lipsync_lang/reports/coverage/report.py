"""The coverage document: models of its parts, and the JSON Schema made of them.

Counts are occurrences of bigrams. Bigrams with silence are counted separately, and other
percentages do not include them. Percentages are from 0 to 100.
"""

from typing import Any, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict

AUTHORED = frozenset(("edited", "approved"))
FITTED_STATUS = "fitted"
BORROWED_LAYER = "like"
UNSTATED = frozenset((BORROWED_LAYER, "draft", "gap"))
"""Layers of bigrams that no bank states: once a bank does, its own are played."""

COVERAGE_FORMAT: Literal["lipsync-lang coverage 1"] = "lipsync-lang coverage 1"
"""The form's name and version; a key that is added at the end does not change it."""


class Fact(BaseModel):
    """A part of the document."""

    model_config = ConfigDict(frozen=True, use_attribute_docstrings=True)


class AuthoredShare(Fact):
    """The needed bigrams that are authored."""

    bigrams: int
    percent: float


class WorkLeft(Fact):
    """The needed bigrams that are left to author."""

    bigrams: int
    hours: float


class NextHour(Fact):
    """The bigrams to author in the next hour."""

    bigrams: tuple[str, ...]
    percent: float


def authored(layer: str, status: str) -> bool:
    """Return True if a person drew a bigram; drafts and borrowed curves do not count."""
    return status in AUTHORED and layer != BORROWED_LAYER


class Tally(Fact):
    """A name in the corpus, with its count and first place."""

    what: str
    count: int
    place: str
    """`file:line`"""


class OtherScript(Tally):
    """A word in a script that the language is not written in."""

    script: str
    """First word of its letters' Unicode names."""
    counted: bool
    """True if a voice reads the word; spelled words are not counted."""


class EntryWord(Tally):
    """A word that deserves an entry in the pack of its language."""

    why: Literal["letters", "name", "engines"]
    """A letter that the pack's texts do not have, a capital within a sentence, or two engines that
    read the word differently."""


class ScriptLines(Fact):
    """Digests of the spoken lines of one reading, in its order."""

    languages: tuple[str, ...]
    """Languages that the lines were read in."""
    column: str = ""
    """The column that was read; empty unless it was stated."""
    named: dict[str, str]
    """Digests by the line's own name."""
    unnamed: dict[str, str]
    """Digests by place, for lines without a name of their own."""


class ScriptChange(Fact):
    """Changes of a script's lines since an older document."""

    languages: tuple[str, ...]
    """Languages in which the same lines changed."""
    lines: tuple[int, int]
    """Number of lines, before and now."""
    added: tuple[str, ...]
    """Names, or places, of new lines."""
    removed: tuple[str, ...]
    """Names, or former places, of removed lines."""
    changed: tuple[str, ...]
    """Names of lines with another text or speaker."""


class Corpus(Fact):
    """The lines that were read."""

    files: tuple[str, ...]
    lines: int
    words: int
    dropped: tuple[Tally, ...] = ()
    """Markup and placeholders that are not spoken, most frequent first."""
    other_speakers: tuple[Tally, ...] = ()
    """Speakers without a character of their own, whose lines the default character speaks."""
    script: tuple[ScriptLines, ...] = ()
    """Digests of the lines, which a later document is compared with."""
    heard: int = 0
    """Lines that are recordings without a text: their phonemes are heard, and some are wrong."""


class BigramNeed(Fact):
    """A bigram that the corpus needs."""

    bigram: str
    count: int
    percent: float
    running: float
    """Percentage of all occurrences of this and all more frequent bigrams."""
    layer: str
    """Source of its curves: character, language, shared, like, draft or gap."""
    status: str
    """drafted, fitted, edited or approved; empty for a gap."""
    example: str
    """A word with this bigram; empty if there is none."""
    places: tuple[str, ...]
    """The first lines with this bigram."""
    in_trigrams: int = 0
    """Occurrences that an authored trigram plays in place of the bigram."""
    stated: str = ""
    """Place of the bigram in a bank or a character, `file:line:column`; empty in none."""

    @property
    def authored(self) -> bool:
        """True if a person drew this very pair, or trigrams that play wherever it occurs."""
        return self.covered >= self.count

    @property
    def covered(self) -> int:
        """Occurrences for which a person drew curves."""
        return self.count if authored(self.layer, self.status) else self.in_trigrams


class TrigramNeed(Fact):
    """A drawn trigram, with its number of occurrences."""

    trigram: str
    count: int
    layer: str
    """Source of its curves: character, language or shared."""
    status: str
    """drafted, edited or approved."""
    places: tuple[str, ...]
    """The first lines with this trigram."""


class GestureNeed(Fact):
    """A gesture that comes by rule in the lines."""

    gesture: str
    count: int
    a_minute: float
    """Times a minute of the lines, at their own times or estimated ones."""
    facts: dict[str, int]
    """Number of them by the fact that drew them, such as `stress`."""


class Sentence(Fact):
    """A line with bigrams that are not authored."""

    place: str
    text: str
    bigrams: tuple[str, ...]
    """Bigrams that no sentence before has."""


class CoverageReport(Fact):
    """A corpus in one language on one character."""

    language: str
    language_title: str
    character: str
    poseset: str
    lines: int
    words: int
    phonemes: dict[str, int]
    """Occurrences of each common phoneme of the language."""
    occurrences: int
    """Occurrences of bigrams without silence."""
    bigrams: tuple[BigramNeed, ...]
    """Bigrams that occur, most frequent first."""
    silence: tuple[BigramNeed, ...]
    """Bigrams into and out of silence; percentages are of these alone."""
    unused: tuple[str, ...]
    """Bigrams of the language that never occur."""
    needed: dict[str, int]
    """Number of bigrams that cover 90, 95, 99 and 100 percent of all occurrences."""
    authored: AuthoredShare
    left: WorkLeft
    next_hour: NextHour
    sentences: tuple[Sentence, ...]
    """A short list of lines that have every bigram that is not authored."""
    unread: tuple[Tally, ...]
    """Words, or characters, that could not be read."""
    unmapped: tuple[Tally, ...]
    """Labels that the language does not map."""
    other_scripts: tuple[OtherScript, ...] = ()
    """Words in scripts that the language is not written in."""
    column: str = ""
    """The column that was read; empty unless the language has several."""
    trigrams: tuple[TrigramNeed, ...] = ()
    """Drawn trigrams, most frequent first; unused ones have a count of 0."""
    entries: tuple[EntryWord, ...] = ()
    """Words that the language may misread, and that have no entry in its `words`."""
    gestures: tuple[GestureNeed, ...] = ()
    """Gestures that were asked for, in the order of the pose set."""

    @property
    def label(self) -> str:
        """The language, with its column if there is one."""
        return labelled(self.language, self.column)


class LanguageAddition(Fact):
    """Phonemes and bigrams that a language adds to those that all languages share."""

    language: str
    phonemes: tuple[str, ...]
    bigrams: int
    """Number of bigrams with one of these phonemes."""
    used: int = 0
    """Number of these bigrams that the corpus needs."""


class ReportChange(Fact):
    """Changes of one report since an older document."""

    language: str
    character: str
    percent: tuple[float, float]
    """Authored share, before and now."""
    left: tuple[int, int]
    """Number of bigrams to author, before and now."""
    authored: tuple[str, ...]
    """Bigrams authored since."""
    lost: tuple[str, ...]
    """Bigrams that are no longer authored."""
    new: tuple[str, ...]
    """Bigrams that the corpus did not need before."""
    gone: tuple[str, ...]
    """Bigrams that the corpus no longer needs."""
    column: str = ""
    """As in the report."""

    @property
    def label(self) -> str:
        """The language, with its column if there is one."""
        return labelled(self.language, self.column)


class CoverageChanges(Fact):
    """Changes since an older document."""

    file: str
    reports: tuple[ReportChange, ...]
    unmatched: tuple[str, ...]
    """Language and character of reports in only one of the two documents."""
    script: tuple[ScriptChange, ...] = ()
    """Lines that changed; empty if the older document has no digests."""
    left: tuple[WorkLeft, WorkLeft] | None = None
    """Work of all reports together, before and now."""


class WorkKey(NamedTuple):
    """Identity of a work item."""

    bigram: str
    poseset: str
    bank: str


class WorkItem(Fact):
    """A bigram to author, once for all languages and faces that it serves."""

    bigram: str
    poseset: str
    bank: str
    """The language or character with a draft of it in its own bank; empty for the shared bank."""
    count: int
    """Occurrences in all reports that nobody has drawn."""
    percent: float
    """Gain in authored speech in percentage points, averaged over the languages."""
    reaches: float
    """Authored percentage after this and all items before it are drawn."""
    languages: tuple[str, ...]
    """Languages that it serves."""
    characters: tuple[str, ...]
    """Characters that it serves."""

    @property
    def piece(self) -> WorkKey:
        """Its identity among all work."""
        return WorkKey(self.bigram, self.poseset, self.bank)


class TotalFigures(Fact):
    """Figures over several languages; shared work counts once."""

    languages: tuple[str, ...]
    needed: int
    """Different bigrams that the languages need."""
    authored: AuthoredShare
    left: WorkLeft
    next_hour: NextHour


class FaceTotal(TotalFigures):
    """The total of all languages on one character."""

    character: str
    poseset: str


class Total(TotalFigures):
    """The total of all languages on all characters."""

    weights: dict[str, float]
    """Weight of each language in percentages."""
    faces: tuple[FaceTotal, ...]
    ranking: tuple[WorkItem, ...] = ()
    """The bigrams that are left, largest gain first."""


class Coverage(Fact):
    """A corpus in some languages on some characters."""

    format: Literal["lipsync-lang coverage 1"] = COVERAGE_FORMAT
    corpus: Corpus
    minutes: float
    """Minutes it takes to author a bigram."""
    reports: tuple[CoverageReport, ...]
    shared: tuple[LanguageAddition, ...]
    total: Total | None = None
    """All reports together; each piece of work counts once. Null in older documents."""
    since: CoverageChanges | None = None
    """Present if the document is compared with an older one."""

    def to_dict(self) -> dict[str, Any]:
        """Return the document as plain JSON data."""
        data = self.model_dump(mode="json", exclude={"since"} if self.since is None else None)
        # As the user wrote it: 15, and not 15.0.
        if self.minutes.is_integer():
            data["minutes"] = int(self.minutes)
        return data


def labelled(language: str, column: str) -> str:
    """Return the language with its column in brackets, if there is one."""
    return f"{language} ({column})" if column else language


def schema() -> dict[str, Any]:
    """Return the JSON Schema of the document."""
    made = Coverage.model_json_schema(mode="serialization")
    # A document that is compared with none has no such field.
    made["required"] = [name for name in made["properties"] if name != "since"]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **made}
