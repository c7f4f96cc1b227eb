"""How the mouth moves: what poses do to each other, how fast, how often, and when not at all."""

from collections.abc import Iterable, Iterator

import numpy as np

from lipsync_lang.pipeline.arrays import Bools, Floats, Ints
from lipsync_lang.quality.figures import Finding
from lipsync_lang.quality.measures import (
    BROKEN,
    FULL,
    QUICK,
    SHORT,
    STIRRING,
    VISIBLE,
    Measured,
    measure,
    named,
    one,
    runs,
    share,
    unjudged,
)
from lipsync_lang.quality.take import Take

SILENT = "nothing is said"


@measure("constraints", "of frames", limit=0)
def constraints(scene: Take) -> Iterable[Measured]:
    """Frames in which poses break a constraint by more than 0.01.

    Pose b yields to pose a, which is higher in priority. The parts are how far the worst pairs go::

        broken(t) = b(t) - max(0, C(a, b) - a(t)) > 0.01   or   b(t) - a(t) > 0.01 for `at_most`
        value = frames with any broken / frames
    """
    broken = np.zeros(len(scene.times), bool)
    parts: dict[str, float] = {}
    findings: list[Finding] = []
    for name, over in _over(scene):
        broken |= over > BROKEN
        worst = int(over.argmax())
        if over[worst] > BROKEN:
            parts[name] = round(float(over[worst]), 6)
            at = round(float(scene.times[worst]), 4)
            findings.append(Finding(at, f"{name} by {over[worst]:.2f}"))
    if not scene.face.caps and not scene.face.at_most:
        return unjudged("nothing is constrained")
    return one(share(broken), parts, findings)


def _over(scene: Take) -> Iterator[tuple[str, Floats]]:
    """Yield, for each constraint, how far each frame goes past it: (T,)."""
    names, curves = scene.face.names, scene.curves
    for low, high, threshold in scene.face.caps:
        over = curves[low] - np.maximum(0, threshold - curves[high])
        yield f"{names[low]} + {names[high]}", over
    for pose, other in scene.face.at_most:
        yield f"{names[pose]} above {names[other]}", curves[pose] - curves[other]


@measure("speed", "per second")
def speed(scene: Take) -> Iterable[Measured]:
    """The top speed of the fastest pose.

    It is::

        value = max over poses and frames of |w(t + 1) - w(t)| * fps
    """
    fastest = scene.speeds.max(axis=1)
    pose = int(fastest.argmax())
    at = round(float(scene.times[scene.speeds[pose].argmax()]), 4)
    return one(
        fastest[pose],
        named(scene.face.names, fastest),
        [Finding(at, f"{scene.face.names[pose]} moves at {fastest[pose]:.1f} per second")],
    )


@measure("jitter", "per second", limit=2)
def jitter(scene: Take) -> Iterable[Measured]:
    """Flickers of the pose that has most of them, in a second of speech.

    A flicker is a move of 0.05 or more and one back of as much, both over within 0.07 s: a frame
    that stands out, or several that tremble::

        value = max over poses of (flickers / seconds of sound)
    """
    if not scene.seconds:
        return unjudged(SILENT)
    counts, findings = [], []
    for name, curve in zip(scene.face.names, scene.share, strict=True):
        at = _flickers(curve, scene.times)
        counts.append(len(at) / scene.seconds)
        findings += [Finding(round(float(t), 4), f"{name} flickers") for t in scene.times[at]]
    return one(max(counts), named(scene.face.names, counts), findings)


def _flickers(curve: Floats, times: Floats) -> Ints:
    """Return the frames at which a curve turns back so quickly."""
    change = np.diff(curve)
    moving = np.flatnonzero(np.abs(change) > 1e-6)  # noqa: PLR2004 rounding
    if not moving.size:
        return moving
    turned = np.flatnonzero(np.diff(np.sign(change[moving])))
    begin = moving[np.concatenate(([0], turned + 1))]
    end = moving[np.append(turned, -1)] + 1
    seen = np.abs(curve[end] - curve[begin]) >= VISIBLE
    quick = times[end[1:]] - times[begin[:-1]] <= QUICK + 1e-9
    found: Ints = end[:-1][seen[:-1] & seen[1:] & quick]
    return found


def _shapes(scene: Take) -> tuple[Ints, Ints, Ints]:
    """Return the runs of the strongest pose while a line is said: pose, first frame, past last.

    The pose is -1 where none is visible.
    """
    said = np.flatnonzero(scene.speaking)
    begin, stop = int(said[0]), int(said[-1]) + 1
    part = scene.share[:, begin:stop]
    strongest = np.where(part.max(axis=0) >= VISIBLE, part.argmax(axis=0), -1)
    first = np.concatenate(([0], np.flatnonzero(np.diff(strongest)) + 1))
    return strongest[first], first + begin, np.append(first[1:], stop - begin) + begin


