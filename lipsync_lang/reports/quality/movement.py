"""Measures of movement: constraints, speed, flicker, changes of shape, and stillness."""

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import isinf

import numpy as np

from lipsync_lang.base.arrays import Bools, Ints
from lipsync_lang.reports.quality.figures import Figure, Finding
from lipsync_lang.reports.quality.measured_scene import MeasuredScene
from lipsync_lang.reports.quality.measures import VISIBLE_SHARE, measure, once, one, runs, unjudged

FLICKER_SECONDS = 0.07
"""Maximum time of a flicker: a movement and its return."""

SHORT_HOLD_SECONDS = 0.06
"""Minimum duration of a visible shape."""

STILL_SPEED = 0.1
"""Minimum speed of a moving pose, in shares per second."""

CONSTRAINT_TOLERANCE = 0.01
"""Maximum invisible excess over a constraint."""

FULL_TOLERANCE = 1e-3
"""Maximum distance of a full pose from its maximum."""

NO_SOUNDS = "the line has no sounds"


@measure("constraints", "of frames", limit=0)
def constraints(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Frames in which poses break a constraint by more than 0.01.

    Pose b yields to pose a, which has the higher priority. Parts are the largest excess of a pair::

        broken(t) = b(t) - max(0, C(a, b) - a(t)) > 0.01   or   b(t) - a(t) > 0.01 for `at_most`
        value = frames with any broken / frames
    """
    if not scene.face.caps and not scene.face.at_most:
        yield from (unjudged("the pose set has no constraints") for _ in scene.spans)
        return
    names, curves = scene.face.names, scene.curves
    low, high, threshold = scene.face.capped
    capped = curves[low] - np.maximum(0, threshold[:, None] - curves[high])
    pose, other = np.array(scene.face.at_most, np.intp).reshape(-1, 2).T
    over = np.concatenate((capped, curves[pose] - curves[other]))
    rules = [f"{names[a]} + {names[b]}" for a, b, _ in scene.face.caps]
    rules += [f"{names[a]} above {names[b]}" for a, b in scene.face.at_most]
    tops = scene.top(over).T
    for span, highest, most in zip(scene.spans, tops, tops.max(axis=1).tolist(), strict=True):
        if most <= CONSTRAINT_TOLERANCE:
            yield one(0.0)
            continue
        parts: dict[str, float] = {}
        findings: list[Finding] = []
        for number in (highest > CONSTRAINT_TOLERANCE).nonzero()[0].tolist():
            name, by = rules[number], float(highest[number])
            parts[name] = round(by, 6)
            at = round(float(scene.times[span][over[number, span].argmax()]), 4)
            findings.append(Finding(at, f"{name} by {by:.2f}"))
        broken = over[:, span] > CONSTRAINT_TOLERANCE
        yield one(_share(np.asarray(broken.any(axis=0))), parts, findings)


@measure("speed", "per second")
def speed(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """The top speed of the fastest pose.

    It is::

        value = max over poses and frames of |w(t + 1) - w(t)| * fps
    """
    names = scene.face.names
    for span, fastest in zip(scene.spans, scene.top(scene.speeds).T.tolist(), strict=True):
        top = max(fastest)
        pose = fastest.index(top)
        at = round(float(scene.times[span][scene.speeds[pose, span].argmax()]), 4)
        found = Finding(at, f"{names[pose]} moves at {top:.1f} per second")
        yield one(top, _named(names, fastest), [found] if top else [])


@measure("jitter", "per second", limit=2)
def jitter(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Flickers per second of speech, for the pose with most flickers.

    A flicker is a movement of 0.05 or more and a movement back of 0.05 or more, both within
    0.07 s. Examples are a single deviating frame and a tremble::

        value = max over poses of (flickers / seconds of sound)
    """
    names = scene.face.names
    found: list[list[tuple[int, float]]] = [[] for _ in scene.spans]
    poses, frames = _flickers(scene)
    rows = (scene.frame_line[frames], poses, scene.times[frames])
    for line, pose, at in zip(*(row.tolist() for row in rows), strict=True):
        found[line].append((pose, at))
    for own, seconds in zip(found, scene.seconds, strict=True):
        if not seconds:
            yield unjudged(NO_SOUNDS)
            continue
        counts = Counter(pose for pose, _ in own)
        shares = [counts[pose] / seconds for pose in range(len(names))]
        findings = [Finding(round(at, 4), f"{names[pose]} flickers") for pose, at in own]
        yield one(max(shares), _named(names, shares), findings)


def _flickers(scene: MeasuredScene) -> tuple[Ints, Ints]:
    """Return the poses and frames at which a curve turns within a flicker.

    A stroke is a movement in one direction; a flicker is two quick, visible strokes in sequence.
    """
    change, curves, times = scene.changes, scene.share, scene.times
    moving = np.flatnonzero(np.abs(change) > 1e-6)  # noqa: PLR2004 rounding
    if not moving.size:
        return moving, moving
    rising = change.ravel()[moving] > 0
    # Strokes end where the direction turns, and at the borders of poses and lines in one array.
    turns = np.concatenate((rising[1:] != rising[:-1], [True]))
    borders = np.arange(len(change))[:, None] * change.shape[1] + scene.frames[:-1]
    turns[moving.searchsorted(borders) - 1] = True
    last = turns.nonzero()[0]
    begin = moving[np.concatenate(([0], last[:-1] + 1))] % change.shape[1]
    pose, end = np.divmod(moving[last], change.shape[1])
    end += 1
    seen = np.abs(curves[pose, end] - curves[pose, begin]) >= VISIBLE_SHARE
    quick = times[end[1:]] - times[begin[:-1]] <= FLICKER_SECONDS + 1e-9
    line = scene.frame_line[end]
    found = seen[:-1] & seen[1:] & quick & (pose[1:] == pose[:-1]) & (line[1:] == line[:-1])
    return pose[:-1][found], end[:-1][found]


@once
def _shapes(scene: MeasuredScene) -> list[tuple[Ints, Ints]]:
    """Return the runs of the strongest pose during the speech of each line: pose and first frame.

    The pose is -1 if none is visible. A run of -1 more begins past the speech; there is no run in
    a line without sounds.
    """
    highest, back = scene.share.max(axis=0), np.arange(len(scene.share), dtype=np.int16)[::-1]
    # the first of equal poses is the farthest from the last; `argmax` takes ten times as long
    first = back[0] - ((scene.share == highest) * back[:, None]).max(axis=0)
    strongest = np.where(highest >= VISIBLE_SHARE, first, -1)
    out: list[tuple[Ints, Ints]] = []
    for span in scene.spans:
        said = scene.speaking[span].nonzero()[0]
        if not said.size:
            out.append((said, said))
            continue
        begin, stop = span.start + int(said[0]), span.start + int(said[-1]) + 1
        part = strongest[begin:stop]
        change = begin + 1 + (part[1:] != part[:-1]).nonzero()[0]
        first = np.concatenate(([begin], change, [stop]))
        out.append((strongest[first[:-1]], first))
    return out


@measure("changes", "per second")
def changes(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Changes of the strongest pose per second of speech. Only some pose sets limit it.

    It is::

        value = changes of argmax over poses of w(t) / seconds of sound
    """
    for (pose, _), seconds in zip(_shapes(scene), scene.seconds, strict=True):
        yield one((len(pose) - 1) / seconds) if pose.size else unjudged(NO_SOUNDS)


@measure("short_holds", "of stays")
def short_holds(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Stays of the strongest pose that are shorter than 0.06 s, without the first and the last.

    Only some pose sets limit it: the strongest of blended poses often changes, but drawings that
    change so fast flicker::

        value = stays under 0.06 s / stays
    """
    names = (*scene.face.names, "rest")  # the pose -1 is the last name
    for poses, first in _shapes(scene):
        if not poses.size:
            yield unjudged(NO_SOUNDS)
            continue
        times, stays = scene.times[first[1:-1]].tolist(), poses[1:-1].tolist()
        seconds = [end - start for start, end in pairwise(times)]
        findings = [
            Finding(round(start, 4), f"{names[pose]} stays {stay:.3f} s")
            for pose, start, stay in zip(stays, times, seconds, strict=False)
            if stay < SHORT_HOLD_SECONDS - 1e-6
        ]
        parts = {"shortest": round(min(seconds), 6)} if stays else {}
        yield one(len(findings) / max(1, len(stays)), parts, findings)


@measure("silence", "of its range", limit=VISIBLE_SHARE)
def silence(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Largest movement of a pose in a pause.

    Next to a sound, the mouth may move for `silence_reach` plus the duration of a pose's movement
    at top speed; only the rest of a pause counts::

        value = max over poses and pauses of (max w - min w)
    """
    room = scene.motion.silence_reach + 1 / scene.motion.speed_limit
    sounds, names = scene.sounds, scene.face.names
    line = scene.line[sounds]
    # a frame is quiet if as many sounds, with their room, have ended before it as have begun
    begun = scene.passed(line, scene.begin[sounds] - room)
    quiet = begun == scene.passed(line, scene.end[sounds] + room, "right")
    first, stop = runs(quiet, scene.frames)
    still, cuts = scene.share[:, quiet], np.cumsum(stop - first) - (stop - first)
    spread = np.maximum.reduceat(still, cuts, axis=1) - np.minimum.reduceat(still, cuts, axis=1)
    parts = first.searchsorted(scene.frames).tolist()
    for start, past in pairwise(parts):
        if start == past:
            shown = f"no pause is longer than {2 * room:.2f} s"
            yield unjudged("the mouth may move in whole pauses" if isinf(room) else shown)
            continue
        moved = spread[:, start:past]
        pose, pause = divmod(int(moved.argmax()), past - start)
        at = round(float(scene.times[first[start + pause]]), 4)
        what = f"{names[pose]} moves by {moved[pose, pause]:.2f}"
        most = _named(names, moved.max(axis=1).tolist(), VISIBLE_SHARE)
        yield one(moved[pose, pause], most, [Finding(at, what)])


@measure("saturation", "of frames")
def saturation(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Frames of speech with a pose at its maximum. Only some pose sets limit it.

    A curve that is clipped at 1 for long has lost its shape::

        value = frames of sound with any w(t) > 0.999 / frames of sound
    """
    level = scene.face.high - FULL_TOLERANCE * scene.face.span
    reached = np.asarray((scene.top(scene.curves) >= level[:, None]).any(axis=0))
    lines = zip(scene.spans, scene.seconds, scene.spoken, reached.tolist(), strict=True)
    for span, seconds, spoken, full in lines:
        if not seconds or not spoken:
            yield unjudged(NO_SOUNDS)
        elif not full:
            yield one(0.0)
        else:
            high = scene.curves[:, span][:, scene.speaking[span]] >= level[:, None]
            parts = _named(scene.face.names, high.mean(axis=1).tolist())
            yield one(_share(np.asarray(high.any(axis=0))), parts)


@measure("still", "of frames")
def still(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Frames of speech without a moving pose. Only some pose sets limit it.

    A pose slower than 0.1 per second is still. Long sounds are still, but a mouth that is still
    for most of a line jumps in between::

        value = frames of sound with all |w'(t)| < 0.1 / frames of sound
    """
    said = scene.speaking[:-1] & scene.speaking[1:]
    said[scene.seams] = False
    resting = (scene.speeds.max(axis=0) < STILL_SPEED) & said
    first, stop = runs(resting, np.minimum(scene.frames, len(said)))
    longest = np.zeros(len(scene.spans))
    np.maximum.at(longest, scene.frame_line[first], scene.times[stop] - scene.times[first])
    for span, seconds, spoken in zip(scene.spans, longest.tolist(), scene.spoken, strict=True):
        if not spoken:
            yield unjudged(NO_SOUNDS)
            continue
        yield one(_share(resting[span][said[span]]), {"longest": round(seconds, 6)})


def _share(part: Bools) -> float:
    """Return the share of True; 0 for no elements."""
    return int(np.count_nonzero(part)) / part.size if part.size else 0.0


def _named(names: Iterable[str], values: Sequence[float], least: float = 0.0) -> dict[str, float]:
    """Return the values above a minimum by name, largest first."""
    pairs = [(n, round(v, 6)) for n, v in zip(names, values, strict=True) if v > least]
    return dict(sorted(pairs, key=lambda pair: -pair[1]))
