"""A project for a table, or for a table and its recordings, drafted from their common names.

The column of ids is the one whose cells name the most recordings; without recordings, the name of
the column tells. Folders that are called like languages or speakers become placeholders.
"""

import json
import os
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from lipsync_lang.base.errors import MAX_KNOWN, LipsyncError, count, shortlist
from lipsync_lang.base.files.names import folded_name
from lipsync_lang.packs.automatic import coded_language
from lipsync_lang.packs.finding import Finder, Kind
from lipsync_lang.packs.language_files import languages_of_files
from lipsync_lang.production.builds.project_folder import from_template, starter
from lipsync_lang.sound.speech.sound import AUDIO_SUFFIXES
from lipsync_lang.text.lines.columns import (
    NAME_COLUMNS,
    SPEAKER_COLUMNS,
    first_column,
    language_column,
    language_parts,
    stated_column,
    text_column,
)
from lipsync_lang.text.lines.line_readers import (
    AS_FOUND,
    LineFile,
    TableLayout,
    by_suffix,
    is_timed,
    line_files,
    read_lines,
)
from lipsync_lang.text.lines.markup import spoken
from lipsync_lang.text.lines.table import cell

FACE_KINDS: tuple[Kind, ...] = ("character", "poseset")

COMPARED_STEMS = 40
"""Maximum number of recordings to search for ids within their names."""

MAX_COMPARED = 5_000
"""Maximum number of cells of a column to search for."""

MAX_SHOWN_CHARS = 60
"""Maximum length of a column's cells in a message."""

MAX_TABLE_ROWS = 100_000
"""Maximum number of rows of the table to compare with the recordings."""

SURE_RATIO = 3
"""Smallest ratio of the letters of a text column, which is a guess, to those of the next."""

LEAST_SHARE = 0.3
"""Minimum share of the recordings that the column of ids names."""

SHOWN_FILES = 4
"""Maximum number of examples of each kind in a message."""

SHOWN_SPEAKERS = 20


class FoundRecording(NamedTuple):
    """A recording below the project's folder."""

    folders: tuple[str, ...]
    stem: str


class Cells(NamedTuple):
    """A table by its columns, or the names and speakers of a script of another format."""

    head: list[str]
    columns: list[list[str]]
    table: bool = True
    """False for a script that names its lines itself, so that a project states no columns."""
    bilingual: bool = False
    """True if the script has translations beside their originals."""
    languages: tuple[str | None, ...] = ()
    """Languages that files of a folder are named after; None for files that are not."""

    def at(self, column: int) -> list[str]:
        """Return the cells of a column that are not empty; none for the column -1."""
        return [one for one in self.columns[column] if one] if column >= 0 else []


class IdColumn(NamedTuple):
    """Column that names recordings, and the parts of their names around it."""

    column: int
    before: str = ""
    after: str = ""

    def stem(self, name: str) -> str:
        """Return the folded name of a line's recording."""
        return folded_name(f"{self.before}{name}{self.after}")


class NewProject(NamedTuple):
    """A drafted project."""

    text: str
    """Text of `lipsync.yaml`, with comments."""
    matches: tuple[str, ...]
    """Counts of the recordings and lines that belong together, with examples."""


