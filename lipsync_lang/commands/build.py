"""The command that builds a whole project."""

import json
import sys
from argparse import Namespace
from collections.abc import Iterator, Mapping
from contextlib import nullcontext
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from lipsync_lang.commands.output import FAULTS, SOUND, count
from lipsync_lang.errors import LipsyncError
from lipsync_lang.terminal import progress, wipe

if TYPE_CHECKING:
    from lipsync_lang.build.build_run import BuildOutcome
    from lipsync_lang.build.planning import BuildPlan
    from lipsync_lang.build.project_build import ProjectBuild

SHOWN_LINES = 20
"""Lines of one kind that text lists."""

LOG_SECONDS = 10.0
"""Pause between two lines of progress in a log."""


def build(options: Namespace) -> int:
    """Make what changed since the last build, and report on all of it."""
    return _watch(options) if options.watch else _once(options)


def _once(options: Namespace) -> int:
    from lipsync_lang.build.build_run import locked, make
    from lipsync_lang.build.keeping import prune
    from lipsync_lang.build.records import Records

    teller = BuildTeller(as_events=options.json)
    project = _opened(options)
    lock = nullcontext() if options.dry_run else locked(project.folder, teller)
    with lock, Records.open(project.folder, write=not options.dry_run) as records:
        plan = project.plan(records, force=options.force, overwrite=options.overwrite)
        if options.dry_run:
            return _listed(plan, project, as_events=options.json)
        outcome = make(
            plan,
            project.maker,
            project.pairs,
            records,
            workers=options.workers,
            scheduler=options.scheduler,
            tell=teller,
        )
        deleted = prune(plan, project.folder, records) if options.prune else []
    return _ended(options, project, outcome, teller, deleted)


def _opened(options: Namespace) -> "ProjectBuild":
    from lipsync_lang.build.project_build import ProjectBuild, Selection

    selection = Selection(
        tuple(options.only or ()), tuple(options.languages or ()), tuple(options.characters or ())
    )
    return ProjectBuild.open(
        paths=options.path,
        selection=selection,
        tts=options.tts,
        remark=lambda text: print(text, file=sys.stderr),
    )


class BuildTeller:
    """Receiver of a build's events: JSON lines, or progress and messages for people."""

    def __init__(self, *, as_events: bool) -> None:
        self.as_events = as_events
        self._told = monotonic()

    def __call__(self, name: str, values: Mapping[str, Any]) -> None:
        """Tell of an event."""
        if self.as_events:
            print(json.dumps({"event": name, **values}), flush=True)
        elif name == "progress":
            self._progress(values)
        elif name == "waiting":
            print("another build of this project is running; waiting for it", file=sys.stderr)
        elif values.get("outcome") == "failed":
            wipe()
            print(values["message"], file=sys.stderr)

    def _progress(self, values: Mapping[str, Any]) -> None:
        done, of, seconds = values["done"], values["of"], values["seconds"]
        rate = done / max(seconds, 1e-3)
        left = (of - done) / rate if rate else 0
        told = f"{done:,} of {of:,} lines, {rate:,.0f} a second, {_clock(left)} left"
        if sys.stderr.isatty():
            progress(told)
        elif monotonic() - self._told > LOG_SECONDS:
            self._told = monotonic()
            print(told, file=sys.stderr, flush=True)


def _clock(seconds: float) -> str:
    """Format a time in words.

    >>> _clock(75), _clock(7265)
    ('1 min 15 s', '2 h 1 min')
    """
    whole = round(seconds)
    if whole < 60:  # noqa: PLR2004 a minute
        return f"{whole} s"
    if whole < 3600:  # noqa: PLR2004 an hour
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole // 60 % 60} min"


def _listed(plan: "BuildPlan", project: "ProjectBuild", *, as_events: bool) -> int:
    """Print the lines that a build would make, each with its reasons."""
    stale = plan.stale
    for step in stale:
        line = step.line
        if as_events:
            named = {"language": line.language, "character": line.character, "name": line.name}
            print(json.dumps({"event": "stale", **named, "reasons": list(step.reasons)}))
        else:
            print(f"{line.language} {line.character} {line.name}: {_reasons(step.reasons)}")
    told = f"{count(len(stale), 'line')} of {len(plan.steps)} would be made"
    _tell_all(
        [f"{told}; {_kept(plan.kept)}" if plan.kept else told, *map(str, project.unsound.values())]
    )
    return FAULTS if project.unsound else SOUND


