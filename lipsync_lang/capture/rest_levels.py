"""Rest levels: weights of a capture during silence, which are subtracted.

The poses of a pose set rest at 0. Captured shapes often rest higher, because the tracker has
another neutral face.

Conventions: times are seconds; T samples, S signals.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lipsync_lang.arrays import Floats
    from lipsync_lang.capture.captured_line import CapturedLine
    from lipsync_lang.performing.performer import Performer

AWAY_SECONDS = 0.15
"""Seconds around sounds that do not count as rest."""

ENOUGH_SECONDS = 0.5
"""Minimum seconds of rest for its level; otherwise the lowest weights of speech determine it."""

LOWEST_SHARE = 0.05
"""Quantile of the weights of speech that is the rest level if there are no pauses."""

LEAST_LEVEL, MOST_LEVEL = 0.02, 0.4
"""Range of subtracted levels; lower levels are noise, and higher ones are expressions."""


def without_rest(
    performer: "Performer", captured: "Sequence[CapturedLine]"
) -> "list[CapturedLine]":
    """Return lines with rest levels subtracted, and remarks on them.

    All lines of a speaker have the same levels. Signals without a scale are unchanged.
    """
    resting: dict[tuple[str, str], list[Floats]] = {}
    speaking: dict[tuple[str, str], list[Floats]] = {}
    read = performer.labels.read([line.schedule for line in captured]) if captured else []
    for line, sounds in zip(captured, read, strict=True):
        spoken = sounds.ids != performer.compiled.tables.silence
        starts, ends = sounds.times[:-1][spoken], sounds.times[1:][spoken]
        at = line.times[:, None]
        rest = ~((at > starts - AWAY_SECONDS) & (at < ends + AWAY_SECONDS)).any(axis=1)
        for name, values in zip(line.signals, line.values.T, strict=True):
            known = np.isfinite(values)
            resting.setdefault((line.speaker, name), []).append(values[known & rest])
            speaking.setdefault((line.speaker, name), []).append(values[known & ~rest])
    fps = max(((len(one.times) - 1) / np.ptp(one.times) for one in captured), default=1.0)
    levels = {}
    for key, parts in resting.items():
        at_rest, speech = np.concatenate(parts), np.concatenate(speaking[key])
        level = 0.0
        if len(at_rest) >= ENOUGH_SECONDS * float(fps):
            level = float(np.median(at_rest))
        elif len(speech):
            level = float(np.quantile(speech, LOWEST_SHARE))
        levels[key] = level if LEAST_LEVEL <= level <= MOST_LEVEL else 0.0
    return [line if line.free else _lowered(line, levels) for line in captured]


def _lowered(line: "CapturedLine", levels: dict[tuple[str, str], float]) -> "CapturedLine":
    own = np.array([levels[line.speaker, name] for name in line.signals])
    if not own.any():
        return line
    named = ", ".join(
        f"{name} {level:.2f}" for name, level in zip(line.signals, own, strict=True) if level
    )
    who = f" of {line.speaker}" if line.speaker else ""
    told = f"weights at rest{who} that were subtracted: {named}"
    return replace(line, values=line.values - own, remarks=(*line.remarks, told))
