"""The model of `lipsync.yaml`, which states once what a folder's commands leave out."""

import re
from pathlib import PureWindowsPath
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from lipsync_lang.base.files.names import BRACES, PLACEHOLDER, fault_of_name
from lipsync_lang.packs.models.fields import (
    Name,
    NotNegative,
    OrNames,
    OrOne,
    PackModel,
    Parent,
    Short,
    Strict,
    Text,
)
from lipsync_lang.packs.models.motion_models import MotionFields, OrPreset
from lipsync_lang.packs.models.pose_models import MouthOrigin
from lipsync_lang.packs.yaml.source import Data

_RATE_PATTERN = r"^\d+(\.\d+)?(/\d+)?$"

PLACEHOLDERS = ("id", "line", "language", "character", "speaker")
"""Placeholders of outputs; `line` is `id`."""


def _outside(path: str) -> bool:
    # by the rules of Windows on every system: a project is to be as safe there
    return ".." in re.split(r"[/\\]", path) or bool(PureWindowsPath(path).anchor)


def _within(output: str) -> str:
    """Refuse outputs elsewhere: a stranger's project writes into its own folder alone."""
    # a format has two letters or more, because one is a drive of Windows
    path = re.sub(r"^[a-z0-9-]{2,}:", "", output)
    what = None
    if ":" in path[2:]:
        what = "'{path}' has a ':', which Windows does not allow; write FORMAT:FILE once"
    elif _outside(path):
        what = "'{path}' is outside the project's folder; name it with -o instead"
    elif ":" in path:
        what = "'{path}' has a ':', which Windows does not allow; write FILE or FORMAT:FILE"
    if what is not None:
        raise PydanticCustomError("P106", what, {"path": path})
    return output


def _inside(path: str) -> str:
    """Refuse files elsewhere: a stranger's project reads its own folder alone."""
    if _outside(path):
        what = "'{path}' is outside the project's folder; move it into the folder"
        raise PydanticCustomError("P106", what, {"path": path})
    return path


def _holding(*known: str) -> AfterValidator:
    """Return a check that text holds no placeholders but the known ones."""
    listed = [f"{{{one}}}" for one in known]
    allowed = {*listed, *(BRACES if known else ())}

    def check(text: str) -> str:
        for name in PLACEHOLDER.findall(text):
            if name not in allowed:
                what = "unknown placeholder '{name}'; known: {known}"
                raise PydanticCustomError("P107", what, {"name": name, "known": ", ".join(listed)})
        return text

    return AfterValidator(check)


def _word(text: str) -> str:
    if wrong := fault_of_name(text):
        raise PydanticCustomError("P106", "'{text}' {wrong}", {"text": text, "wrong": wrong})
    return text


def _rate(value: Data) -> Data:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    # a rate is text, because 24000/1001 is exact and 23.976 is not
    return f"{value:g}" if number else value


OrSwitch = Short(
    lambda value: ("all" if value else "none") if isinstance(value, bool) else value,
    forms=lambda full: [full, {"type": "boolean"}],
)
"""Accepts true or false as a choice of all gestures, or none."""

Output = Annotated[Text, AfterValidator(_within), _holding(*PLACEHOLDERS)]
"""A file, or FORMAT:FILE."""

ScriptPath = Annotated[Text, AfterValidator(_inside), _holding("language")]
"""A file with the lines of a game, or a folder of them."""

RecordingPath = Annotated[
    Text, AfterValidator(_inside), _holding("id", "line", "language", "speaker")
]
"""The file of a line's recording, or of its timings."""

SingleWord = Annotated[Text, AfterValidator(_word)]
"""Part of the name of a file."""

ReportFile = Annotated[Text, AfterValidator(_within), _holding()]
"""A file for the report of a build."""


class ScriptColumns(Strict):
    """Columns of the tables of a script, by name or by number from 1."""

    text: Annotated[Text, _holding("language")] | None = None
    """The spoken text. By default the column named like the language, or the only text."""
    id: Text | None = None
    """The line's own name, which names its files. By default the first of `id`, `key` and such."""
    speaker: Text | None = None
    """The speaker. By default the first of `speaker`, `character` and such. In comments of gettext,
    the word before the name, or the form of the comment, such as `[{speaker}]`."""
    sheet: Text | None = None
    """The only sheet of a spreadsheet that is read. By default all that look like a script."""
    header_row: Annotated[int, Field(ge=1)] | None = None
    """Number of the row that names the columns. By default the first, or the one below a title."""


