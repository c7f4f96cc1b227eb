"""Gestures of a performed line: its facts, and their curves beside those of speech.

Speech is not changed: each pose of a gesture is a column after those of speech.
"""

from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import accumulate
from math import inf
from statistics import median
from typing import Any
from zlib import crc32

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.explanation import PoseAt, StageAt
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError, did_you_mean, spelled
from lipsync_lang.performing.effort import PRIMARY, VOWEL
from lipsync_lang.performing.label_sounds import LabelSounds
from lipsync_lang.performing.played_pair import PlayedPair
from lipsync_lang.performing.sound_memory import kept_with
from lipsync_lang.pipeline.gestures.laying import GestureSet, LaidGesture
from lipsync_lang.pipeline.gestures.pitch import pitches
from lipsync_lang.pipeline.gestures.placing import (
    DRAWING_SECONDS,
    LineFact,
    LineFacts,
    PlacedGesture,
    place,
)
from lipsync_lang.resolver.compiled import CompiledPair
from lipsync_lang.schedules.schedule import Audio, Schedule

GestureScales = str | Mapping[str, float]
"""Factors by gesture; or text such as ``blink,accent:0.5``, ``all`` and ``none``."""

ALL, NONE = "all", "none"
"""Words for every gesture and for no gesture."""

MOST_SCALE = 2.0
"""Largest factor of a gesture."""

PAUSE_SECONDS = 0.12
"""Shortest silence that is a pause."""

PAUSE_SETTLED_SECONDS = 0.3
"""Latest place of a pause's fact after its beginning."""

RANGE_SEMITONES = 6.0
"""Rise of the voice over its median nearby that gives a gesture all of its height."""

LEAST_HEIGHT = 0.4
"""Height of a gesture where the voice does not rise."""

BEFORE_SECONDS = 2.0
"""Time before a vowel over whose median its voice rises."""

ASKING_SECONDS, ASKING_SEMITONES = 0.35, 2.5
"""End of a phrase in which the voice rises by so much, if it asks."""

ASKED_SECONDS = 0.25
"""Silence after a question. The voice rises before the shorter pause of a comma, too."""

BY_HAND = "by hand"
"""Trigger of a gesture that a person placed."""

MARKS = ".,;:!?\"'()[]«»“”„’…¡¿。、！？"
"""Marks around a word of a transcript."""

MARKED_PROMINENCE = 1000.0
"""Prominence of a word with emphasis in the text, above any pitch and length."""


def scales_of(
    compiled: CompiledPair, asked: GestureScales | None, line: str | None = None
) -> list[float] | None:
    """Return the factor of each gesture; None if all are off.

    Settings of a call come on top of those of the line, or else the character. Raises LipsyncError
    if a gesture is unknown, a factor out of range, or the pose set has no gestures.
    """
    stated = _parsed(asked) if isinstance(asked, str) else dict(asked or {})
    if not stated:
        return None
    known = [gesture["name"] for gesture in compiled.gestures["gestures"]]
    every = stated.pop(ALL, 0.0)
    for name, factor in [(ALL, every), *stated.items()]:
        if not 0 <= factor <= MOST_SCALE:
            raise LipsyncError(f"gesture {name}: {factor:g} is not from 0 to {MOST_SCALE:g}")
    if not known and stated:
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


