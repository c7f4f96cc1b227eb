"""Columns of an animation, with their ranges, contacts, constraints and roles.

Conventions: a column is a pose or a channel of a rig, C in all; N common phonemes. A performer's
columns are the same for all its animations, so they are derived once.
"""

from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.effort import VOWEL
from lipsync_lang.performing.performer import Performer
from lipsync_lang.pipeline.constrain import Cap
from lipsync_lang.pipeline.drive import Rig
from lipsync_lang.pipeline.tables import Tables
from lipsync_lang.resolver.compiled import CompiledPair

FLOOR_SHARE = 0.9
"""Minimum share of a floor for a visible contact."""

OPENS_SHARE = 0.4
"""Minimum opening of a phoneme that must visibly open the mouth, as a share of the widest one."""

OPENED_SHARE = 0.25
"""Minimum aperture of a vowel in a line, as a share of its aperture if spoken alone."""

BLOCK_SHARE = 0.25
"""Minimum share of the highest weight of a pose, or of an opponent's, in phonemes that prevent its
anticipation."""


APERTURE = "aperture"
"""Name of the measure of a pose set that tells how far the mouth is open."""

LEAST_APERTURE = 0.05
"""Minimum visible aperture."""


class Touch(NamedTuple):
    """A contact as bounds of columns; infinite bounds have no effect."""

    name: str
    phonemes: Bools
    """(N,) True for common phonemes that demand the contact."""
    low: Floats
    """(C,) lower bound of each column."""
    high: Floats
    """(C,) upper bound of each column."""


class Roles(NamedTuple):
    """The pose set's facts about its poses and phonemes, for measures of motion."""

    opening: Bools
    """(C,) True for the columns that loudness opens (`intensity`); all False if unknown."""
    ahead: Floats
    """(C,) seconds of anticipation of each column (`anticipate`)."""
    opens: Bools
    """(N,) True for common phonemes that open the mouth wide if spoken alone."""
    begins: Floats
    """(N, C) peak of each column in the first half of a phoneme spoken alone, of its maximum."""
    blocks: Bools
    """(N, C) True for phonemes that prevent the anticipation of a column."""


class SeenMouth(NamedTuple):
    """The mouth on the mesh of a model, beside that of filmed people."""

    gains: Floats
    """(4, C) measures of the mouth of each column at 1."""
    apertures: Floats
    """(N,) aperture of each phoneme in film, at this reach; NaN if none is stated."""
    rounded: Floats
    """(N,) width of each rounded phoneme in film; NaN for others."""
    consonants: Bools
    """(N,)"""
    reach: float


class BoundedColumns(NamedTuple):
    """The bounded columns of all contacts in sequence: B in all."""

    columns: Ints
    """(B,)"""
    floor: Floats
    """(B, 1) minimum for a visible contact."""
    high: Floats
    """(B, 1)"""
    starts: Ints
    """(contacts,) index of the first column of each contact."""

    def part(self, number: int) -> slice:
        """Return the columns of a contact."""
        ends = [*self.starts[1:].tolist(), len(self.columns)]
        return slice(int(self.starts[number]), ends[number])