@measure("changes", "per second")
def changes(scene: Take) -> Iterable[Measured]:
    """Changes of the strongest pose, in a second of speech. Limited only where a pose set says so.

    It is::

        value = changes of argmax over poses of w(t) / seconds of sound
    """
    if not scene.speaking.any():
        return unjudged(SILENT)
    return one((len(_shapes(scene)[0]) - 1) / scene.seconds)


@measure("short_holds", "of stays")
def short_holds(scene: Take) -> Iterable[Measured]:
    """Stays of the strongest pose that are shorter than 0.1 s, the first and the last left out.

    Limited only where a pose set says so: poses that blend change places all the time, drawings
    that do are a flicker::

        value = stays under 0.1 s / stays
    """
    if not scene.speaking.any():
        return unjudged(SILENT)
    pose, first, stop = (part[1:-1] for part in _shapes(scene))
    if not pose.size:
        return one(0.0)
    seconds = scene.times[stop] - scene.times[first]
    short = np.flatnonzero(seconds < SHORT - 1e-6)
    return one(
        len(short) / len(pose),
        {"shortest": round(float(seconds.min()), 6)},
        (
            Finding(
                round(float(scene.times[first[n]]), 4),
                f"{_called(scene, pose[n])} stays {seconds[n]:.3f} s",
            )
            for n in short
        ),
    )


def _called(scene: Take, pose: int) -> str:
    return scene.face.names[pose] if pose >= 0 else "rest"


@measure("silence", "of its range", limit=VISIBLE)
def silence(scene: Take) -> Iterable[Measured]:
    """How far a pose moves while nothing is said.

    Beside a sound the mouth may move for `silence_reach` and the time a pose takes at its top
    speed; what is left of a pause is looked at::

        value = max over poses and pauses of (max w - min w)
    """
    room = scene.motion.silence_reach + 1 / scene.motion.speed_limit
    quiet = _quiet(scene, room)
    first, stop = runs(quiet)
    if not first.size:
        return unjudged(f"no pause is longer than {2 * room:.2f} s")
    cuts = np.column_stack((first, stop)).ravel()
    padded = np.concatenate((scene.share, scene.share[:, -1:]), axis=1)
    moved = np.maximum.reduceat(padded, cuts, axis=1) - np.minimum.reduceat(padded, cuts, axis=1)
    moved = moved[:, ::2]
    pose, pause = np.unravel_index(int(moved.argmax()), moved.shape)
    at = round(float(scene.times[first[pause]]), 4)
    what = f"{scene.face.names[int(pose)]} moves by {moved[pose, pause]:.2f}"
    return one(
        moved[pose, pause], named(scene.face.names, moved.max(axis=1), VISIBLE), [Finding(at, what)]
    )


def _quiet(scene: Take, room: float) -> Bools:
    """Tell which frames lie in silence, and farther from any sound than `room`: (T,)."""
    bounds, sounds = scene.track.bounds, np.flatnonzero(scene.sounds)
    if not sounds.size:
        return np.ones(len(scene.times), bool)
    start, end = bounds[sounds] - room, bounds[sounds + 1] + room
    before = np.searchsorted(start, scene.times, side="right")
    after = np.searchsorted(end, scene.times, side="left")
    quiet: Bools = before == after
    return quiet


@measure("saturation", "of frames")
def saturation(scene: Take) -> Iterable[Measured]:
    """Frames of speech in which some pose stands at its most. Limited only where a set says so.

    A curve that is cut off at 1 for long has lost its shape::

        value = frames of sound with any w(t) > 0.999 / frames of sound
    """
    if not scene.speaking.any():
        return unjudged(SILENT)
    said = scene.curves[:, scene.speaking]
    room = FULL * scene.face.span
    full = said >= (scene.face.high - room)[:, None]
    return one(share(np.asarray(full.any(axis=0))), named(scene.face.names, full.mean(axis=1)))


@measure("still", "of frames")
def still(scene: Take) -> Iterable[Measured]:
    """Frames of speech in which no pose moves. Limited only where a pose set says so.

    Slower than 0.1 per second is still. A long sound holds still; a mouth that does so for most of
    a line jumps in between::

        value = frames of sound with all |w'(t)| < 0.1 / frames of sound
    """
    if not scene.speaking.any():
        return unjudged(SILENT)
    resting = scene.speeds.max(axis=0) < STIRRING
    said = scene.speaking[:-1] & scene.speaking[1:]
    first, stop = runs(resting & said)
    longest = float((scene.times[stop] - scene.times[first]).max()) if first.size else 0.0
    return one(share(np.asarray(resting[said])), {"longest": round(longest, 6)})
