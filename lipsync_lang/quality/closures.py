"""Measures of contacts, of the timing of closures, and of the rules of a pose set."""

from collections.abc import Iterable, Iterator
from statistics import median
from typing import NamedTuple

import numpy as np

from lipsync_lang.arrays import Bools, Floats, Ints
from lipsync_lang.quality.figures import Figure, Finding
from lipsync_lang.quality.measured_scene import MeasuredScene
from lipsync_lang.quality.measures import measure, once, one, places, runs, unjudged

SEARCH_SECONDS = 0.25
"""Maximum distance of a closure from its sound."""

RULE_TOLERANCE = 1e-4
"""Maximum shortfall from a rule by rounding in files."""

MAX_CLOSURES = 8
"""Maximum number of closures in findings."""

NO_CONTACT = "the pose set has no contacts"


@measure("contacts", "of sounds", limit=0)
def contacts(scene: MeasuredScene) -> Iterable[Figure]:
    """Sounds that demand a contact and do not get it, for each contact.

    A sound gets its contact if two conditions hold at one frame, within half a frame of the sound.
    All poses with a floor reach 0.9 of it. All poses with a ceiling are at most 0.05 above it. On
    a rig, the same holds for each channel, because its gains transfer floors and ceilings. Sounds
    of bigrams with `contact: free` demand nothing. Contacts for lips and teeth and the rules below
    are the features that every lip sync needs, according to Edwards, Landreth, Fiume and Singh,
    "JALI" (2016)::

        value = missed / demanded
    """
    unmade = scene.demanded & ~(scene.highest(scene.margin) >= 0)
    for number, (touch, count) in enumerate(zip(scene.face.touches, scene.wanted, strict=True)):
        if not count:
            yield from unjudged("no sound of the line demands this contact", of=touch.name)
            continue
        missed = np.flatnonzero(unmade[number])
        yield Figure(
            touch.name,
            len(missed) / count,
            parts={"made": count - len(missed), "missed": len(missed)},
            findings=tuple(_missed(scene, number, missed)) if len(missed) else (),
        )
    if not scene.face.touches:
        yield from unjudged(NO_CONTACT)


def _missed(scene: MeasuredScene, contact: int, missed: Ints) -> Iterator[Finding]:
    """Yield a finding for each sound without its contact: the pose that prevents it."""
    touch, least, names = scene.face.touches[contact], scene.margin[contact], scene.face.names
    part = scene.face.bounded.part(contact)
    descriptions = {}
    for number, (a, b) in zip(missed.tolist(), scene.cuts[missed].tolist(), strict=True):
        if a >= b:
            descriptions[number] = "has no frame"
            continue
        # the frame that comes nearest to the contact, and the pose that is farthest off there
        frame = a + int(least[a:b].argmax())
        pose = int(scene.face.bounded.columns[part][scene.margins[part, frame].argmin()])
        value, low, high = scene.curves[pose, frame], touch.low[pose], touch.high[pose]
        asked = f"{low:g} or more" if value < low else f"{high:g} or less"
        descriptions[number] = (
            f"brings {names[pose]} to {value:.2f}, but '{touch.name}' requires {asked}"
        )
    return places(scene, descriptions)


@measure("false_contacts", "of sounds", limit=0)
def false_contacts(scene: MeasuredScene) -> Iterable[Figure]:
    """Sounds with a contact at their middle frame that they do not demand, for each contact.

    Contacts that raise no pose are left out, because a face at rest makes them too::

        value = made / sounds that do not demand it
    """
    middles = (scene.track.bounds[:-1] + scene.track.bounds[1:]) / 2
    frames = scene.times.searchsorted(middles - scene.frame / 2)
    making = scene.margin[:, np.minimum(frames, len(scene.times) - 1)] >= 0
    if not scene.face.touches:
        yield from unjudged(NO_CONTACT)
        return
    others = scene.sounds & ~scene.face.demanding[:, scene.track.ids]
    wrong = others & making
    counts = zip(wrong.sum(axis=1).tolist(), others.sum(axis=1).tolist(), strict=True)
    for number, (touch, (count, sounds)) in enumerate(zip(scene.face.touches, counts, strict=True)):
        if not scene.face.raised[number]:
            yield from unjudged("a face at rest makes this contact", of=touch.name)
            continue
        made = np.flatnonzero(wrong[number]).tolist() if count else []
        yield Figure(
            touch.name,
            count / max(1, sounds),
            parts={"made": count} if count else {},
            findings=tuple(places(scene, dict.fromkeys(made, f"makes '{touch.name}'"))),
        )