@dataclass(frozen=True, eq=False)
class Face:
    """The columns of an animation, with their ranges, contacts and constraints."""

    names: tuple[str, ...]
    touches: tuple[Touch, ...]
    caps: tuple[Cap, ...]
    at_most: tuple[tuple[int, int], ...]
    low: Floats
    high: Floats
    """(C,) the range of each column; infinite for bones."""
    span: Floats
    """(C,) width of each range."""
    measures: dict[str, Floats]
    """By name, (C,) gains."""
    meant: dict[str, Bools]
    """By rule, (N,) True for its common phonemes and their shades."""
    roles: Roles | None = None
    """None for the channels of a rig."""
    seen: SeenMouth | None = None
    """None if the mouth cannot be measured on a mesh."""
    aperture: Floats | None = None
    """(C,) gains of the opening of the mouth; None if nothing states them."""
    vowels: Floats | None = None
    """(N,) least aperture of each vowel that opens the mouth; NaN for other phonemes."""
    yields: Bools = field(default_factory=lambda: np.zeros((0, 0), bool))
    """(contacts, contacts) True if the first excludes the second, and yields to it."""

    @cached_property
    def raised(self) -> tuple[bool, ...]:
        """True for contacts that raise a column; a face at rest makes all others."""
        return tuple(bool(np.isfinite(touch.low).any()) for touch in self.touches)

    @cached_property
    def demanding(self) -> Bools:
        """(contacts, N) True for common phonemes that demand a contact."""
        return np.stack([touch.phonemes for touch in self.touches])

    @cached_property
    def bounded(self) -> "BoundedColumns":
        """The bounded columns of all contacts in sequence."""
        finite = [np.isfinite(t.low) | np.isfinite(t.high) for t in self.touches]
        # a contact without bounds keeps one column, since `reduceat` has no empty spans
        columns = [np.flatnonzero(one) if one.any() else np.zeros(1, int) for one in finite]
        counts = [len(one) for one in columns]
        low = np.concatenate([t.low[c] for t, c in zip(self.touches, columns, strict=True)])
        high = np.concatenate([t.high[c] for t, c in zip(self.touches, columns, strict=True)])
        asked = np.isfinite(low)
        low = np.where(asked, low, 0.0)
        floor = np.where(asked, low - (1 - FLOOR_SHARE) * np.abs(low), -np.inf)
        starts = np.cumsum([0, *counts[:-1]])
        return BoundedColumns(np.concatenate(columns), floor[:, None], high[:, None], starts)

    @cached_property
    def capped(self) -> tuple[Ints, Ints, Floats]:
        """(K,) yielding column, its opponent, and their threshold."""
        low, high, threshold = np.array(self.caps, float).reshape(-1, 3).T
        return low.astype(np.intp), high.astype(np.intp), threshold


def face_of(animation: Animation, performer: Performer) -> Face:
    """Return the face of an animation: a performer's poses, or its rig's channels.

    Columns of postures, expressions and gestures come after these, and are no part of the face.
    Other columns raise `LipsyncError`.
    """
    known = _FACES.setdefault(performer, {})
    faces = {performer.poses: partial(_posed, performer)}
    if (driver := performer.driver) is not None:
        rigged = tuple(channel.name for channel in driver.channels)
        faces.setdefault(rigged, partial(_rigged, performer, driver.rig, rigged))
    for names in sorted(faces, key=len, reverse=True):
        if animation.poses[: len(names)] == names:
            if names not in known:
                known[names] = faces[names]()
            return known[names]
    raise LipsyncError(
        f"the columns of the animation are not the poses of {performer.character}; read its "
        "file for this character (quality.fitting.read_for), or name the character of the "
        "animation"
    )


_FACES: "WeakKeyDictionary[Performer, dict[tuple[str, ...], Face]]" = WeakKeyDictionary()
"""Cache of faces by their columns, for all animations of a performer."""


def _posed(performer: Performer) -> Face:
    compiled = performer.compiled
    tables, count = compiled.tables, len(performer.poses)
    touches = [
        Touch(
            name,
            contact.phonemes,
            np.where(contact.floor > 0, contact.floor, -np.inf),
            np.where(contact.ceiling < 1, contact.ceiling, np.inf),
        )
        for name, contact in zip(compiled.contact_names, tables.contacts, strict=True)
    ]
    measures = {
        name: np.array([gains.get(pose, 0.0) for pose in performer.poses])
        for name, gains in compiled.measures.items()
    }
    alone = _alone(compiled)
    roles = _roles(compiled, performer.opening_poses, alone)
    mouth, moving = _on_mesh(performer, performer.poses)
    stated = measures.get(APERTURE, roles.opening.astype(float))
    opening = stated if mouth is None else mouth.gains[0]
    aperture = opening * moving if stated.any() else None
    unit = np.ones(count)
    limits = tables.caps, tables.at_most, np.zeros(count), unit, unit
    judged = measures, _meant(compiled), roles, mouth, aperture
    vowels = _vowels(compiled, alone @ opening)
    return Face(performer.poses, tuple(touches), *limits, *judged, vowels, _yields(tables))


