"""Compare the lines of a script with the record of the last build, to find stale lines."""

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from lipsync_lang.performing.performer import Performer
from lipsync_lang.production.builds.archives import StandingOutputs, split_archive
from lipsync_lang.production.builds.digests import digest, file_digest, joined
from lipsync_lang.production.builds.needs import PairNeeds, need_in_words
from lipsync_lang.production.builds.planned_line import PlannedLine, recorded_path
from lipsync_lang.production.builds.records import (
    NEED,
    Key,
    LineRecord,
    OutputRecord,
    Records,
    as_json,
    from_json,
    unusable,
)
from lipsync_lang.production.builds.unchanged import TICK_NANOSECONDS
from lipsync_lang.text.phonology.g2p.tokens import plain

Needs = Mapping[tuple[str, str], PairNeeds]
"""Needs of every pair with its current packs, by language and character."""

INPUTS = {
    "text": "its text",
    "words": "a pronunciation of its words",
    "edits": "the edits of the line",
    "outputs": "its outputs",
    "timings": "its timings",
    "audio": "its recording",
}
"""Parts of a line's inputs in words."""

FILE_INPUTS = ("timings", "audio")
"""Parts of the inputs that are files: path, size, and times of change of content and of status.

Tools that copy or restore files may set the first time; nobody sets the second.
"""

REMAKE_REASONS = {
    "missing": "is missing",
    "unfinished": "was not finished",
    "replaced": "was edited",
}
"""States of an output that make its line stale, in words."""

STANDING = ("edited", "unknown")
"""States of an output that a build must not replace."""

NO_OUTPUTS: Mapping[str, OutputRecord] = {}


@dataclass(frozen=True, slots=True)
class PlannedStep:
    """A line with the reasons to make it, in words; none if its outputs are valid."""

    line: PlannedLine
    inputs: str
    """Inputs for its record, as JSON; empty without a reason."""
    reasons: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()
    """Outputs that somebody changed since the last build, which are left alone."""
    unknown: tuple[str, ...] = ()
    """Outputs that stand where no build wrote."""
    record: LineRecord | None = None
    """Record of the last build without outputs; None with a reason."""

    @property
    def making(self) -> PlannedLine:
        """The line with the outputs that are to be written."""
        if not self.kept:
            return self.line
        outputs = tuple(one for one in self.line.outputs if one[1] not in self.kept)
        return replace(self.line, outputs=outputs)


@dataclass(frozen=True)
class BuildPlan:
    """All lines of a project, and the outputs of records without a line."""

    steps: tuple[PlannedStep, ...]
    gone: tuple[tuple[Key, Mapping[str, OutputRecord]], ...] = ()

    @property
    def stale(self) -> tuple[PlannedStep, ...]:
        """The lines to make."""
        return tuple(step for step in self.steps if step.reasons)

    @property
    def kept(self) -> tuple[str, ...]:
        """The outputs to keep, because a person changed them."""
        return tuple(path for step in self.steps for path in step.kept)

    def files(self, folder: Path) -> Iterator[str]:
        """Yield the outputs, timings and recordings of the lines."""
        home = str(folder)
        for line in (step.line for step in self.steps):
            for _, path in line.outputs:
                yield os.path.join(home, (split_archive(path) or (path,))[0])  # noqa: PTH118
            for read in filter(None, (line.timings, line.audio)):
                yield os.path.join(home, read)  # noqa: PTH118


def plan(  # noqa: PLR0913 the lines, records and options
    lines: Sequence[PlannedLine],
    folder: Path,
    records: Records,
    needs: Needs,
    *,
    force: bool = False,
    overwrite: bool = False,
) -> BuildPlan:
    """Find the lines whose outputs are not up to date.

    Parameters
    ----------
    lines : of the project, each with a key of its own
    force : make every line
    overwrite : write outputs that somebody changed, too
    """
    planner = _Planner(folder, needs, force, overwrite, StandingOutputs(folder))
    places = {line.key: at for at, line in enumerate(lines)}
    steps: list[PlannedStep | None] = [None] * len(lines)
    gone: list[tuple[Key, Mapping[str, OutputRecord]]] = []

    @lru_cache(1)  # records are in the order of their pairs
    def comparison(language: str, character: str) -> _PairComparison:
        return _PairComparison(needs[language, character], records)

    for block in records.blocks():
        gone += [(key, record.outputs) for key, record in block if key not in places]
        known = [(key, record) for key, record in block if key in places]
        for pair, some in groupby(known, lambda one: one[0][:2]):
            own = list(some)
            told = comparison(*pair).changed([record.needs for _, record in own])
            for (key, record), changed in zip(own, told, strict=True):
                at = places[key]
                steps[at] = planner.step(lines[at], record, changed)
    found = (step or planner.step(line, None, ()) for line, step in zip(lines, steps, strict=True))
    return BuildPlan(tuple(found), tuple(gone))


