"""The commands that report a study, and plan its size."""

import sys
from argparse import Namespace
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang import LipsyncError, OutputError
from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.base.files import STANDARD_STREAM, argument_path, write_all
from lipsync_lang.commands.output import FAULTS, SOUND, as_json, tell_written, working
from lipsync_lang.commands.registry import Add, command
from lipsync_lang.commands.shared_options import add_options, flag, option

if TYPE_CHECKING:
    from lipsync_lang.plugins.study.study_report import StudyReport

SUFFIXES = {".json": "json", ".html": "html"}
"""Format of a file by its suffix; all other files are text."""

FORMS = ("text", "json", "html")


@command("study report")
def _add_report(action: Add) -> None:
    made = action(
        report,
        "report which method people prefer, how strongly, and how certain the result is",
        "study report study/ -o report.html",
    )
    made.add_argument("study", metavar="STUDY", type=Path, help="the study's folder")
    made.add_argument(
        "answers", metavar="ANSWERS", type=argument_path, nargs="*",
        help="files of answers, or folders of them; - is standard input [those in the study's "
        "folder]",
    )  # fmt: skip
    option(
        made, "-o, --output FILE",
        "write to a file, as HTML, JSON or text by its suffix; - is standard output [print it]",
        type=argument_path,
    )  # fmt: skip
    option(
        made, "--format NAME", "output format: text, json, html [by the suffix of -o, else text]"
    )
    add_options(made, ["json form"])
    option(
        made, "--failed-checks N", "number of attention checks that a rater may fail [0]", type=int,
        default=0,
    )  # fmt: skip
    option(
        made, "--least-seconds N", "shortest time for a pair [the length of the clip]", type=float
    )
    option(
        made, "--one-side N",
        "exclude a rater who chooses one side in all of N or more pairs; 0 for never [10]",
        type=int, default=10,
    )  # fmt: skip
    flag(made, "--keep-unfinished", "count raters who stopped early, too")


@command("study power")
def _add_power(action: Add) -> None:
    made = action(
        power,
        "compute the raters and pairs that a study needs, or the power of a design",
        "study power --share 0.6 --pairs 20",
    )
    option(
        made, "--share X", "expected share of choices for the better method, such as 0.6",
        type=float, required=True,
    )  # fmt: skip
    option(made, "--raters N", "number of raters [as many as needed]", type=int)
    option(made, "--pairs N", "number of pairs per rater [10, 20 and 40]", type=int)
    alike = "correlation of the choices of one rater, 0 to 1; the report of a study measures it"
    for spelled, usual, told in (
        ("--power X", 0.8, "wanted probability of a significant result"),
        ("--alpha X", 0.05, "level of the two-sided test"),
        ("--correlation X", 0.1, alike),
    ):
        option(made, spelled, f"{told} [{usual}]", type=float, default=usual)
    add_options(made, ["json"])


def report(options: Namespace) -> int:
    """Print or write the report of a study; no choices to count are a fault."""
    from lipsync_lang.plugins.study.answer_sorting import SortingRules
    from lipsync_lang.plugins.study.study_report import report_study

    suffix = options.output.suffix.lower() if options.output else ""
    form: str = options.format or SUFFIXES.get(suffix, "text")
    if form not in FORMS:
        raise LipsyncError(f"--format {form}: {did_you_mean(form, FORMS)}")
    for name in ("failed_checks", "least_seconds", "one_side"):
        value = getattr(options, name)
        if value is not None and not 0 <= value < float("inf"):
            raise LipsyncError(f"--{name.replace('_', '-')} {value:g}: give 0 or more")
    rules = SortingRules(*(getattr(options, field.name) for field in fields(SortingRules)))
    with working("reading answers"):
        found = report_study(options.study, options.answers, rules)
    text = _written(options, found, form)
    if options.output in (None, STANDARD_STREAM):
        sys.stdout.write(text)
    else:
        content = text.encode("utf-8", "backslashreplace")
        write_all({options.output: lambda stream: stream.write(content)})
        tell_written(options.output)
    if not found.answers.choices:
        what = "no choice counts; the report lists the excluded answers and the reasons"
        print(what, file=sys.stderr)
        return FAULTS
    return SOUND


def _written(options: Namespace, found: "StudyReport", form: str) -> str:
    """Return the report in a format; refuse an output that is a file of the study."""
    from lipsync_lang.plugins.study.study_file import STUDY_NAME

    if options.output not in (None, STANDARD_STREAM):
        study = options.study / STUDY_NAME if options.study.is_dir() else options.study
        if options.output.resolve() in {Path(one).resolve() for one in (study, *found.files)}:
            raise OutputError(f"{options.output}: is a file of the study; name another file")
    if form == "json":
        return as_json(found.to_dict()) + "\n"
    if form == "html":
        from lipsync_lang.plugins.study.preference_page import report_page

        return report_page(found)
    from lipsync_lang.plugins.study.study_text import report_text

    return report_text(found)


def power(options: Namespace) -> int:
    """Print the necessary size of a study, or the power of a design."""
    from lipsync_lang.plugins.study.power import PowerQuestion, plan_study
    from lipsync_lang.plugins.study.study_text import plan_text

    # The options have the names of the fields.
    asked = (getattr(options, field.name) for field in fields(PowerQuestion))
    plan = plan_study(PowerQuestion(*asked))
    if options.json:
        print(as_json(plan.to_dict()))
    else:
        sys.stdout.write(plan_text(plan))
    return SOUND