class Offset(NamedTuple):
    """Time between a sound and its closure."""

    seconds: float
    """Above 0 if the closure is late."""
    phoneme: int
    touch: str


@once
def offsets(scene: MeasuredScene) -> tuple[Offset, ...]:
    """Return the offset of each closure of an animation."""
    asked = [number for number, count in enumerate(scene.wanted) if count]
    return tuple(offset for number in asked for offset in _offsets(scene, number))


def _offsets(scene: MeasuredScene, contact: int) -> Iterator[Offset]:
    bounds, raised = scene.track.bounds, scene.face.raised[contact]
    # neighbours that demand the contact share one closure
    begin, past = runs(scene.demanded[contact])
    first, stop = runs(scene.margin[contact] >= 0)
    if not first.size:
        return
    start, end = scene.times[first], scene.times[stop - 1]
    middles = (bounds[begin] + bounds[past]) / 2
    owner = _nearest(middles, (start + end) / 2)
    sound = middles[owner]
    off = (start + end) / 2 - sound
    if not raised:
        # rest before and after a sound makes the contact too, so its middle says nothing
        owner = np.arange(len(begin))
        start, end = _covering(start, end, middles)
        sound = middles
        off = np.maximum(0, start - sound) + np.minimum(0, end - sound)
    # a closure over several sounds belongs to none of them: which one it is late for is unknown
    crowded = np.searchsorted(bounds[begin], end) - np.searchsorted(bounds[past], start) > 1
    away = np.maximum(start - bounds[past][owner], bounds[begin][owner] - end)
    off[(crowded & raised) | (away > SEARCH_SECONDS)] = np.inf
    least: dict[int, float] = {}
    for number, seconds in zip(owner.tolist(), off.tolist(), strict=True):
        if abs(seconds) < abs(least.get(number, np.inf)):
            least[number] = seconds
    name = scene.face.touches[contact].name
    for number, phoneme in enumerate(begin.tolist()):
        if number in least:
            yield Offset(least[number], phoneme, name)


def _covering(start: Floats, end: Floats, at: Floats) -> tuple[Floats, Floats]:
    """Return the start and end of the run that covers each time, or of the nearest run."""
    before = np.maximum(start.searchsorted(at, side="right") - 1, 0)
    after = np.minimum(before + 1, len(start) - 1)
    nearer = (start[after] - at < at - end[before]) & (at > end[before])
    chosen = np.where(nearer, after, before)
    return start[chosen], end[chosen]


def _nearest(places: Floats, to: Floats) -> Ints:
    """Return the index of the nearest of `places`, which ascend, for each of `to`."""
    if len(places) == 1:
        return np.zeros(len(to), np.intp)
    after = np.minimum(np.maximum(places.searchsorted(to), 1), len(places) - 1)
    nearer: Bools = to - places[after - 1] <= places[after] - to
    return np.where(nearer, after - 1, after)


def _largest_offset(scene: MeasuredScene, sign: int) -> Iterable[Figure]:
    """Return the largest offset in one direction: late for sign 1, early for -1."""
    every = offsets(scene)
    if not every:
        return unjudged("no closure can be judged")
    found = [offset for offset in every if offset.seconds * sign > 0]
    word = "late" if sign > 0 else "early"
    descriptions = {o.phoneme: f"closes '{o.touch}' {abs(o.seconds):.3f} s {word}" for o in found}
    worst = sorted(found, key=lambda offset: -offset.seconds * sign)[:MAX_CLOSURES]
    shown = {offset.phoneme: descriptions[offset.phoneme] for offset in worst}
    return one(abs(worst[0].seconds) if worst else 0.0, {}, places(scene, shown))


