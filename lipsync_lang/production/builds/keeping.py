"""Put outputs of workers in place: record them, then rename them or pack them into archives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isnan
from pathlib import Path
from typing import Any, Self

from lipsync_lang.base.files.signals import undisturbed
from lipsync_lang.base.files.writing import replace_file
from lipsync_lang.production.builds.archives import StandingOutputs, rewrite, split_archive
from lipsync_lang.production.builds.making import MadeLine
from lipsync_lang.production.builds.planned_line import BuiltLine, JudgedFigure, PlannedLine
from lipsync_lang.production.builds.planning import BuildPlan, PlannedStep
from lipsync_lang.production.builds.records import (
    Key,
    LineRecord,
    OutputRecord,
    Records,
    unpacked_figures,
    unusable,
)

MAX_WAITING_LINES = 10_000
"""Maximum number of waiting lines, at which their archives are rewritten."""


@dataclass
class OutputKeeper:
    """Keeper of a build's outputs; at its end, it deletes waiting outputs."""

    folder: Path
    records: Records
    steps: Mapping[Key, PlannedStep]
    _rows: list[tuple[Key, LineRecord]] = field(default_factory=list)
    """Records of lines whose archives are not written yet."""
    _moves: list[tuple[str, Path]] = field(default_factory=list)
    _members: dict[str, dict[str, Path]] = field(default_factory=dict)
    """Files of new members, by archive and name."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for new in self._members.values():
            for temporary in new.values():
                temporary.unlink(missing_ok=True)

    def keep(self, made: Sequence[MadeLine]) -> list[str]:
        """Record lines and put their outputs in place; return kept files of other origin."""
        kept: list[str] = []
        standing = StandingOutputs(self.folder)
        for one in made:
            step, outputs = self.steps[one.key], self.records.outputs(one.key)
            for file in one.files:
                # Again, since the plan is older: somebody may have written the file meanwhile.
                stands = standing.digest(file.path) if file.path in step.unknown else ""
                if stands not in ("", file.digest):
                    kept.append(file.path)
                    outputs[file.path] = OutputRecord(0, 0, "")
                    Path(file.temporary).unlink(missing_ok=True)
                    continue
                before = outputs[file.path].digest if file.path in outputs else ""
                outputs[file.path] = OutputRecord(file.size, file.changed, file.digest, before)
                split = split_archive(file.path)
                if split is None:
                    self._moves.append((file.temporary, self.folder / file.path))
                else:
                    self._members.setdefault(split[0], {})[split[1]] = Path(file.temporary)
            needs = self.records.packed(one.needs)
            whole = one.record._replace(inputs=step.inputs, needs=needs, outputs=outputs)
            self._rows.append((one.key, whole))
        if not self._members or len(self._rows) >= MAX_WAITING_LINES:
            self.flush()
        return kept

    def flush(self) -> None:
        """Put the waiting outputs into their archives."""
        with undisturbed():
            # The record precedes the files: a build killed in between finds outputs that it knows
            # how to finish, and never takes its own files for edited ones.
            self.records.put(self._rows)
            for temporary, target in self._moves:
                replace_file(Path(temporary), target)
        for archive, new in self._members.items():
            rewrite(self.folder / archive, new)
            for temporary_file in new.values():
                temporary_file.unlink(missing_ok=True)
        self._rows, self._moves, self._members = [], [], {}


def prune(plan: BuildPlan, folder: Path, records: Records) -> list[str]:
    """Delete the outputs of lines that the script no longer has, and return their paths.

    Outputs that a person changed are kept, and removed from the record.
    """
    standing = StandingOutputs(folder)
    deleted = [
        path
        for _, outputs in plan.gone
        for path, written in outputs.items()
        if standing.is_within(path) and standing.digest(path) == written.digest
    ]
    standing.delete(deleted)
    records.forget(key for key, _ in plan.gone)
    return deleted


def restored(line: PlannedLine, judged: Sequence[Any], result: Sequence[Any]) -> BuiltLine:
    """Return a line from its confidence and `packed_figures`, and from `Records.result`."""
    try:
        # Records of earlier builds have no words left out.
        outcome, message, seconds, notes, *left = result
        values, limits, heads = unpacked_figures(judged[1], [judged[2]])
        # Arrays hold no None, so a missing value or limit is kept as not-a-number.
        known = ([None if isnan(n) else n for n in row[0].tolist()] for row in (values, limits))
        rows = zip(heads, *known, notes, strict=True)
        figures = [
            JudgedFigure(name, value, unit, limit, at, words, binding)
            for (name, unit, binding), value, limit, (at, words) in rows
        ]
        words = tuple(left[0]) if left else ()
        return BuiltLine(line, outcome, message, seconds, judged[0], tuple(figures), words)
    except (TypeError, ValueError):
        raise unusable() from None
