"""Measures of movement: constraints, speed, flicker, changes of shape, and stillness."""

from collections.abc import Iterable

import numpy as np

from lipsync_lang.arrays import Ints
from lipsync_lang.quality.figures import Figure, Finding
from lipsync_lang.quality.measured_scene import MeasuredScene
from lipsync_lang.quality.measures import (
    CONSTRAINT_TOLERANCE,
    FLICKER_SECONDS,
    FULL_TOLERANCE,
    SHORT_HOLD_SECONDS,
    STILL_SPEED,
    VISIBLE_SHARE,
    measure,
    named,
    once,
    one,
    runs,
    share,
    unjudged,
)

NO_SOUNDS = "the line has no sounds"


@measure("constraints", "of frames", limit=0)
def constraints(scene: MeasuredScene) -> Iterable[Figure]:
    """Frames in which poses break a constraint by more than 0.01.

    Pose b yields to pose a, which has the higher priority. Parts are the largest excess of a pair::

        broken(t) = b(t) - max(0, C(a, b) - a(t)) > 0.01   or   b(t) - a(t) > 0.01 for `at_most`
        value = frames with any broken / frames
    """
    if not scene.face.caps and not scene.face.at_most:
        return unjudged("the pose set has no constraints")
    names, curves = scene.face.names, scene.curves
    low, high, threshold = scene.face.capped
    capped = curves[low] - np.maximum(0, threshold[:, None] - curves[high])
    pose, other = np.array(scene.face.at_most, np.intp).reshape(-1, 2).T
    over = np.concatenate((capped, curves[pose] - curves[other]))
    highest = over.max(axis=1)
    if highest.max() <= CONSTRAINT_TOLERANCE:
        return one(0.0)
    parts: dict[str, float] = {}
    findings: list[Finding] = []
    rules = [f"{names[a]} + {names[b]}" for a, b, _ in scene.face.caps]
    rules += [f"{names[a]} above {names[b]}" for a, b in scene.face.at_most]
    for number in np.flatnonzero(highest > CONSTRAINT_TOLERANCE).tolist():
        name, by = rules[number], float(highest[number])
        parts[name] = round(by, 6)
        at = round(float(scene.times[over[number].argmax()]), 4)
        findings.append(Finding(at, f"{name} by {by:.2f}"))
    return one(share(np.asarray((over > CONSTRAINT_TOLERANCE).any(axis=0))), parts, findings)


@measure("speed", "per second")
def speed(scene: MeasuredScene) -> Iterable[Figure]:
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
def jitter(scene: MeasuredScene) -> Iterable[Figure]:
    """Flickers per second of speech, for the pose with most flickers.

    A flicker is a movement of 0.05 or more and a movement back of 0.05 or more, both within
    0.07 s. Examples are a single deviating frame and a tremble::

        value = max over poses of (flickers / seconds of sound)
    """
    if not scene.seconds:
        return unjudged(NO_SOUNDS)
    names = scene.face.names
    pose, frame = _flickers(scene)
    counts = np.bincount(pose, minlength=len(names)) / scene.seconds
    at = scene.times[frame].tolist()
    findings = [
        Finding(round(t, 4), f"{names[number]} flickers")
        for number, t in zip(pose.tolist(), at, strict=True)
    ]
    return one(counts.max(), named(names, counts), findings)


def _flickers(scene: MeasuredScene) -> tuple[Ints, Ints]:
    """Return the poses and frames at which a curve turns within a flicker.

    A stroke is a movement in one direction; a flicker is two quick, visible strokes in sequence.
    """
    change, curves, times = scene.changes, scene.share, scene.times
    pose, frame = np.nonzero(np.abs(change) > 1e-6)  # noqa: PLR2004 rounding
    if not pose.size:
        return pose, frame
    rising = change[pose, frame] > 0
    last = np.flatnonzero((rising[1:] != rising[:-1]) | (pose[1:] != pose[:-1]))
    begin = frame[np.concatenate(([0], last + 1))]
    last = np.concatenate((last, [len(pose) - 1]))
    end, pose = frame[last] + 1, pose[last]
    seen = np.abs(curves[pose, end] - curves[pose, begin]) >= VISIBLE_SHARE
    quick = times[end[1:]] - times[begin[:-1]] <= FLICKER_SECONDS + 1e-9
    found = seen[:-1] & seen[1:] & quick & (pose[1:] == pose[:-1])
    return pose[:-1][found], end[:-1][found]


@once
def _shapes(scene: MeasuredScene) -> tuple[Ints, Ints, Ints]:
    """Return the runs of the strongest pose during speech: pose, first frame, frame past the last.

    The pose is -1 if none is visible.
    """
    said = np.flatnonzero(scene.speaking)
    begin, stop = int(said[0]), int(said[-1]) + 1
    part = scene.share[:, begin:stop]
    strongest = np.where(part.max(axis=0) >= VISIBLE_SHARE, part.argmax(axis=0), -1)
    first = np.concatenate(([0], np.flatnonzero(strongest[1:] != strongest[:-1]) + 1))
    past = np.concatenate((first[1:], [stop - begin]))
    return strongest[first], first + begin, past + begin