def _on_mesh(performer: Performer, names: tuple[str, ...]) -> tuple[SeenMouth | None, Bools]:
    """Return the mouth on the model, and True for poses, or channels, that move it: (C,)."""
    from lipsync_lang.faces.rigs.face_on_model import find, mouth_gains
    from lipsync_lang.faces.rigs.model import known_model
    from lipsync_lang.faces.rigs.recognise import MIN_SHOWN_SHARE
    from lipsync_lang.faces.rigs.shape_matching import on_mesh

    unknown = None, np.ones(len(names), bool)
    if performer.model is None:
        return unknown
    driver, model = performer.driver, known_model(performer.model, bones=True)
    channels = driver.channels if driver else performer.channels
    shapes = {number for mesh in model.meshes for number in on_mesh(channels, mesh).shapes}
    bones = any(channel.node is not None for channel in channels)
    # A rig without a model has that of its pose set, which has other shapes.
    if driver and not bones and len(shapes) < MIN_SHOWN_SHARE * len(channels):
        return unknown
    gains, places = mouth_gains(channels, model), find(channels, model).places
    moves = np.array([one.name in places for one in channels])
    if driver and names == performer.poses:
        gains = None if gains is None else gains @ driver.rig.gains
        moves = ((driver.rig.gains != 0) & moves[:, None]).any(axis=0)
    if gains is None:
        return None, moves
    compiled = performer.compiled
    stated, spoken = compiled.checks, np.arange(len(compiled.phonemes))
    filmed, rounded = (
        np.array([stated[measure].get(name, np.nan) for name in compiled.phonemes])
        for measure in ("apertures", "rounded")
    )
    consonants = ~_are_vowels(compiled) & (spoken != compiled.tables.silence)
    return SeenMouth(gains, filmed, rounded, consonants, stated["reach"]), moves


def _yields(tables: Tables) -> Bools:
    """Return True for contacts that yield to others: floors pass the threshold of their poses."""
    low, high, threshold = np.array(tables.caps, float).reshape(-1, 3).T
    floors = np.array([one.floor for one in tables.contacts]).reshape(-1, len(tables.priority))
    one, other = (floors[:, poses.astype(np.intp)] for poses in (low, high))
    sums = one[:, None] + other[None]
    passed = (sums > threshold + 1e-9) & (one[:, None] > 0) & (other[None] > 0)
    return passed.any(axis=2)


def _meant(compiled: CompiledPair) -> dict[str, Bools]:
    named = [{name, compiled.shades.get(name, name)} for name in compiled.phonemes]
    return {
        rule: np.array([bool(names & {*stated["phonemes"]}) for names in named])
        for rule, stated in compiled.checks["rules"].items()
    }


def _alone(compiled: CompiledPair) -> Floats:
    """Return the curves of each phoneme in its own part of silence-phoneme, else 0: (N, S, C)."""
    rows = compiled.tables.pairs[compiled.tables.silence]
    curves = compiled.tables.curves[rows].astype(float)
    at = np.linspace(0, 1, curves.shape[1])
    return curves * (at >= compiled.tables.boundary[rows][:, None])[:, :, None]


def _vowels(compiled: CompiledPair, aperture: Floats) -> Floats:
    """Return the least aperture of each vowel, (N,), from that of phonemes alone, (N, S).

    A vowel that the face opens little, as for rounded lips, has none. If the face opens for no
    vowel, all vowels have the least visible aperture, so that none of them gets it.
    """
    vowel, peak = _are_vowels(compiled), aperture.max(axis=1)
    widest = peak[vowel].max(initial=0.0)
    opens = (peak > OPENS_SHARE * widest) | (widest < LEAST_APERTURE)
    least = np.maximum(LEAST_APERTURE, OPENED_SHARE * peak)
    return np.where(vowel & opens, least, np.nan)


