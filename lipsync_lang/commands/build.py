"""The command that builds a whole project, once or whenever an input of it changes."""

import json
import sys
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import replace
from functools import partial
from itertools import chain, islice
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from lipsync_lang.base.errors import LipsyncError, count, shortlist
from lipsync_lang.base.extras import needing
from lipsync_lang.base.terminal import progress, wipe
from lipsync_lang.commands.output import FAULTS, SOUND, as_options, tell_all
from lipsync_lang.commands.registry import handler
from lipsync_lang.packs.project import find_project, load_project

if TYPE_CHECKING:
    from lipsync_lang.packs.yaml.faults import Fault
    from lipsync_lang.production.builds.build_run import BuildOutcome
    from lipsync_lang.production.builds.planning import BuildPlan
    from lipsync_lang.production.builds.project_build import ProjectBuild


WAKE_MILLISECONDS = 500
"""Longest wait for a change before the watcher looks at signals; the first one comes before the
first build, so that nothing that is saved during it is missed."""

MAX_NAMED = 3
"""Maximum number of reasons or paths in a line."""

SHOWN_LINES = 20
"""Maximum number of lines of one kind in a list."""

SHOWN_FAILURES = 100
"""Maximum number of failed lines to report at once; a fault of all lines would fill screens."""

LOG_SECONDS = 10.0
"""Pause between two lines of progress in a log."""


class StandingRemarks:
    """Prints each remark once while it holds, since every build repeats it."""

    def __init__(self) -> None:
        self._before: dict[str | Fault, None] = {}
        self.now: dict[str | Fault, None] = {}

    def begin(self) -> None:
        """Begin another build."""
        self._before, self.now = self.now, {}

    def __call__(self, text: "str | Fault") -> None:
        """Print a remark, unless the build before printed it."""
        if text not in self._before | self.now:
            print(text, file=sys.stderr)
        self.now[text] = None

    @property
    def changed(self) -> bool:
        """True if this build has other remarks than the one before."""
        return self.now != self._before


class MadeByBuilds:
    """The files that builds of a project write, which are not a reason for another build."""

    _files: frozenset[str] = frozenset()
    _folders: tuple[str, ...] = ()

    def learn(self, project: "ProjectBuild", reports: Iterable[Path]) -> None:
        """Read the current files of a project."""
        from lipsync_lang.production.builds.archives import split_archive
        from lipsync_lang.production.builds.unchanged import pages_folder

        outputs = (path for line in project.lines for _, path in line.outputs)
        made = (project.folder / (split_archive(path) or (path,))[0] for path in outputs)
        self._files = frozenset(str(path.absolute()) for path in (*reports, *made))
        self._folders = tuple(f"{pages_folder(path.absolute())}" for path in reports)

    def has(self, path: str) -> bool:
        """Return True for a file that builds write."""
        from lipsync_lang.base.files.temporary import SUFFIX
        from lipsync_lang.production.builds.faces import FACE_SUFFIX
        from lipsync_lang.production.builds.unchanged import FOLDER

        at = Path(path)
        return (
            path in self._files
            or path.endswith((SUFFIX, FACE_SUFFIX))
            or FOLDER in at.parts
            or any(at.is_relative_to(folder) for folder in self._folders)
        )


def watch_project(options: Namespace, build: Callable[[StandingRemarks, MadeByBuilds], int]) -> int:
    """Build at once and whenever an input changes, until Ctrl-C.

    A fault of the project or its packs is told, and watching goes on.
    """
    with needing(LipsyncError, "--watch needs watchfiles:", "watch"):
        from watchfiles import Change, DefaultFilter, watch
    remarks, made, usual = StandingRemarks(), MadeByBuilds(), DefaultFilter()

    def is_input(change: Change, path: str) -> bool:
        if not usual(change, path):
            return False
        # A deleted output must be made again, so its deletion counts as an input.
        return change == Change.deleted or not made.has(path)

    def tried() -> None:
        remarks.begin()
        try:
            build(remarks, made)
        except (LipsyncError, OSError) as error:
            remarks(f"lipsync-lang: {error}")

    changes: Iterable[Any] = watch(
        *_folders(options),
        watch_filter=is_input,
        raise_interrupt=True,
        yield_on_timeout=True,
        rust_timeout=WAKE_MILLISECONDS,
    )
    told = False
    # The first item comes without a change: by then the watcher runs, so nothing is missed.
    for number, found in enumerate(changes):
        if number == 0 or found:
            tried()
        if not told:
            print("watching; end it with Ctrl-C", file=sys.stderr, flush=True)
        told = True
    return SOUND


def _folders(options: Namespace) -> list[Path]:
    """Return the folders with the inputs of the current project."""
    file = find_project()
    folder = (file or Path.cwd() / "none").absolute().parent
    # Without a project, the folder is watched all the same: it may get one.
    found = [folder, *options.path]
    if file is not None:
        with suppress(LipsyncError):  # the first build tells it
            found += [folder / path for path in load_project(file).model.paths]
    return [path for path in found if path.exists()]