@measure("closure_late", "s", limit=0.045)
def closure_late(scene: MeasuredScene) -> Iterable[Figure]:
    """Lateness of the latest closure.

    A closure is a run of frames that make a contact. It belongs to the sounds that demand it and
    whose middle is nearest, within 0.25 s. If a face at rest makes the contact too, the offset is
    the time by which the closure misses the sound's middle. Viewers notice a late picture beyond
    0.045 s (ITU-R BT.1359)::

        value = max(0, max over closures of (middle of closure - middle of sound))
    """
    return _largest_offset(scene, 1)


@measure("closure_early", "s", limit=0.125)
def closure_early(scene: MeasuredScene) -> Iterable[Figure]:
    """Earliness of the earliest closure; viewers notice an early picture beyond 0.125 s.

    It is::

        value = max(0, max over closures of (middle of sound - middle of closure))
    """
    return _largest_offset(scene, -1)


@measure("closure_offset", "s", limit=0.045)
def closure_offset(scene: MeasuredScene) -> Iterable[Figure]:
    """Absolute offset of the median closure; `median` is the signed offset, positive if late.

    It is::

        value = |median over closures of (middle of closure - middle of sound)|
    """
    found = [offset.seconds for offset in offsets(scene)]
    if not found:
        return unjudged("no closure can be judged")
    middle = median(found)
    return one(abs(middle), {"median": round(middle, 6), "closures": len(found)})


@measure("rules", "of sounds", limit=0)
def rules(scene: MeasuredScene) -> Iterable[Figure]:
    """Phonemes that violate a rule of the pose set, for each rule.

    A rule names phonemes, a measure of the pose set, and a bound. At one frame of the
    phoneme, extended by half a frame, the measure must be at least `at_least` or at most
    `at_most`. The limit is the rule's own `missed`::

        value = missed / phonemes of the rule
    """
    if not scene.rules:
        yield from unjudged("the pose set has no rules")
    for name, rule in scene.rules.items():
        gains = scene.face.measures.get(rule["measure"])
        which = np.flatnonzero(scene.face.meant[name][scene.track.ids])
        if gains is None or not which.size:
            rigged, unsaid = (
                "channels of a rig have no measures",
                "no sound of the line has this rule",
            )
            yield from unjudged(rigged if gains is None else unsaid, of=name)
            continue
        shown = gains @ scene.curves
        least, most = rule.get("at_least", -np.inf), rule.get("at_most", np.inf)
        best = scene.highest(np.minimum(shown - least, most - shown))[which]
        # turned round, so that a phoneme without frames, whose best is NaN, is missed
        missed = ~(best >= -RULE_TOLERANCE)
        count = int(np.count_nonzero(missed))
        descriptions = {
            int(number): f"misses the rule by {-short:.2f} of {rule['measure']}"
            for number, short in zip(which[missed], best[missed], strict=True)
        }
        parts = {"kept": len(which) - count, "missed": count}
        found = tuple(places(scene, descriptions))
        share = count / len(which)
        yield Figure(name, share, limit=rule["missed"], parts=parts, findings=found)


@measure("unopened", "of vowels", limit=0.34)
def unopened(scene: MeasuredScene) -> Iterable[Figure]:
    """Vowels that do not open the mouth.

    The opening is the measure `aperture` of the pose set, or else the sum of the poses that
    loudness opens (`intensity`). For channels of a rig it is the `aperture` of the pose set in
    `to`, or else the channels that follow the opening of the poses. Vowels that open the mouth
    wide if spoken alone are judged. In a line, each must reach a quarter of that at one frame, and
    at least 0.05. If no vowel of the face does so alone, all are judged, and fail. Full speech
    opens nearly all; the limit lets one short vowel of three pass::

    value = vowels that stay below / vowels judged
    """
    aperture, vowels = scene.face.aperture, scene.face.vowels
    if aperture is None or vowels is None:
        return unjudged("the pose set states no aperture")
    least = vowels[scene.track.ids]
    which = np.flatnonzero(np.isfinite(least))
    if not which.size:
        return unjudged("no vowel of the line opens the mouth")
    best = scene.highest(aperture @ scene.curves)
    # turned round, so that a vowel without frames, whose best is NaN, is missed
    missed = which[~(best[which] >= least[which])]
    told = {n: f"opens the mouth to {best[n]:.2f}, below {least[n]:.2f}" for n in missed.tolist()}
    parts = {"opened": len(which) - len(missed), "closed": len(missed)}
    return one(len(missed) / len(which), parts, places(scene, told))
