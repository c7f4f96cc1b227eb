"""The command that reports the bigram coverage of a corpus and the gaps to author next.

The corpus has parts: each language is read from some files, and from one of their columns.
"""

import sys
from argparse import Namespace
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from io import TextIOWrapper
from itertools import chain
from math import inf
from os.path import commonpath
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from lipsync_lang.base.errors import MAX_KNOWN, LipsyncError, OutputError, shortlist
from lipsync_lang.base.files import STANDARD_STREAM, write_all
from lipsync_lang.base.terminal import progress, wipe
from lipsync_lang.commands.output import FAULTS, SOUND, as_options, tell_written
from lipsync_lang.commands.registry import handler
from lipsync_lang.commands.shared_options import cleaning
from lipsync_lang.packs.project import FILE, find_project
from lipsync_lang.reports.coverage.forms import FORMS, SUFFIXES, FormOptions

if TYPE_CHECKING:
    from lipsync_lang.packs.finding import Finder
    from lipsync_lang.reports.coverage import Coverage
    from lipsync_lang.text.lines import Line
    from lipsync_lang.text.lines.line_readers import TableLayout


WHOLE = 100
"""Percent."""

WORD = "{language}"
"""Placeholder of the project's scripts and columns."""


@handler(
    "coverage",
    "show which bigrams a script needs, and what to author next",
    "coverage script.txt -l english -c facefx",
)
def coverage(options: Namespace) -> int:
    """Count a corpus and print what it needs; too little authored is a fault."""
    from lipsync_lang.reports.coverage.changes import read_document, since

    if options.fail_under is not None and not 0 <= options.fail_under <= WHOLE:
        raise LipsyncError(f"--fail-under {options.fail_under:g}: give a percentage, 0 to 100")
    inputs = {path.resolve() for path in options.corpus if path != STANDARD_STREAM}
    for output in options.output:
        if output != STANDARD_STREAM and output.resolve() in inputs:
            raise OutputError(f"{output}: is an input; name another file")
    old = read_document(options.against) if options.against else None
    found = _counted(options)
    if old:
        found = since(old, found, shown_names([options.against])(str(options.against)))
    _write(options, found)
    under = [one for one in found.reports if one.authored.percent < (options.fail_under or 0)]
    for one in under:
        share = f"{one.authored.percent:g} % are authored, under {options.fail_under:g} %"
        print(f"{one.label} on {one.character}: {share}", file=sys.stderr)
    return FAULTS if under else SOUND


def _counted(options: Namespace) -> "Coverage":
    """Count all lines together and each column separately."""
    from lipsync_lang.reports.coverage import coverage as count
    from lipsync_lang.reports.coverage.reading_cache import heard_lines
    from lipsync_lang.reports.coverage.total import joined
    from lipsync_lang.sound.speech.needed_extras import engines_of, refuse_missing
    from lipsync_lang.sound.speech.sound import AUDIO_SUFFIXES
    from lipsync_lang.sound.speech.speaking.speaker import Speaker
    from lipsync_lang.text.lines import read_lines
    from lipsync_lang.text.lines.line_readers import TableLayout

    parts = corpus_parts(options)
    weights = weights_of(options)
    shown = shown_names(path for part in parts for path in (*part.paths, *part.recordings))

    @cache  # each remark once, however many columns are read
    def tell(remark: str) -> None:
        print(as_options(remark), file=sys.stderr)

    languages = {language for part in parts for language in part.languages}
    speakers = {language: Speaker.of(language, options.path) for language in languages}
    refuse_missing({name: engines_of(one.manner) for name, one in sorted(speakers.items())})
    # One part after the other: a column is another script, whose lines no other part may count.
    counted: list[tuple[CorpusPart, Coverage]] = []
    for part in parts:
        lines = read_lines(
            part.paths, column=part.column, encoding=options.encoding, remark=tell,
            cleaning=cleaning(options), names=part.names, speaker=options.speaker_column,
            layout=TableLayout(options.sheet, options.header_row), elsewhere=AUDIO_SUFFIXES,
        )  # fmt: skip
        heard = heard_lines(part.recordings, speakers[part.languages[0]], tell)
        found = count(
            _shown(chain(lines, heard), shown), part.languages, options.character,
            paths=options.path, minutes=options.minutes, weights=weights, cast=options.cast,
            gestures=options.gestures,
        )  # fmt: skip
        counted.append((part, found))
    # A title tells parts of one language apart, and would be noise for all others.
    of = Counter(name for _, one in counted for name in {each.language for each in one.reports})
    titled = [
        (part.title if any(of[each.language] > 1 for each in one.reports) else part.column, one)
        for part, one in counted
    ]
    found = joined(titled, weights)
    if others := [f"{one.what} ({one.count})" for one in found.corpus.other_speakers]:
        default, names = " and ".join(options.character), shortlist(others)
        print(f"speakers that `cast` does not name get {default}: {names}", file=sys.stderr)
    return found