def new_project(  # noqa: PLR0913 the parts of a draft
    recordings: Path | None,
    table: Path,
    *,
    folder: Path,
    finder: Finder,
    language: str | None = None,
    characters: Sequence[str] = (),
    column: str | None = None,
    encoding: str | None = None,
    layout: TableLayout = AS_FOUND,
) -> NewProject:
    """Draft the project of a table, and of a folder of recordings if there is one.

    Raises LipsyncError if the two have nothing in common, a language or character is not known, or
    several columns may be the text.

    Parameters
    ----------
    recordings : folder of recordings, with folders for languages or speakers; None for none yet
    table : the script, a row for each line
    folder : the project's folder, which holds both
    language : of the recordings; None if folders or columns tell; without recordings, all columns
        that are named after languages, or else the language of new projects
    column : of the text, by name or number from 1; None for the columns of languages, or else the
        likeliest
    encoding : of the script; None for UTF-8, or what the file's own mark says
    layout : the sheet and the row that names the columns, if the table does not tell
    """
    for path in (recordings, table):
        if path is not None and not path.resolve().is_relative_to(folder.resolve()):
            what = "move both into it, or start in the folder of both"
            raise LipsyncError(f"{path}: is outside of {folder}, the project's folder; {what}")
    found, suffix = recordings_below(recordings, folder) if recordings else ([], "")
    cells = read_cells(table, finder, encoding, layout)
    stated = -1
    if column is not None:
        stated = stated_column(LineFile(table, lambda _: None), cells.head, column)
    ids = find_ids(found, cells, recordings, table) if recordings else _named_ids(cells, table)
    speaker = first_column(cells.head, SPEAKER_COLUMNS, [ids.column, stated])
    named = {ids.stem(name) for name in cells.at(ids.column)}
    matching = [one for one in found if folded_name(one.stem) in named]
    taken = {ids.column, speaker}
    if matching:
        pattern, words = _folders(matching, cells.at(speaker), finder)
    else:
        usual = starter().language
        pattern, words = [], _headed(cells, taken, finder) or {usual: usual}
    languages = _languages(cells, taken, words, finder, language)
    text: dict[str, str] = {"text": cells.head[stated]}
    remarks: list[str] = []
    if stated < 0:
        text, remarks = _text(cells, taken, languages, finder, table)
    for name in characters:
        if not any(finder.lookup(kind, name) for kind in FACE_KINDS):
            raise finder.unknown(name, *FACE_KINDS)
    if not characters:
        known = sorted({one.name for kind in FACE_KINDS for one in finder.names(kind)})
        raise LipsyncError(f"the character is missing; name one of: {shortlist(known, MAX_KNOWN)}")
    columns = {"id": cells.head[ids.column], **text}
    columns |= {"speaker": cells.head[speaker]} if speaker >= 0 else {}
    begins = {name: value for name, value in layout._asdict().items() if value is not None}
    spoken = Counter(cells.at(speaker)).most_common(SHOWN_SPEAKERS)
    several = "{language}/" if len(languages) > 1 else ""
    same = all(name == word for name, word in languages.items())
    file = f"{_doubled(ids.before)}{{id}}{_doubled(ids.after)}{suffix}"
    drafted: dict[str, Any] = {
        "lines": _doubled(table.resolve().relative_to(folder.resolve()).as_posix()),
        "columns": columns | begins if cells.table else {},
        "encoding": encoding,
        "languages": list(languages) if same else languages,
        "audio": "/".join([*pattern, file]) if found else None,
        "usual_audio": f"vo/{several}{{id}}.wav",
        "characters": list(characters),
        "speakers": [json.dumps(name, ensure_ascii=False) for name, _ in spoken],
        "outputs": f"takes/{several}{{character}}/{{id}}.csv",
    }
    matches = _matches(found, cells.at(ids.column), ids, matching)
    if cells.bilingual:
        remarks += [_side(table, finder.column_names(name), encoding) for name in languages]
    return NewProject(from_template("script.yaml", drafted), (*matches, *remarks))


def _doubled(path: str) -> str:
    """Return a path as a project states it, which fills in names in single braces."""
    return path.replace("{", "{{").replace("}", "}}")


# What there is


def recordings_below(recordings: Path, folder: Path) -> tuple[list[FoundRecording], str]:
    """List the recordings below a folder, and return their most frequent suffix."""
    if not recordings.is_dir():
        raise LipsyncError(f"{recordings}: no such folder; name the folder of the recordings")
    home = folder.resolve()
    found: list[tuple[str, FoundRecording]] = []
    for here, inner, names in os.walk(recordings.resolve()):
        inner[:] = sorted(name for name in inner if not name.startswith("."))
        parts = Path(here).relative_to(home).parts
        for name in sorted(names):
            stem, suffix = os.path.splitext(name)  # noqa: PTH122 there may be many
            if suffix.lower() in AUDIO_SUFFIXES and not name.startswith("."):
                found.append((suffix, FoundRecording(parts, stem)))
    if not found:
        raise LipsyncError(f"{recordings}: contains no {', '.join(AUDIO_SUFFIXES)}; name another")
    usual = Counter(suffix for suffix, _ in found).most_common(1)[0][0]
    return [one for suffix, one in found if suffix.lower() == usual.lower()], usual


