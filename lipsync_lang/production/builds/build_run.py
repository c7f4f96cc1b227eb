"""Build a project: make the changed lines, record them, and put their outputs in place."""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field, replace
from functools import cache, partial
from multiprocessing import parent_process
from pathlib import Path
from shutil import copyfileobj, rmtree
from sys import intern
from time import monotonic, sleep
from typing import Any

from lipsync_lang.base.errors import LipsyncError, OutputError
from lipsync_lang.base.files.locking import claim
from lipsync_lang.base.files.temporary import sweep
from lipsync_lang.base.files.writing import atomic, cannot_write
from lipsync_lang.production.builds.build_tally import CountedLine
from lipsync_lang.production.builds.digests import file_digest
from lipsync_lang.production.builds.keeping import OutputKeeper, restored
from lipsync_lang.production.builds.making import LineBatch, LineMaker, MadeLine, parent_of
from lipsync_lang.production.builds.needs import PairNeeds
from lipsync_lang.production.builds.planned_line import BuiltLine, PlannedLine
from lipsync_lang.production.builds.planning import BuildPlan, Needs, PlannedStep
from lipsync_lang.production.builds.records import (
    RECORD_CURE,
    Key,
    LineRecord,
    Records,
    record_folder,
)
from lipsync_lang.production.builds.timing import prune_timings
from lipsync_lang.production.builds.workers import LostBatch, run_batches

MAX_BATCH_LINES = 64
"""Maximum number of lines that a worker makes before it reports."""

MIN_BATCH_LINES = 12
"""Minimum number of lines in a batch, if each worker gets one: engines start for each batch."""

MAX_BATCH_CHARACTERS = 8
"""Maximum number of characters of a line in a batch, whose tables the worker keeps."""

POOL_BATCHES_PER_WORKER = 4
"""Minimum number of batches per worker, if there are enough lines."""

MIN_SPREAD_LINES = 48
"""Number of lines to align or speak from which several processes pay."""

MIN_SPREAD_TIMED_LINES = 200
"""The same number for lines with timings, which take a hundredth of a second."""

LOCK = "build.lock"

FILE_COPIES = "copies"
"""Folder, beside the record of builds, of models and lexicons for the workers of a cluster."""

WAIT_SECONDS = 0.2
"""Pause between two attempts to lock a folder."""

Tell = Callable[[str, Mapping[str, Any]], None]
"""Receiver of events: a name and JSON values."""


@dataclass
class BuildOutcome:
    """The result of a build."""

    plan: BuildPlan
    records: Records
    built: dict[Key, LineRecord] = field(default_factory=dict)
    """Lines made by this build, by key, with their figures alone."""
    kept: list[str] = field(default_factory=list)
    """Outputs that were kept, because a person changed them."""
    remarks: dict[str, None] = field(default_factory=dict)
    """Remarks of writers on models, and on words that recordings lack, each once."""
    seconds: float = 0.0

    def lines(self) -> Iterator[CountedLine]:
        """Yield every line of the project as it stands; the record is open while they are used."""
        lacking = self.records.lacking()
        for step in self.plan.steps:
            key = step.line.key
            record = self.built.get(key, step.record)
            if record is not None:
                figures = record.confidence, record.heading, record.figures
                whole = partial(self._restored, step.line, figures)
                failed = record.verdict == "failed"
                yield CountedLine(step.line, failed, *figures, whole, key in lacking)

    def _restored(self, line: PlannedLine, figures: Sequence[Any]) -> BuiltLine:
        return restored(line, figures, self.records.result(line.key))


@contextmanager
def locked(folder: Path, tell: Tell, part: str = "") -> Iterator[None]:
    """Hold the lock of a project's builds, after other builds have released it."""
    path = record_folder(folder) / part / LOCK
    waiting = False
    try:
        while (held := claim(path)) is None:
            # A script without the guard of `__main__` starts its build again in each worker, which
            # would wait here for its own parent.
            if parent_process() is not None:
                raise LipsyncError(
                    "a worker process of this build ran its script again; start the "
                    "build below `if __name__ == '__main__':`"
                )
            if not waiting:
                tell("waiting", {"folder": str(folder)})
            waiting = True
            sleep(WAIT_SECONDS)
    except OSError as error:
        raise cannot_write(path, error, RECORD_CURE) from None
    try:
        yield
    finally:
        # The file stays: a build that waits has opened it, and would lock a file without a name.
        os.close(held)


