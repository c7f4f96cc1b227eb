"""The commands that report a study, and plan its size."""

import sys
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from lipsync_lang.commands.output import FAULTS, SOUND, as_json, tell_written, working
from lipsync_lang.errors import LipsyncError, OutputError, did_you_mean
from lipsync_lang.files import STANDARD_STREAM

if TYPE_CHECKING:
    from lipsync_lang.study.study_report import StudyReport

SUFFIXES = {".json": "json", ".html": "html"}
"""Format of a file by its suffix; all other files are text."""

FORMS = ("text", "json", "html")


def report(options: Namespace) -> int:
    """Print or write the report of a study; no choices to count are a fault."""
    from lipsync_lang.study.answer_sorting import SortingRules
    from lipsync_lang.study.study_report import report_study

    form = _form(options)
    for name in ("failed_checks", "least_seconds", "one_side"):
        value = getattr(options, name)
        if value is not None and not 0 <= value < float("inf"):
            raise LipsyncError(f"--{name.replace('_', '-')} {value:g}: give 0 or more")
    rules = SortingRules(
        failed_checks=options.failed_checks,
        keep_unfinished=options.keep_unfinished,
        least_seconds=options.least_seconds,
        one_side=options.one_side,
    )
    with working("reading answers"):
        found = report_study(options.study, options.answers, rules)
    _refuse_inputs(options, found)
    text = _written(found, form)
    if options.output in (None, STANDARD_STREAM):
        sys.stdout.write(text)
    else:
        _write(options, text)
    if not found.answers.choices:
        print(
            "no choice counts; the report lists the excluded answers and the reasons",
            file=sys.stderr,
        )
        return FAULTS
    return SOUND


def _form(options: Namespace) -> str:
    suffix = options.output.suffix.lower() if options.output else ""
    form: str = options.format or SUFFIXES.get(suffix, "text")
    if form not in FORMS:
        raise LipsyncError(f"--format {form}: {did_you_mean(form, FORMS)}")
    return form


def _refuse_inputs(options: Namespace, found: "StudyReport") -> None:
    """Refuse an output that is a file of the study."""
    from lipsync_lang.study.answer_texts import STUDY_NAME

    if options.output in (None, STANDARD_STREAM):
        return
    study = options.study / STUDY_NAME if options.study.is_dir() else options.study
    read = {path.resolve() for path in (study, *map(Path, found.files))}
    if options.output.resolve() in read:
        raise OutputError(f"{options.output}: is a file of the study; name another file")


def _written(found: "StudyReport", form: str) -> str:
    """Return the report in a format."""
    if form == "json":
        return as_json(found.to_dict()) + "\n"
    if form == "html":
        from lipsync_lang.study.preference_page import report_page

        return report_page(found)
    from lipsync_lang.study.study_text import report_text

    return report_text(found)


def _write(options: Namespace, text: str) -> None:
    from lipsync_lang.files import write_all

    def encoded(stream: BinaryIO) -> None:
        stream.write(text.encode("utf-8", "backslashreplace"))

    write_all({options.output: encoded})
    tell_written(options.output)


def power(options: Namespace) -> int:
    """Print the necessary size of a study, or the power of a design."""
    from lipsync_lang.study.power import PowerQuestion, plan_study
    from lipsync_lang.study.study_text import plan_text

    plan = plan_study(
        PowerQuestion(
            share=options.share,
            raters=options.raters,
            pairs=options.pairs,
            power=options.power,
            alpha=options.alpha,
            correlation=options.correlation,
        )
    )
    if options.json:
        print(as_json(plan.to_dict()))
    else:
        sys.stdout.write(plan_text(plan))
    return SOUND
