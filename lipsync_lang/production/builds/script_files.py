"""Rows of a script: its tables and other files of lines, in all languages of a build."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from unicodedata import normalize

from lipsync_lang.base.errors import LipsyncError, ScheduleError, shortlist
from lipsync_lang.base.files.names import fault_of_name, folded_name
from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.production.builds.script_faults import ScriptFaults, in_words_of_project
from lipsync_lang.text.lines import Line, read_lines
from lipsync_lang.text.lines.cleaning import AS_WRITTEN, Cleaning
from lipsync_lang.text.lines.columns import (
    NAME_COLUMNS,
    SPEAKER_COLUMNS,
    known_column,
    lacking,
    language_column,
    stated_column,
    text_column,
)
from lipsync_lang.text.lines.line_readers import LineFile, Table, TableLayout, by_suffix, is_timed
from lipsync_lang.text.lines.markup import spoken
from lipsync_lang.text.lines.table import cell

if TYPE_CHECKING:
    from lipsync_lang.packs.models.project_models import ScriptColumns

MAX_SLUG_CHARS = 32
DIGEST_CHARS = 8
SHOWN_IDS = 4
LINE_TAG = "line:"
"""Start of the ids in tables of Yarn Spinner, which its scripts leave out of a line's name."""


class ScriptLanguage(NamedTuple):
    """A language of a build."""

    name: str
    """Name of its pack, or ENGINE:CODE."""
    word: str
    """Word for ``{language}`` in paths."""
    answers: tuple[str, ...]
    """Names that a column may have, folded, likeliest first."""


class ScriptRow(NamedTuple):
    """A line of the script in some languages."""

    number: int | str
    """Line of the file; for a spreadsheet's other sheets, with their title."""
    name: str
    speaker: str
    texts: tuple[tuple[int, str], ...]
    """Texts by index of the language; empty where it is not translated."""
    timings: str | None = None
    """File of timed phonemes that is a line by itself."""


@dataclass(frozen=True)
class ScriptFile:
    """A file of lines, with the languages that it holds by their index."""

    path: Path
    languages: dict[int, ScriptLanguage]
    encoding: str | None = None
    among_others: bool = False
    """True if it was found in a folder, which may hold other files too."""
    cleaning: Cleaning = AS_WRITTEN

    @cached_property
    def shown(self) -> str:
        """The path as text; a path object makes it again for every line."""
        return str(self.path)


PlanRemark = Callable[[str | Fault], None]


def read_rows(
    file: ScriptFile, columns: "ScriptColumns", faults: ScriptFaults, remark: PlanRemark
) -> Iterator[ScriptRow]:
    """Yield the rows of a file; its faults are collected, and end its reading."""
    try:
        opened = by_suffix()[file.path.suffix.lower()].table
        layout = TableLayout(columns.sheet, columns.header_row)
        settings = LineFile(
            file.path, remark, encoding=file.encoding, cleaning=file.cleaning, layout=layout
        )
        source = settings.at(file.path) if opened is not None else settings
        stated = columns.text is not None or columns.id is not None
        if opened is not None and (stated or not is_timed(source)):
            yield from _table_rows(file, source, opened(source), columns, faults)
            return
        rows: dict[str, ScriptRow] = {}
        met: set[tuple[str, ...]] = set()
        for index, language in file.languages.items():
            lines = list(read_lines(
                file.path, encoding=file.encoding, remark=remark, cleaning=file.cleaning,
                names=language.answers, speaker=columns.speaker,
            ))  # fmt: skip
            met.add(tuple(line.text for line in lines))
            for line, name in zip(lines, _identifiers(lines), strict=True):
                number = line.place.rpartition(":")[2]
                timings = str(file.path) if line.schedule is not None else None
                row = rows.get(name) or ScriptRow(number, name, line.speaker, (), timings)
                rows[name] = row._replace(texts=(*row.texts, (index, line.text)))
        if len(met) < len(file.languages):  # a file of several languages has other texts in each
            faults.add_error(
                f"{file.path}: has one language, but the build has {len(file.languages)}; add "
                "{language} to its path"
            )
            return
        yield from rows.values()
    except ScheduleError as error:
        if not file.among_others:
            faults.add_error(in_words_of_project(error))
        else:
            remark(f"{str(error).partition(chr(10))[0].removesuffix(':')}; left out")
    except LipsyncError as error:
        faults.add_error(in_words_of_project(error), first=True)


def read_apart(
    files: Sequence[ScriptFile], columns: "ScriptColumns", faults: ScriptFaults, remark: PlanRemark
) -> Iterator[tuple[ScriptFile, ScriptRow]]:
    """Yield the rows of files; an id of several files begins with the name of its file in each."""
    homes = {(index, file.path) for file in files for index in file.languages}
    several = max(Counter(index for index, _ in homes).values(), default=0) > 1
    first: dict[tuple[int, str], Path] = {}
    shared: set[str] = set()
    read = ((file, read_rows(file, columns, faults, remark)) for file in files)
    kept = [(file, list(rows)) for file, rows in read] if several else []
    for file, listed in kept:
        for key in (folded_name(row.name) for row in listed):
            if any(first.setdefault((at, key), file.path) != file.path for at in file.languages):
                shared.add(key)
    labels = _labels(files) if shared else {}
    named: list[str] = []
    for file, own_rows in kept or read:
        for row in own_rows:
            if not shared or folded_name(row.name) not in shared:
                yield file, row
                continue
            # Timings and events are named after their file already.
            stem, label = file.path.stem, labels[file.path]
            after = row.name[len(stem) :] if row.name.startswith(stem) else None
            own = row.name if after is None or after[:1] not in ("", ".") else ""
            named.append(f"{label}.{own}" if own else f"{label}{after}")
            yield file, row._replace(name=named[-1])
    if named:
        told = shortlist(dict.fromkeys(named), SHOWN_IDS)
        remark(f"ids that several files share begin with the name of the file: {told}")


