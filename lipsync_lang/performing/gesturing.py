"""Gestures of a performed line: its facts, and their curves beside those of speech.

Speech is not changed: each pose of a gesture is a column after those of speech.
"""

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING
from zlib import crc32

import numpy as np

from lipsync_lang.animations.explanation import PoseAt, StageAt
from lipsync_lang.arrays import Bools, Floats, Ints
from lipsync_lang.errors import LipsyncError, did_you_mean, spelled
from lipsync_lang.gestures.laying import GestureSet, LaidGesture
from lipsync_lang.gestures.placing import NEAR_SECONDS, LineFact, LineFacts, place
from lipsync_lang.performing.stress import PRIMARY, VOWEL
from lipsync_lang.rigs.channel import Channel

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.performing.label_sounds import LabelSounds
    from lipsync_lang.performing.performed_line import PerformedLine
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.resolver.compiled import CompiledPair
    from lipsync_lang.schedules.schedule import Schedule

GestureScales = str | Mapping[str, float]
"""Factors by gesture; or text such as ``blink,accent:0.5``, ``all`` and ``none``."""

ALL, NONE = "all", "none"
"""Words for every gesture and for no gesture."""

MOST_SCALE = 2.0
"""Largest factor of a gesture."""

PAUSE_SECONDS = 0.12
"""Shortest silence that is a pause."""

SETTLED_SECONDS = 0.3
"""Latest place of a pause's fact after its beginning."""

RANGE_SEMITONES = 6.0
"""Rise of the voice over its median nearby that gives a gesture all of its height."""

LEAST_HEIGHT = 0.4
"""Height of a gesture where the voice does not rise."""

MARKED = 1000.0
"""Prominence of a word with emphasis in the text, above any pitch and length."""


def scales_of(
    compiled: "CompiledPair", asked: GestureScales | None, line: str | None = None
) -> list[float] | None:
    """Return the factor of each gesture; None if all are off.

    Settings of a call come on top of those of the line, or else the character.

    Raises
    ------
    LipsyncError
        A gesture is unknown, a factor out of range, or the pose set has no gestures.
    """
    stated = _parsed(asked) if isinstance(asked, str) else dict(asked or {})
    if not stated:
        return None
    known = [gesture["name"] for gesture in compiled.gestures["gestures"]]
    every = stated.pop(ALL, 0.0)
    for name, factor in [(ALL, every), *stated.items()]:
        if not 0 <= factor <= MOST_SCALE:
            raise LipsyncError(f"gesture {name}: {factor:g} is not from 0 to {MOST_SCALE:g}")
    if not known and (every or stated):
        raise LipsyncError(
            f"pose set {compiled.poseset} has no gestures; declare them under `gestures`"
        )
    for name in list(stated):
        own = spelled(name, known)
        if own not in known:
            raise LipsyncError(f"unknown gesture '{name}'; {did_you_mean(name, known)}")
        stated[own] = stated.pop(name)
    usual = compiled.delivery["gestures"]
    usual = {**usual, **compiled.line_deliveries.get(line or "", {}).get("gestures", {})}
    found = [stated.get(name, every) * usual.get(name, 1.0) for name in known]
    return found if any(found) else None


def _parsed(text: str) -> dict[str, float]:
    """Parse ``blink,accent:0.5``."""
    found = {}
    for part in filter(None, (one.strip() for one in text.split(","))):
        name, colon, factor = part.partition(":")
        try:
            found[name.strip()] = float(factor) if colon else 1.0
        except ValueError:
            what = f"gesture {part}: write NAME or NAME:FACTOR, such as {name}:0.5"
            raise LipsyncError(what) from None
    return {} if [*found] == [NONE] else found


def gestured(
    performer: "Performer",
    animation: "Animation",
    sounds: "LabelSounds",
    scales: list[float],
    line: str | None,
) -> "Animation":
    """Return an animation with the curves of gestures after those of speech."""
    curves, _ = _laid(performer, animation, sounds, scales, line)
    own = performer.gesture_set
    return replace(
        animation,
        poses=(*animation.poses, *own.poses),
        weights=np.hstack([animation.weights, curves]),
        channels=(*animation.channels, *(Channel(**fields) for fields in own.channels)),
    )


def without_gestures(animation: "Animation", count: int) -> "Animation":
    """Return an animation with only its first columns, those of speech."""
    if len(animation.poses) <= count:
        return animation
    return replace(
        animation,
        poses=animation.poses[:count],
        weights=np.ascontiguousarray(animation.weights[:, :count]),
        channels=animation.channels[:count],
    )


def explained(said: "PerformedLine", animation: "Animation", frame: int) -> tuple[PoseAt, ...]:
    """Explain the amounts of the poses of gestures in a frame."""
    performer, line = said.performer, said.settings["line"]
    scales = scales_of(performer.compiled, said.settings["gestures"], line)
    if scales is None:
        return ()
    (sounds,) = performer.labels.read([animation.schedule])
    curves, laid = _laid(performer, animation, sounds, scales, line)
    own, found = performer.gesture_set, []
    for number, pose in enumerate(own.poses):
        amount = float(curves[frame, number])
        why = ", ".join(
            _told(own, one, animation)
            for one in laid
            if one.first <= frame < one.stop
            and any(pose == number for pose, _ in own.shapes[one.gesture.number].poses)
        )
        found.append(PoseAt(pose, amount, (), (StageAt("gesture", amount, why),)))
    return tuple(found)


