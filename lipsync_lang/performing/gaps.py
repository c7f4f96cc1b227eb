"""Gaps: bigrams of a line for which its character has no curves."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import PackError, count, shortlist
from lipsync_lang.performing.played_pair import PlayedPair
from lipsync_lang.pipeline.track import lay_track

if TYPE_CHECKING:
    from lipsync_lang.performing.label_sounds import LabelSounds
    from lipsync_lang.schedules.schedule import Schedule

MAX_SHOWN_GAPS = 12
"""Bigrams in a message."""


def without_gaps(pair: PlayedPair, schedule: "Schedule", sounds: "LabelSounds") -> "Schedule":
    """Return a schedule whose bigrams have curves, or with a remark on those at rest.

    Only the line's own bigrams count: a set drawn for one sentence says it (paper, 5.3).

    Raises
    ------
    PackError
        Some have none, and gaps are errors.
    """
    compiled = pair.compiled
    if not compiled.report.gaps:
        return schedule
    track = lay_track(*sounds[:3], pair.tables(()), pair.motion)
    silent = track.ids == compiled.tables.silence
    # all gaps share the row of rest, so that the phonemes tell them apart
    at = (~(silent[1:] | silent[:-1]) & (track.rows == 0)).nonzero()[0]
    names = [compiled.phonemes[one] for one in track.ids.tolist()]
    parents = [compiled.shades.get(name, name) for name in names]
    missing = list(dict.fromkeys(f"{parents[n]}-{parents[n + 1]}" for n in at.tolist()))
    if not missing:
        return schedule
    if pair.gaps == "error":
        raise gap_error(pair, missing, "this line")
    told = f"{count(len(missing), 'bigram')} without curves at rest: {', '.join(missing)}"
    return replace(schedule, remarks=(*schedule.remarks, told))


def refuse_gaps(pair: PlayedPair) -> None:
    """Raise PackError for a pair with gaps, if they are errors and no line is known yet."""
    missing = pair.compiled.report.gaps
    if missing and pair.gaps == "error":
        raise gap_error(pair, missing, pair.compiled.report.language)


def gap_error(pair: PlayedPair, missing: Sequence[str], of: str) -> PackError:
    """Return the error that names bigrams without curves."""
    report = pair.compiled.report
    return PackError(
        f"{report.character} has no curves for {count(len(missing), 'bigram')} of {of}: "
        f"{shortlist(missing, MAX_SHOWN_GAPS)}. Draw them, give {report.poseset} targets for their "
        "phonemes, or perform gaps as rest (`gaps='rest'`)"
    )