def gesture_curves(  # noqa: PLR0913, PLR0917 the line, its frames and its settings
    performer: PlayedPair,
    schedule: Schedule,
    times: Floats,
    fps: float,
    scales: list[float],
    settings: Mapping[str, Any],
) -> tuple[Floats, list[LaidGesture]]:
    """Return the curves of gestures over (T,) frames, (T, G), and the gestures.

    A part of a line has those of the whole line whose facts lie in the part.

    Parameters
    ----------
    settings : options of `Performer.perform`, and the name of the line
    """
    own, line, stated = performer.gesture_set, settings.get("line"), settings.get("placed")
    whole: Any = settings.get("whole")

    def found(said: Schedule, ends: tuple[float, float]) -> list[PlacedGesture]:
        by_hand = placed_by_hand(performer, said, line, stated)
        return place(own.shapes, scales, line_facts(performer, said, ends, by_hand))

    def found_in_whole() -> list[PlacedGesture]:
        # loudness takes time, and adds no frames
        said = performer.performance(whole, fps, line=line, styles=styles, intensity=0.0)
        start, *_, end = said.frames.times().tolist()
        return found(whole, (start, end))

    if whole is None:
        placed = found(schedule, (float(times[0]), float(times[-1])))
    else:
        styles = settings["styles"]
        given = performer, fps, repr((scales, line, stated, styles))
        first = schedule.start if schedule.start > whole.start else -inf
        last = schedule.end if schedule.end < whole.end else inf
        every = kept_with(whole, "gestures", given, found_in_whole)
        placed = [one for one in every if first <= one.fact < last]
    return own.lay(placed, float(times[0]), len(times), fps)


def laid_gestures(
    performer: PlayedPair, settings: Mapping[str, Any], animation: Animation
) -> tuple[Floats, list[LaidGesture]]:
    """Return the curves and the gestures of an animation, whose frames are all of its line."""
    scales = scales_of(performer.compiled, settings.get("gestures"), settings["line"])
    if scales is None:
        return np.zeros((len(animation), 0)), []
    line_at = performer, animation.schedule, animation.times, animation.fps
    return gesture_curves(*line_at, scales, settings)


def gesture_rates(performer: PlayedPair, settings: Mapping[str, Any], animation: Animation) -> str:
    """Describe how often an animation has each gesture, and how far its head turns."""
    curves, laid = laid_gestures(performer, settings, animation)
    own, minutes = performer.gesture_set, (animation.times[-1] - animation.times[0]) / 60
    counts = Counter(one.gesture.number for one in laid)
    told = []
    for number, shape in enumerate(own.shapes):
        aim = " ({:g} in speech, {:g} in silence)".format(*shape.rates) if shape.rates else ""
        if aim or counts[number]:
            told.append(f"{shape.name} {counts[number] / minutes:.0f}{aim}")
    turns = curves[:, [channel["node"] is not None for channel in own.channels]]
    degrees = 2 * float(np.sqrt(turns.var(axis=0).sum()))
    turned = f"; turns of {degrees:.1f} degrees (2 standard deviations)" if turns.size else ""
    return f"gestures a minute: {', '.join(told)}{turned}"


def explained(
    performer: PlayedPair, settings: Mapping[str, Any], animation: Animation, frame: int
) -> tuple[PoseAt, ...]:
    """Explain the amounts of the poses of gestures in a frame."""
    curves, laid = laid_gestures(performer, settings, animation)
    if not curves.size:
        return ()
    own, found = performer.gesture_set, []
    for number, pose in enumerate(own.poses):
        amount = float(curves[frame, number])
        why = ", ".join(
            told_gesture(own, one, animation)
            for one in laid
            if one.first <= frame < one.stop
            and any(pose == number for pose, _ in own.shapes[one.gesture.number].poses)
        )
        found.append(PoseAt(pose, amount, (), (StageAt("gesture", amount, why),)))
    return tuple(found)


def told_gesture(own: GestureSet, laid: LaidGesture, animation: Animation) -> str:
    """Describe a gesture of a frame: its trigger, its word, its height and its place."""
    placed, shape = laid.gesture, own.shapes[laid.gesture.number]
    fact = placed.fact + 1e-9
    word = next((w.text for w in reversed(animation.schedule.words) if w.start <= fact), None)
    trigger = placed.trigger.replace("_", " ") or "by itself"
    where = f"at '{word}', " if word else ""
    height = "" if placed.height == 1 else f"height {placed.height:.2f}, "
    return f"{shape.name}: {trigger} {where}{placed.fact:.3f} s, {height}{shape.place}"


