"""Judgement of captures: unsound ones are set aside, each with its reason and numbers.

Every line is compared with the curves that the performer gives to its phonemes. The limits were
chosen on lines of 2 to 3 s that the project made: four faces with other targets than the shipped
ones, another method of coarticulation, 20 ms of jitter, and noise, seen as 9 poses, as 32, and as 3
measures. Of 300 sound lines, 297 pass; 3 of 300 pass with the timings of another line, and none of
200 of noise. Offsets of 0.1 to 0.2 s are corrected; of 0.4 s, all are set aside. A clock that
is 8 % fast over such a line is set aside in 94 of 100; 4 % in 14, which is 0.1 s, and 1 % in all of
16 s. Of lines with fewer than 12 sounds, 3 of 100 sound ones are refused (30 with 3 measures), and
1 to 7 of 100 with other timings pass.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from hashlib import sha256
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.capture.capture_clock import (
    NEAR_SECONDS,
    ClockReading,
    ComparedMotion,
    best_speed,
    read_clock,
    sounds_of,
    spoken_span,
)
from lipsync_lang.capture.capture_reading import Captures
from lipsync_lang.capture.fit_file import SetAside
from lipsync_lang.errors import AnimationError, LipsyncError
from lipsync_lang.quality.fitting import some_names

if TYPE_CHECKING:
    from lipsync_lang.capture.captured_line import CapturedLine
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.pipeline.arrays import Bools

LEAST_FPS = 24.0
"""Slowest capture; slower ones miss closures of the lips."""

LEAST_COVERED = 0.8
"""Share of the speech that a capture has to cover."""

LEAST_SOUNDS = 6
"""Sounds of a line whose clock can be judged."""

STUCK_SECONDS = 0.5
"""Sounds do not last so long without any movement: then tracking was lost."""

MAX_LOST = 0.5
"""Share of the speech in which a signal may be lost; others are left out."""

UNMOVED = 1e-4
"""Range of a signal that never moves, as a share of its size."""

SHOWN_SPREAD = 0.02
"""Standard deviation of a curve that moves."""

LEAST_LIKENESS = 0.3
"""Likeness of motion and curves below which they are not of the same words."""

CHANCES, FEW_CHANCES = 3.5, 2.5
"""Standard deviations by which the likeness has to be better than chance; and for few sounds."""

FEW_SOUNDS = 12
"""Sounds below which a line is short, and chance spreads more."""

SURE_CHANCES = 5.0
"""Standard deviations beyond chance from which a line is never taken for a stray."""

LEAST_JUDGED, UNUSUAL = 4, 0.65
"""Lines from which others tell what is usual, and the share of the usual likeness below which a
line is a stray."""

CLEARLY = 0.1
"""Likeness by which one clock has to be better than another."""

LEAST_OFFSET_SECONDS = 0.08
"""Smaller offsets are how a mouth moves, not how a clock was set; they stay."""

LEAST_GAIN = 0.03
"""Likeness that a corrected offset has to gain."""

LEAST_DRIFT_SECONDS = 0.15
"""Smaller drifts over a line do no harm, and look like the delivery of the line."""

REVERSED = -0.5
"""Likeness of a signal that runs against its curve."""

OUTLYING = 6.0
"""Deviations from the median residual that make a line an outlier."""

LEAST_COMPARED = 6
"""Lines from which residuals tell an outlier; of fewer, the odd one may be the only one of its
sounds."""

LEAST_DEVIATION = 0.25
"""Least deviation of residuals, as a share of their median: lines differ by their sounds."""


def judge_captures(
    performer: "Performer",
    captures: Captures,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> Captures:
    """Set unsound captures aside, and correct the offsets of the others.

    Parameters
    ----------
    captures : as read for this performer
    progress : called with the number of lines judged, and of all

    Returns
    -------
    The sound lines, with remarks on what was corrected or left out, and all captures set aside
    """
    kept: list[tuple[CapturedLine, ClockReading | None]] = []
    aside = list(captures.set_aside)
    seen: dict[str, str] = {}
    for number, line in enumerate(captures.lines, 1):
        try:
            _check_repeated(line, seen)
            kept.append(_judged(performer, line))
        except LipsyncError as error:
            aside.append(SetAside(line=line.name, why=str(error)))
        if progress is not None:
            progress(number, len(captures.lines))
    strays = _unlike_the_others(kept)
    lines = (line for line, _ in kept if line.name not in {one.line for one in strays})
    return Captures(tuple(lines), (*aside, *strays))


def _unlike_the_others(
    kept: "list[tuple[CapturedLine, ClockReading | None]]",
) -> list[SetAside]:
    """Name lines that follow their timings far less than the others do, and hardly beyond chance.

    Of many lines, a few with the timings of another pass the test of chance alone.
    """
    judged = {line.name: reading for line, reading in kept if reading is not None}
    if len(judged) < LEAST_JUDGED:
        return []
    usual = median(reading.near for reading in judged.values())
    return [
        SetAside(
            line=name,
            why=f"its motion hardly follows its timings (likeness {one.near:.2f}, {usual:.2f} is "
            f"usual; chance gives {one.chance:.2f} +- {one.spread:.2f}); are they of another line?",
        )
        for name, one in judged.items()
        if one.near < UNUSUAL * usual and one.near < one.chance + SURE_CHANCES * one.spread
    ]


def _check_repeated(line: "CapturedLine", seen: dict[str, str]) -> None:
    """Refuse a line with the motion of an earlier one."""
    told = repr((line.signals, line.values.shape)).encode()
    digest = sha256(told + np.round(line.values, 3).tobytes()).hexdigest()
    if digest in seen:
        raise AnimationError(f"its motion is that of '{seen[digest]}', value by value")
    seen[digest] = line.name


def _judged(
    performer: "Performer", line: "CapturedLine"
) -> "tuple[CapturedLine, ClockReading | None]":
    """Return a sound line, corrected, with its clock; raise an error for an unsound one."""
    _check_rate(line)
    _check_covered(performer, line)
    line = _without_stuck(performer, line)
    line = _moving(performer, line)
    count = len(sounds_of(performer, line.schedule))
    if count < LEAST_SOUNDS:
        return _remarked(line, f"has {count} sounds, too few to judge its clock"), None
    reading, motion = read_clock(performer, line)
    _check_words(reading, motion, FEW_CHANCES if count < FEW_SOUNDS else CHANCES)
    _check_clock(reading)
    return _forwards(_in_time(line, reading), motion), reading


def _remarked(line: "CapturedLine", told: str) -> "CapturedLine":
    return replace(line, remarks=(*line.remarks, f"{line.name}: {told}"))


def _check_rate(line: "CapturedLine") -> None:
    fps = 1 / float(np.median(np.diff(line.times)))
    if fps < LEAST_FPS * 0.99:
        raise AnimationError(
            f"has {fps:.3g} frames per second; closures of the lips need {LEAST_FPS:g}"
        )


def _check_covered(performer: "Performer", line: "CapturedLine") -> None:
    start, end = spoken_span(performer, line.schedule)
    first, last = float(line.times[0]), float(line.times[-1])
    covered = (min(end, last) - max(start, first)) / (end - start)
    if covered < LEAST_COVERED:
        raise AnimationError(
            f"the capture lasts from {first:.2f} to {last:.2f} s, but the speech from {start:.2f} "
            f"to {end:.2f} s; are these the timings of another line?"
        )


def _speech(performer: "Performer", line: "CapturedLine") -> "Bools":
    """Return True for the samples within sounds: (T,)."""
    places = sounds_of(performer, line.schedule)
    at = np.searchsorted(line.schedule.times, line.times, side="right") - 1
    return np.isin(at, places)


def _without_stuck(performer: "Performer", line: "CapturedLine") -> "CapturedLine":
    """Take samples for lost where all signals stand still while sounds are spoken."""
    speech = _speech(performer, line)
    same = np.append(False, (np.diff(line.values, axis=0) == 0).all(axis=1)) & speech
    edges = np.flatnonzero(np.diff(np.concatenate(([0], same, [0]))))
    values = line.values.copy()
    fps = 1 / float(np.median(np.diff(line.times)))
    lost = 0
    for first, stop in edges.reshape(-1, 2):
        if stop - first >= STUCK_SECONDS * fps:
            values[first:stop] = np.nan
            lost += int(stop - first)
    if lost > MAX_LOST * speech.sum():
        raise AnimationError(
            f"nothing moves in {lost / fps:.1f} of {speech.sum() / fps:.1f} s of speech"
        )
    if not lost:
        return line
    told = f"nothing moves in {lost / fps:.1f} s of speech, which are left out"
    return _remarked(replace(line, values=values), told)


def _moving(performer: "Performer", line: "CapturedLine") -> "CapturedLine":
    """Leave out signals that are lost, or stand still while their curves move."""
    speech = _speech(performer, line)
    spoken = line.values[speech]
    known = np.isfinite(spoken)
    lost = known.mean(axis=0) < 1 - MAX_LOST if len(spoken) else np.ones(len(line.signals), bool)
    shown = performer.perform(line.schedule, fps=LEAST_FPS, intensity=None).weights @ line.gains.T
    high = np.where(known, spoken, -np.inf).max(axis=0, initial=-np.inf)
    low = np.where(known, spoken, np.inf).min(axis=0, initial=np.inf)
    size = np.maximum(np.maximum(np.abs(high), np.abs(low)), 1e-6)
    still = ~lost & (high <= low + UNMOVED * size)
    frozen = still & (shown.std(axis=0) > SHOWN_SPREAD)
    if (lost | still).all():
        which = "lost" if lost.all() else "without any motion"
        raise AnimationError(f"all signals are {which} during the speech")
    line = _named(line, lost, "lost in most of the speech")
    line = _named(line, frozen, "frozen")
    kept = ~(lost | frozen)
    return replace(
        line,
        signals=tuple(np.array(line.signals)[kept].tolist()),
        values=line.values[:, kept],
        gains=line.gains[kept],
    )


def _named(line: "CapturedLine", which: "Bools", what: str) -> "CapturedLine":
    """Return a line with a remark on signals that will be left out."""
    if not which.any():
        return line
    names = some_names(np.array(line.signals)[which].tolist())
    return _remarked(line, f"signals that are {what}, and left out: {names}")


def _check_words(reading: ClockReading, motion: ComparedMotion, chances: float) -> None:
    """Refuse motion that is not of these words, or only at an absurd offset or speed."""
    needed = max(LEAST_LIKENESS, reading.chance + chances * reading.spread)
    best = max(reading.near, reading.drifting)
    chance = f"chance gives {reading.chance:.2f} +- {reading.spread:.2f}"
    if reading.far > max(needed, reading.near + CLEARLY):
        late = f"{abs(reading.far_offset):.2f} s {'late' if reading.far_offset > 0 else 'early'}"
        raise AnimationError(
            f"its motion comes {late} (likeness {reading.far:.2f} there, {best:.2f} within "
            f"{NEAR_SECONDS:g} s; {chance}); state where it starts in a list of captures"
        )
    if best >= needed:
        return
    likeness, speed = best_speed(motion)
    if likeness > max(needed, best + CLEARLY):
        raise AnimationError(
            f"its frame rate lies: the motion fits at {speed:.3g} times its speed (likeness "
            f"{likeness:.2f} there, {best:.2f} as it is; {chance})"
        )
    raise AnimationError(
        f"its motion does not follow its timings (likeness {best:.2f}, hardly better than "
        f"chance; {chance}); are they of another line?"
    )


def _check_clock(reading: ClockReading) -> None:
    """Refuse a clock that drifts, or whose offset is not well determined."""
    if abs(reading.drift) >= LEAST_DRIFT_SECONDS and reading.drifting > reading.near + LEAST_GAIN:
        how = "loses" if reading.drift > 0 else "gains"
        raise AnimationError(
            f"its clock drifts: it {how} {abs(reading.drift):.2f} s over the speech (likeness "
            f"{reading.drifting:.2f} with that drift, {reading.near:.2f} without)"
        )
    if _is_offset(reading) and reading.near < reading.rival + CLEARLY:
        raise AnimationError(
            f"its offset is uncertain: {reading.offset:+.2f} s has likeness {reading.near:.2f}, "
            f"another {reading.rival:.2f}"
        )


def _is_offset(reading: ClockReading) -> bool:
    """Tell an offset of the clock from how a mouth moves."""
    large = abs(reading.offset) >= LEAST_OFFSET_SECONDS
    return large and reading.near > reading.likeness + LEAST_GAIN


def _in_time(line: "CapturedLine", reading: ClockReading) -> "CapturedLine":
    """Correct the offset of a line."""
    if not _is_offset(reading):
        return line
    told = (
        f"its motion comes {abs(reading.offset):.2f} s {'late' if reading.offset > 0 else 'early'} "
        f"and is moved (likeness {reading.near:.2f}, {reading.likeness:.2f} before)"
    )
    return _remarked(replace(line, times=line.times - reading.offset), told)


def _forwards(line: "CapturedLine", motion: ComparedMotion) -> "CapturedLine":
    """Leave out signals of sensors that run against their curves: their sign is wrong."""
    if not line.free:
        return line
    each = motion.signals()
    wrong = each < REVERSED
    if not wrong.any() or wrong.all():
        return line
    names = np.array(line.signals)
    told = ", ".join(f"{n} (r {r:.2f})" for n, r in zip(names[wrong], each[wrong], strict=True))
    kept = ~wrong
    line = _remarked(line, f"signals that run against their curves, and are left out: {told}")
    return replace(
        line, signals=tuple(names[kept].tolist()), values=line.values[:, kept],
        gains=line.gains[kept],
    )  # fmt: skip


def outlying_lines(residuals: Mapping[str, float]) -> tuple[SetAside, ...]:
    """Name the lines whose residual is far above the others': misaligned, or spoken differently.

    Parameters
    ----------
    residuals : RMS difference after a fit, by line
    """
    if len(residuals) < LEAST_COMPARED:
        return ()
    middle = median(residuals.values())
    usual = 1.4826 * median(abs(one - middle) for one in residuals.values())
    limit = middle + OUTLYING * max(usual, LEAST_DEVIATION * middle)
    why = "after the fit its error is {:.3f}, and {:.3f} is usual; check its timings"
    return tuple(
        SetAside(line=name, why=why.format(one, middle))
        for name, one in residuals.items()
        if one > limit
    )
