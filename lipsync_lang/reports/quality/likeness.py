"""Measures of the likeness of a mouth's movement to captured faces.

Conventions: the jaw is the sum of the columns that loudness opens, as the pose set states them
(`intensity`). For statistics it is sampled at 30 frames per second, the rate of the captures, and
divided by its 99th percentile, as the captures were.

The figures of the captures are over many lines of one face. Lines of a few seconds
vary widely around them, so each limit has a margin, which its measure states.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from statistics import median
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.reports.quality import curve_statistics as statistics
from lipsync_lang.reports.quality.face_columns import LEAST_APERTURE, Roles
from lipsync_lang.reports.quality.figures import Figure, Finding
from lipsync_lang.reports.quality.measured_scene import MeasuredScene, search
from lipsync_lang.reports.quality.measures import (
    VISIBLE_SHARE,
    measure,
    once,
    one,
    places,
    unjudged,
)

CAPTURE_FPS = 30.0
"""Frames per second of the captures; jerk and power depend on it."""

LEAST_FPS = 29.0
"""Minimum frame rate for a comparison with captures."""

LEAST_SPEECH_SECONDS = 2.0
"""Minimum length of speech for statistics."""

HELD_SECONDS = 0.3
"""Minimum length of sounds that may hold their shape."""

LEAD_SECONDS = 0.1
"""Minimum time by which lips begin to round before their sound in continuous speech."""

MAX_LEAD_SECONDS = 1.0
"""Length of the search for the rise of a pose before its sound."""

ONSET_SHARE = 0.1
"""Share of its peak in the sound at which a pose has begun."""

ROUNDED_SHARE = 0.5
"""Minimum initial weight of a pose in phonemes that want it, as a share of its highest weight."""

MAX_PLACES = 8
"""Maximum number of sounds in findings."""


class Jaws(NamedTuple):
    """The jaws of lines, sampled like the captures, one after the other."""

    whys: list[str]
    """The reason why a line has no jaw; empty for others. (L,)"""
    times: Floats
    """(F,) seconds, `CAPTURE_FPS` apart."""
    curve: Floats
    """(F,) shares of the peak."""
    cuts: Ints
    """(jaws + 1,) first sample of each jaw, and F."""
    line: Ints
    """(F,) line of each sample."""
    of: list[int]
    """(jaws,) line of each jaw."""


LEAST_SOUNDS = 3
"""Minimum number of sounds for a median."""


class Opening(NamedTuple):
    """Opening of the jaw, or of the mouth on the mesh."""

    curve: Floats
    """(T,) sum of the columns that open the jaw, or the aperture on the mesh."""
    peaks: list[float]
    """(L,)"""
    whys: list[str]
    """(L,) the reason why a line has no opening; empty for others."""

    def level(self, scene: MeasuredScene) -> Floats:
        """Return the level of a shut mouth in each frame."""
        return statistics.SHUT_SHARE * np.array(self.peaks)[scene.frame_line]


def _unlike(scene: MeasuredScene) -> str:
    """Return the reason why captures say nothing about a face; empty if there is none."""
    if scene.face.roles is None:
        return "channels of a rig have no roles; check the poses"
    return "poses are shown one at a time" if scene.motion.hold > 0 else ""


@once
def _opening(scene: MeasuredScene) -> Opening:
    """Return the opening of the mouth."""
    roles, why = scene.face.roles, _unlike(scene)
    if roles is not None and not why and not roles.opening.any():
        why = "the pose set does not state the poses that open the mouth (`intensity`)"
    if why or roles is None:
        return Opening(scene.times[:0], [], [why] * len(scene.spans))
    return _opening_of(scene, scene.curves[roles.opening].sum(axis=0), VISIBLE_SHARE)


@once
def _lips(scene: MeasuredScene) -> Opening:
    """Return the opening of the lips on the mesh, or that of the jaw if none is measured."""
    seen, jaw = scene.face.seen, _opening(scene)
    if seen is None or not jaw.peaks:
        return jaw
    return _opening_of(scene, np.maximum(0.0, seen.gains[0] @ scene.curves), LEAST_APERTURE)


def _opening_of(scene: MeasuredScene, curve: Floats, least: float) -> Opening:
    peaks = [statistics.peak(curve[span]) for span in scene.spans]
    flat = "the mouth does not open"
    return Opening(curve, peaks, ["" if peak >= least else flat for peak in peaks])


@once
def _jaws(scene: MeasuredScene) -> Jaws:
    """Return the jaws sampled like the captures.

    A multiple of the captures' frame rate gives several jaws, each one frame later.
    """
    opening = _opening(scene)
    whys, times, curves, of = opening.whys.copy(), [np.zeros(0)], [np.zeros(0)], []
    lines = zip(scene.spans, scene.frame.tolist(), scene.seconds, strict=True)
    for line, (span, frame, spoken) in enumerate(lines):
        if not whys[line] and 1 / frame < LEAST_FPS:
            few = f"fewer than the {CAPTURE_FPS:g} frames per second of captures"
            whys[line] = f"the animation has {few}"
        elif not whys[line] and spoken < LEAST_SPEECH_SECONDS:
            few = f"{spoken:.1f} s of speech are too short"
            whys[line] = f"{few}; statistics need {LEAST_SPEECH_SECONDS:g} s"
        if whys[line]:
            continue
        own, curve = scene.times[span], opening.curve[span] / opening.peaks[line]
        end = float(own[-1]) + 1e-9
        for phase in range(max(1, int(1 / frame / CAPTURE_FPS + 0.01))):
            times.append(np.arange(float(own[0]) + frame * phase, end, 1 / CAPTURE_FPS))
            curves.append(np.interp(times[-1], own, curve))
            of.append(line)
    counts = [len(one) for one in times]
    owner = np.array(of, np.intp).repeat(counts[1:])
    return Jaws(whys, np.concatenate(times), np.concatenate(curves), np.cumsum(counts), owner, of)


def _jaw_figures(
    scene: MeasuredScene, value_of: Callable[[Floats], float]
) -> Iterator[list[Figure]]:
    """Yield the mean of a value over the jaws of each line."""
    jaws = _jaws(scene)
    own: list[list[float]] = [[] for _ in scene.spans]
    for line, (start, stop) in zip(jaws.of, pairwise(jaws.cuts.tolist()), strict=True):
        own[line].append(value_of(jaws.curve[start:stop]))
    for why, found in zip(jaws.whys, own, strict=True):
        yield unjudged(why) if why else one(sum(found) / len(found))


@measure("jerk", "peaks per s^3", limit=2.2e4)
def jerk(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Jerk of the jaw: the 95th percentile of its third derivative.

    Corners have a large jerk. Captures have 6.4e3 to 8.3e3 over many lines, and 1.2e4 in fast
    clips. Single lines reach twice that, which is the limit::

        value = 95th percentile over frames of |jaw'''(t)|,   jaw in shares of its peak
    """
    jaws = _jaws(scene)
    every = statistics.derivative(jaws.curve, CAPTURE_FPS, 3)
    # a third difference spans four frames of one jaw: it counts at the second of them
    jaw = np.arange(len(jaws.of)).repeat(jaws.cuts[1:] - jaws.cuts[:-1])
    within = (jaw[3:] == jaw[:-3]).nonzero()[0]
    size, times = every[within], jaws.times[within + 1]
    cuts = jaws.line[within].searchsorted(np.arange(len(scene.spans) + 1)).tolist()
    for why, (start, stop) in zip(jaws.whys, pairwise(cuts), strict=True):
        if why:
            yield unjudged(why)
            continue
        at = round(float(times[start + size[start:stop].argmax()]), 4)
        found = [Finding(at, "the highest jerk of the jaw")]
        yield one(statistics.percentile(size[start:stop], 95), {}, found)


