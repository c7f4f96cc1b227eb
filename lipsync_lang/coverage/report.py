"""What coverage tells, as a document: the models say its form, and make its JSON Schema.

Counts are of bigrams as they occur. Bigrams with silence are counted apart, and no percentage
elsewhere includes them. Percentages are of 100.
"""

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

FORMAT: Literal["lipsync-lang coverage 1"] = "lipsync-lang coverage 1"
"""The form's name and version; a key that is added at the end does not change it."""

AUTHORED = frozenset(("edited", "approved"))
BORROWED = "like"


class Fact(BaseModel):
    """A part of the document."""

    model_config = ConfigDict(frozen=True, use_attribute_docstrings=True)


class Tally(Fact):
    """Something that was met, how often, and where first."""

    what: str
    count: int
    place: str
    """`file:line`"""


class OtherScript(Tally):
    """A word in a script that the language is not written in."""

    script: str
    """By the first word of its letters' names in Unicode."""
    counted: bool
    """Whether it is read as a word. What would be spelled by its letters is not counted."""


class Corpus(Fact):
    """What was read."""

    files: tuple[str, ...]
    lines: int
    words: int
    dropped: tuple[Tally, ...] = ()
    """Markup and placeholders that are not spoken, most frequent first."""


class BigramNeed(Fact):
    """A bigram that the corpus needs."""

    bigram: str
    count: int
    percent: float
    running: float
    """Percent that this and all more frequent ones make up."""
    layer: str
    """Where it comes from: character, language, shared, like, draft or gap."""
    status: str
    """drafted, edited or approved; empty for a gap."""
    example: str
    """A word that has it, or nothing."""
    places: tuple[str, ...]
    """The first lines that have it."""

    @property
    def authored(self) -> bool:
        """Whether somebody drew it, for this very pair."""
        return authored(self.layer, self.status)


class Authored(Fact):
    """What is authored of what the corpus needs."""

    bigrams: int
    percent: float


class Left(Fact):
    """What is left to author."""

    bigrams: int
    hours: float


class NextHour(Fact):
    """What another hour buys."""

    bigrams: tuple[str, ...]
    percent: float


class Sentence(Fact):
    """A line to try bigrams with."""

    place: str
    text: str
    bigrams: tuple[str, ...]
    """Those that no sentence before it has."""


class CoverageReport(Fact):
    """A corpus in one language on one character."""

    language: str
    language_title: str
    character: str
    poseset: str
    lines: int
    words: int
    phonemes: dict[str, int]
    """How often each common phoneme occurs, all of the language's."""
    occurrences: int
    """Of bigrams, silence apart."""
    bigrams: tuple[BigramNeed, ...]
    """Those that occur, most frequent first."""
    silence: tuple[BigramNeed, ...]
    """Those into and out of silence; their percentages are of each other."""
    unused: tuple[str, ...]
    """Bigrams of the language that never occur."""
    needed: dict[str, int]
    """How many bigrams cover 90, 95, 99 and 100 percent of all occurrences."""
    authored: Authored
    left: Left
    next_hour: NextHour
    sentences: tuple[Sentence, ...]
    """A short list of lines that have every bigram that is not authored."""
    unread: tuple[Tally, ...]
    """Words, or characters, that nothing could read."""
    unmapped: tuple[Tally, ...]
    """Labels that the language does not map."""
    other_scripts: tuple[OtherScript, ...] = ()
    """Words in scripts that the language is not written in."""
    column: str = ""
    """The column that was read, where the language has several."""

    @property
    def label(self) -> str:
        """The language, with what tells it from other reports of it."""
        return labelled(self.language, self.column)


class Shared(Fact):
    """What a language adds to the phonemes that all languages share."""

    language: str
    phonemes: tuple[str, ...]
    bigrams: int
    """Those with one of these phonemes."""
    used: int = 0
    """How many of them the corpus needs."""


class ReportChange(Fact):
    """What changed of one report since an older document."""

    language: str
    character: str
    percent: tuple[float, float]
    """Authored, before and now."""
    left: tuple[int, int]
    """Bigrams to author, before and now."""
    authored: tuple[str, ...]
    """Bigrams authored since."""
    lost: tuple[str, ...]
    """Bigrams that were authored and are no longer."""
    new: tuple[str, ...]
    """Bigrams that the corpus did not need before."""
    gone: tuple[str, ...]
    """Bigrams that it needs no longer."""
    column: str = ""
    """As in the report."""

    @property
    def label(self) -> str:
        """The language, with what tells it from other reports of it."""
        return labelled(self.language, self.column)


class Since(Fact):
    """What changed since an older document."""

    file: str
    reports: tuple[ReportChange, ...]
    unmatched: tuple[str, ...]
    """Language and character of reports that only one of the two documents has."""


class Coverage(Fact):
    """A corpus in some languages on some characters."""

    format: Literal["lipsync-lang coverage 1"] = FORMAT
    corpus: Corpus
    minutes: float
    """Minutes it takes to author a bigram."""
    reports: tuple[CoverageReport, ...]
    shared: tuple[Shared, ...]
    since: Since | None = None
    """Only where the document is compared with an older one."""

    def to_dict(self) -> dict[str, Any]:
        """Return the document as JSON holds it."""
        data = self.model_dump(mode="json", exclude={"since"} if self.since is None else None)
        if self.minutes.is_integer():
            data["minutes"] = int(self.minutes)
        return data


def labelled(language: str, column: str) -> str:
    """Name a language, and of several of its columns which."""
    return f"{language} ({column})" if column else language


def authored(layer: str, status: str) -> bool:
    """Tell whether somebody drew a bigram: neither a draft nor what is borrowed counts."""
    return status in AUTHORED and layer != BORROWED


def schema() -> dict[str, Any]:
    """Return the JSON Schema of the document."""
    made = Coverage.model_json_schema(mode="serialization")
    made["required"] = [name for name in made["properties"] if name != "since"]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **made}
