"""Judgement of captures, which sets unsound ones aside with reasons and numbers.

Every line is compared with the curves that the performer gives to its phonemes. The limits were
tried on lines of 2 to 3 s that the project made: faces with other ranges than the shipped one,
another method of coarticulation, and noise, seen as poses and as 3 measures. 180 of 180 sound lines
pass, 4 of 180 with the timings of another line that were stretched to the same length, and none of
120 of noise. Offsets of 0.15 s are corrected in all of 120. A clock that is 8 % fast over such a
line is set aside in all of 120; 4 %, which is 0.1 s, in 10. 100 of 100 sound lines with fewer than
12 sounds pass, and 5 with other timings.

Real lips follow the curves less (likeness 0.5 to 0.85). The limits were chosen on 144 takes of film
with 2 s of speech. Of 46 others, 43 pass by the gap of the lips alone on facefx, 39 by gap and
width on arkit, and 29 as 52 channels. With the timings of others that share one word of six at
most, 4, 3 and 1 of 92 pass; of neighbours that share up to four words, 7, 9 and 4.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from hashlib import sha256
from statistics import median

import numpy as np

from lipsync_lang import AnimationError, LipsyncError, Performer
from lipsync_lang.base.arrays import Bools
from lipsync_lang.plugins.capture.capture_clock import (
    NEAR_SECONDS,
    SEARCHED_OFFSETS_SECONDS,
    SPEEDS,
    ClockReading,
    ComparedMotion,
    read_clock,
    sounds_of,
    spoken_span,
)
from lipsync_lang.plugins.capture.capture_reading import Captures, few_names
from lipsync_lang.plugins.capture.fit_file import SetAside
from lipsync_lang.plugins.capture.fit_lines import CapturedLine

LEAST_CAPTURE_FPS = 24.0
"""Minimum frame rate; slower captures miss closures of the lips."""

LEAST_COVERED = 0.8
"""Minimum share of the speech that a capture covers."""

LEAST_CLOCK_SOUNDS = 6
"""Minimum number of sounds for a judgement of the clock."""

STUCK_SECONDS = 0.5
"""Minimum length of speech without any movement that means lost tracking."""

MAX_LOST = 0.5
"""Maximum share of the speech in which a signal is lost; other signals are left out."""

UNMOVED = 1e-4
"""Maximum range of a still signal, relative to its size."""

SHOWN_SPREAD = 0.02
"""Minimum standard deviation of a moving curve."""

LEAST_LIKENESS = 0.3
"""Minimum likeness of motion and curves of the same words."""

SURE_LIKENESS, SURE_LIKENESS_CHANCES = 0.6, 1.0
"""Likeness above which a line passes nearer to chance. Over 2 s of one measure, shuffled phonemes
that choose their offset are nearly as like."""

CHANCES, MOVED_CHANCES = 3.0, 3.5
"""Minimum distance of the likeness from chance in standard deviations, and that of a line with
another offset, drift or speed. A search among many finds a good one by chance."""

SURE_CHANCES = 5.0
"""Distance from chance in standard deviations above which a line is never set aside as a stray."""

LEAST_JUDGED, UNUSUAL = 4, 0.65
"""Minimum number of lines for a comparison of their likeness, and the share of the median likeness
below which a line is a stray."""

CLEARLY = 0.1
"""Minimum difference of likeness between two clocks."""

LEAST_OFFSET_SECONDS = 0.08
"""Minimum offset of a clock; smaller ones are normal movement and are not corrected."""

LEAST_GAIN = 0.03
"""Minimum gain in likeness of a corrected offset."""

LEAST_DRIFT_SECONDS, LEAST_DRIFT_GAIN = 0.15, 2.0
"""Minimum drift over a line, and minimum `drift_gain`: smaller ones are harmless and resemble
normal delivery."""

REVERSED = -0.5
"""Maximum likeness of an inverted signal."""

OUTLYING = 6.0
"""Minimum number of deviations of an outlier from the median residual."""

LEAST_COMPARED = 6
"""Minimum number of lines for a search for outliers; among fewer lines, an unusual line may be the
only one with its sounds."""

LEAST_DEVIATION = 0.25
"""Minimum deviation of residuals relative to their median, because lines differ in their sounds."""


def judge_captures(
    performer: Performer,
    captures: Captures,
    *,
    progress: Callable[[int, int], None] = lambda _done, _all: None,
) -> Captures:
    """Set unsound captures aside, and correct the offsets of the others.

    Returns the sound lines, with remarks on what was corrected or left out, and all captures set
    aside. `progress` is called with the numbers of judged lines and of all lines.
    """
    kept: list[tuple[CapturedLine, ClockReading | None]] = []
    aside = list(captures.set_aside)
    seen: dict[str, str] = {}
    for number, line in enumerate(captures.lines, 1):
        try:
            # Rounded values, so that a second export of one recording is found as well.
            told = repr((line.signals, line.values.shape)).encode()
            digest = sha256(told + np.round(line.values, 3).tobytes()).hexdigest()
            if digest in seen:
                raise AnimationError(
                    f"its motion is identical to that of '{seen[digest]}'; remove one"
                )
            seen[digest] = line.name
            kept.append(_judged(performer, line))
        except LipsyncError as error:
            aside.append(SetAside(line=line.name, why=str(error)))
        progress(number, len(captures.lines))
    strays = _unlike_the_others(kept)
    lines = (line for line, _ in kept if line.name not in {one.line for one in strays})
    return Captures(tuple(lines), (*aside, *strays))


def _unlike_the_others(kept: list[tuple[CapturedLine, ClockReading | None]]) -> list[SetAside]:
    """Return lines that follow their timings far less than the others, and hardly beyond chance.

    The test of chance alone accepts a few of many lines with the timings of another.
    """
    judged = {line.name: reading for line, reading in kept if reading is not None}
    if len(judged) < LEAST_JUDGED:
        return []
    usual = median(reading.near for reading in judged.values())
    return [
        SetAside(
            line=name,
            why=f"its motion hardly follows its timings (likeness {one.near:.2f}, median "
            f"{usual:.2f}; chance gives {one.chance:.2f} +- {one.spread:.2f}); check that they "
            "are of this line",
        )
        for name, one in judged.items()
        if one.near < UNUSUAL * usual and one.near < one.beyond_chance(SURE_CHANCES)
    ]


def _judged(performer: Performer, line: CapturedLine) -> tuple[CapturedLine, ClockReading | None]:
    """Return a corrected line with its clock; raise an error for an unsound line."""
    fps = 1 / float(np.median(np.diff(line.times)))
    # Film's 24 is 23.976 on video.
    if fps < LEAST_CAPTURE_FPS * 0.99:
        raise AnimationError(
            f"has {fps:.3g} frames per second, too few for closures of the lips; record at least "
            f"{LEAST_CAPTURE_FPS:g}"
        )
    start, end = spoken_span(performer, line.schedule)
    first, last = float(line.times[0]), float(line.times[-1])
    if (min(end, last) - max(start, first)) / (end - start) < LEAST_COVERED:
        raise AnimationError(
            f"the capture lasts from {first:.2f} to {last:.2f} s, but the speech lasts from "
            f"{start:.2f} to {end:.2f} s; check that the timings are of this line"
        )
    # Before the clock is read: frozen stretches would pull the likeness down.
    line = _without_stuck(performer, line)
    line = _moving(performer, line)
    count = len(sounds_of(performer, line.schedule))
    if count < LEAST_CLOCK_SOUNDS:
        return _remarked(line, f"has only {count} sounds, too few to judge its clock"), None
    reading, motion = read_clock(performer, line)
    _check_words(reading, motion)
    line = _in_time(line, reading)
    each = motion.signals()
    wrong = (each < REVERSED) & line.free
    if wrong.any() and not wrong.all():  # sensors with the wrong sign
        names = np.array(line.signals)[wrong]
        told = ", ".join(f"{n} (r {r:.2f})" for n, r in zip(names, each[wrong], strict=True))
        line = _remarked(line, f"signals left out, because they move against their curves: {told}")
        line = _selected(line, ~wrong)
    return line, reading


def _remarked(line: CapturedLine, told: str) -> CapturedLine:
    return replace(line, remarks=(*line.remarks, f"{line.name}: {told}"))


def _speech(performer: Performer, line: CapturedLine) -> Bools:
    """Return True for the samples within sounds: (T,)."""
    places = sounds_of(performer, line.schedule)
    at = np.searchsorted(line.schedule.times, line.times, side="right") - 1
    return np.isin(at, places)


def _without_stuck(performer: Performer, line: CapturedLine) -> CapturedLine:
    """Mark samples as lost if all signals stand still during speech."""
    speech = _speech(performer, line)
    # A sample is compared with the one before, which the first lacks.
    same = np.append(False, (np.diff(line.values, axis=0) == 0).all(axis=1)) & speech
    # With a 0 at both ends, starts and stops take turns.
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
    told = f"nothing moves in {lost / fps:.1f} s of speech; they are left out"
    return _remarked(replace(line, values=values), told)


def _moving(performer: Performer, line: CapturedLine) -> CapturedLine:
    """Leave out signals that are lost, and still signals whose curves move."""
    speech = _speech(performer, line)
    spoken = line.values[speech]
    known = np.isfinite(spoken)
    lost = known.mean(axis=0) < 1 - MAX_LOST if len(spoken) else np.ones(len(line.signals), bool)
    shown = (
        performer.perform(line.schedule, fps=LEAST_CAPTURE_FPS, intensity=None).weights
        @ line.gains.T
    )
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
    return _selected(line, ~(lost | frozen))


def _selected(line: CapturedLine, kept: Bools) -> CapturedLine:
    signals = tuple(np.array(line.signals)[kept].tolist())
    return replace(line, signals=signals, values=line.values[:, kept], gains=line.gains[kept])


def _named(line: CapturedLine, which: Bools, what: str) -> CapturedLine:
    """Return a line with a remark on signals that will be left out."""
    if not which.any():
        return line
    names = few_names(np.array(line.signals)[which].tolist())
    return _remarked(line, f"signals left out, because they are {what}: {names}")


def _check_words(reading: ClockReading, motion: ComparedMotion) -> None:
    """Raise an error for motion of other words, or with an implausible offset or speed."""
    needed = max(LEAST_LIKENESS, reading.beyond_chance(MOVED_CHANCES))
    drifts = _drifts(reading)
    best = max(reading.near, reading.drifting if drifts else -1.0)
    chance = f"chance gives {reading.chance:.2f} +- {reading.spread:.2f}"
    if reading.far > max(needed, reading.near + CLEARLY):
        late = f"{abs(reading.far_offset):.2f} s {'late' if reading.far_offset > 0 else 'early'}"
        raise AnimationError(
            f"its motion is {late} (likeness {reading.far:.2f} there, {best:.2f} within "
            f"{NEAR_SECONDS:g} s; {chance}); state its start in a list of captures"
        )
    enough = min(
        max(LEAST_LIKENESS, reading.beyond_chance(CHANCES)),
        max(SURE_LIKENESS, reading.beyond_chance(SURE_LIKENESS_CHANCES)),
    )
    in_time = abs(reading.offset) < LEAST_OFFSET_SECONDS
    if best >= needed or (in_time and reading.near >= enough):
        return
    searched = np.meshgrid(SEARCHED_OFFSETS_SECONDS, SPEEDS)
    offsets, speeds = (one.ravel().tolist() for one in searched)
    alike = motion.likenesses(offsets, speeds=speeds)[:, 0].tolist()
    likeness, speed = max(zip(alike, speeds, strict=True))
    if likeness > max(needed, best + CLEARLY):
        raise AnimationError(
            f"its frame rate is wrong: the motion fits at {speed:.3g} times its speed (likeness "
            f"{likeness:.2f} there, {best:.2f} now; {chance}); export it at the right rate"
        )
    raise AnimationError(
        f"its motion does not follow its timings (likeness {best:.2f}, hardly better than "
        f"chance; {chance}); check that they are of this line"
    )


def _drifts(reading: ClockReading) -> bool:
    return abs(reading.drift) >= LEAST_DRIFT_SECONDS and reading.drift_gain > LEAST_DRIFT_GAIN


def _in_time(line: CapturedLine, reading: ClockReading) -> CapturedLine:
    """Correct the offset of a line; raise an error for a drift or an uncertain offset."""
    if _drifts(reading):
        how = "loses" if reading.drift > 0 else "gains"
        raise AnimationError(
            f"its clock drifts: it {how} {abs(reading.drift):.2f} s over the speech (likeness "
            f"{reading.drifting:.2f} with that drift, {reading.near:.2f} without); "
            "correct its times"
        )
    large = abs(reading.offset) >= LEAST_OFFSET_SECONDS
    if not large or reading.near <= reading.likeness + LEAST_GAIN:  # normal movement
        return line
    if reading.near < reading.rival + CLEARLY:
        raise AnimationError(
            f"its offset is uncertain: {reading.offset:+.2f} s has likeness {reading.near:.2f}, "
            f"another {reading.rival:.2f}; state its start in a list of captures"
        )
    told = (
        f"its motion is {abs(reading.offset):.2f} s {'late' if reading.offset > 0 else 'early'} "
        f"and was shifted (likeness {reading.near:.2f}, {reading.likeness:.2f} before)"
    )
    return _remarked(replace(line, times=line.times - reading.offset), told)


def outlying_lines(residuals: Mapping[str, float]) -> tuple[SetAside, ...]:
    """Return misaligned or otherwise spoken lines, by their RMS differences after a fit."""
    if len(residuals) < LEAST_COMPARED:
        return ()
    middle = median(residuals.values())
    # The median deviation of a normal distribution, as its standard deviation.
    usual = 1.4826 * median(abs(one - middle) for one in residuals.values())
    limit = middle + OUTLYING * max(usual, LEAST_DEVIATION * middle)
    why = "its error after the fit is {:.3f}, and the median is {:.3f}; check its timings"
    return tuple(
        SetAside(line=name, why=why.format(one, middle))
        for name, one in residuals.items()
        if one > limit
    )