def read_cells(
    table: Path, finder: Finder, encoding: str | None = None, layout: TableLayout = AS_FOUND
) -> Cells:
    """Read the first rows of a table, or lines of a script of another format, or of a folder."""
    found = [file for file, _ in line_files(table, lambda _: None)]
    if not found:
        raise LipsyncError(f"{table}: has no script; name a folder with {', '.join(by_suffix())}")
    file = found[0]
    opened = by_suffix()[file.suffix.lower()].table if len(found) == 1 else None
    source = LineFile(file, lambda _: None, encoding=encoding, layout=layout)
    if opened is None or is_timed(source):
        read = read_lines(table, encoding=encoding, remark=lambda _: None)
        lines = list(islice(read, MAX_TABLE_ROWS))
        names, speakers = [one.name for one in lines], [one.speaker for one in lines]
        both = any(one.original and spoken(one.original).text != one.text for one in lines)
        head = [NAME_COLUMNS[0], SPEAKER_COLUMNS[0]]
        named = dict.fromkeys(languages_of_files(found, table, cache(finder.language_of)).values())
        of_files = (*named,) if any(named) else ()
        both = both and not of_files
        return Cells(head, [names, speakers], table=False, bilingual=both, languages=of_files)
    head, rows = opened(source.at(file))
    taken = [row for _, row in islice(rows, MAX_TABLE_ROWS)]
    return Cells(head, [[cell(row, at) for row in taken] for at in range(len(head))])


# What the two have in common


def find_ids(
    found: Sequence[FoundRecording], cells: Cells, recordings: Path, table: Path
) -> IdColumn:
    """Return the column whose cells name the most recordings, as they are or within a name."""
    stems = {folded_name(one.stem) for one in found}
    plain = [IdColumn(at) for at in range(len(cells.head))]
    for candidates in (plain, [one for at in plain for one in _within(stems, cells, at.column)]):
        shares = []
        for one in candidates:
            counts = Counter(map(one.stem, cells.at(one.column)))
            # a cell that is repeated is not an id
            named = sum(count == 1 and stem in stems for stem, count in counts.items())
            shares.append((named, -one.column, one))
        most, _, best = max(shares, default=(0, 0, IdColumn(0)))
        if most >= LEAST_SHARE * len(stems):
            return best
    shown = ", ".join(one.stem for one in found[:SHOWN_FILES])
    if not cells.table:
        names = shortlist([one for one in cells.columns[0] if one] or ["none"], SHOWN_FILES)
        raise LipsyncError(
            f"{table}: no line is named like a recording in {recordings}, such as {shown}; rename "
            f"the recordings, or write a table. Names of lines: {names}"
        )
    columns = ""
    for at, name in enumerate(cells.head):
        text = ", ".join(cells.at(at)[:2]) or "empty"
        short = text if len(text) <= MAX_SHOWN_CHARS else f"{text[: MAX_SHOWN_CHARS - 3]}..."
        columns += f"\n  {name}: {short}"
    raise LipsyncError(
        f"{table}: no column names the {len(found)} recordings in {recordings}, such as "
        f"{shown}; add a column with their names. Its columns:{columns}"
    )


def _named_ids(cells: Cells, table: Path) -> IdColumn:
    """Return the column that is named like one of ids."""
    column = first_column(cells.head, NAME_COLUMNS)
    if column < 0:
        known = ", ".join(NAME_COLUMNS)
        raise LipsyncError(
            f"{table}:1: no column is named like one of ids ({known}); rename the column of ids, "
            f"or add one. Its columns: {shortlist(cells.head, MAX_KNOWN)}"
        )
    return IdColumn(column)


