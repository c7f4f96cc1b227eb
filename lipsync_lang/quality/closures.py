"""Whether the mouth makes what is heard: contacts, their time, and the rules of a pose set."""

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from lipsync_lang.pipeline.arrays import Bools, Floats, Ints
from lipsync_lang.quality.figures import Finding
from lipsync_lang.quality.measures import Measured, measure, one, places, runs, share, unjudged
from lipsync_lang.quality.take import Take, Touch

SEARCHED = 0.25
"""Seconds around a sound in which a closure may be meant for it."""

ROUNDED = 1e-4
"""By how much a file that rounds its numbers may miss a rule."""

WORST = 8
"""As many closures as are named."""

NO_CONTACT = "the pose set has no contacts"


@measure("contacts", "of sounds", limit=0)
def contacts(scene: Take) -> Iterable[Measured]:
    """Sounds that demand a contact and do not get it, for each contact.

    A sound gets it if at one frame, within half a frame of the sound, all poses that the contact
    holds up reach 0.9 of their floors, and those it keeps down stay below their ceilings, or no
    more than 0.05 above. On a rig, the same of each channel, as its gains pass floors and ceilings
    on. Sounds of bigrams that say `contact: free` demand nothing. With contacts for lips and teeth
    and the rules below, these are the signs that Edwards, Landreth, Fiume and Singh, "JALI" (2016),
    say no lip sync may lack::

        value = missed / demanded
    """
    for touch in scene.face.touches:
        wanted = np.flatnonzero(scene.demanded(touch))
        if not wanted.size:
            yield from unjudged("no sound of the line demands it", of=touch.name)
            continue
        best = scene.over(wanted, scene.margin(touch), np.maximum)
        missed = wanted[~(best >= 0)]
        yield Measured(
            len(missed) / len(wanted),
            {"made": len(wanted) - len(missed), "missed": len(missed)},
            tuple(_missed(scene, touch, missed)),
            of=touch.name,
        )
    if not scene.face.touches:
        yield from unjudged(NO_CONTACT)


def _missed(scene: Take, touch: Touch, missed: Ints) -> Iterator[Finding]:
    """Say of each sound which pose comes closest to a contact, and how close."""
    margins = scene.margins(touch)
    least = margins.min(axis=0, initial=np.inf)
    first, stop = scene.frames(scene.track.bounds[missed], scene.track.bounds[missed + 1])
    told = {}
    for number, a, b in zip(missed.tolist(), first.tolist(), stop.tolist(), strict=True):
        frame = a + int(least[a:b].argmax()) if a < b else None
        told[number] = "has no frame" if frame is None else _short(scene, touch, margins, frame)
    return places(scene, told)


def _short(scene: Take, touch: Touch, margins: Floats, frame: int) -> str:
    """Say which pose keeps a frame from making a contact."""
    pose = int(margins[:, frame].argmin())
    value, low, high = scene.curves[pose, frame], touch.low[pose], touch.high[pose]
    wanted = f"{low:g} or more" if value < low else f"{high:g} or less"
    return f"brings {scene.face.names[pose]} to {value:.2f}, where '{touch.name}' wants {wanted}"


@measure("false_contacts", "of sounds", limit=0)
def false_contacts(scene: Take) -> Iterable[Measured]:
    """Sounds in whose middle a contact is made that they do not demand, for each contact.

    Only contacts that hold something up: any other is made by a face at rest, too::

        value = made / sounds that do not demand it
    """
    for touch in scene.face.touches:
        if not touch.raised:
            yield from unjudged("a face at rest makes it", of=touch.name)
            continue
        others = np.flatnonzero(scene.sounds & ~touch.phonemes[scene.track.ids])
        middle = (scene.track.bounds[others] + scene.track.bounds[others + 1]) / 2
        frame = np.searchsorted(scene.times, middle - scene.frame / 2).clip(0, len(scene.times) - 1)
        made = others[scene.margin(touch)[frame] >= 0]
        yield Measured(
            len(made) / max(1, len(others)),
            {"made": len(made)} if len(made) else {},
            tuple(places(scene, dict.fromkeys(made.tolist(), f"makes '{touch.name}'"))),
            of=touch.name,
        )
    if not scene.face.touches:
        yield from unjudged(NO_CONTACT)


class Offset(NamedTuple):
    """By how much the closure for a sound is off."""

    seconds: float
    """Later than the sound where above 0."""
    phoneme: int
    touch: str


def offsets(scene: Take) -> tuple[Offset, ...]:
    """Return by how much each closure of an animation is off."""
    return tuple(offset for touch in scene.face.touches for offset in _offsets(scene, touch))