def make(  # noqa: PLR0913 a plan, workers and callbacks
    plan: BuildPlan,
    maker: LineMaker,
    needs: Needs,
    records: Records,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Tell = lambda _name, _values: None,
) -> BuildOutcome:
    """Make the stale lines of a plan.

    Raises OutputError if the disk is full, or the folder is read-only. Everything made before
    stands.

    Parameters
    ----------
    workers : processes at most; None for one per processor. Few lines are made in this process
    scheduler : address of a Dask scheduler whose workers make the lines
    tell : receives `line` and `progress` events
    """
    begun = monotonic()
    stale = plan.stale
    outcome = BuildOutcome(plan, records, kept=list(plan.kept))
    if not stale:
        return outcome
    if scheduler is None:
        workers = (workers or os.cpu_count()) if _pays(stale, maker, needs) else 1
    if scheduler is not None:
        # Only pairs with work: the copies of models take space in the project's folder.
        pairs = {(step.line.language, step.line.character) for step in stale}
        needs = with_seen_files({pair: needs[pair] for pair in pairs}, maker.folder)
    _sweep(maker.folder, stale)
    keeper = OutputKeeper(maker.folder, records, {step.line.key: step for step in stale})
    done = 0

    @cache  # one object for the same characters, which each worker receives once
    def cast(language: str, characters: tuple[str, ...]) -> dict[str, PairNeeds]:
        return {one: needs[language, one] for one in characters}

    running = run_batches(
        maker,
        _batches(stale, workers or POOL_BATCHES_PER_WORKER),
        shared=lambda batch: cast(batch.language, batch.characters),
        workers=workers,
        scheduler=scheduler,
        folder=maker.folder,
    )
    with ExitStack() as stack:
        # Workers leave files that were not put in place, at the end or after an error.
        stack.callback(_sweep, maker.folder, stale, ended=maker.owner)
        stack.callback(rmtree, record_folder(maker.folder) / FILE_COPIES, ignore_errors=True)
        stack.enter_context(closing(running))
        stack.enter_context(keeper)
        for found in running:
            results: Sequence[MadeLine]
            if isinstance(found, LostBatch):
                results = [
                    MadeLine.of(BuiltLine(line, "failed", f"{line.place}: {found.message}"))
                    for line in found.batch.lines
                ]
            else:
                results = found
            outcome.kept += keeper.keep(results)
            for one in results:
                # One heading for all lines of a pair, and no text that only the record needs.
                heading = intern(one.record.heading)
                small = one.record._replace(heading=heading, contents="", result="")
                outcome.built[one.key] = small
                outcome.remarks |= dict.fromkeys(one.remarks)
                _tell_line(tell, one, keeper.steps[one.key])
            done += len(results)
            seconds = monotonic() - begun
            tell("progress", {"done": done, "of": len(stale), "seconds": round(seconds, 3)})
            # After the results are kept, so that lines which fitted onto the disk are recorded.
            _refuse_full(results, done, len(stale))
        keeper.flush()
    prune_timings()
    outcome.seconds = monotonic() - begun
    return outcome


def _pays(stale: Sequence[PlannedStep], maker: LineMaker, needs: Needs) -> bool:
    """Return True if several processes pay: not for few lines, nor for timings in the cache."""
    if len(stale) >= MIN_SPREAD_TIMED_LINES:
        return True
    untimed = [step.line for step in stale if step.line.timings is None]
    if len(untimed) < MIN_SPREAD_LINES:
        return False
    caches = {pair: maker.cache(one) for pair, one in needs.items()}
    fresh = sum(not caches[line.language, line.character].has(line) for line in untimed)
    return fresh >= MIN_SPREAD_LINES


def with_seen_files(needs: Needs, folder: Path) -> Needs:
    """Return needs whose models and lexicons lie in the project's folder, as every machine sees."""

    def seen(path: str | None) -> str | None:
        file = Path(path or "")
        if not file.is_file() or file.resolve().is_relative_to(folder.resolve()):
            return path
        copy = record_folder(folder) / FILE_COPIES / f"{file_digest(file)}{file.suffix}"
        if not copy.exists():
            copy.parent.mkdir(exist_ok=True)
            with atomic(copy) as stream, file.open("rb") as content:
                copyfileobj(content, stream)
        return str(copy)

    found = {}
    for pair, one in needs.items():
        compiled = one.performer.compiled
        settings = compiled.manner["settings"]
        manner = compiled.manner | {"settings": settings | {"file": seen(settings["file"])}}
        compiled = replace(compiled, model=seen(compiled.model), manner=manner)
        found[pair] = PairNeeds(replace(one.performer, compiled=compiled), one.settings)
    return found


def _refuse_full(results: Sequence[MadeLine], done: int, of: int) -> None:
    """End a build whose disk refuses every line."""
    fatal = next((one for one in results if one.fatal), None)
    if fatal is not None:
        raise OutputError(
            f"{fatal.message}; {done} of {of} lines were tried, and finished lines are "
            "recorded: build again then"
        )


def _tell_line(tell: Tell, made: MadeLine, step: PlannedStep) -> None:
    line = step.line
    tell(
        "line",
        {
            "language": line.language,
            "character": line.character,
            "name": line.name,
            "outcome": "failed" if made.record.verdict == "failed" else "built",
            "message": made.message,
            "reasons": list(step.reasons),
            "failed": list(made.failed),
            "left_out": list(made.left_out),
            "place": line.place,
        },
    )


def _batches(stale: Sequence[PlannedStep], workers: int) -> Iterator[LineBatch]:
    """Yield the lines in batches of one language; a line's characters are in one batch."""
    # Small batches keep the last worker from working alone, but each starts engines again.
    share = max(len(stale) // (workers * POOL_BATCHES_PER_WORKER), MIN_BATCH_LINES)
    size = min(MAX_BATCH_LINES, share, max(1, len(stale) // workers))
    takes: dict[tuple[str, str], list[PlannedLine]] = {}
    for step in stale:
        takes.setdefault((step.line.language, step.line.name), []).append(step.making)
    casts: dict[tuple[str, tuple[str, ...]], list[PlannedLine]] = {}
    for (language, _), lines in takes.items():
        for first in range(0, len(lines), MAX_BATCH_CHARACTERS):
            some = lines[first : first + MAX_BATCH_CHARACTERS]
            casts.setdefault((language, tuple(one.character for one in some)), []).extend(some)
    for (language, characters), lines in casts.items():
        stride = max(1, size // len(characters)) * len(characters)
        for first in range(0, len(lines), stride):
            yield LineBatch(language, characters, tuple(lines[first : first + stride]))


def _sweep(folder: Path, stale: Iterable[PlannedStep], ended: str = "") -> None:
    """Delete temporary files of killed builds in the folders of outputs."""
    paths = (path for step in stale for _, path in step.line.outputs)
    for parent in {parent_of(folder, path) for path in paths}:
        sweep(parent, again=True, ended=ended)