def _reasons(reasons: tuple[str, ...]) -> str:
    shown = ", ".join(reasons[:3])
    return f"{shown} and {len(reasons) - 3} more" if len(reasons) > 3 else shown  # noqa: PLR2004


def _ended(
    options: Namespace,
    project: "ProjectBuild",
    outcome: "BuildOutcome",
    teller: BuildTeller,
    deleted: list[str],
) -> int:
    """Tell the outcome, write the reports, and return the exit code."""
    from lipsync_lang.build.build_reports import report

    wipe()
    reports = options.reports or [project.folder / path for path in project.project.reports]
    refused = project.refused()
    tally, over = report(project, outcome, refused, reports, SHOWN_LINES)
    figures = {
        "lines": len(project.lines),
        "built": sum(one.outcome == "built" for one in outcome.built.values()),
        "current": len(outcome.plan.steps) - len(outcome.plan.stale),
        "failed": tally.failed,
        "over_limits": tally.over,
        "doubted": tally.doubtful,
        "kept": outcome.kept,
        "gone": [] if options.prune else _gone(outcome),
        "deleted": deleted,
        "reports": [str(path) for path in reports],
        "seconds": round(outcome.seconds, 3),
    }
    if options.json:
        teller("end", figures)
    elif outcome.built or not options.watch:
        _tell_all(_in_words(figures, project, over))
    return SOUND if tally.passed() else FAULTS


def _gone(outcome: "BuildOutcome") -> list[str]:
    """Return the outputs of lines that the script no longer has."""
    return [path for _, record in outcome.plan.gone for path in record.outputs]


def _in_words(
    figures: Mapping[str, Any], project: "ProjectBuild", over: list[Any]
) -> Iterator[str]:
    yield from map(str, project.unsound.values())
    told = f"{count(figures['built'], 'line')} built in {figures['seconds']:.1f} s"
    yield f"{told}, {figures['current']} up to date, {figures['failed']} failed"
    for one in over:
        line = one.line
        worst = ", ".join(f"{figure.name} {figure.value:.3g}" for figure in one.failed)
        yield f"{line.place}: {line.name}, {line.language} on {line.character}: {worst}"
    if figures["over_limits"]:
        yield f"{count(figures['over_limits'], 'line')} past a limit of the project"
    if figures["doubted"]:
        told = f"{count(figures['doubted'], 'line')} past a limit of the face"
        yield f"{told}; state `limits` in the project to fail the build by them"
    if figures["deleted"]:
        yield f"{count(len(figures['deleted']), 'file')} deleted: {_some(figures['deleted'])}"
    yield from (f"wrote {path}" for path in figures["reports"])
    if figures["kept"]:
        yield _kept(figures["kept"])
    if figures["gone"]:
        gone = figures["gone"]
        yield (
            f"{count(len(gone), 'file')} of lines that the script no longer has: "
            f"{_some(gone)}; --prune deletes them"
        )


def _kept(paths: Any) -> str:
    told = f"{count(len(paths), 'file')} changed by hand stay as they are: {_some(paths)}"
    return f"{told}; --overwrite replaces them"


def _some(paths: Any) -> str:
    return ", ".join(paths[:3]) + (", ..." if len(paths) > 3 else "")  # noqa: PLR2004 a glance


def _tell_all(lines: Any) -> None:
    for line in lines:
        print(line, file=sys.stderr)


def _watch(options: Namespace) -> int:
    """Build whenever something changes, until it is interrupted."""
    try:
        from watchfiles import watch
    except ImportError:
        raise LipsyncError("--watch needs watchfiles: pip install 'lipsync-lang[watch]'") from None
    from lipsync_lang.packs.project import find_project

    file = find_project()
    code = _tried(options)
    folders = [
        path for path in ((file or Path.cwd()).absolute().parent, *options.path) if path.exists()
    ]
    print("watching; end it with Ctrl-C", file=sys.stderr)
    for _ in watch(*folders, watch_filter=_is_input, raise_interrupt=True):
        code = _tried(options)
    return code


def _tried(options: Namespace) -> int:
    """Build once; a fault of the project or its packs is told, and watching goes on."""
    try:
        return _once(options)
    except LipsyncError as error:
        print(f"lipsync-lang: {error}", file=sys.stderr)
        return FAULTS


def _is_input(_change: Any, path: str) -> bool:
    """Return True for a file that a build may depend on."""
    from lipsync_lang.build.records import FOLDER
    from lipsync_lang.files.temporary import SUFFIX

    return not path.endswith(SUFFIX) and FOLDER not in Path(path).parts