def _are_vowels(compiled: CompiledPair) -> Bools:
    """Return True for phonemes that are vowels: (N,)."""
    kinds = compiled.manner["kinds"]
    named = [compiled.shades.get(name, name) for name in compiled.phonemes]
    return np.array([kinds.get(name) == VOWEL for name in named])


def _roles(compiled: CompiledPair, opening: Bools, alone: Floats) -> Roles:
    """Derive roles from the bank, by the curves of each phoneme alone."""
    tables = compiled.tables
    start = tables.boundary[tables.pairs[tables.silence]][:, None]
    early = np.linspace(0, 1, alone.shape[1])[None] <= (1 + start) / 2
    widest = alone[:, :, opening].sum(axis=2).max(axis=1)
    begins = (alone * early[:, :, None]).max(axis=1) / tables.highest
    shown = alone.max(axis=1)
    blocks = tables.opposed | (shown @ tables.blockers > BLOCK_SHARE) | (begins > BLOCK_SHARE)
    for contact in tables.contacts:
        blocks |= contact.phonemes[:, None] & (contact.ceiling < 1)
    opens = widest > OPENS_SHARE * widest.max(initial=0.0)
    return Roles(opening, tables.anticipate, opens, begins, blocks)


def _rigged(performer: Performer, rig: Rig, names: tuple[str, ...]) -> Face:
    """Return the face of a rig's channels; gains transfer the bounds of contacts to channels."""
    compiled = performer.compiled
    span = np.where(rig.span > 0, rig.span, 1.0)
    mouth, moving = _on_mesh(performer, names)
    aperture, posed = (compiled.rig or {}).get("measures", {}).get(APERTURE), _posed(performer)
    if mouth is not None:
        aperture = mouth.gains[0]
    elif aperture is not None:
        aperture = np.array([aperture.get(name, 0.0) for name in names])
    elif posed.aperture is not None:
        # of all gains that read the aperture of the poses, the smallest
        aperture = posed.aperture @ np.linalg.pinv(rig.gains / span[:, None]) / span
    alone = np.clip(_alone(compiled) @ rig.gains.T, rig.low, rig.high)
    yielding = np.isin(np.arange(len(names)), [channel for channel, _ in rig.at_most])
    free = _bounds(rig, np.zeros(len(performer.poses)), np.ones(len(performer.poses)))
    touches = []
    for name, contact in zip(compiled.contact_names, compiled.tables.contacts, strict=True):
        low, high = _bounds(rig, contact.floor, contact.ceiling)
        asks = (low > free[0] + 1e-9) & ~yielding
        bounds = np.where(asks, low, -np.inf), np.where(high < free[1] - 1e-9, high, np.inf)
        touches.append(Touch(name, contact.phonemes, *bounds))
    ranges = rig.at_most, rig.low, rig.high, span
    vowels = None if aperture is None else _vowels(compiled, alone @ aperture)
    shown = None if aperture is None else aperture * moving
    return Face(
        names, tuple(touches), (), *ranges, {}, _meant(compiled),
        seen=mouth, aperture=shown, vowels=vowels, yields=posed.yields,
    )  # fmt: skip


def _bounds(rig: Rig, floor: Floats, ceiling: Floats) -> tuple[Floats, Floats]:
    """Return the lower and upper bound of every channel for poses within floors and ceilings."""
    up, down = np.maximum(rig.gains, 0), np.minimum(rig.gains, 0)
    low = np.clip(up @ floor + down @ ceiling, rig.low, rig.high)
    high = np.clip(up @ ceiling + down @ floor, rig.low, rig.high)
    return low, high
