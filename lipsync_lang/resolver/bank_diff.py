"""Compare bigrams of one character with those of another, or with the layers beneath.

Curves are compared as they are performed: sampled over normalised time, 0 outside their points.
With d(x) what a pose gained at normalised time x, the figures are the largest |d| with its sign
and its x, the root of the mean of d squared, and the area, the mean of |d|. A trigram that one side
does not draw is compared with the larger of its two bigrams there. Banks of other manners of
speaking, and a character's words, lines and motion, are not looked at.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.base.presentation.text_templates import filled
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import Character
from lipsync_lang.packs.pack import Pack
from lipsync_lang.pipeline.tables import RESOLUTION
from lipsync_lang.resolver.compile import drawn_trigrams, played_trigrams, tabulated
from lipsync_lang.resolver.compiled import Origin, Pair, Triple
from lipsync_lang.resolver.layers import THIRDS, BigramRow, Halves, PairPacks

SLACK = 1e-6
"""Maximum difference that counts as none."""

TIMES: Floats = np.linspace(0, 1, RESOLUTION + 1)
"""(K,) normalised times at which curves are compared."""


@dataclass(frozen=True, eq=False)
class Side:
    """A bigram of one of the two characters."""

    origin: Origin
    curves: Floats
    """(K, P) weights at `TIMES`."""
    boundary: float | tuple[float, float]
    """Normalised end of the first phoneme; for a trigram, of the first two."""
    free: bool
    """True if the bigram waives its contacts."""

    def __str__(self) -> str:
        return self.origin.source

    @property
    def boundaries(self) -> tuple[float, ...]:
        """Normalised times at which all phonemes but the last end."""
        return self.boundary if isinstance(self.boundary, tuple) else (self.boundary,)


@dataclass(frozen=True)
class PoseChange:
    """Difference of one pose's curve in a bigram."""

    pose: str
    largest: float
    """Largest difference; positive if the pose gained weight."""
    at: float
    """Normalised time of the largest difference."""
    rms: float
    """Root mean square difference."""
    area: float
    """Area between the two curves."""


@dataclass(frozen=True, eq=False)
class BigramChange:
    """A bigram on both sides, with its changed poses, largest difference first."""

    before: Side
    after: Side
    poses: tuple[PoseChange, ...]

    @property
    def bigram(self) -> str:
        """The bigram, such as `l-ow`, or the trigram."""
        return self.after.origin.name

    @property
    def word(self) -> str | None:
        """An example word with this bigram."""
        return self.after.origin.word or self.before.origin.word

    @property
    def largest(self) -> float:
        """Largest absolute difference of any pose."""
        return max((abs(pose.largest) for pose in self.poses), default=0.0)

    @property
    def changed(self) -> bool:
        """True if any curve, boundary or waiver differs."""
        before, after = self.before, self.after
        return bool(self.poses) or (before.boundary, before.free) != (after.boundary, after.free)

    def to_dict(self) -> dict[str, Any]:
        """Return the change as JSON data."""
        return {
            "bigram": self.bigram,
            "word": self.word,
            "changed": self.changed,
            "before": _origin(self.before),
            "after": _origin(self.after),
            "poses": [vars(pose) for pose in self.poses],
        }


@dataclass(frozen=True, eq=False)
class Diff:
    """Differences between two characters of one pose set."""

    language: str
    character: str
    against: str
    """Display name of the other side of the comparison."""
    poses: tuple[str, ...]
    total: int
    """Number of bigrams compared."""
    named: tuple[BigramChange, ...]
    """Requested bigrams, or all changed ones; largest difference first."""

    @cached_property
    def changes(self) -> tuple[BigramChange, ...]:
        """The changed bigrams among `named`."""
        return tuple(change for change in self.named if change.changed)

    def to_dict(self) -> dict[str, Any]:
        """Return the comparison as JSON data."""
        return {
            "language": self.language,
            "character": self.character,
            "against": self.against,
            "bigrams": self.total,
            "changed": len(self.changes),
            "unchanged": self.total - len(self.changes),
            "changes": [change.to_dict() for change in self.named],
        }