class GlbFields(Strict):
    """Form of the GLB files of a build."""

    face: Literal["each", "once"] = "each"
    """`each` file holds the character's whole model. With `once`, its data are in a file
    `CHARACTER-DIGEST.face.bin` beside the GLB files, which hold the animation and refer to it."""


class TimingRecords(Strict):
    """A list of records in JSON, and the names of their fields."""

    records: str = ""
    """Path of the list, such as `result.words`: lists on the way stand for all their objects, with
    `[0]` for the first alone. Several paths have `|` between them, and the first with records
    counts. By default the outermost objects."""
    text: Text
    """Field with the label of a phoneme, or with a word; or its path, as in
    `alternatives[0].content`. Several have `|` between them, here and below."""
    start: Text
    """Field with the start."""
    end: Text | None = None
    """Field with the end."""
    duration: Text | None = None
    """Field with the duration, instead of `end`."""
    unnamed: bool = False
    """True if a record without a text is silence."""
    untimed: bool = False
    """True if records without times, such as punctuation, are left out."""
    speaker: Text | None = None
    """Field with the speaker of words, in a record or in an object around it; `tier` names one."""
    columns: bool = False
    """True if the path leads to objects whose fields are lists of one length, with an item for each
    record."""

    @model_validator(mode="after")
    def _one_length(self) -> Self:
        if (self.end is None) == (self.duration is None):
            what = "records need `end` or `duration`, and only one of them"
            raise PydanticCustomError("P115", what, {"field": "start"})
        return self


class TimingFormat(Strict):
    """A format of timings in JSON, for `--read-as` and by its content."""

    title: Text | None = None
    """Title in `formats`, of one line."""
    phonemes: TimingRecords | None = None
    """The timed phonemes."""
    words: TimingRecords | None = None
    """The timed words."""
    unit: Literal["s", "ms", "ticks"] = "s"
    """Unit of the times; `ticks` last 100 ns."""
    rate: Annotated[float, Field(gt=0, le=1e9)] | None = None
    """Units of the times in a second, such as frames, instead of `unit`."""
    notation: Text | None = None
    """Notation of the phonemes."""
    mentions: tuple[Text, ...] = ()
    """Fields that tell the format: a file has one. By default the fields of its first record."""

    @model_validator(mode="after")
    def _some_list(self) -> Self:
        if self.phonemes is None and self.words is None:
            what = "the format has no records: give `phonemes`, `words` or both"
            raise PydanticCustomError("P115", what, {"field": "unit"})
        if self.rate is not None and "unit" in self.model_fields_set:
            what = "the format has `unit` and `rate`: give only one of them"
            raise PydanticCustomError("P115", what, {"field": "rate"})
        return self


class ScriptFormat(Strict):
    """A format of scripts in JSON, or in XML if it states `entries`.

    Paths have dots in JSON and slashes in XML, where `@id` is an attribute at the end. Several have
    `|` between them, and the first that leads to a text counts.
    """

    suffix: Annotated[str, Field(pattern=r"^\.[a-z0-9._-]+$")]
    """Suffix of its files, in small letters."""
    title: Text | None = None
    """Title in `formats`, of one line."""
    entries: Text | None = None
    """Names of the elements that are entries. In JSON, every object with a `text` is one."""
    root: Text | None = None
    """Name of the outermost element, if the suffix alone does not tell."""
    each: Text | None = None
    """Path from an element to its parts, each of which has a text."""
    text: Text
    """Path of the text in an entry; `.` is the text of the element itself."""
    id: Text | None = None
    """Path of the identifier. In JSON, the keys on the way to the entry by default."""
    original: Text | None = None
    """Path of the text that `text` translates."""
    speaker: Text | None = None
    """Path of the speaker."""
    note: Text | None = None
    """Path of a note, which may name the speaker, as in `Speaker: Bob`."""
    state: Text | None = None
    """Path of the state of the translation."""
    unready: tuple[Text, ...] = ()
    """States of entries that are left out, because their translation is not done."""

    @model_validator(mode="after")
    def _elements(self) -> Self:
        if self.entries is None and (self.root or self.each):
            what = "`root` and `each` are fields of XML, which states `entries`"
            raise PydanticCustomError("P115", what, {"field": "text"})
        if self.entries is not None and self.id is None:
            raise PydanticCustomError("P115", "`entries` of XML need an `id`", {"field": "entries"})
        return self


