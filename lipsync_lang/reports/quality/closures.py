"""Measures of contacts, of the timing of closures, and of the rules of a pose set."""

from collections.abc import Iterable, Iterator
from statistics import median
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.reports.quality.face_columns import APERTURE
from lipsync_lang.reports.quality.figures import Figure, Finding
from lipsync_lang.reports.quality.measured_scene import MeasuredScene, search
from lipsync_lang.reports.quality.measures import measure, once, one, places, runs, unjudged
from lipsync_lang.reports.quality.seen import FLAP

SEARCH_SECONDS = 0.25
"""Maximum distance of a closure from its sound."""

RULE_TOLERANCE = 1e-4
"""Maximum shortfall from a rule by rounding in files."""

FULL_OPENING = 0.55
"""Aperture of a usual jaw at full weight, in widths of the mouth: the unit of a rule's bounds."""

YIELD_SECONDS = 0.06
"""Duration below which a sound may yield its contact, for each neighbour that excludes it."""

HALF_SHARE = 0.5
"""Share of a floor above which a contact is half made."""

MAX_CLOSURES = 8
"""Maximum number of closures in findings."""

NO_CONTACT = "the pose set has no contacts"


@measure("contacts", "of sounds", limit=0)
def contacts(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Sounds that demand a contact and do not get it, for each contact.

    A sound gets its contact if two conditions hold at one frame, within half a frame of the sound.
    All poses with a floor reach 0.9 of it. All poses with a ceiling are at most 0.05 above it. On
    a rig, the same holds for each channel, because its gains transfer floors and ceilings. Sounds
    of bigrams with `contact: free` demand nothing. If the contact of a neighbour excludes that of
    a sound and wins, the sound yields below 0.06 s, or 0.12 s between two such neighbours. A sound
    that yields has a remark, and is not missed. Contacts for lips and teeth and the rules below
    are the features that every lip sync needs, according to Edwards, Landreth, Fiume and Singh,
    "JALI" (2016)::

        value = missed / demanded
    """
    unmade = scene.demanded & ~(scene.highest(scene.margin) >= 0)
    excused = unmade & (scene.lengths < YIELD_SECONDS * _stronger_neighbours(scene) - 1e-9)
    counted = (scene.demanded, unmade & ~excused, excused)
    columns = zip(*(scene.counts(marks).tolist() for marks in counted), strict=True)
    for line, (asked, lacking, yielding) in enumerate(columns):
        out = [] if scene.face.touches else unjudged(NO_CONTACT)
        for number, touch in enumerate(scene.face.touches):
            count, short, yielded = asked[number], lacking[number], yielding[number]
            if not count:
                out += unjudged("no sound of the line demands this contact", of=touch.name)
                continue
            findings: Iterable[Finding] = ()
            if short or yielded:
                found = _within(scene, line, unmade[number])
                findings = _missed(scene, number, found, excused[number])
            parts = {"made": count - short - yielded, "missed": short}
            parts |= {"yielded": yielded} if yielded else {}
            out.append(Figure(touch.name, short / count, parts=parts, findings=tuple(findings)))
        yield out


def _within(scene: MeasuredScene, line: int, marked: Bools) -> Ints:
    """Return the phonemes of a line that are marked."""
    first, past = scene.phonemes[line : line + 2]
    return first + marked[first:past].nonzero()[0]


def _stronger_neighbours(scene: MeasuredScene) -> Ints:
    """Return the number of neighbours to which each phoneme yields a contact: (contacts, n)."""
    stronger = (scene.face.yields[:, :, None] & scene.demanded).any(axis=1)
    # a line begins and ends with silence, which demands nothing, so lines do not meet
    beside = np.pad(stronger.astype(np.intp), ((0, 0), (1, 1)))
    return beside[:, 2:] + beside[:, :-2]


def _missed(scene: MeasuredScene, contact: int, missed: Ints, excused: Bools) -> Iterator[Finding]:
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
            f"{'; it yields to its neighbour' if excused[number] else ''}"
        )
    return places(scene, descriptions)


@measure("false_contacts", "of sounds", limit=0)
def false_contacts(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Sounds with a contact at their middle frame that they do not demand, for each contact.

    Contacts that raise no pose are left out, because a face at rest makes them too::

        value = made / sounds that do not demand it
    """
    if not scene.face.touches:
        yield from (unjudged(NO_CONTACT) for _ in scene.spans)
        return
    middles = (scene.begin + scene.end) / 2 - scene.frame[scene.line] / 2
    frames = scene.frame_at(scene.line, middles)
    making = scene.margin[:, np.minimum(frames, scene.frames[scene.line + 1] - 1)] >= 0
    others = scene.sounds & ~scene.face.demanding[:, scene.ids]
    wrong = others & making
    made, sounds = (scene.counts(marks).tolist() for marks in (wrong, others))
    for line in range(len(scene.spans)):
        out = []
        for number, touch in enumerate(scene.face.touches):
            if not scene.face.raised[number]:
                out += unjudged("a face at rest makes this contact", of=touch.name)
                continue
            count = made[line][number]
            which = _within(scene, line, wrong[number]).tolist() if count else ()
            findings = tuple(places(scene, dict.fromkeys(which, f"makes '{touch.name}'")))
            parts = {"made": count} if count else {}
            value = count / max(1, sounds[line][number])
            out.append(Figure(touch.name, value, parts=parts, findings=findings))
        yield out


@measure("clashes", "s", limit=0.05)
def clashes(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Longest time in which two contacts that exclude each other are both half made.

    Two contacts exclude each other if their floors add up to more than the threshold of their
    poses: a lip cannot press the other lip and meet the teeth. A contact is half made if all its
    poses with a floor are above half of it. Lips that do both are pressed and bared. A mouth
    passes from one contact to the other in 0.02 s, and in up to 0.046 s around a short sound; the
    limit is just above::

        value = max over such times of (last frame - first frame)
    """
    face = scene.face
    if face.roles is None or not face.yields.any():
        why = "no contacts of the pose set exclude each other"
        why = "channels of a rig share the poses of contacts" if face.roles is None else why
        yield from (unjudged(why) for _ in scene.spans)
        return
    half = [(HALF_SHARE * touch.low < scene.curves.T).all(axis=1) for touch in face.touches]
    found: list[list[tuple[float, Finding]]] = [[] for _ in scene.spans]
    for number, other in np.argwhere(face.yields).tolist():
        names = " and ".join(f"'{face.touches[at].name}'" for at in (number, other))
        first, stop = runs(np.asarray(half[number] & half[other]), scene.frames)
        for start, last in zip(first.tolist(), (stop - 1).tolist(), strict=True):
            seconds = float(scene.times[last] - scene.times[start])
            said = " ".join(scene.labels[scene.owner[start] : scene.owner[last] + 1])
            what = f"{said} half makes both {names} for {seconds:.3f} s"
            finding = Finding(round(float(scene.times[start]), 4), what)
            found[scene.frame_line[start]].append((seconds, finding))
    for own in found:
        worst = sorted(own, reverse=True)[:MAX_CLOSURES]
        yield one(max(worst)[0] if worst else 0.0, {}, [told for seconds, told in worst if seconds])


class Offset(NamedTuple):
    """Time between a sound and its closure."""

    seconds: float
    """Above 0 if the closure is late."""
    phoneme: int
    touch: str


@once
def offsets(scene: MeasuredScene) -> list[list[Offset]]:
    """Return the offset of each closure, line by line."""
    out: list[list[Offset]] = [[] for _ in scene.spans]
    raised = scene.face.raised
    # rest makes contacts without a floor: where there are others, those tell the time better
    for contact in (n for n, floor in enumerate(raised) if floor or not any(raised)):
        for offset in _offsets(scene, contact):
            out[scene.line[offset.phoneme]].append(offset)
    return out


def _offsets(scene: MeasuredScene, contact: int) -> Iterator[Offset]:
    raised = scene.face.raised[contact]
    # neighbours that demand the contact share one closure
    begin, past = runs(scene.demanded[contact], scene.phonemes)
    first, stop = runs(scene.margin[contact] >= 0, scene.frames)
    # only lines with both sounds and closures
    asked, closed = np.zeros((2, len(scene.spans)), bool)
    of, on = scene.line[begin], scene.frame_line[first]
    asked[of] = closed[on] = True
    begin, past, of = (one[closed[of]] for one in (begin, past, of))
    first, stop, on = (one[asked[on]] for one in (first, stop, on))
    if not first.size:
        return
    start, end = scene.times[first], scene.times[stop - 1]
    starts, ends = scene.begin[begin], scene.end[past - 1]
    sound = middles = (starts + ends) / 2
    middle = (start + end) / 2
    if raised:
        owner = _nearest((of, middles), (on, middle))
        off = middle - middles[owner]
    else:
        # rest before and after a sound makes the contact too, so its middle says nothing
        owner = np.arange(len(begin))
        chosen = _covering((on, start), end, (of, middles))
        on, start, end = of, start[chosen], end[chosen]
        off = np.maximum(0, start - sound) + np.minimum(0, end - sound)
    # a closure over several sounds belongs to none of them: which one it is late for is unknown
    crowded = search((of, starts), (on, end)) - search((of, ends), (on, start)) > 1
    away = np.maximum(start - ends[owner], starts[owner] - end)
    off[(crowded & raised) | (away > SEARCH_SECONDS)] = np.inf
    least: dict[int, float] = {}
    for number, seconds in zip(owner.tolist(), off.tolist(), strict=True):
        if abs(seconds) < abs(least.get(number, np.inf)):
            least[number] = seconds
    name = scene.face.touches[contact].name
    for number, phoneme in enumerate(begin.tolist()):
        if number in least:
            yield Offset(least[number], phoneme, name)


LineTimes = tuple[Ints, Floats]
"""Lines and seconds of events, in ascending order."""


def _covering(start: LineTimes, end: Floats, at: LineTimes) -> Ints:
    """Return the run that covers each time, or the nearest run of its line."""
    lines, times = at
    before = np.maximum(search(start, at, "right") - 1, start[0].searchsorted(lines))
    after = np.minimum(before + 1, start[0].searchsorted(lines, "right") - 1)
    nearer = (start[1][after] - times < times - end[before]) & (times > end[before])
    return np.where(nearer, after, before)


def _nearest(places: LineTimes, to: LineTimes) -> Ints:
    """Return the index of the nearest of `places` in its line, for each of `to`."""
    lines, times = to
    first, last = places[0].searchsorted(lines), places[0].searchsorted(lines, "right") - 1
    after = np.minimum(np.maximum(search(places, to), first + 1), last)
    before = np.maximum(after - 1, first)
    nearer: Bools = times - places[1][before] <= places[1][after] - times
    return np.where(nearer, before, after)


def _largest_offset(scene: MeasuredScene, sign: int) -> Iterable[list[Figure]]:
    """Yield the largest offset in one direction: late for sign 1, early for -1."""
    word = "late" if sign > 0 else "early"
    for every in offsets(scene):
        if not every:
            yield unjudged("no closure can be judged")
            continue
        found = [offset for offset in every if offset.seconds * sign > 0]
        worst = sorted(found, key=lambda offset: -offset.seconds * sign)[:MAX_CLOSURES]
        last = {offset.phoneme: offset for offset in found}
        told = (last[offset.phoneme] for offset in worst)
        shown = {o.phoneme: f"closes '{o.touch}' {abs(o.seconds):.3f} s {word}" for o in told}
        yield one(abs(worst[0].seconds) if worst else 0.0, {}, places(scene, shown))


@measure("closure_late", "s", limit=0.045)
def closure_late(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Lateness of the latest closure.

    A closure is a run of frames that make a contact. It belongs to the sounds that demand it and
    whose middle is nearest, within 0.25 s. If a face at rest makes the contact too, the offset is
    the time by which the closure misses the sound's middle. Viewers notice a late picture beyond
    0.045 s (ITU-R BT.1359)::

        value = max(0, max over closures of (middle of closure - middle of sound))
    """
    return _largest_offset(scene, 1)


@measure("closure_early", "s", limit=0.125)
def closure_early(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Earliness of the earliest closure; viewers notice an early picture beyond 0.125 s.

    It is::

        value = max(0, max over closures of (middle of sound - middle of closure))
    """
    return _largest_offset(scene, -1)


@measure("closure_offset", "s", limit=0.045)
def closure_offset(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Absolute offset of the median closure; `median` is the signed offset, positive if late.

    It is::

        value = |median over closures of (middle of closure - middle of sound)|
    """
    for every in offsets(scene):
        if not every:
            yield unjudged("no closure can be judged")
            continue
        middle = median(offset.seconds for offset in every)
        yield one(abs(middle), {"median": round(middle, 6), "closures": len(every)})


@measure("rules", "of sounds", limit=0)
def rules(scene: MeasuredScene) -> Iterable[list[Figure]]:
    """Phonemes that violate a rule of the pose set, for each rule.

    A rule names phonemes, a measure of the pose set, and a bound. At one frame of the
    phoneme, extended by half a frame, the measure must be at least `at_least` or at most
    `at_most`. An aperture is judged on the mesh, if there is one, over that of a usual jaw, and at
    reach 1. Lips part farther than teeth, so 0.1 of the mouth's width may come on top of `at_most`.
    The limit is the rule's own `missed`::

        value = missed / phonemes of the rule
    """
    out: list[list[Figure]] = [[] for _ in scene.spans]
    for name, rule in scene.rules.items():
        gains, seen = scene.face.measures.get(rule["measure"]), scene.face.seen
        least, most = rule.get("at_least", -np.inf), rule.get("at_most", np.inf)
        if rule["measure"] == APERTURE and seen is not None:
            gains, most = seen.gains[0] / (FULL_OPENING * seen.reach), most + FLAP / FULL_OPENING
        which = scene.face.meant[name][scene.ids].nonzero()[0]
        why = "no sound of the line has this rule"
        why = "channels of a rig have no measures" if gains is None else why
        best = np.zeros(len(which))
        if gains is not None and which.size:
            shown = gains @ scene.curves
            best = scene.highest(np.minimum(shown - least, most - shown))[which]
        # turned round, so that a phoneme without frames, whose best is NaN, is missed
        missed = ~(best >= -RULE_TOLERANCE)
        for line, part in enumerate(scene.split(which)):
            if gains is None or part.start == part.stop:
                out[line] += unjudged(why, of=name)
                continue
            numbers, own = which[part], missed[part]
            short = zip(numbers[own].tolist(), best[part][own].tolist(), strict=True)
            told = {n: f"misses the rule by {-by:.2f} of {rule['measure']}" for n, by in short}
            parts = {"kept": len(numbers) - len(told), "missed": len(told)}
            found, share = tuple(places(scene, told)), len(told) / len(numbers)
            out[line].append(Figure(name, share, limit=rule["missed"], parts=parts, findings=found))
    return out if scene.rules else [unjudged("the pose set has no rules") for _ in out]


@measure("unopened", "of vowels", limit=0.34)
def unopened(scene: MeasuredScene) -> Iterable[list[Figure]]:
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
        yield from (unjudged("the pose set states no aperture") for _ in scene.spans)
        return
    least = vowels[scene.ids]
    which = np.isfinite(least).nonzero()[0]
    best = scene.highest(aperture @ scene.curves)
    # turned round, so that a vowel without frames, whose best is NaN, is missed
    missed = which[~(best[which] >= least[which])]
    for judged, shut in zip(scene.split(which), scene.split(missed), strict=True):
        count, closed = judged.stop - judged.start, missed[shut].tolist()
        if not count:
            yield unjudged("no vowel of the line opens the mouth")
            continue
        told = {n: f"opens the mouth to {best[n]:.2f}, below {least[n]:.2f}" for n in closed}
        parts = {"opened": count - len(closed), "closed": len(closed)}
        yield one(len(closed) / count, parts, places(scene, told))