def _told(own: GestureSet, laid: LaidGesture, animation: "Animation") -> str:
    """Describe a gesture of a frame: its trigger, its word, its height and its place."""
    placed, shape = laid.gesture, own.shapes[laid.gesture.number]
    fact = placed.fact + 1e-9
    word = next((w.text for w in reversed(animation.schedule.words) if w.start <= fact), None)
    trigger = placed.trigger.replace("_", " ") or "by itself"
    where = f"at '{word}', " if word else ""
    height = "" if placed.height == 1 else f"height {placed.height:.2f}, "
    return f"{shape.name}: {trigger} {where}{placed.fact:.3f} s, {height}{shape.place}"


def _laid(
    performer: "Performer",
    animation: "Animation",
    sounds: "LabelSounds",
    scales: list[float],
    line: str | None,
) -> tuple[Floats, list[LaidGesture]]:
    """Place gestures, and lay their curves over the frames of an animation."""
    own, times, fps = performer.gesture_set, animation.times, animation.fps
    active = [shape for shape, scale in zip(own.shapes, scales, strict=True) if scale]
    wanted = {name for shape in active for name in ((shape.on,) if shape.on else shape.at)}
    pitched = any(shape.by_pitch for shape in active)
    start, end = float(times[0]), float(times[-1])
    facts = _facts(performer, animation.schedule, sounds, wanted, pitched=pitched)
    whole = LineFacts(start, end, *facts, *_seeds(animation.schedule, line))
    return own.lay(place(own.shapes, scales, whole), start, len(times), fps)


def _seeds(schedule: "Schedule", line: str | None) -> tuple[list[float], list[int]]:
    """Return the start of each word, and a number for the words before each, and for all."""
    words = [(word.start, word.text) for word in schedule.words]
    words = words or [*zip(schedule.times.tolist(), schedule.labels, strict=False)]
    seeds = [crc32((line or "").encode())]
    for _, text in words:
        seeds.append(crc32(text.encode(), seeds[-1]))
    return [start for start, _ in words], seeds


def _facts(
    performer: "Performer",
    schedule: "Schedule",
    sounds: "LabelSounds",
    wanted: Collection[str],
    *,
    pitched: bool,
) -> tuple[list[tuple[float, float]], dict[str, list[LineFact]]]:
    """Return the phrases of a line, and its facts by trigger."""
    phrases, pauses = _phrases(sounds, performer.compiled.tables.silence)
    facts = {
        "phrase_end": [LineFact(end) for _, end in phrases],
        "pause": [LineFact(min((a + b) / 2, a + SETTLED_SECONDS)) for a, b in pauses],
    }
    if not {"stress", "emphasis"} & {*wanted}:
        return phrases, facts
    stresses = performer.labels.stresses(sounds)
    if not stresses.size:  # a language without marks: any vowel may stand out
        kinds = performer.labels.classes(sounds.ids, sounds.source, len(schedule))
        stresses = np.array([0 if kind == VOWEL else -1 for kind in kinds])
    vowels = np.flatnonzero(stresses == PRIMARY)
    marked = bool(vowels.size)
    vowels = vowels if marked else np.flatnonzero(stresses >= 0)
    begins, ends = schedule.times[vowels], schedule.times[vowels + 1]
    heights, rises = np.ones(len(vowels)), ends - begins
    if schedule.audio is not None and pitched:
        rises = _rises(schedule, begins, ends)
        heights = np.clip(LEAST_HEIGHT + rises / RANGE_SEMITONES, LEAST_HEIGHT, 1)
    for word in schedule.words:
        if word.emphasis:
            rises = rises + MARKED * ((begins >= word.start) & (begins < word.end))
    every = list(map(LineFact, begins.tolist(), heights.tolist()))
    facts["stress"] = every if marked else []
    facts["emphasis"] = [every[n] for n in np.flatnonzero(_stand_out(begins, rises)).tolist()]
    return phrases, facts


def _phrases(
    sounds: "LabelSounds", silence: int
) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """Return the stretches of speech of a line, and the pauses between and around them."""
    times = sounds.times.tolist()
    pauses: list[tuple[float, float]] = []
    for number in np.flatnonzero(sounds.ids == silence).tolist():
        begin, end = times[number], times[number + 1]
        if pauses and pauses[-1][1] == begin:
            begin = pauses.pop()[0]
        pauses.append((begin, end))
    pauses = [(begin, end) for begin, end in pauses if end - begin >= PAUSE_SECONDS]
    edges = [times[0], *(at for pause in pauses for at in pause), times[-1]]
    both = zip(edges[::2], edges[1::2], strict=True)
    return [(begin, end) for begin, end in both if end > begin], pauses


def _rises(schedule: "Schedule", begins: Floats, ends: Floats) -> Floats:
    """Return how far the voice rises in each vowel over those before and soon after: semitones."""
    from lipsync_lang.gestures.pitch import pitches

    if schedule.audio is None:
        return np.zeros(len(begins))
    at = (begins + 0.4 * (ends - begins), begins + 0.7 * (ends - begins))
    samples, rate = schedule.audio.samples, schedule.audio.rate
    heard = np.maximum(*(pitches(samples, rate, one) for one in at))
    tones = 12 * np.log2(np.maximum(heard, 1.0))
    voiced = heard > 0
    # what comes more than `NEAR_SECONDS` later does not count, so that it changes nothing here
    near = voiced & (begins <= begins[:, None] + NEAR_SECONDS)
    near &= begins >= begins[:, None] - 2
    usual = [np.median(tones[own]) if own.any() else 0.0 for own in near]
    return np.where(voiced, tones - np.array(usual), 0.0)


def _stand_out(times: Floats, rises: Floats) -> Bools:
    """Return True for each vowel that no other near it exceeds: (V,)."""
    near = np.abs(times - times[:, None]) <= NEAR_SECONDS
    order: Ints = np.arange(len(times))
    # of equals the first stands out
    above = (rises > rises[:, None]) | ((rises == rises[:, None]) & (order < order[:, None]))
    out: Bools = ~(near & above).any(axis=1)
    return out