def _shown(lines: "Iterable[Line]", shown: Callable[[str], str]) -> "Iterator[Line]":
    """Yield lines whose places name files as reports do, with a running count on a terminal."""
    try:
        for number, line in enumerate(lines):
            file, colon, at = line.place.rpartition(":")
            name = shown(file)
            named = line if name == file else replace(line, place=f"{name}{colon}{at}")
            # A terminal takes longer to draw a line than this takes to read it.
            if number % 1000 == 0:
                progress(f"{number:,} lines, {named.file}")
            yield named
    finally:
        wipe()


def _write(options: Namespace, found: "Coverage") -> None:
    asked = FormOptions(everything=options.all, fail_under=options.fail_under)
    if not options.output:
        FORMS.find(options.format or "text")(found, sys.stdout, asked)

    def encoded(path: Path, stream: BinaryIO) -> None:
        write = FORMS.find(options.format or SUFFIXES.get(path.suffix.lower(), "text"))
        text = TextIOWrapper(stream, "utf-8", "backslashreplace", newline="", write_through=True)
        write(found, text, asked)
        # Else the wrapper closes the stream, which `write_all` still renames.
        text.detach()

    write_all({path: partial(encoded, path) for path in options.output})
    tell_written(*options.output)


@dataclass(frozen=True)
class CorpusPart:
    """Files that some languages are read from, in one column.

    Parameters
    ----------
    column : as it was stated; None for the one that is named after the language, or the likeliest
    names : of the language, which a column may have
    title : what tells it from other parts of a language: its column, or the language as given
    """

    paths: tuple[Path, ...]
    column: str | None
    names: tuple[str, ...]
    title: str
    recordings: tuple[Path, ...] = ()
    """Recordings without a text, which are heard; such a part has one language."""
    languages: list[str] = field(default_factory=list)


def corpus_parts(options: Namespace) -> list[CorpusPart]:
    """Return the parts of a corpus; languages of the same files and column share one.

    Raises LipsyncError if nothing is to be read, or a table has no column for a language.
    """
    from lipsync_lang.base.files.names import BRACES, fill
    from lipsync_lang.packs.finding import Finder, folders_of
    from lipsync_lang.reports.coverage.reading_cache import is_recording, unwritten
    from lipsync_lang.text.lines.line_readers import TableLayout, line_files

    finder = Finder(folders_of(options.path))
    stated = _stated(options.language, options.column)
    layout = TableLayout(options.sheet, options.header_row)
    named = {one: finder.column_names(one, options.words.get(one)) for one in options.language}
    finding = _Columns(options.encoding, layout, finder, named)
    parts: dict[object, CorpusPart] = {}
    if options.language and not (options.corpus or options.lines):
        raise LipsyncError(f"there is no script to count; name a file, or state `lines` in {FILE}")
    for language in dict.fromkeys(options.language):
        word = options.words.get(language) or language
        listed = (Path(fill(str(path), {WORD: word, **BRACES})) for path in options.lines)
        paths = tuple(options.corpus or listed)
        recordings = tuple(unwritten(paths))
        paths = tuple(path for path in paths if not (is_recording(path) and path.exists()))
        if not options.corpus:
            line_files(paths, lambda _: None, project=options.home)
        paths = finding.own_files(language, paths)
        default = options.text_column and options.text_column.replace(WORD, word)
        names = finding.names[language]
        for column in stated.get(language, [default]):
            found = column or finding.of(language, paths)
            title = column or finding.title(paths, found) or language
            part = CorpusPart(paths, column, names, title, recordings)
            own = language if recordings else None
            parts.setdefault((paths, found, own), part).languages.append(language)
    return list(parts.values())


def _stated(languages: Sequence[str], columns: Sequence[str]) -> dict[str, list[str | None]]:
    """Map languages to columns, from ``german=de`` or from a default such as ``de``."""
    own: dict[str, list[str | None]] = {}
    others: str | None = None
    for one in columns:
        language, equals, column = one.partition("=")
        if equals and language in languages:
            own.setdefault(language, []).append(column)
        elif others is None:
            others = one
        else:
            raise LipsyncError(
                f"--column {one}: there is already --column {others}; state the language of each "
                f"column: --column {languages[0]}={others}"
            )
    if others is not None:
        own = {language: own.get(language, [others]) for language in languages}
    return own