def diff_banks(
    library: Library,
    language: str,
    character: str,
    against: str | None = None,
    wanted: Sequence[str] = (),
) -> Diff:
    """Compare the bigrams of two characters of one pose set.

    Parameters
    ----------
    against : another character of the pose set; None is what lies beneath: a character's bare pose
        set, or a bare pose set's drafts
    wanted : bigrams such as `l-ow` to compare; none means all, and of those with shades the ones
        that a bank draws
    """
    shelf = PairPacks.open(library, language, character)
    other, words = _beneath(shelf) if against is None else _other(library, shelf, against)
    rows = zip(other.rows(), shelf.rows(), strict=True)
    pairs = {"-".join(after.origin.pair): (before, after) for before, after in rows}
    for key, pair in _shaded(shelf, other, wanted).items():
        pairs[key] = (other.row(pair), shelf.row(pair))
    trigrams = _trigrams(other, shelf)
    known = [*pairs, *trigrams]
    for key in wanted:
        if key not in known:
            name = shelf.language.model.name
            raise LipsyncError(f"unknown bigram '{key}' in {name}; {did_you_mean(key, known)}")
    chosen = list(dict.fromkeys(wanted)) or known
    both = [row for key in chosen if key in pairs for row in pairs[key]]
    sides = [
        Side(row.origin, curves, row.boundary, row.free)
        for row, curves in zip(both, _sampled(both, len(shelf.poses)), strict=True)
    ]
    sides += [side for key in chosen if key in trigrams for side in trigrams[key]]
    found = [_change(*two, shelf.poses) for two in zip(sides[::2], sides[1::2], strict=True)]
    found.sort(key=lambda change: -change.largest)
    return Diff(
        language=shelf.language.model.name,
        character=shelf.character.model.name,
        against=words,
        poses=shelf.poses,
        total=len(chosen),
        named=tuple(change for change in found if wanted or change.changed),
    )


def _shaded(shelf: PairPacks, other: PairPacks, wanted: Sequence[str]) -> dict[str, Pair]:
    """Return the bigrams with shades to compare, which a bank of either side draws.

    The others follow their parents, and are compared if they are asked for.
    """
    named = {*wanted}
    drawn = [*shelf.drawn_shade_pairs(), *other.drawn_shade_pairs()]
    possible = [*shelf.shade_pairs(), *other.shade_pairs()] if named else drawn
    pairs = {"-".join(pair): pair for pair in possible}
    return {key: pair for key, pair in pairs.items() if not named or key in named}


def _beneath(shelf: PairPacks) -> tuple[PairPacks, str]:
    """Return the layers beneath a shelf, the bare pose set or its drafts, and their name."""
    name = shelf.poseset.model.name
    if shelf.character.path == shelf.poseset.path:
        return replace(shelf, banks=()), "its drafts"
    bare = Character(kind="character", format=1, name=name, poseset=name)
    return replace(shelf, character=Pack(bare, shelf.poseset.sources), own_banks=()), name


def _other(library: Library, shelf: PairPacks, against: str) -> tuple[PairPacks, str]:
    """Open another character of the same pose set."""
    other = PairPacks.open(library, shelf.language.model.name, against)
    mine, its = shelf.poseset.model.name, other.poseset.model.name
    if mine != its:
        raise LipsyncError(
            f"'{shelf.character.model.name}' moves the poses of {mine}, '{against}' those of "
            f"{its}; compare characters of one pose set"
        )
    return other, other.character.model.name


def _sampled(rows: Sequence[BigramRow], poses: int) -> Floats:
    """Return (B, K, P) curves, sampled like the tables; a half of a trigram as all of it."""
    whole = [replace(row, span=(0.0, 1.0)) for row in rows]
    return tabulated(whole, poses, kind=np.float64)[1:]