@measure("changes", "per second")
def changes(scene: MeasuredScene) -> Iterable[Figure]:
    """Changes of the strongest pose per second of speech. Only some pose sets limit it.

    It is::

        value = changes of argmax over poses of w(t) / seconds of sound
    """
    if not scene.speaking.any():
        return unjudged(NO_SOUNDS)
    return one((len(_shapes(scene)[0]) - 1) / scene.seconds)


@measure("short_holds", "of stays")
def short_holds(scene: MeasuredScene) -> Iterable[Figure]:
    """Stays of the strongest pose that are shorter than 0.06 s, without the first and the last.

    Only some pose sets limit it: the strongest of blended poses often changes, but drawings that
    change so fast flicker::

        value = stays under 0.06 s / stays
    """
    if not scene.speaking.any():
        return unjudged(NO_SOUNDS)
    pose, first, stop = (part[1:-1] for part in _shapes(scene))
    if not pose.size:
        return one(0.0)
    seconds = scene.times[stop] - scene.times[first]
    short = np.flatnonzero(seconds < SHORT_HOLD_SECONDS - 1e-6)
    names = (*scene.face.names, "rest")  # the pose -1 is the last name
    return one(
        len(short) / len(pose),
        {"shortest": round(float(seconds.min()), 6)},
        (
            Finding(
                round(float(scene.times[first[n]]), 4), f"{names[pose[n]]} stays {seconds[n]:.3f} s"
            )
            for n in short
        ),
    )


@measure("silence", "of its range", limit=VISIBLE_SHARE)
def silence(scene: MeasuredScene) -> Iterable[Figure]:
    """Largest movement of a pose in a pause.

    Next to a sound, the mouth may move for `silence_reach` plus the duration of a pose's movement
    at top speed; only the rest of a pause counts::

        value = max over poses and pauses of (max w - min w)
    """
    room = scene.motion.silence_reach + 1 / scene.motion.speed_limit
    bounds, sounds = scene.track.bounds, np.flatnonzero(scene.sounds)
    # a frame is quiet if as many sounds, with their room, have ended before it as have begun
    begun = np.searchsorted(bounds[sounds] - room, scene.times, side="right")
    ended = np.searchsorted(bounds[sounds + 1] + room, scene.times, side="left")
    first, stop = runs(begun == ended)
    if not first.size:
        return unjudged(f"no pause is longer than {2 * room:.2f} s")
    # `reduceat` folds from each cut to the next: every second span is a pause
    cuts = np.column_stack((first, stop)).ravel()
    padded = np.concatenate((scene.share, scene.share[:, -1:]), axis=1)
    moved = np.maximum.reduceat(padded, cuts, axis=1) - np.minimum.reduceat(padded, cuts, axis=1)
    moved = moved[:, ::2]
    pose, pause = np.unravel_index(int(moved.argmax()), moved.shape)
    at = round(float(scene.times[first[pause]]), 4)
    what = f"{scene.face.names[int(pose)]} moves by {moved[pose, pause]:.2f}"
    return one(
        moved[pose, pause],
        named(scene.face.names, moved.max(axis=1), VISIBLE_SHARE),
        [Finding(at, what)],
    )


@measure("saturation", "of frames")
def saturation(scene: MeasuredScene) -> Iterable[Figure]:
    """Frames of speech with a pose at its maximum. Only some pose sets limit it.

    A curve that is clipped at 1 for long has lost its shape::

        value = frames of sound with any w(t) > 0.999 / frames of sound
    """
    if not scene.speaking.any():
        return unjudged(NO_SOUNDS)
    level = scene.face.high - FULL_TOLERANCE * scene.face.span
    if (scene.curves.max(axis=1) < level).all():
        return one(0.0)
    full = scene.curves[:, scene.speaking] >= level[:, None]
    return one(share(np.asarray(full.any(axis=0))), named(scene.face.names, full.mean(axis=1)))


@measure("still", "of frames")
def still(scene: MeasuredScene) -> Iterable[Figure]:
    """Frames of speech without a moving pose. Only some pose sets limit it.

    A pose slower than 0.1 per second is still. Long sounds are still, but a mouth that is still
    for most of a line jumps in between::

        value = frames of sound with all |w'(t)| < 0.1 / frames of sound
    """
    if not scene.speaking.any():
        return unjudged(NO_SOUNDS)
    resting = scene.speeds.max(axis=0) < STILL_SPEED
    said = scene.speaking[:-1] & scene.speaking[1:]
    first, stop = runs(resting & said)
    longest = float((scene.times[stop] - scene.times[first]).max()) if first.size else 0.0
    return one(share(np.asarray(resting[said])), {"longest": round(longest, 6)})