@measure("high_power", "of power", limit=0.055)
def high_power(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Share of the power of the jaw's spectrum above 8 Hz.

    Speech is not that fast, so this power comes from corners and tremble. Captures have 0.003 to
    0.005 over many lines, and 0.011 in fast clips. Smooth single lines with quick consonants reach
    0.052; the limit is just above::

        value = power above 8 Hz / power,   Hann window, mean removed
    """
    return _jaw_figures(scene, lambda curve: statistics.high_share(curve, CAPTURE_FPS))


@measure("shelves", "of open frames", limit=0.1)
def shelves(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Frames with an open jaw that stands still.

    A frame is still if the jaw moves by less than 0.015 of its peak before and after it, so a
    plateau is still and a peak is not. Sounds longer than 0.3 s may hold and are left out.
    Captures have 0.03 to 0.08 over many lines. The limit allows the slow turns of a single line;
    curves with filled valleys have 0.2 to 0.4::

        value = still frames / frames with the jaw above 0.1 of its peak
    """
    jaws = _jaws(scene)
    opened, still = statistics.open_frames(jaws.curve)
    opened[jaws.cuts[:-1]] = opened[jaws.cuts[1:] - 1] = False
    at = opened.nonzero()[0]
    moments = jaws.line[at], jaws.times[at]
    owner = search((scene.line, scene.begin), moments, "right") - 1
    owner = np.maximum(owner, scene.phonemes[moments[0]])
    free = ~(scene.sounds & (scene.lengths > HELD_SECONDS))[owner]
    counted = np.bincount(jaws.line[at[free]], minlength=len(scene.spans)).tolist()
    standing: list[list[tuple[int, float]]] = [[] for _ in scene.spans]
    stands = free & still[at]
    rows = jaws.line[at[stands]], owner[stands], jaws.times[at[stands]]
    for line, number, seconds in zip(*(row.tolist() for row in rows), strict=True):
        standing[line].append((number, seconds))
    for why, own, count in zip(jaws.whys, standing, counted, strict=True):
        if why:
            yield unjudged(why)
            continue
        shown = [
            Finding(round(seconds, 4), f"the jaw stands still in {scene.labels[number]}")
            for number, seconds in dict(own).items()
        ]
        yield one(len(own) / max(1, count), {}, shown)


@measure("turns", "per second")
def turns(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Turns of the jaw, larger than 0.02 of its peak, per second of the line.

    Captures have 4.3 to 5.8. Mumbled or slow lines have fewer, so only packs that state a limit
    have one::

        value = turns / seconds
    """
    return _jaw_figures(scene, lambda c: CAPTURE_FPS * statistics.turns(c) / len(c))


@measure("lead_missing", "s", limit=0.05)
def lead_missing(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Delay of poses with anticipation, relative to 0.1 s before their sound.

    A pose with anticipation (`anticipate`) begins when it rises to a tenth of its peak in a sound
    that begins with it. Sounds in the 0.1 s before may not oppose the pose, be constrained with it,
    demand a contact that keeps it down, or want it too. Lips round 0.1 s and more before their
    vowel; the limit is half of that::

        value = max(0, 0.1 - median over sounds of (start of sound - start of rise))
    """
    roles, why = scene.face.roles, _unlike(scene)
    if roles is not None and not why and not (roles.ahead > 0).any():
        why = "no pose of the pose set has anticipation"
    if why or roles is None:
        yield from (unjudged(why) for _ in scene.spans)
        return
    every: list[dict[int, float]] = [{} for _ in scene.spans]
    for number, lead in _leads(scene, roles):
        every[scene.line[number]][number] = lead
    for leads in every:
        if len(leads) < LEAST_SOUNDS:
            yield unjudged(f"fewer than {LEAST_SOUNDS} sounds allow the anticipation of a pose")
            continue
        middle = median(leads.values())
        late = sorted(leads, key=leads.__getitem__)[:MAX_PLACES]
        told = {number: f"begins {leads[number]:.3f} s ahead" for number in late}
        parts = {"median": round(middle, 6), "sounds": len(leads)}
        yield one(max(0.0, LEAD_SECONDS - middle), parts, places(scene, told))


def _leads(scene: MeasuredScene, roles: Roles) -> Iterator[tuple[int, float]]:
    """Yield sounds and the seconds by which their poses lead, for sounds without an obstacle."""
    phonemes = (scene.line, scene.begin)
    for pose in (roles.ahead > 0).nonzero()[0].tolist():
        wanted = (roles.begins[scene.ids, pose] >= ROUNDED_SHARE) & scene.sounds
        which = wanted.nonzero()[0]
        line, start = scene.line[which], scene.begin[which]
        first = search(phonemes, (line, start - LEAD_SECONDS), "right") - 1
        # blocked phonemes before each phoneme: equal counts have none between them
        blocked = np.concatenate(([0], np.cumsum(roles.blocks[scene.ids, pose])))
        free = blocked[np.maximum(first, scene.phonemes[line])] == blocked[which]
        which, line, start = which[free], line[free], start[free]
        times = (start - MAX_LEAD_SECONDS, start, scene.end[which])
        spans = np.column_stack([scene.frame_at(line, one) for one in times]).tolist()
        for number, (far, here, there) in zip(which.tolist(), spans, strict=True):
            curve = scene.curves[pose, far:there]
            begun = statistics.rise(curve, here - far, there - far, ONSET_SHARE)
            if begun is not None:
                # a sound may begin after the last frame
                at = min(far + begun, int(scene.frames[scene.line[number] + 1]) - 1)
                yield number, float(scene.begin[number] - scene.times[at])


@measure("shut_vowels", "of frames", limit=0.12)
def shut_vowels(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Frames with a shut mouth, in sounds beside a contact that should open it.

    These are the sounds that open the mouth wide if spoken alone. The lips on the mesh are judged,
    and the jaw if there is no mesh. Captures keep the jaw shut for 0.08 of the time of vowels
    beside p b m f v; the limit is 1.5 times that::

        value = frames with the mouth below 0.1 of its peak / frames of such sounds
    """
    opening, count = _lips(scene), len(scene.ids)
    # silence is around each line, so that neighbours of sounds are in their line
    touched = np.asarray(scene.demanded.any(axis=0))
    beside = np.zeros(count, bool)
    beside[:-1] |= touched[1:]
    beside[1:] |= touched[:-1]
    meant = beside & _opens(scene)
    which = meant.nonzero()[0]
    closed = meant[scene.owner]
    if opening.peaks:
        closed &= opening.curve < opening.level(scene)
    shut, whole = (
        np.bincount(owner, minlength=count) for owner in (scene.owner[closed], scene.owner)
    )
    never, frame = shut == whole, scene.frame.tolist()
    for line, (why, part) in enumerate(zip(opening.whys, scene.split(which), strict=True)):
        own = which[part]
        if why or len(own) < LEAST_SOUNDS:
            few = f"fewer than {LEAST_SOUNDS} sounds beside a contact open the mouth"
            yield unjudged(why or few)
            continue
        counts = shut[own]
        worst = np.argsort(-counts, kind="stable")[:MAX_PLACES]
        told = {
            n: f"keeps the mouth closed for {frames * frame[line]:.3f} s"
            for n, frames in zip(own[worst].tolist(), counts[worst].tolist(), strict=True)
            if frames
        }
        parts = {"never": int(never[own].sum()), "sounds": len(own)}
        yield one(counts.sum() / max(1, whole[own].sum()), parts, places(scene, told))


def _opens(scene: MeasuredScene) -> Bools:
    """Return True for the sounds that open the mouth if spoken alone: (n,)."""
    roles = scene.face.roles
    if roles is None:
        return np.zeros(len(scene.sounds), bool)
    return scene.sounds & roles.opens[scene.ids]


@measure("opening_lag", "s", limit=0.017)
def opening_lag(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Time from the end of a sound with a contact until the mouth opens for the next sound.

    The sounds open the mouth wide if spoken alone, and follow a contact. Each counts the seconds
    until the lips on the mesh, or the jaw if there is none, reach 0.1 of their peak and stay above
    on the way to it. A sound that never
    does so counts as a whole. The limit does not come from captures: released lips open with their
    sound, so the limit is half a frame of the captures::

        value = median over such sounds of (mouth opens - sound begins), at least 0
    """
    opening = _lips(scene)
    touched = np.asarray(scene.demanded.any(axis=0))
    which = (_opens(scene)[1:] & touched[:-1]).nonzero()[0] + 1
    every = _lags(scene, opening, which) if opening.peaks else np.zeros(len(which))
    for why, part in zip(opening.whys, scene.split(which), strict=True):
        own, lags = which[part], every[part]
        if why or len(own) < LEAST_SOUNDS:
            few = f"fewer than {LEAST_SOUNDS} sounds after a contact open the mouth"
            yield unjudged(why or few)
            continue
        worst = np.argsort(-lags)[:MAX_PLACES]
        told = {
            int(own[n]): f"opens the mouth {lags[n]:.3f} s late" for n in worst.tolist() if lags[n]
        }
        parts = {"longest": round(float(lags.max()), 6), "sounds": len(own)}
        yield one(median(lags.tolist()), parts, places(scene, told))


def _lags(scene: MeasuredScene, opening: Opening, which: Ints) -> Floats:
    """Return the seconds from the start of sounds until the mouth opens and stays open."""
    curve, times, level = opening.curve, scene.times, opening.level(scene)
    line, start, end = scene.line[which], scene.begin[which], scene.end[which]
    far, here, there = (scene.frame_at(line, one) for one in (scene.begin[which - 1], start, end))
    # the latest frame with a shut mouth, at each frame
    shut = np.maximum.accumulate(np.where(curve <= level, np.arange(len(curve)), -1))
    seen = (here < there).nonzero()[0]
    spans = zip(here[seen].tolist(), there[seen].tolist(), strict=True)
    top = np.array([at + curve[at:past].argmax() for at, past in spans], np.intp)
    opens = curve[top] > level[top]
    seen, top = seen[opens], top[opens]
    low, lags = shut[top], end - start
    lags[seen] = 0.0
    shuts = low >= far[seen]
    seen, low, most = seen[shuts], low[shuts], level[top[shuts]]
    # between its two frames the mouth opens evenly
    slope = (times[low + 1] - times[low]) / (curve[low + 1] - curve[low])
    lags[seen] = np.maximum(0.0, slope * (most - curve[low]) + times[low] - start[seen])
    return lags