def _labels(files: Iterable[ScriptFile]) -> dict[Path, str]:
    """Return the shortest end of each path that differs from the ends of a language's other files.

    It has no suffix and no word for a language, unless two names in a folder differ in them alone.
    """
    stems: dict[Path, str] = {}
    for file in files:
        words = "|".join(re.escape(language.word) for language in file.languages.values())
        stems[file.path] = re.sub(rf"(?<=.)[._-](?:{words})$", "", file.path.stem)
    homes = {(index, file.path) for file in files for index in file.languages}
    alike = Counter((index, path.parent, stems[path]) for index, path in homes)
    clear = {path for index, path in homes if alike[index, path.parent, stems[path]] == 1}
    ends: dict[Path, list[str]] = {}
    for path, stem in stems.items():
        last = stem if path in clear else path.name
        parts = [*path.parent.parts, last]
        ends[path] = [".".join(parts[-depth:]) for depth in range(1, len(parts) + 1)]
    met = Counter((index, end) for index, path in homes for end in ends[path])
    taken = {end for (_, end), times in met.items() if times > 1}
    return {
        path: next((end for end in own if end not in taken), own[-1]) for path, own in ends.items()
    }


def _table_rows(
    file: ScriptFile, source: LineFile, table: Table, columns: "ScriptColumns", faults: ScriptFaults
) -> Iterator[ScriptRow]:
    texts = _text_columns(source, table, file, columns.text)
    taken = [at for _, at in texts]
    name = known_column(source, table.head, columns.id, NAME_COLUMNS, taken)
    speaker = known_column(source, table.head, columns.speaker, SPEAKER_COLUMNS, [*taken, name])
    if name < 0:
        what = "has no column of ids for the file names; add one, or state `columns: {id: NAME}`"
        raise lacking(source, table.head, what)
    for number, row in table.rows:
        said: list[tuple[int, str]] = []
        for index, at in texts:
            text = cell(row, at)
            part = spoken(text, source.cleaning)
            for remark in part.remarks:
                source.remark(f"{source.path}:{number}: {remark}")
            # A cell of markup alone stays, and is performed as rest.
            said.append((index, part.text or (text.strip() if part.dropped else "")))
        own = cell(row, name).removeprefix(LINE_TAG)
        if own:
            yield ScriptRow(number, own, cell(row, speaker), tuple(said))
        elif any(text for _, text in said):
            faults.add(f"{file.path}:{number}", "this line has no id for its file names")


def _text_columns(
    source: LineFile, table: Table, file: ScriptFile, asked: str | None
) -> list[tuple[int, int]]:
    """Return (index of the language, column) for each language."""
    found: dict[int, str] = {}
    texts: list[tuple[int, int]] = []
    for index, language in file.languages.items():
        if asked is not None:
            own = asked.replace("{language}", language.word)
            at = stated_column(replace(source, names=language.answers), table.head, own)
        else:
            alone = len(file.languages) == 1
            at = language_column(table.head, language.answers)
            at = text_column(table.head) if at < 0 and alone else at
            if at < 0:
                what = (
                    f"which column is the text in {language.word}? State `columns: {{text: NAME}}`"
                )
                if not alone:
                    what += ", or what the column calls the language: `languages: {NAME: CODE}`"
                raise lacking(source, table.head, what)
        if at in found:
            what = f"one column for {found[at]} and {language.word}: state `columns: {{text: ...}}`"
            raise lacking(source, table.head, f"{what} with {{language}}")
        found[at] = language.word
        texts.append((index, at))
    return texts


def _identifiers(lines: Sequence[Line]) -> Iterator[str]:
    """Yield an id for each line: its own name, or else a slug of its text and a digest.

    The order of lines does not count, except among lines of equal name and text.
    """
    named = Counter(line.name for line in lines)
    used: Counter[str] = Counter()
    for line in lines:
        text = line.original or line.text
        if not line.name:
            name = _slug(text, text)
        elif fault_of_name(line.name):
            name = _slug(line.name, line.name + (text if named[line.name] > 1 else ""))
        elif named[line.name] > 1:
            name = f"{line.name}-{_digest(text)}"
        else:
            name = line.name
        used[name] += 1
        yield name if used[name] == 1 else f"{name}-{used[name]}"


def _slug(text: str, whole: str) -> str:
    words = re.sub(r"[^\w]+", "-", normalize("NFC", text))[:MAX_SLUG_CHARS].strip("-")
    return f"{words}-{_digest(whole)}".lstrip("-")


def _digest(text: str) -> str:
    return sha256(normalize("NFC", text).encode("utf-8", "replace")).hexdigest()[:DIGEST_CHARS]