@handler("build", "make all lines of a script, and then only the changed ones", "build --dry-run")
def build(options: Namespace) -> int:
    """Make the lines that changed since the last build, and report on all lines."""
    if options.watch:
        return watch_project(options, partial(_once, options))
    from lipsync_lang.production.builds.unchanged import answer

    file, part = find_project(), options.shard.replace("/", "-of-") if options.shard else ""
    said = None if file is None else answer(file.absolute().parent, part, options)
    if said is None:
        return _once(options, StandingRemarks(), MadeByBuilds())
    tell_all([*said["remarks"], *said["words"]])
    if options.json:
        BuildTeller(as_events=True)("end", said["figures"])
    return SOUND if said["passed"] else FAULTS


def _once(options: Namespace, remarks: StandingRemarks, made: MadeByBuilds) -> int:
    from lipsync_lang.production.builds.unchanged import BuildLog

    log = BuildLog((find_project() or Path("none")).absolute().parent)
    from lipsync_lang.production.builds.build_run import locked, make
    from lipsync_lang.production.builds.faces import write_faces
    from lipsync_lang.production.builds.keeping import prune
    from lipsync_lang.production.builds.records import Records

    teller = BuildTeller(as_events=options.json)
    teller.begin("reading the script")
    project = _opened(options, remarks)
    shard = project.selection.shard
    part = shard.name if shard else ""
    # Shards build at the same time, and would overwrite one report.
    stated = [shard.named(path) if shard else path for path in project.project.reports]
    reports = options.reports or [project.folder / path for path in stated]
    if options.watch:
        made.learn(project, reports)
    # A dry run writes nothing, and may look at a project while it is built.
    lock = nullcontext() if options.dry_run else locked(project.folder, teller, part)
    with lock:
        with Records.open(project.folder, write=not options.dry_run, part=part) as records:
            teller.begin(f"comparing {len(project.lines):,} lines with the last build")
            plan = project.plan(records, force=options.force, overwrite=options.overwrite)
            log.listens = not plan.stale
            if options.dry_run:
                return _listed(plan, project, as_events=options.json)
            if project.settings.face_once:
                write_faces(project.folder, [step.line for step in plan.steps], project.pairs)
            outcome = make(
                plan, replace(project.maker, reuse=not options.force), project.pairs, records,
                workers=options.workers, scheduler=options.scheduler, tell=teller,
            )  # fmt: skip
            deleted = prune(plan, project.folder, records) if options.prune else []
            wipe()
            figures, over, passed = _report(options, project, outcome, reports, deleted)
            words = [] if options.json else [*_in_words(figures, over)]
        if not (plan.stale or deleted or project.unsound):
            told = list(map(str, remarks.now))
            said = {"figures": figures, "words": words, "passed": passed, "remarks": told}
            files = plan.files(project.folder)
            log.keep(records.path.parent, options, said=said, files=files, reports=reports)
    if options.json:
        teller("end", figures)
    elif outcome.built or remarks.changed or not options.watch:
        tell_all(words)
    return SOUND if passed else FAULTS


def _opened(options: Namespace, remarks: StandingRemarks) -> "ProjectBuild":
    """Open the project for the lines that the options select, and tell its faults."""
    from lipsync_lang.production.builds.project_build import ProjectBuild, Selection, Shard

    shard = Shard.parse(options.shard) if options.shard else None
    if shard and options.scheduler:
        raise LipsyncError("--shard and --scheduler both spread the work; give one of them")
    chosen = Selection(
        tuple(options.only), tuple(options.languages), tuple(options.characters), shard
    )
    project = ProjectBuild.open(
        paths=options.path, selection=chosen, tts=options.tts, remark=remarks, adapt=True
    )
    wipe()
    for fault in project.unsound.values():
        remarks(str(fault))
    return project


