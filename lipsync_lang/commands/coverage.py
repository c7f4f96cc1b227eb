"""The command that reports the bigram coverage of a corpus and the gaps to author next."""

import sys
from argparse import Namespace
from collections import Counter
from dataclasses import replace
from functools import cache, partial
from io import TextIOWrapper
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from lipsync_lang.base.errors import LipsyncError, OutputError, shortlist
from lipsync_lang.base.files import STANDARD_STREAM, argument_path, write_all
from lipsync_lang.base.terminal import progress, wipe
from lipsync_lang.commands.coverage_corpus import CorpusPart, corpus_parts, shown_names, weights_of
from lipsync_lang.commands.options import flag, option, repeated
from lipsync_lang.commands.output import FAULTS, SOUND, as_options, tell_written
from lipsync_lang.commands.registry import Add, command
from lipsync_lang.commands.shared_options import (
    add_json_form,
    add_output,
    add_path,
    add_values,
    cleaning,
)
from lipsync_lang.reports.coverage.forms import FORMS, SUFFIXES, FormOptions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from lipsync_lang.reports.coverage import Coverage
    from lipsync_lang.text.lines import Line

WHOLE = 100
"""Percent."""

MAX_NAMES = 8
"""Speakers that a remark names."""


@command("coverage")
def _add_coverage(add: Add) -> None:
    coverage_ = add(
        coverage,
        "show which bigrams a script needs, and what to author next",
        "coverage script.txt -l english -c facefx",
    )
    coverage_.add_argument(
        "corpus", metavar="CORPUS", type=argument_path, nargs="*",
        help="a file of lines, a recording, a folder, or - for standard input "
        "[the project's lines]",
    )  # fmt: skip
    coverage_.set_defaults(words={}, lines=(), text_column=None, speaker_column=None, cast=None)
    for spelled, what in (
        ("-l, --language LANGUAGE", "name or tag of a language"),
        ("-c, --character CHARACTER", "a character or a pose set that speaks every line"),
    ):
        repeated(coverage_, spelled, f"{what} [the project's]; may be repeated")
    option(
        coverage_, "--format NAME",
        f"what to write: {', '.join(FORMS.modules)} [by the suffix of -o, else text]",
    )  # fmt: skip
    add_output(coverage_)
    add_json_form(coverage_)
    repeated(
        coverage_, "--column NAME",
        "the text's column in tables, by name or number; LANGUAGE=NAME for one language's, which "
        "may have several [the one named after the language]",
    )  # fmt: skip
    option(coverage_, "--encoding NAME", "the encoding of all files [UTF-8]")
    option(coverage_, "--minutes N", "minutes to author a bigram [5]", type=float, default=5.0)
    repeated(
        coverage_, "--weight LANGUAGE=N",
        "weight of a language in the total of all; may be repeated [1 each]",
    )  # fmt: skip
    option(
        coverage_, "--fail-under PERCENT", "exit with 1 if less of the speech is authored",
        type=float,
    )  # fmt: skip
    option(
        coverage_, "--against OLD.json", "show the changes since an older JSON report", type=Path
    )
    option(
        coverage_, "--gestures NAME[:FACTOR],...",
        "count these gestures of the pose set, at estimated times: all, or such as blink,nod [the "
        "project's, or none]",
    )  # fmt: skip
    flag(coverage_, "--all", "list every bigram and line")
    add_values(coverage_)
    add_path(coverage_)


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
        print(
            f"{one.label} on {one.character}: {one.authored.percent:g} % are authored, under "
            f"{options.fail_under:g} %",
            file=sys.stderr,
        )
    return FAULTS if under else SOUND


def _counted(options: Namespace) -> "Coverage":
    """Count all lines together and each column separately."""
    from lipsync_lang.reports.coverage import coverage as count
    from lipsync_lang.reports.coverage.column_joining import joined
    from lipsync_lang.reports.coverage.heard_lines import heard_lines
    from lipsync_lang.sound.speech.needed_extras import engines_of, refuse_missing
    from lipsync_lang.sound.speech.sound_forms import AUDIO_SUFFIXES
    from lipsync_lang.sound.speech.speaking.speaker import Speaker
    from lipsync_lang.text.lines import read_lines

    parts = corpus_parts(options)
    weights = weights_of(options)
    shown = shown_names(path for part in parts for path in (*part.paths, *part.recordings))

    @cache  # each remark once, however many columns are read
    def tell(remark: str) -> None:
        print(as_options(remark), file=sys.stderr)

    languages = {language for part in parts for language in part.languages}
    speakers = {language: Speaker.of(language, options.path) for language in languages}
    refuse_missing({name: engines_of(one.manner) for name, one in sorted(speakers.items())})
    counted: list[tuple[CorpusPart, Coverage]] = []
    for part in parts:
        lines = read_lines(
            part.paths, column=part.column, encoding=options.encoding, remark=tell,
            cleaning=cleaning(options), names=part.names, speaker=options.speaker_column,
            elsewhere=AUDIO_SUFFIXES,
        )  # fmt: skip
        heard = heard_lines(part.recordings, speakers[part.languages[0]], tell)
        found = count(
            _shown(chain(lines, heard), shown), part.languages, options.character,
            paths=options.path, minutes=options.minutes, weights=weights, cast=options.cast,
            gestures=options.gestures,
        )  # fmt: skip
        counted.append((part, found))
    of = Counter(name for _, one in counted for name in {each.language for each in one.reports})
    found = joined(
        [
            (part.title if any(of[each.language] > 1 for each in one.reports) else part.column, one)
            for part, one in counted
        ],
        weights,
    )
    others = [f"{one.what} ({one.count})" for one in found.corpus.other_speakers]
    if others:
        default, names = " and ".join(options.character), shortlist(others, MAX_NAMES)
        print(f"speakers that `cast` does not name get {default}: {names}", file=sys.stderr)
    return found


def _shown(lines: "Iterable[Line]", shown: "Callable[[str], str]") -> "Iterator[Line]":
    """Yield lines whose places name files as reports do, with a running count on a terminal."""
    try:
        for number, line in enumerate(lines):
            file, colon, at = line.place.rpartition(":")
            name = shown(file)
            named = line if name == file else replace(line, place=f"{name}{colon}{at}")
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
        text.detach()

    write_all({path: partial(encoded, path) for path in options.output})
    for path in options.output:
        tell_written(path)