def _trigrams(before: PairPacks, after: PairPacks) -> dict[str, tuple[Side, Side]]:
    """Return both sides of each trigram that either side draws and plays."""
    drawn = [drawn_trigrams(shelf) for shelf in (before, after)]
    both = zip((before, after), drawn, strict=True)
    played = {triple for shelf, own in both for triple in played_trigrams(shelf, own).values()}
    found = {}
    for triple in sorted(played):
        old, new = (own.get(triple) for own in drawn)
        ends = _ends(new or old)
        sides = _trigram_side(before, triple, old, ends), _trigram_side(after, triple, new, ends)
        found["-".join(triple)] = sides
    return found


def _ends(halves: Halves | None) -> tuple[float, float]:
    """Return the boundaries of a trigram."""
    return THIRDS if halves is None else (halves[1].span[0], halves[0].span[1])


def _trigram_side(
    shelf: PairPacks, triple: Triple, halves: Halves | None, ends: tuple[float, float]
) -> Side:
    """Return a trigram of one side, or the larger of its two bigrams at some boundaries."""
    count = len(shelf.poses)
    if halves is not None:
        row = halves[0]
        return Side(row.origin, _sampled([row], count)[0], _ends(halves), row.free)
    rows = [shelf.row(triple[:2]), shelf.row(triple[1:])]
    first, last = ends
    spans = ((0.0, first, last), (first, last, 1.0))
    curves = np.zeros((len(TIMES), count))
    for row, own, span in zip(rows, _sampled(rows, count), spans, strict=True):
        inside = (span[0] <= TIMES) & (span[2] >= TIMES)
        # the boundary of the bigram is put on that of the trigram, as `warp` would
        at = np.interp(TIMES, span, (0, row.boundary, 1))
        for pose, curve in enumerate(own.T):
            curves[:, pose] = np.maximum(curves[:, pose], inside * np.interp(at, TIMES, curve))
    places = (place for row in rows for place in row.origin.places)
    origin = Origin(triple[:2], "bigrams", "", tuple(dict.fromkeys(places)), None, triple)
    return Side(origin, curves, ends, all(row.free for row in rows))


def _change(before: Side, after: Side, poses: Sequence[str]) -> BigramChange:
    gained = after.curves - before.curves
    differs = np.flatnonzero(np.abs(gained).max(axis=0) > SLACK).tolist()
    changes = []
    for pose in differs:
        own = gained[:, pose]
        peak = int(np.abs(own).argmax())
        rms, area = float(np.sqrt(_mean(own**2))), _mean(np.abs(own))
        changes.append(PoseChange(poses[pose], float(own[peak]), float(TIMES[peak]), rms, area))
    changes.sort(key=lambda change: -abs(change.largest))
    return BigramChange(before, after, tuple(changes))


def _mean(values: Floats) -> float:
    """Return the mean over normalised time, by the trapezoidal rule."""
    return float((values[1:] + values[:-1]).mean() / 2)


def _origin(side: Side) -> dict[str, Any]:
    return {
        "layer": side.origin.layer,
        "status": side.origin.status,
        "places": list(side.origin.places),
        "boundary": list(side.boundary) if isinstance(side.boundary, tuple) else side.boundary,
        "contact": "free" if side.free else "hold",
    }


def told(diff: Diff, most: int | None = None) -> str:
    """Return a comparison in words, with figures for at most `most` bigrams."""
    shown = diff.named[:most]
    trigrams = any(change.after.origin.triple for change in shown)
    facts = {
        **vars(diff),
        "changes": diff.changes,
        "shown": shown,
        "units": "bigrams and trigrams" if trigrams else "bigrams",
        "numbers": lambda values: ", ".join(f"{one:g}" for one in values),
    }
    return filled(__package__, "bank_diff", facts).removesuffix("\n")