@dataclass(frozen=True)
class _Columns:
    """The columns of tables that are named after languages."""

    encoding: str | None
    layout: "TableLayout"
    finder: "Finder"
    names: dict[str, tuple[str, ...]]
    """By language, the names that its column may have."""
    heads: dict[tuple[Path, ...], dict[Path, list[str]]] = field(default_factory=dict)

    def own_files(self, language: str, paths: tuple[Path, ...]) -> tuple[Path, ...]:
        """Return the files of a language in place of folders that hold several languages."""
        from lipsync_lang.packs.language_files import spoken_in
        from lipsync_lang.text.lines.line_readers import line_files

        found: list[Path] = []
        for path in paths:
            files = [file for file, _ in line_files(path, lambda _: None)] if path.is_dir() else []
            own = self.finder.language_of(language) or language
            spoken = spoken_in(files, path, {own: self.names[language]}, self.finder)
            kept = [file for file in files if spoken[file]]
            found += kept if len(kept) < len(files) else [path]
        return tuple(found)

    def of(self, language: str, paths: tuple[Path, ...]) -> tuple[int, ...]:
        """Return the column in each table, or -1 where the likeliest text is taken."""
        from lipsync_lang.text.lines.columns import language_column, text_column
        from lipsync_lang.text.lines.line_readers import heads

        if paths not in self.heads:
            self.heads[paths] = heads(paths, self.encoding, self.layout)
        others = [names for other, names in self.names.items() if other != language]
        found = []
        for path, head in self.heads[paths].items():
            at = language_column(head, self.names[language])
            found.append(at)
            if at >= 0:
                continue
            # A text of no stated language is taken; that of another language never.
            at = text_column(head)
            theirs = at >= 0 and self.finder.lookup("language", head[at].casefold())
            if at < 0 or theirs or any(language_column(head, one) >= 0 for one in others):
                raise LipsyncError(
                    f"{path}:1: which column is the text in {language}? Say "
                    f"--column {language}=NAME. Its columns: {shortlist(head, MAX_KNOWN)}"
                )
        return tuple(found)

    def title(self, paths: tuple[Path, ...], found: Iterable[int]) -> str:
        """Return the names of the columns that were found in tables."""
        heads = zip(self.heads[paths].values(), found, strict=True)
        return ", ".join(dict.fromkeys(head[at] for head, at in heads if at >= 0))


def weights_of(options: Namespace) -> dict[str, float]:
    """Return the weight of each language that has one, by the name of its pack."""
    from lipsync_lang.packs.finding import Finder, folders_of

    finder = Finder(folders_of(options.path))

    def own(given: str) -> str:
        paths = () if ":" in given else finder.lookup("language", given)
        return Path(paths[0]).stem if paths else given

    counted = [own(given) for given in options.language] if options.weight else []
    weights: dict[str, float] = {}
    for one in options.weight:
        given, equals, number = one.partition("=")
        try:
            weight = float(number)
        except ValueError:
            weight = -1.0  # refused below
        if not (equals and 0 <= weight < inf):
            raise LipsyncError(f"--weight {one}: write LANGUAGE=NUMBER")
        if own(given) not in counted:
            known = ", ".join(counted)
            what = f"--weight {one}: {given} is not a language of this report; these are {known}"
            raise LipsyncError(what)
        weights[own(given)] = weight
    if weights and not any(weights.get(one, 1.0) for one in counted):
        raise LipsyncError("--weight: all weights are 0; give a language a larger weight")
    return weights


def shown_names(corpus: Iterable[Path]) -> Callable[[str], str]:
    """Return a function that names a file from the project's folder.

    A file elsewhere is named from the folder that all files elsewhere have in common, so that no
    report names the folders of a machine.
    """
    project = find_project()
    root = (project.parent if project else Path.cwd()).resolve()
    named = [path.resolve() for path in corpus if path != STANDARD_STREAM]
    outside = [str(path.parent) for path in named if not path.is_relative_to(root)]
    try:
        common = Path(commonpath(outside)) if outside else root
    except ValueError:  # drives of Windows
        common = root

    @cache
    def shown(file: str) -> str:
        path = Path(file).resolve()
        base = next((one for one in (root, common) if path.is_relative_to(one)), path.parent)
        return file if file == str(STANDARD_STREAM) else path.relative_to(base).as_posix()

    return shown