class Project(PackModel):
    """Defaults for the commands of a folder; an option of the command line wins."""

    kind: Literal["project"]
    """The kind of file."""
    name: Name = "project"
    """Name of the project."""
    language: Parent | None = None
    """The language of its lines, by name or tag."""
    character: Name | None = None
    """The face that speaks: a character or a pose set."""
    fps: (
        Annotated[
            str,
            Field(pattern=_RATE_PATTERN),
            Short(_rate, forms=lambda full: [full, {"type": "number", "minimum": 1}]),
        ]
        | None
    ) = None
    """Frames per second: a number, or a fraction such as 24000/1001."""
    offset: Annotated[float, Field(ge=0, le=86_400)] | None = None
    """Seconds of every file at which its sound begins. By default 0, or the length of the movement
    before the sound in formats without time below zero."""
    motion: Annotated[MotionFields, OrPreset] | None = None
    """Motion settings over the character's own; a preset's name alone is short for it."""
    shades: bool | None = None
    """False to perform each shade as its parent; unless stated, only the paper's thresholds do."""
    mouth: MouthOrigin | None = None
    """`declared` keeps the targets of the pose sets on every model; a character may state its own.
    By default each pose set says."""
    gestures: Annotated[Text, OrSwitch] | None = None
    """Gestures of every output: `all`, or those to make, such as `blink,accent:0.5`. By default
    pages and videos of `run` have them all, and other files none."""
    idle: Annotated[float, Field(ge=0, le=600)] | None = None
    """Seconds after each line in which the face rests, with the gestures of silence."""
    outputs: Annotated[tuple[Output, ...], OrOne] = ()
    """Outputs of `run` and `build`, from this folder: FILE or FORMAT:FILE.

    `{id}` and `{line}` stand for the line, and `{language}`, `{character}` and `{speaker}` for its
    own.
    """
    glb: GlbFields = GlbFields()
    """Form of the GLB files of `build`."""
    paths: Annotated[tuple[Text, ...], OrOne] = ()
    """Folders of packs to search first, from this folder."""
    lines: Annotated[tuple[ScriptPath, ...], OrOne] = ()
    """The script, from this folder; `{language}` is the language, and `{{` a brace of the name."""
    languages: Annotated[dict[Parent, SingleWord | None], OrNames] = Field(default_factory=dict)
    """The languages that `build` makes, each with what `{language}` stands for: a list of names,
    or a mapping from names. By default `language`."""
    columns: ScriptColumns = ScriptColumns()
    """Columns of tables, where their names do not tell."""
    encoding: Text | None = None
    """Encoding of the script's files, such as cp1252. By default UTF-8, or what a file states."""
    audio: RecordingPath | None = None
    """The recording of a line, such as `vo/{language}/{id}.wav`; lines without one are spoken."""
    recordings: Literal["optional", "required"] = "optional"
    """`required` if a text without a recording or timings is a fault; else a voice speaks it."""
    adapt: bool = False
    """True to adapt the acoustic model of each language to its recordings before aligning them."""
    timings: RecordingPath | None = None
    """The timed phonemes of a line. By default the file beside the recording."""
    timing_formats: dict[Name, TimingFormat] = Field(default_factory=dict)
    """Formats of timings in JSON, by name, which other services write."""
    script_formats: dict[Name, ScriptFormat] = Field(default_factory=dict)
    """Formats of scripts in JSON and XML, by name, which other tools write."""
    cast: dict[Text, Annotated[tuple[Name, ...], OrOne, Field(min_length=1)]] = Field(
        default_factory=dict
    )
    """The characters that each speaker is made on; `*` stands for all other speakers. By default
    `character`."""
    values: dict[Text, str] = Field(default_factory=dict)
    """Texts to say for placeholders such as `[player]`, `{player}` and `$player`, by name."""
    unspoken: Annotated[tuple[Text, ...], OrOne] = ()
    """Passages that are not spoken, such as `NPC_01`, `SFX:...` and `<<...>>`: their text, or their
    two ends with `...` between them. Without a second end, a passage ends with the line."""
    limits: dict[Text, NotNegative] = Field(default_factory=dict)
    """Limits that fail a build: by measure of `check`, and the least `confidence` of alignment."""
    reports: Annotated[tuple[ReportFile, ...], OrOne] = ()
    """Reports of `build`, from this folder: `.html`, `.xml` (JUnit) or `.json`."""
