"""Options of `coverage`."""

import argparse
from pathlib import Path

from lipsync_lang.commands import coverage
from lipsync_lang.commands.script_options import add_values
from lipsync_lang.commands.shared_options import Add, add_json_form, add_path
from lipsync_lang.coverage.forms import FORMS
from lipsync_lang.files import argument_path


def add_coverage(add: Add) -> None:
    """Add `coverage`."""
    coverage_ = add(
        "coverage",
        coverage.coverage,
        "show which bigrams a script needs, and what to author next",
        "coverage script.txt -l english -c facefx",
    )
    _add_corpus(coverage_)
    coverage_.add_argument(
        "--format",
        metavar="NAME",
        help=f"what to write: {', '.join(FORMS.modules)} [by the suffix of -o, else text]",
    )
    coverage_.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=argument_path,
        help="write to a file; - is standard output [print it]",
    )
    add_json_form(coverage_)
    coverage_.add_argument(
        "--column", metavar="NAME", action="append", default=[],
        help="the text's column in tables, by name or number; LANGUAGE=NAME for one language's, "
        "which may have several [the one named after the language]",
    )  # fmt: skip
    coverage_.add_argument("--encoding", metavar="NAME", help="the encoding of all files [UTF-8]")
    coverage_.add_argument(
        "--minutes", metavar="N", type=float, default=5.0, help="minutes to author a bigram [5]"
    )
    coverage_.add_argument(
        "--weight", metavar="LANGUAGE=N", action="append", default=[],
        help="weight of a language in the total of all; may be repeated [1 each]",
    )  # fmt: skip
    coverage_.add_argument(
        "--fail-under", metavar="PERCENT", type=float,
        help="exit with 1 if less of the speech is authored",
    )  # fmt: skip
    coverage_.add_argument(
        "--against",
        metavar="OLD.json",
        type=Path,
        help="show the changes since an older JSON report",
    )
    coverage_.add_argument("--all", action="store_true", help="list every bigram and line")
    add_values(coverage_)
    add_path(coverage_)


def _add_corpus(made: argparse.ArgumentParser) -> None:
    """Add the texts, and the languages and characters that speak them."""
    made.add_argument(
        "corpus",
        metavar="CORPUS",
        type=argument_path,
        nargs="*",
        help="a file of lines, a folder, or - for standard input [the project's lines]",
    )
    made.set_defaults(words={}, lines=(), text_column=None, speaker_column=None, cast=None)
    for short, name, what in (
        ("-l", "language", "name or tag of a language"),
        ("-c", "character", "a character or a pose set that speaks every line"),
    ):
        made.add_argument(
            short, f"--{name}", metavar=name.upper(), action="append", default=[],
            help=f"{what} [the project's]; may be repeated",
        )  # fmt: skip
