"""Measures of the likeness of a mouth's movement to captured faces.

Conventions: the jaw is the sum of the columns that loudness opens, as the pose set states them
(`intensity`). For statistics it is sampled at 30 frames per second, the rate of the captures, and
divided by its 99th percentile, as the captures were.

The figures of the captures are over many lines of one face. Lines of a few seconds
vary widely around them, so each limit has a margin, which its measure states.
"""

from collections.abc import Iterable, Iterator
from statistics import median
from typing import NamedTuple

import numpy as np

from lipsync_lang.arrays import Bools, Floats
from lipsync_lang.quality import curve_statistics as statistics
from lipsync_lang.quality.face_columns import Roles
from lipsync_lang.quality.figures import Figure, Finding
from lipsync_lang.quality.measured_scene import MeasuredScene
from lipsync_lang.quality.measures import (
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


class Jaw(NamedTuple):
    """The jaw of a line, sampled like the captures."""

    times: Floats
    """(F,) seconds, `CAPTURE_FPS` apart."""
    curve: Floats
    """(F,) shares of the peak."""


LEAST_SOUNDS = 3
"""Minimum number of sounds for a median."""


class Opening(NamedTuple):
    """The sum of the columns that open the mouth."""

    curve: Floats
    """(T,) sum of these columns."""
    peak: float


@once
def _opening(scene: MeasuredScene) -> Opening | str:
    """Return the opening of the mouth, or the reason why there is none."""
    roles = scene.face.roles
    if roles is None:
        return "channels of a rig have no roles; check the poses"
    if scene.motion.hold > 0:
        return "poses are shown one at a time"
    if not roles.opening.any():
        return "the pose set does not state the poses that open the mouth (`intensity`)"
    curve: Floats = scene.curves[roles.opening].sum(axis=0)
    peak = statistics.peak(curve)
    return "the mouth does not open" if peak < VISIBLE_SHARE else Opening(curve, peak)


@once
def _jaws(scene: MeasuredScene) -> list[Jaw] | str:
    """Return the jaw sampled like the captures, or the reason why it cannot be compared.

    A multiple of the captures' frame rate gives several jaws, each one frame later.
    """
    opening = _opening(scene)
    if isinstance(opening, str):
        return opening
    if 1 / scene.frame < LEAST_FPS:
        return f"the animation has fewer than the {CAPTURE_FPS:g} frames per second of captures"
    if scene.seconds < LEAST_SPEECH_SECONDS:
        few = f"{scene.seconds:.1f} s of speech are too short"
        return f"{few}; statistics need {LEAST_SPEECH_SECONDS:g} s"
    curve = opening.curve / opening.peak
    phases = max(1, int(1 / scene.frame / CAPTURE_FPS + 0.01))
    starts = scene.times[0] + scene.frame * np.arange(phases)
    grids = [np.arange(start, scene.times[-1] + 1e-9, 1 / CAPTURE_FPS) for start in starts]
    return [Jaw(times, np.interp(times, scene.times, curve)) for times in grids]


@measure("jerk", "peaks per s^3", limit=2.2e4)
def jerk(scene: MeasuredScene) -> Iterable[Figure]:
    """Jerk of the jaw: the 95th percentile of its third derivative.

    Corners have a large jerk. Captures have 1.1e4 to 1.3e4 over eight lines. Single lines reach
    1.7 times that, which is the limit::

        value = 95th percentile over frames of |jaw'''(t)|,   jaw in shares of its peak
    """
    jaws = _jaws(scene)
    if isinstance(jaws, str):
        return unjudged(jaws)
    size = np.concatenate([statistics.derivative(j.curve, CAPTURE_FPS, 3) for j in jaws])
    # a third difference spans four frames: it counts at the second of them
    times = np.concatenate([j.times[1:-2] for j in jaws])
    at = round(float(times[size.argmax()]), 4)
    return one(statistics.percentile(size, 95), {}, [Finding(at, "the highest jerk of the jaw")])


@measure("high_power", "of power", limit=0.055)
def high_power(scene: MeasuredScene) -> Iterable[Figure]:
    """Share of the power of the jaw's spectrum above 8 Hz.

    Speech is not that fast, so this power comes from corners and tremble. Captures have 0.010 to
    0.012 over eight lines. Smooth single lines with quick consonants reach 0.052; the limit is
    just above::

        value = power above 8 Hz / power,   Hann window, mean removed
    """
    jaws = _jaws(scene)
    if isinstance(jaws, str):
        return unjudged(jaws)
    return one(float(np.mean([statistics.high_share(j.curve, CAPTURE_FPS) for j in jaws])))


@measure("shelves", "of open frames", limit=0.1)
def shelves(scene: MeasuredScene) -> Iterable[Figure]:
    """Frames with an open jaw that stands still.

    A frame is still if the jaw moves by less than 0.015 of its peak before and after it, so a
    plateau is still and a peak is not. Sounds longer than 0.3 s may hold and are left out.
    Captures have 0.01 to 0.02 over eight lines. The limit allows the slow turns of a single line;
    curves with filled valleys have 0.2 to 0.4::

        value = still frames / frames with the jaw above 0.1 of its peak
    """
    jaws = _jaws(scene)
    if isinstance(jaws, str):
        return unjudged(jaws)
    found: dict[int, float] = {}
    standing = counted = 0
    lasting = scene.sounds & (scene.lengths > HELD_SECONDS)
    for jaw in jaws:
        opened, still = statistics.open_frames(jaw.curve)
        owner = scene.track.bounds.searchsorted(jaw.times, side="right") - 1
        owner = np.minimum(np.maximum(owner, 0), len(scene.track.ids) - 1)
        opened, still = opened & ~lasting[owner], still & ~lasting[owner]
        standing += int(still.sum())
        counted += int(opened.sum())
        found |= dict(zip(owner[still].tolist(), jaw.times[still].tolist(), strict=True))
    shown = [
        Finding(round(at, 4), f"the jaw stands still in {scene.labels[number]}")
        for number, at in found.items()
    ]
    return one(standing / max(1, counted), {}, shown)


@measure("turns", "per second")
def turns(scene: MeasuredScene) -> Iterable[Figure]:
    """Turns of the jaw, larger than 0.02 of its peak, per second of the line.

    Captures have 6.5 to 7.3. Mumbled or slow lines have fewer, so only packs that state a limit
    have one::

        value = turns / seconds
    """
    jaws = _jaws(scene)
    if isinstance(jaws, str):
        return unjudged(jaws)
    rates = [statistics.turns(jaw.curve) / len(jaw.curve) for jaw in jaws]
    return one(CAPTURE_FPS * float(np.mean(rates)))


@measure("lead_missing", "s", limit=0.05)
def lead_missing(scene: MeasuredScene) -> Iterable[Figure]:
    """Delay of poses with anticipation, relative to 0.1 s before their sound.

    A pose with anticipation (`anticipate`) begins when it rises to a tenth of its peak in a sound
    that begins with it. Sounds in the 0.1 s before may not oppose the pose, be constrained with it,
    demand a contact that keeps it down, or want it too. Lips round 0.1 s and more before their
    vowel; the limit is half of that::

        value = max(0, 0.1 - median over sounds of (start of sound - start of rise))
    """
    roles = scene.face.roles
    if roles is None:
        return unjudged("channels of a rig have no roles; check the poses")
    if scene.motion.hold > 0:
        return unjudged("poses are shown one at a time")
    if not (roles.ahead > 0).any():
        return unjudged("no pose of the pose set has anticipation")
    leads = dict(_leads(scene, roles))
    if len(leads) < LEAST_SOUNDS:
        return unjudged(f"fewer than {LEAST_SOUNDS} sounds allow the anticipation of a pose")
    middle = median(leads.values())
    late = sorted(leads, key=lambda number: leads[number])[:MAX_PLACES]
    told = {number: f"begins {leads[number]:.3f} s ahead" for number in late}
    parts = {"median": round(middle, 6), "sounds": len(leads)}
    return one(max(0.0, LEAD_SECONDS - middle), parts, places(scene, told))


def _leads(scene: MeasuredScene, roles: Roles) -> Iterator[tuple[int, float]]:
    """Yield sounds and the seconds by which their poses lead, for sounds without an obstacle."""
    track, times = scene.track, scene.times
    for pose in np.flatnonzero(roles.ahead > 0).tolist():
        wanted = (roles.begins[track.ids, pose] >= ROUNDED_SHARE) & scene.sounds
        blocked = roles.blocks[track.ids, pose]
        for number in np.flatnonzero(wanted).tolist():
            start = float(track.bounds[number])
            first = int(np.searchsorted(track.bounds, start - LEAD_SECONDS, side="right")) - 1
            if blocked[max(0, first) : number].any():
                continue
            span = (start - MAX_LEAD_SECONDS, start, track.bounds[number + 1])
            far, here, there = times.searchsorted(span).tolist()
            begun = statistics.rise(scene.curves[pose, far:], here - far, there - far, ONSET_SHARE)
            if begun is not None:
                yield number, start - float(times[far + begun])


@measure("shut_vowels", "of frames", limit=0.12)
def shut_vowels(scene: MeasuredScene) -> Iterable[Figure]:
    """Frames with a shut jaw, in sounds beside a contact that should open the mouth.

    These are the sounds that open the mouth wide if spoken alone. Captures keep the jaw shut for
    0.08 of the time of vowels beside p b m f v; the limit is 1.5 times that::

        value = frames with the jaw below 0.1 of its peak / frames of such sounds
    """
    opening = _opening(scene)
    if isinstance(opening, str):
        return unjudged(opening)
    curve, level = opening.curve, statistics.SHUT_SHARE * opening.peak
    touched = _touched(scene)
    beside = np.zeros(len(touched), bool)
    beside[:-1] |= touched[1:]
    beside[1:] |= touched[:-1]
    which = np.flatnonzero(beside & _opens(scene))
    if len(which) < LEAST_SOUNDS:
        return unjudged(f"fewer than {LEAST_SOUNDS} sounds beside a contact open the mouth")
    meant = np.zeros(len(scene.track.ids), bool)
    meant[which] = True
    inside = meant[scene.owner]
    closed = inside & (curve < level)
    counts = np.bincount(scene.owner[closed], minlength=len(scene.track.ids))
    worst = np.argsort(-counts, kind="stable")[:MAX_PLACES]
    told = {
        n: f"keeps the jaw closed for {counts[n] * scene.frame:.3f} s"
        for n in worst.tolist()
        if counts[n]
    }
    never = counts[which] == np.bincount(scene.owner, minlength=len(counts))[which]
    parts = {"never": int(never.sum()), "sounds": len(which)}
    return one(closed.sum() / max(1, inside.sum()), parts, places(scene, told))


@once
def _touched(scene: MeasuredScene) -> Bools:
    """Return True for the sounds that demand any contact: (n,)."""
    return np.asarray(scene.demanded.any(axis=0))


def _opens(scene: MeasuredScene) -> Bools:
    """Return True for the sounds that open the mouth if spoken alone: (n,)."""
    roles = scene.face.roles
    if roles is None:
        return np.zeros(len(scene.sounds), bool)
    opens: Bools = scene.sounds & roles.opens[scene.track.ids]
    return opens


@measure("opening_lag", "s", limit=0.017)
def opening_lag(scene: MeasuredScene) -> Iterable[Figure]:
    """Time from the end of a sound with a contact until the mouth opens for the next sound.

    The sounds open the mouth wide if spoken alone, and follow a contact. Each counts the seconds
    until the jaw reaches 0.1 of its peak and stays above on its way to the peak. A sound that never
    does so counts as a whole. The limit does not come from captures: released lips open with their
    sound, so the limit is half a frame of the captures::

        value = median over such sounds of (jaw opens - sound begins), at least 0
    """
    opening = _opening(scene)
    if isinstance(opening, str):
        return unjudged(opening)
    curve, level = opening.curve, statistics.SHUT_SHARE * opening.peak
    which = np.flatnonzero(_opens(scene)[1:] & _touched(scene)[:-1]) + 1
    if len(which) < LEAST_SOUNDS:
        return unjudged(f"fewer than {LEAST_SOUNDS} sounds after a contact open the mouth")
    lags = np.array([_lag(scene, curve, level, number) for number in which.tolist()])
    worst = np.argsort(-lags)[:MAX_PLACES]
    told = {int(which[n]): f"opens the mouth {lags[n]:.3f} s late" for n in worst}
    parts = {"longest": round(float(lags.max()), 6), "sounds": len(which)}
    return one(median(lags.tolist()), parts, places(scene, told))


def _lag(scene: MeasuredScene, curve: Floats, level: float, number: int) -> float:
    """Return the seconds from the start of a sound until the jaw opens and stays open."""
    around = scene.track.bounds[number - 1 : number + 2]
    _, start, end = map(float, around.tolist())
    far, here, there = scene.times.searchsorted(around).tolist()
    if not curve[here:there].max(initial=0.0) > level:
        return end - start
    top = here + int(curve[here:there].argmax())
    low = np.flatnonzero(curve[far:top] <= level)
    if not low.size:
        return 0.0
    frame = far + int(low[-1])
    crossed = np.interp(level, curve[frame : frame + 2], scene.times[frame : frame + 2])
    return max(0.0, float(crossed) - start)
