"""Placing: the gestures of a line, at its facts or at intervals drawn for it.

Conventions: times are seconds. A draw depends on the words up to its place, so a line has the same
gestures in every build, and a changed word leaves those before it where they were. Nothing looks
more than a second ahead: a fact draws gestures from `DRAWING_SECONDS`, and may lead by as much.
"""

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from math import cos, exp, log, pi, sqrt
from typing import NamedTuple

DRAWING_SECONDS = 0.5
"""Distance from which a fact draws a gesture that comes by itself."""

OPENING_SECONDS = 0.9
"""Time at the beginning of a line whose words tell it from other lines."""

_MASK = 0xFFFFFFFF


class GestureShape(NamedTuple):
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

    @property
    def room(self) -> float:
        """Least seconds between the beginnings of two."""
        return max(self.apart, self.seconds)


class LineFact(NamedTuple):
    """A time at which a gesture may be placed."""

    seconds: float
    height: float = 1.0
    """Rise of the voice, from 0 to 1; 1 without sound."""


class LineFacts(NamedTuple):
    """A line as far as gestures know it."""

    start: float
    end: float
    phrases: Sequence[tuple[float, float]]
    """Beginning and end of each stretch of speech between pauses."""
    facts: Mapping[str, Sequence[LineFact]]
    """Facts by trigger, in order of time."""
    starts: Sequence[float]
    """Start of each word."""
    seeds: Sequence[int]
    """A number for the words up to each word; one more than there are words."""
    by_hand: "Sequence[PlacedGesture]" = ()
    """Gestures that a person placed."""

    def seed(self, seconds: float) -> int:
        """Return the number of the words that have begun by a time."""
        return self.seeds[bisect_right(self.starts, seconds + 1e-9)]


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
    """Return the gestures of a line, each kind in order of time.

    Parameters
    ----------
    scales : factor of each gesture; 0 leaves it out
    """
    found: list[PlacedGesture] = []
    for number, (gesture, scale) in enumerate(zip(gestures, scales, strict=True)):
        if scale == 0:
            continue
        stated = [one for one in line.by_hand if one.number == number]
        found += [one._replace(height=scale * one.height) for one in stated if one.height]
        drawn = _on_facts if gesture.on else _by_itself
        free = -1e9  # time from which the next one may begin
        for trigger, fact in drawn(number, gesture, line):
            begin = fact.seconds - gesture.lead
            near = stated and any(abs(begin - one.begin) < gesture.room for one in stated)
            if begin >= free and not near:
                height = fact.height if gesture.by_pitch else 1.0
                found.append(PlacedGesture(number, begin, scale * height, trigger, fact.seconds))
                free = begin + gesture.room
    return found


def _on_facts(
    number: int, gesture: GestureShape, line: LineFacts
) -> Iterator[tuple[str, LineFact]]:
    """Yield the facts with the gesture."""
    for fact, trigger in _at(gesture.on, line):
        if gesture.share >= 1 or _uniform(line.seed(fact.seconds), number) < gesture.share:
            yield trigger, fact


def _at(triggers: Sequence[str], line: LineFacts) -> list[tuple[LineFact, str]]:
    """Return the facts of some triggers in order of time."""
    return sorted((fact, name) for name in triggers for fact in line.facts.get(name, ()))


def _by_itself(
    number: int, gesture: GestureShape, line: LineFacts
) -> Iterator[tuple[str, LineFact]]:
    """Yield times whose gaps are log-normal, in a clock that runs with the rate of the moment."""
    at, clock = _clock(gesture.rates or (0.0, 0.0), line)
    drawing = _at(gesture.at, line)
    seed, salt = line.seed(line.start + OPENING_SECONDS), 2 * number
    # the line begins at a random place within a gap, and long gaps cover more places
    passed = _uniform(seed, salt + 97) * _gap(seed, salt, gesture.spread, gesture.spread / 2)
    free = line.start
    while passed < clock[-1]:
        part = bisect_right(clock, passed) - 1
        share = (passed - clock[part]) / (clock[part + 1] - clock[part])
        time = at[part] + share * (at[part + 1] - at[part])
        near = [
            (abs(fact.seconds - time), fact, trigger)
            for fact, trigger in drawing
            if fact.seconds >= free and abs(fact.seconds - time) <= DRAWING_SECONDS
        ]
        _, fact, trigger = min(near, default=(0.0, LineFact(time), ""))
        yield trigger, fact
        free = max(free, fact.seconds + gesture.room)
        salt += 1000
        passed += _gap(line.seed(time), salt, gesture.spread, -gesture.spread / 2)


def _clock(rates: tuple[float, float], line: LineFacts) -> tuple[list[float], list[float]]:
    """Return times at which the rate changes, and the mean number of gestures until each."""
    at, clock = [line.start], [0.0]
    edges = [edge for phrase in line.phrases for edge in phrase]
    for number, until in enumerate((*edges, line.end)):
        if until > at[-1]:
            clock.append(clock[-1] + (until - at[-1]) * rates[number % 2 == 0] / 60)
            at.append(until)
    return at, clock


def _gap(seed: int, salt: int, spread: float, shift: float) -> float:
    """Draw a log-normal gap; its mean is 1 for the shift -spread / 2."""
    radius = sqrt(-2 * log(_uniform(seed, salt)))
    normal = radius * cos(2 * pi * _uniform(seed, salt + 31))
    return exp(spread * (normal + shift))


def _uniform(seed: int, salt: int) -> float:
    """Draw a number between 0 and 1, from all bits of a seed (the finaliser of MurmurHash3)."""
    bits = (seed + 0x9E3779B1 * (salt + 1)) & _MASK
    bits = ((bits ^ bits >> 16) * 0x85EBCA6B) & _MASK
    bits = ((bits ^ bits >> 13) * 0xC2B2AE35) & _MASK
    return ((bits ^ bits >> 16) + 0.5) / (_MASK + 1)