def _offsets(scene: Take, touch: Touch) -> Iterator[Offset]:
    bounds = scene.track.bounds
    begin, past = runs(scene.demanded(touch))  # neighbours that demand it close once
    first, stop = runs(scene.margin(touch) >= 0)
    if not begin.size or not first.size:
        return
    start, end = scene.times[first], scene.times[stop - 1]
    middles = (bounds[begin] + bounds[past]) / 2
    owner = _nearest(middles, (start + end) / 2)
    sound = middles[owner]
    off = (start + end) / 2 - sound
    if not touch.raised:  # a face at rest goes on for as long as it likes
        owner = np.arange(len(begin))
        start, end = _covering(start, end, middles)
        sound = middles
        off = np.maximum(0, start - sound) + np.minimum(0, end - sound)
    crowded = np.searchsorted(bounds[begin], end) - np.searchsorted(bounds[past], start) > 1
    away = np.maximum(start - bounds[past][owner], bounds[begin][owner] - end)
    off[(crowded & touch.raised) | (away > SEARCHED)] = np.inf
    for number, phoneme in enumerate(begin.tolist()):
        own = off[owner == number]
        if own.size and np.isfinite(own).any():
            yield Offset(float(own[np.abs(own).argmin()]), phoneme, touch.name)


def _covering(start: Floats, end: Floats, at: Floats) -> tuple[Floats, Floats]:
    """Return the run that covers each time, or else the nearest one."""
    before = (np.searchsorted(start, at, side="right") - 1).clip(0)
    after = np.minimum(before + 1, len(start) - 1)
    nearer = (start[after] - at < at - end[before]) & (at > end[before])
    chosen = np.where(nearer, after, before)
    return start[chosen], end[chosen]


def _nearest(places: Floats, to: Floats) -> Ints:
    """Return which of rising places is the nearest to each of others."""
    if len(places) == 1:
        return np.zeros(len(to), np.intp)
    after = np.searchsorted(places, to).clip(1, len(places) - 1)
    nearer: Bools = to - places[after - 1] <= places[after] - to
    return np.where(nearer, after - 1, after)


def _off(scene: Take, sign: int) -> Iterable[Measured]:
    """Return the closure that is off the most one way."""
    every = offsets(scene)
    if not every:
        return unjudged("no closure can be told")
    found = [offset for offset in every if offset.seconds * sign > 0]
    word = "late" if sign > 0 else "early"
    told = {o.phoneme: f"closes '{o.touch}' {abs(o.seconds):.3f} s {word}" for o in found}
    worst = sorted(found, key=lambda offset: -offset.seconds * sign)[:WORST]
    shown = {offset.phoneme: told[offset.phoneme] for offset in worst}
    return one(abs(worst[0].seconds) if worst else 0.0, {}, places(scene, shown))


@measure("closure_late", "s", limit=0.045)
def closure_late(scene: Take) -> Iterable[Measured]:
    """How late the latest closure is.

    A closure is a run of frames that make a contact; the one whose middle is nearest to that of the
    sounds that demand it, within 0.25 s of them, is theirs. Where a face at rest makes the contact
    too, a closure is off only as far as it misses the sound's middle. Beyond 0.045 s viewers notice
    that the picture is late (ITU-R BT.1359)::

        value = max(0, max over closures of (middle of closure - middle of sound))
    """
    return _off(scene, 1)


@measure("closure_early", "s", limit=0.125)
def closure_early(scene: Take) -> Iterable[Measured]:
    """How early the earliest closure is; viewers notice it beyond 0.125 s.

    It is::

        value = max(0, max over closures of (middle of sound - middle of closure))
    """
    return _off(scene, -1)


@measure("closure_offset", "s", limit=0.045)
def closure_offset(scene: Take) -> Iterable[Measured]:
    """How far the median closure is off; `median` says which way: above 0, it comes late.

    It is::

        value = |median over closures of (middle of closure - middle of sound)|
    """
    found = [offset.seconds for offset in offsets(scene)]
    if not found:
        return unjudged("no closure can be told")
    median = float(np.median(found))
    return one(abs(median), {"median": round(median, 6), "closures": len(found)})


@measure("rules", "of sounds", limit=0)
def rules(scene: Take) -> Iterable[Measured]:
    """Phonemes that never show what a rule of the pose set asks of them, for each rule.

    A rule names phonemes, a measure of the pose set, and what that must reach (`at_least`) or come
    down to (`at_most`) at one frame within half a frame of the phoneme. Its own `missed` is the
    limit::

        value = missed / phonemes of the rule
    """
    if not scene.rules:
        yield from unjudged("the pose set states none")
    for name, rule in scene.rules.items():
        yield from _rule(scene, name, rule)


def _rule(scene: Take, name: str, rule: dict[str, Any]) -> Iterable[Measured]:
    gains = scene.face.measures.get(rule["measure"])
    about = [n for n, label in enumerate(scene.phonemes) if label in rule["phonemes"]]
    which = np.flatnonzero(np.isin(scene.track.ids, about))
    if gains is None:
        return unjudged("channels of a rig have no measures", of=name)
    if not which.size:
        return unjudged("no sound of the line is meant", of=name)
    shown = gains @ scene.curves
    room = np.minimum(shown - rule.get("at_least", -np.inf), rule.get("at_most", np.inf) - shown)
    best = scene.over(which, room, np.maximum)
    missed = ~(best >= -ROUNDED)
    told = {
        int(number): f"misses it by {-short:.2f} of {rule['measure']}"
        for number, short in zip(which[missed], best[missed], strict=True)
    }
    parts = {"kept": int((~missed).sum()), "missed": int(missed.sum())}
    found = tuple(places(scene, told))
    return [Measured(share(missed), parts, found, of=name, limit=rule["missed"])]