class _PairComparison:
    """Comparison of recorded needs with the packs of a pair; each need is computed once."""

    def __init__(self, needs: PairNeeds, records: Records) -> None:
        self._needs, self._records = needs, records
        self._now = np.zeros(len(records.names) + 1, "<u8")
        self._met = np.zeros(len(records.names) + 1, bool)
        self._told: dict[int, str] = {}

    def changed(self, recorded: Sequence[bytes]) -> Iterator[list[str]]:
        """Yield which needs of each line have changed, in words."""
        every = np.frombuffer(b"".join(recorded), NEED)
        numbers = every["number"]
        if numbers.max(initial=0) >= len(self._now):
            raise unusable()
        new = np.unique(numbers[~self._met[numbers]])
        values = [self._needs.current(self._records.name(number)) for number in new.tolist()]
        self._now[new] = np.frombuffer(b"".join(values), "<u8")
        self._met[new] = True
        other = np.flatnonzero(self._now[numbers] != every["digest"])
        found, told = numbers[other].tolist(), self._told
        # All lines share the text of a change: a stale line may have some tens of them.
        for number in {*found} - told.keys():
            told[number] = f"{need_in_words(self._records.name(number))} changed"
        words = [told[number] for number in found]
        ends = np.cumsum([len(stated) for stated in recorded]) // NEED.itemsize
        for first, last in pairwise((0, *other.searchsorted(ends).tolist())):
            yield words[first:last]


@dataclass
class _Planner:
    folder: Path
    needs: Needs
    force: bool
    overwrite: bool
    standing: StandingOutputs

    def step(
        self, line: PlannedLine, record: LineRecord | None, changed: Sequence[str]
    ) -> PlannedStep:
        inputs = line_inputs(line, self.folder, self.needs[line.language, line.character].performer)
        text = as_json(inputs)
        reasons = ["it is new"]
        kept: list[str] = []
        unknown: list[str] = []
        if record is not None:
            reasons = [*self._inputs_changed(inputs, text, record), *changed]
            if record.verdict == "failed":
                reasons.append("it failed in the last build")
        if self.force:
            reasons.append("all lines were requested")
        for _, path in line.outputs:
            written = record.outputs.get(path) if record is not None else None
            state = self._state(path, written)
            if state in STANDING:
                (kept if state == "edited" else unknown).append(path)
            elif state in REMAKE_REASONS and written is not None:
                reasons.append(f"{path} {REMAKE_REASONS[state]}")
        if line.outputs and len(kept) == len(line.outputs):
            reasons = []
        if reasons:
            return PlannedStep(line, text, tuple(reasons), tuple(kept), tuple(unknown))
        # Without what only the comparison needs: a million records are kept.
        known = record and record._replace(inputs="", contents="", needs=b"", outputs=NO_OUTPUTS)
        return PlannedStep(line, "", (), tuple(kept), tuple(unknown), known)

    def _inputs_changed(
        self, inputs: Mapping[str, Any], text: str, record: LineRecord
    ) -> Iterator[str]:
        sure = record.at - TICK_NANOSECONDS
        late = {part for part in FILE_INPUTS if part in inputs and max(inputs[part][2:]) > sure}
        if record.verdict == "failed" or (text == record.inputs and not late):
            return
        before = from_json(record.inputs)
        for part, words in INPUTS.items():
            now, then = inputs.get(part), before.get(part)
            if now == then and part not in late:
                continue
            # A file may have another time, but the content of the last build.
            if part in FILE_INPUTS and now and isinstance(then, list) and now[:1] == then[:1]:
                with suppress(OSError):
                    if file_digest(self.folder / now[0]) == from_json(record.contents).get(now[0]):
                        continue
            yield f"{words} changed"

    def _state(self, path: str, written: OutputRecord | None) -> str:
        """Return the state of an output: `sound`, or one of `REMAKE_REASONS` or `STANDING`."""
        stamp = self.standing.stamp(path)
        if stamp is None:
            return "missing"
        if written is None:
            return "replaced" if self.overwrite else "unknown"
        # The stamp spares the reading of all outputs; a stamp that differs alone is no edit, since
        # copies of a project have new times.
        if stamp == (written.size, written.changed):
            return "sound"
        found = self.standing.digest(path)
        if found == written.digest:
            return "sound"
        # A build was killed between its record and the rename: the old file is there, as noted.
        if found == written.before:
            return "unfinished"
        return "replaced" if self.overwrite else "edited"


def line_inputs(line: PlannedLine, folder: Path, performer: Performer) -> dict[str, Any]:
    """Return the inputs of a line as JSON data for its record."""
    compiled, place = performer.compiled, str(folder)
    text = plain(line.text) if compiled.words else ""
    words = {word: sounds for word, sounds in compiled.words.items() if word in text}
    edits = compiled.line_edits.get(line.name), compiled.line_deliveries.get(line.name)
    inputs: dict[str, Any] = {
        "text": joined(line.text.encode("utf-8", "surrogatepass")).hex(),
        "words": digest(words).hex() if words else "",
        "edits": digest(*edits).hex() if any(edits) else "",
        "outputs": [list(one) for one in line.outputs],
    }
    for part, path in (("timings", line.timings), ("audio", line.audio)):
        if path is not None:
            name = recorded_path(folder, path)
            try:
                stat = os.stat(os.path.join(place, name))  # noqa: PTH116, PTH118 once a line
                stamp = stat.st_size, stat.st_mtime_ns, stat.st_ctime_ns
            except OSError:
                stamp = 0, 0, 0
            inputs[part] = [name, *stamp]
    return inputs