def _within(stems: Collection[str], cells: Cells, at: int) -> Iterator[IdColumn]:
    """Yield the text around cells of a column in names of recordings, most frequent first."""
    # A sample of both sides: every cell in every name would take minutes for a large game.
    names = {folded_name(one) for one in cells.at(at)[:MAX_COMPARED]}
    around: Counter[tuple[str, str]] = Counter()
    for stem in sorted(stems)[:: max(1, len(stems) // COMPARED_STEMS)]:
        inner = max((name for name in names if name in stem), key=len, default="")
        if len(inner) > 1:
            around[stem[: stem.index(inner)], stem[stem.index(inner) + len(inner) :]] += 1
    return (IdColumn(at, *both) for both, _ in around.most_common(1))


def _folders(
    found: Sequence[FoundRecording], speakers: Sequence[str], finder: Finder
) -> tuple[list[str], dict[str, str]]:
    """Return the pattern of the folders with the most recordings, and the words of languages."""
    depth = Counter(len(one.folders) for one in found).most_common(1)[0][0]
    levels = zip(*(one.folders for one in found if len(one.folders) == depth), strict=True)
    pattern: list[str] = []
    languages: dict[str, str] = {}
    known = {folded_name(one) for one in speakers}
    for level in levels:
        names = Counter(level)
        tongues = {name: finder.language_of(name) for name in names}
        if all(tongues.values()) and not languages:
            pattern.append("{language}")
            # Only the first level with nothing but languages: a folder `de` may be a speaker.
            languages = {own: name for name, own in tongues.items() if own}
        elif len(names) > 1 and all(folded_name(name) in known for name in names):
            pattern.append("{speaker}")
        else:
            pattern.append(_doubled(names.most_common(1)[0][0]))
    return pattern, languages


def _headed(cells: Cells, taken: Collection[int], finder: Finder) -> dict[str, str]:
    """Return the languages that files or columns with texts are called like, and their words.

    The word is the column's own name, such as "EN". If more is in the name, such as "English(en)",
    a build finds the column by the language's name, which is a better word in paths of files.
    """
    found = {own or starter().language: own or starter().language for own in cells.languages}
    for at, name in enumerate(cells.head):
        # The "id" of Indonesian is more often a second column of ids.
        texts = at not in taken and name.casefold() not in NAME_COLUMNS and cells.at(at)
        parts = language_parts(name) if texts else ()
        own = next((own for part in parts if (own := finder.language_of(part))), None)
        if own is not None and own not in found:
            alone = language_column(cells.head, finder.column_names(own)) == at
            found[own] = own if alone and not finder.language_of(name) else name
    return found


def _languages(
    cells: Cells, taken: Collection[int], folders: dict[str, str], finder: Finder, asked: str | None
) -> dict[str, str]:
    """Return the languages with the words for them in folders or columns."""
    heads = _headed(cells, taken, finder)
    if asked is not None:
        own = finder.language_of(asked) or (asked if coded_language(asked) else None)
        if own is None:
            raise finder.unknown(asked, "language")
        words = {own: folders.get(own, heads.get(own, own))}
    else:
        words = folders or heads
    if len(words) > 1 and not folders:
        which = f"`language='{next(iter(words))}'`, or another of {shortlist(words, MAX_KNOWN)}"
        raise LipsyncError(f"the language of the recordings is unknown; state {which}")
    if not words:
        raise LipsyncError("the language of the recordings is unknown; state `language='NAME'`")
    return words


def _text(
    cells: Cells, taken: Collection[int], languages: Collection[str], finder: Finder, table: Path
) -> tuple[dict[str, str], list[str]]:
    """Return the text column if the project must state it, and remarks on a guess."""
    if len(languages) > 1 or set(languages) <= _headed(cells, taken, finder).keys():
        return {}, []
    at = text_column(cells.head)
    if at not in {-1, *taken}:
        return {"text": cells.head[at]}, []
    sizes = [(sum(map(len, cells.at(at))), -at) for at in range(len(cells.head)) if at not in taken]
    (most, number), (next_most, other) = [*sorted(sizes, reverse=True), (0, 0), (0, 0)][:2]
    if not most:
        return {}, []
    name = cells.head[-number]
    if most < SURE_RATIO * next_most:
        raise LipsyncError(
            f"{table}: which column is the text, '{name}' or '{cells.head[-other]}'? "
            f"Say `column='{name}'`, or another"
        )
    return {"text": name}, [f"the text is a guess: '{name}', the column with the most letters"]


def _side(table: Path, names: Sequence[str], encoding: str | None) -> str:
    """Say which side of a bilingual script is read in a language, and what its reader remarks."""
    told: list[str] = []
    lines = [*read_lines(table, encoding=encoding, remark=told.append, names=names)]
    side = "translations" if any(one.original for one in lines) else "originals"
    return "\n".join([f"{table}: the {side} are the text in {names[0]}", *told])


def _matches(
    found: Sequence[FoundRecording],
    names: Sequence[str],
    ids: IdColumn,
    matching: Sequence[FoundRecording],
) -> tuple[str, ...]:
    """Count matched and unmatched lines and recordings, with examples."""
    if not found:
        return ()
    there = {folded_name(one.stem) for one in found}
    silent = [name for name in names if ids.stem(name) not in there]
    known = set(matching)
    loose = ["/".join([*one.folders, one.stem]) for one in found if one not in known]
    told = [f"{len(matching):,} of {len(found):,} recordings have a line"]
    for what, of, some in (("recording", "line", loose), ("line", "recording", silent)):
        if some:
            told.append(f"{count(len(some), what)} without a {of}: {shortlist(some, SHOWN_FILES)}")
    return tuple(told)