def _seeds(schedule: Schedule) -> tuple[list[float], list[int]]:
    """Return the start of each word, and a number for the words before each, and for all."""
    words = [(word.start, word.text) for word in schedule.words]
    words = words or [*zip(schedule.times.tolist(), schedule.labels, strict=False)]
    seeds = accumulate((text for _, text in words), seed_after, initial=0)
    return [start for start, _ in words], [*seeds]


def line_facts(
    performer: PlayedPair,
    schedule: Schedule,
    ends: tuple[float, float] | None = None,
    by_hand: Sequence[PlacedGesture] = (),
) -> LineFacts:
    """Return a line as far as its gestures ask for it.

    Parameters
    ----------
    ends : times of its first and last frame; None for those of the schedule
    by_hand : gestures that a person placed
    """
    own = performer.gesture_set
    (sounds,) = performer.labels.read([schedule])
    phrases, pauses = _phrases(sounds, performer.compiled.tables.silence)
    facts = {
        "phrase_end": [LineFact(end) for _, end in phrases],
        "pause": [LineFact(pause_fact(a, b)) for a, b in pauses],
    }
    for word in schedule.words if own.words else ():
        for trigger in word_facts(own, word.text):
            facts.setdefault(trigger, []).append(LineFact(word.start))
    if own.triggers & {"stress", "emphasis"}:
        facts |= _vowel_facts(performer, schedule, sounds)
    if "rise" in own.triggers and schedule.audio is not None:
        audio = schedule.audio
        facts["rise"] = kept_with(audio, "rising", tuple(phrases), lambda: _rising(audio, phrases))
    start, end = ends or (schedule.start, schedule.end)
    return LineFacts(start, end, phrases, facts, *_seeds(schedule), by_hand)


def word_facts(own: GestureSet, word: str) -> tuple[str, ...]:
    """Return the facts that a word of the language is."""
    return own.words.get(_plain(word), ())


@lru_cache(maxsize=4096)
def _plain(word: str) -> str:
    """Return a word of a transcript as language packs list it."""
    return word.casefold().replace("’", "'").strip(MARKS)


def pause_fact(begin: float, end: float) -> float:
    """Return the time of the fact of a pause."""
    return min((begin + end) / 2, begin + PAUSE_SETTLED_SECONDS)


def seed_after(seed: int, text: str) -> int:
    """Return the number of the words so far, with one more."""
    return crc32(text.encode("utf-8", "surrogatepass"), seed)


def placed_by_hand(
    performer: PlayedPair,
    schedule: Schedule,
    line: str | None,
    asked: Iterable[Mapping[str, Any]] | None = None,
) -> list[PlacedGesture]:
    """Return the gestures that a call places in a line, or else the character's file.

    Raises LipsyncError if a gesture or a word does not exist, or a field of a call is wrong.
    """
    words, own = schedule.words, performer.gesture_set
    found, names = [], [shape.name for shape in own.shapes]
    if asked is None:
        asked = performer.compiled.line_deliveries.get(line or "", {}).get("placed", ())
    else:
        asked = [_by_hand(one) for one in asked]
    for stated in asked:
        name, word = stated["gesture"], stated.get("word")
        if name not in names:
            raise LipsyncError(f"unknown gesture '{name}'; {did_you_mean(name, names)}")
        if word is not None and word >= len(words):
            raise LipsyncError(
                f"a gesture '{name}' of line '{line}' is at word {word}, counted from 0, but the "
                f"line has {len(words)} words"
            )
        number = names.index(name)
        fact = float(stated["at"] if word is None else words[word].start + stated.get("after", 0))
        begin = fact - own.shapes[number].lead
        found.append(PlacedGesture(number, begin, stated.get("scale", 1.0), BY_HAND, fact))
    return found


def _by_hand(stated: Mapping[str, Any]) -> dict[str, Any]:
    """Check a gesture of a call, which has the fields of a character's file."""
    from pydantic import ValidationError

    from lipsync_lang.packs.models.gesture_models import GestureByHand

    try:
        return GestureByHand.model_validate(stated).model_dump(exclude_defaults=True)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise LipsyncError(f"a gesture by hand: {where}: {first['msg']}") from None


