"""Options of `build`, which makes all lines of a script."""

import argparse
from pathlib import Path

from lipsync_lang.commands import build
from lipsync_lang.commands.shared_options import Add, add_path


def add_build(add: Add) -> None:
    """Add `build`."""
    made = add(
        "build",
        build.build,
        "make all lines of a script, and then only the changed ones",
        "build --dry-run",
    )
    _add_which(made.add_argument_group("which lines to make"))
    _add_how(made.add_argument_group("how to make them"))
    add_path(made)
    made.set_defaults(in_project=False)


def _add_which(which: argparse._ArgumentGroup) -> None:
    which.add_argument(
        "--only", metavar="PATTERN", action="append", default=[],
        help="make lines whose ids match, such as 'intro_*'; may be repeated",
    )  # fmt: skip
    which.add_argument(
        "-l", "--language", metavar="LANGUAGE", action="append", default=[], dest="languages",
        help="make lines in this language; may be repeated [all]",
    )  # fmt: skip
    which.add_argument(
        "-c", "--character", metavar="CHARACTER", action="append", default=[], dest="characters",
        help="make lines on this character; may be repeated [all]",
    )  # fmt: skip
    which.add_argument(
        "--prune", action="store_true", help="delete files of lines that the script no longer has"
    )
    which.add_argument(
        "--force", action="store_true", help="make lines again even if nothing changed"
    )
    which.add_argument(
        "--overwrite", action="store_true", help="replace files that were edited by hand"
    )
    which.add_argument(
        "--dry-run", action="store_true", help="list the lines that would be made, and why"
    )


def _add_how(how: argparse._ArgumentGroup) -> None:
    how.add_argument(
        "--workers", metavar="N", type=int, default=None, help="number of processes [one per core]"
    )
    how.add_argument(
        "--scheduler", metavar="ADDRESS", default=None,
        help="give the work to this Dask cluster, such as tcp://10.0.0.5:8786",
    )  # fmt: skip
    how.add_argument("--watch", action="store_true", help="keep making changed lines until Ctrl-C")
    how.add_argument(
        "--tts", metavar="ENGINE", help="speech engine for all lines; none estimates times"
    )
    how.add_argument(
        "--report", metavar="FILE", type=Path, action="append", default=[], dest="reports",
        help="write a report: .html, .xml (JUnit) or .json; may be repeated [the project's]",
    )  # fmt: skip
    how.add_argument("--json", action="store_true", help="print events as JSON, one on each line")
