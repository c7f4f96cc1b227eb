"""Placing: the gestures of a line, at its facts or at intervals drawn for it.

Conventions: times are seconds. A draw depends on the words up to its place, so a line has the same
gestures in every build, and a changed word leaves those before it where they were. Nothing looks
more than a second ahead: a fact draws gestures from `DRAWING_SECONDS`, and may lead by as much.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, exp, inf, log, pi, sqrt
from typing import NamedTuple

DRAWING_SECONDS = 0.5
"""Distance from which a fact draws a gesture that comes by itself."""

OPENING_SECONDS = 0.9
"""Time at the beginning of a line whose words tell it from other lines."""

_MASK = 0xFFFFFFFF


@dataclass(frozen=True)
class GestureShape:
    """A gesture as the pose set states it."""

    name: str
    curve: tuple[tuple[float, float], ...]
    """Points of seconds and value."""
    poses: tuple[tuple[int, float], ...]
    """Number and amount of each pose that it moves."""
    on: tuple[str, ...]
    """Facts at which it is placed; empty for one that comes by itself."""
    share: float
    lead: float
    rates: tuple[float, float] | None
    """Times a minute in speech, and in silence."""
    at: tuple[str, ...]
    apart: float
    spread: float
    """Standard deviation of the logarithm of the gaps between those that come by themselves."""
    by_pitch: bool
    place: str
    """file:line:column"""

    @property
    def seconds(self) -> float:
        """Length of the gesture."""
        return self.curve[-1][0]

    @cached_property
    def room(self) -> float:
        """Least seconds between the beginnings of two."""
        return max(self.apart, self.seconds)

    @cached_property
    def per_second(self) -> tuple[float, float]:
        """Times a second in speech, and in silence."""
        in_speech, in_silence = self.rates or (0.0, 0.0)
        return in_speech / 60, in_silence / 60


class LineFact(NamedTuple):
    """A time at which a gesture may be placed."""

    seconds: float
    height: float = 1.0
    """Rise of the voice, from 0 to 1; 1 without sound."""


@dataclass(slots=True)
class LineFacts:
    """A line as far as gestures know it; one that goes on grows in place."""

    start: float
    end: float
    """Time of the last frame; infinite while it is unknown."""
    phrases: list[tuple[float, float]]
    """Beginning and end of each stretch of speech between pauses; the last end may be infinite."""
    facts: dict[str, list[LineFact]]
    """Facts by trigger, in order of time."""
    starts: list[float]
    """Start of each word."""
    seeds: list[int]
    """A number for the words up to each word; one more than there are words."""
    by_hand: "Sequence[PlacedGesture]" = ()
    """Gestures that a person placed."""
    until: float = inf
    """Time up to which gestures can be placed; all facts are known `DRAWING_SECONDS` farther."""

    def seed(self, seconds: float) -> int:
        """Return the number of the words that have begun by a time."""
        return self.seeds[bisect_right(self.starts, seconds + 1e-9)]

    def change(self, seconds: float) -> tuple[float, bool]:
        """Return the time at which speech or silence ends after a time, and True for speech."""
        number = bisect_right(self.phrases, (seconds, inf))
        if number and seconds < self.phrases[number - 1][1]:
            return self.phrases[number - 1][1], True
        return (self.phrases[number][0] if number < len(self.phrases) else self.end), False

    def between(self, trigger: str, first: float, last: float) -> list[LineFact]:
        """Return the facts of a trigger between two times, both included."""
        found = self.facts.get(trigger, [])
        return found[bisect_left(found, (first,)) : bisect_right(found, (last, inf))]


class PlacedGesture(NamedTuple):
    """A gesture in a line."""

    number: int
    """Index among the gestures of the pose set."""
    begin: float
    height: float
    """Factor of its amounts."""
    trigger: str
    fact: float
    """Time of the fact; for a gesture that comes by itself, its own."""


def place(
    gestures: Sequence[GestureShape], scales: Sequence[float], line: LineFacts
) -> list[PlacedGesture]:
    """Return the gestures of a whole line, each kind in order of time.

    Parameters
    ----------
    scales : factor of each gesture; 0 leaves it out
    """
    found: list[PlacedGesture] = []
    for number, (gesture, scale) in enumerate(zip(gestures, scales, strict=True)):
        absent = gesture.on and not any(map(line.facts.get, gesture.on))
        if scale and (line.by_hand or not absent):
            found += filter(None, placing(number, gesture, scale, line))
    return found


def placing(
    number: int, gesture: GestureShape, scale: float, line: LineFacts
) -> Iterator[PlacedGesture | None]:
    """Yield the gestures of a kind in order of time, and None where the line must be known farther.

    Parameters
    ----------
    scale : factor of the gesture, above 0
    """
    stated = [one for one in line.by_hand if one.number == number]
    for one in stated:
        if one.height:  # one that is taken away has none
            yield one._replace(height=scale * one.height)
    room = gesture.room
    free = -inf  # time from which the next one may begin
    for found in (_on_facts if gesture.on else _by_itself)(number, gesture, line):
        if found is None:
            yield None
            continue
        fact, trigger = found
        begin = fact.seconds - gesture.lead
        near = stated and any(abs(begin - one.begin) < room for one in stated)
        if begin >= free and not near:
            height = fact.height if gesture.by_pitch else 1.0
            yield PlacedGesture(number, begin, scale * height, trigger, fact.seconds)
            free = begin + room


def _on_facts(
    number: int, gesture: GestureShape, line: LineFacts
) -> Iterator[tuple[LineFact, str] | None]:
    """Yield the facts with the gesture, and None where the line must be known farther."""
    passed = -inf
    while passed < inf:
        until = line.until
        found = [(one, name) for name in gesture.on for one in line.between(name, passed, until)]
        for fact, trigger in sorted(found) if len(gesture.on) > 1 else found:
            if fact.seconds > passed and (
                gesture.share >= 1 or _uniform(line.seed(fact.seconds), number) < gesture.share
            ):
                yield fact, trigger
        passed = until
        yield None


def _by_itself(
    number: int, gesture: GestureShape, line: LineFacts
) -> Iterator[tuple[LineFact, str] | None]:
    """Yield times whose gaps are log-normal, and None where the line must be known farther.

    They pass in a clock that runs with the rate of the moment.
    """
    in_speech, in_silence = gesture.per_second
    salt = 2 * number
    seed = line.seed(line.start + OPENING_SECONDS)
    # a line begins at a random place within a gap, and long gaps cover more places
    passed = _uniform(seed, salt + 97) * _gap(seed, salt, gesture.spread, gesture.spread / 2)
    free = at = line.start
    clock = 0.0
    while at < line.end:
        until, speaking = line.change(at)
        rate = in_speech if speaking else in_silence
        time = at + (passed - clock) / rate if rate else inf
        if min(time, until) > line.until:
            yield None
        elif time >= until:
            at, clock = until, clock + (until - at) * rate
        else:
            near = [
                (abs(fact.seconds - time), fact, trigger)
                for trigger in gesture.at
                for fact in line.between(trigger, time - DRAWING_SECONDS, time + DRAWING_SECONDS)
                if fact.seconds >= free
            ]
            _, fact, trigger = min(near) if near else (0.0, LineFact(time), "")
            yield fact, trigger
            free = max(free, fact.seconds + gesture.room)
            salt += 1000
            passed += _gap(line.seed(time), salt, gesture.spread, -gesture.spread / 2)


def _gap(seed: int, salt: int, spread: float, shift: float) -> float:
    """Draw a log-normal gap; its mean is 1 for the shift -spread / 2."""
    radius = sqrt(-2 * log(_uniform(seed, salt)))
    normal = radius * cos(2 * pi * _uniform(seed, salt + 31))
    return exp(spread * (normal + shift))


def _uniform(seed: int, salt: int) -> float:
    """Draw a number between 0 and 1, from all bits of a seed (the finaliser of MurmurHash3)."""
    # Python has no numbers of 32 bits: each product is cut to them.
    bits = (seed + 0x9E3779B1 * (salt + 1)) & _MASK
    bits = ((bits ^ bits >> 16) * 0x85EBCA6B) & _MASK
    bits = ((bits ^ bits >> 13) * 0xC2B2AE35) & _MASK
    return ((bits ^ bits >> 16) + 0.5) / (_MASK + 1)