def _vowel_facts(
    performer: PlayedPair, schedule: Schedule, sounds: LabelSounds
) -> dict[str, list[LineFact]]:
    """Return the stressed vowels of a line, and the vowels that stand out."""
    labels = performer.labels
    stresses = labels.stresses(sounds).tolist()
    vowels = [number for number, stress in enumerate(stresses) if stress == PRIMARY]
    marked = bool(vowels)
    if not stresses:  # a language without marks: any vowel may stand out
        kinds = labels.classes(sounds, len(schedule))
        vowels = [number for number, kind in enumerate(kinds) if kind == VOWEL]
    times = schedule.times.tolist()
    begins, ends = [times[n] for n in vowels], [times[n + 1] for n in vowels]
    if performer.gesture_set.by_pitch and schedule.audio is not None and vowels:
        audio, starts, stops = schedule.audio, np.array(begins), np.array(ends)
        vowels_at = (starts.tobytes(), stops.tobytes())
        rises = [*kept_with(audio, "rises", vowels_at, lambda: _rises(audio, starts, stops))]
        heights = [min(max(LEAST_HEIGHT + one / RANGE_SEMITONES, LEAST_HEIGHT), 1) for one in rises]
        every = list(map(LineFact, begins, heights))
    else:
        rises = [end - begin for begin, end in zip(begins, ends, strict=True)]
        every = list(map(LineFact, begins))
    for word in schedule.words:
        if word.emphasis:
            for at, number in enumerate(vowels):
                rises[at] += MARKED_PROMINENCE * (word.first <= number < word.stop)
    out = [every[number] for number in stand_out(begins, rises)]
    return {"stress": every if marked else [], "emphasis": out}


def _phrases(
    sounds: LabelSounds, silence: int
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


def _rising(audio: Audio, phrases: list[tuple[float, float]]) -> list[LineFact]:
    """Return the ends of the phrases whose voice rises, as in a question."""
    found = []
    nexts = (*(begin for begin, _ in phrases[1:]), inf)
    for (begin, end), then in zip(phrases, nexts, strict=False):
        if then - end < ASKED_SECONDS:
            continue
        since = max(begin, end - ASKING_SECONDS)
        heard = pitches(audio.samples, audio.rate, np.linspace(since, end, 10))
        heard = heard[heard > 0]
        if len(heard) and 12 * np.log2(heard[-1] / heard.min()) >= ASKING_SEMITONES:
            found.append(LineFact(since))
    return found


def _rises(audio: Audio, begins: Floats, ends: Floats) -> list[float]:
    """Return how far the voice rises in each vowel over those before and soon after: semitones."""
    vowels = [*zip(begins.tolist(), ends.tolist(), strict=True)]
    known: dict[tuple[float, float], float] = kept_with(audio, "pitches", None, dict)
    new = [one for one in vowels if one not in known]
    if new:
        starts, stops = np.array(new).T
        at = (starts + 0.4 * (stops - starts), starts + 0.7 * (stops - starts))
        heard = np.maximum(*(pitches(audio.samples, audio.rate, one) for one in at))
        known.update(zip(new, heard.tolist(), strict=True))
    tones = (12 * np.log2([max(known[one], 1.0) for one in vowels])).tolist()
    # what comes more than `DRAWING_SECONDS` later does not count, so that it changes nothing here
    firsts = begins.searchsorted(begins - BEFORE_SECONDS).tolist()
    stops = begins.searchsorted(begins + DRAWING_SECONDS, "right").tolist()
    return [
        tone - median(one for one in tones[first:stop] if one) if tone else 0.0
        for tone, first, stop in zip(tones, firsts, stops, strict=True)
    ]


def stand_out(times: list[float], rises: list[float]) -> list[int]:
    """Return the vowels that no other near them exceeds; of equals the first stands out."""
    found = []
    for number, time in enumerate(times):
        first = bisect_left(times, time - DRAWING_SECONDS)
        near = rises[first : bisect_right(times, time + DRAWING_SECONDS)]
        if number == first + near.index(max(near)):
            found.append(number)
    return found