class BuildTeller:
    """Receiver of a build's events: JSON lines, or progress and messages for people."""

    def __init__(self, *, as_events: bool) -> None:
        self.as_events = as_events
        self._told = monotonic()
        self._failures = 0

    def begin(self, text: str) -> None:
        """Show the work before the first line, which takes a while for a million lines."""
        if not self.as_events:
            progress(text)

    def __call__(self, name: str, values: Mapping[str, Any]) -> None:
        """Report an event."""
        if self.as_events:
            print(json.dumps({"event": name, **values}), flush=True)
        elif name == "progress":
            done, of = values["done"], values["of"]
            # The first lines may be done before the clock has moved.
            rate = done / max(values["seconds"], 1e-3)
            left = _clock((of - done) / rate if rate else 0)
            told = f"{done:,} of {of:,} lines, {rate:,.0f} a second, {left} left"
            # A terminal shows one line that changes; a log would hold thousands of them.
            if sys.stderr.isatty():
                progress(told)
            elif monotonic() - self._told > LOG_SECONDS:
                self._told = monotonic()
                print(told, file=sys.stderr, flush=True)
        elif name == "waiting":
            print("another build of this project is running; waiting for it", file=sys.stderr)
        elif values.get("outcome") == "failed":
            self._failures += 1
            if self._failures <= SHOWN_FAILURES:
                wipe()
                print(values["message"], file=sys.stderr)
            elif self._failures == SHOWN_FAILURES + 1:
                print("more lines fail; a report or --json names them all", file=sys.stderr)


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
    wipe()
    stale = plan.stale
    for step in stale:
        line = step.line
        if as_events:
            named = {"language": line.language, "character": line.character, "name": line.name}
            print(json.dumps({"event": "stale", **named, "reasons": list(step.reasons)}))
        else:
            reasons = shortlist(step.reasons, MAX_NAMED)
            print(f"{line.language} {line.character} {line.name}: {reasons}")
    told = f"{count(len(stale), 'line')} of {len(plan.steps)} would be made"
    tell_all([f"{told}; {_kept(plan.kept)}" if plan.kept else told])
    return FAULTS if project.unsound else SOUND


def _report(
    options: Namespace,
    project: "ProjectBuild",
    outcome: "BuildOutcome",
    reports: Sequence[Path],
    deleted: list[str],
) -> tuple[dict[str, Any], list[Any], bool]:
    """Write the reports; return the figures, the lines past a limit, and if all passed."""
    from lipsync_lang.production.builds.build_tally import BuildTally, CountedLine

    refused = [*map(CountedLine.of, project.refused())]
    tally = BuildTally(chain(outcome.lines(), refused))
    if reports:
        from lipsync_lang.production.builds.build_reports import report

        report(project, outcome, chain(outcome.lines(), refused), tally, reports)
    over = [*islice(tally.past_limits, SHOWN_LINES)]
    gone = [path for _, outputs in outcome.plan.gone for path in outputs]
    figures = {
        "lines": len(project.lines),
        "built": sum(one.verdict != "failed" for one in outcome.built.values()),
        "current": len(outcome.plan.steps) - len(outcome.plan.stale),
        "failed": tally.failed,
        "over_limits": tally.over,
        "doubted": tally.doubtful,
        "unsure": tally.unsure,
        "lacking": tally.lacking,
        "remarks": list(map(as_options, outcome.remarks)),
        "kept": outcome.kept,
        "gone": [] if options.prune else gone,
        "deleted": deleted,
        "reports": [str(path) for path in reports],
        "seconds": round(outcome.seconds, 3),
    }
    return figures, over, tally.passed()


COUNTED = {
    "over_limits": "line past a limit of the project",
    "unsure": "recording may not hold the text: listen first",
    "lacking": "line with words left out; a report names them, and asterisks bring one back",
    "doubted": "line doubtful: past a recommended limit of the face, or unlike the recording; "
    "`limits` in the project make them fail the build",
}
"""Words after the number of each count; the first word is counted."""


def _in_words(figures: Mapping[str, Any], over: list[Any]) -> Iterator[str]:
    told = f"{count(figures['built'], 'line')} built in {figures['seconds']:.1f} s"
    yield f"{told}, {figures['current']} up to date, {figures['failed']} failed"
    for one in over:
        line = one.line
        worst = [f"{figure.name} {figure.value:.3g}" for figure in one.failed]
        if one.unsure:
            worst.append(f"the recording may hold other words ({one.confidence:.0%})")
        yield f"{line.place}: {line.name}, {line.language} on {line.character}: {', '.join(worst)}"
    for name, counted in COUNTED.items():
        noun, _, told = counted.partition(" ")
        if figures[name]:
            yield f"{count(figures[name], noun)} {told}"
    if deleted := figures["deleted"]:
        yield f"{count(len(deleted), 'file')} deleted: {shortlist(deleted, MAX_NAMED)}"
    yield from (f"wrote {path}" for path in figures["reports"])
    yield from figures["remarks"][:SHOWN_LINES]
    if len(figures["remarks"]) > SHOWN_LINES:
        yield f"and {len(figures['remarks']) - SHOWN_LINES} more remarks; --json has all"
    if figures["kept"]:
        yield _kept(figures["kept"])
    if gone := figures["gone"]:
        told = f"{count(len(gone), 'file')} of lines that the script no longer has"
        yield f"{told}: {shortlist(gone, MAX_NAMED)}; --prune deletes them"


def _kept(paths: Any) -> str:
    told = f"{count(len(paths), 'file')} changed by hand and kept: {shortlist(paths, MAX_NAMED)}"
    return f"{told}; --overwrite replaces them"
