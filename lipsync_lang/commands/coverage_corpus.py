"""The corpus of `coverage`: which files and which column each language is read from."""

from argparse import Namespace
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from math import inf
from os.path import commonpath
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import MAX_KNOWN, LipsyncError, shortlist
from lipsync_lang.base.files import STANDARD_STREAM
from lipsync_lang.packs.project import FILE, find_project

if TYPE_CHECKING:
    from lipsync_lang.packs.finding import Finder

WORD = "{language}"
"""Placeholder of the project's scripts and columns."""


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

    Raises
    ------
    LipsyncError
        Nothing is to be read, or a table has no column for a language.
    """
    from lipsync_lang.packs.finding import Finder, folders_of
    from lipsync_lang.reports.coverage.heard_lines import is_recording, unwritten
    from lipsync_lang.text.lines.line_readers import line_files

    finder = Finder(folders_of(options.path))
    stated = _stated(options.language, options.column)
    finding = _Columns(options.encoding, finder, options.language, options.words)
    parts: dict[object, CorpusPart] = {}
    if options.language and not (options.corpus or options.lines):
        raise LipsyncError(f"there is no script to count; name a file, or state `lines` in {FILE}")
    for language in dict.fromkeys(options.language):
        word = options.words.get(language) or language
        paths = tuple(
            options.corpus or (Path(str(path).replace(WORD, word)) for path in options.lines)
        )
        recordings = tuple(unwritten(paths))
        paths = tuple(path for path in paths if not (is_recording(path) and path.exists()))
        if not options.corpus:
            line_files(paths, lambda _: None, project=options.home)
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


class _Columns:
    """The columns of tables that are named after languages."""

    def __init__(
        self,
        encoding: str | None,
        finder: "Finder",
        languages: Iterable[str],
        words: dict[str, str | None],
    ) -> None:
        self._encoding = encoding
        self._finder = finder
        self.names = {one: finder.column_names(one, words.get(one)) for one in languages}
        self._heads: dict[tuple[Path, ...], dict[Path, list[str]]] = {}

    def of(self, language: str, paths: tuple[Path, ...]) -> tuple[int, ...]:
        """Return the column in each table, or -1 where the likeliest text is taken."""
        from lipsync_lang.text.lines.columns import language_column, text_column
        from lipsync_lang.text.lines.line_readers import heads

        if paths not in self._heads:
            self._heads[paths] = heads(paths, self._encoding)
        others = [names for other, names in self.names.items() if other != language]
        found = []
        for path, head in self._heads[paths].items():
            at = language_column(head, self.names[language])
            found.append(at)
            if at >= 0:
                continue
            # A text of no stated language is taken; that of another language never.
            at = text_column(head)
            theirs = at >= 0 and self._finder.lookup("language", head[at].casefold())
            if at < 0 or theirs or any(language_column(head, one) >= 0 for one in others):
                raise LipsyncError(
                    f"{path}:1: which column is the text in {language}? Say "
                    f"--column {language}=NAME. Its columns: {shortlist(head, MAX_KNOWN)}"
                )
        return tuple(found)

    def title(self, paths: tuple[Path, ...], found: Iterable[int]) -> str:
        """Return the names of the columns that were found in tables."""
        heads = zip(self._heads[paths].values(), found, strict=True)
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
    known: dict[str, str] = {str(STANDARD_STREAM): str(STANDARD_STREAM)}

    def shown(file: str) -> str:
        if file not in known:
            path = Path(file).resolve()
            base = next((one for one in (root, common) if path.is_relative_to(one)), path.parent)
            known[file] = path.relative_to(base).as_posix()
        return known[file]

    return shown
