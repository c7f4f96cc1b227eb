"""Everything a performance looks up, compiled to arrays."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from lipsync_lang.pipeline.arrays import Bools, Floats, Ints, Singles
from lipsync_lang.pipeline.constrain import FREE, Cap, caps

RESOLUTION = 128
"""Steps of normalised time at which a bigram's curves are tabulated."""


@dataclass(frozen=True, eq=False)
class Contact:
    """What some phonemes demand to be seen: poses held up to a floor, others under a ceiling."""

    phonemes: Bools
    """(N,) True where the common phoneme demands it."""
    floor: Floats
    """(P,) least weight while held; 0 demands nothing."""
    ceiling: Floats
    """(P,) greatest weight while held; 1 forbids nothing."""

    @cached_property
    def raised(self) -> list[int]:
        """Poses that it holds up."""
        return [int(pose) for pose in np.flatnonzero(self.floor > 0)]

    @cached_property
    def lowered(self) -> list[int]:
        """Poses that it keeps down."""
        return [int(pose) for pose in np.flatnonzero(self.ceiling < 1)]


class Bank(NamedTuple):
    """Curves of every bigram in one manner of speaking; row 0 is rest."""

    curves: Singles
    """(B, RESOLUTION + 1, P) weights over normalised time."""
    boundary: Floats
    """(B,) where in normalised time the first phoneme ends."""
    free: Bools
    """(B,) True where a bigram waives the contacts of its two phonemes."""


@dataclass(frozen=True, eq=False)
class Tables:
    """A language and a character, ready to be performed."""

    curves: Singles
    """(B, RESOLUTION + 1, P) weights over normalised time; row 0 is rest."""
    boundary: Floats
    """(B,) where in normalised time the first phoneme ends."""
    free: Bools
    """(B,) True where a bigram waives the contacts of its two phonemes."""
    pairs: Ints
    """(N, N) row of each ordered pair of common phonemes."""
    silence: int
    """Which common phoneme is silence."""
    contacts: tuple[Contact, ...]
    thresholds: Floats
    """(P, P) symmetric, in (0, 2]."""
    paper: Floats
    """(P, P) likewise, where the paper's thresholds are asked for."""
    priority: Floats
    """(P,) larger wins; infinite never yields."""
    softness: Floats
    """(P,) seconds from the middle of a pose's kernel to its end; 0 leaves corners."""
    anticipate: Floats
    """(P,) seconds by which a pose begins early; 0 for those that do not."""
    highest: Floats
    """(P,) the greatest weight that any target gives a pose; 1 where none does."""
    opposed: Bools
    """(N, P) True where a phoneme keeps a pose from beginning early."""
    at_most: tuple[tuple[int, int], ...] = ()
    """(pose, other): pose never above other, in an order in which each other is final."""
    styles: tuple[Bank, ...] = ()
    """Other manners of speaking, row by row like the neutral one."""

    @property
    def neutral(self) -> Bank:
        """The neutral manner of speaking."""
        return Bank(self.curves, self.boundary, self.free)

    @cached_property
    def papers(self) -> Self:
        """These tables with the paper's thresholds."""
        return replace(self, thresholds=self.paper)

    @cached_property
    def caps(self) -> tuple[Cap, ...]:
        """Constraints that can bind, in the order in which they are applied."""
        return caps(self.thresholds, self.priority)

    @cached_property
    def held(self) -> Bools:
        """(P,) True for the poses that some contact holds up."""
        return self.floors > 0

    @cached_property
    def floors(self) -> Floats:
        """(P,) the highest floor of any contact."""
        floors = np.zeros(len(self.priority))
        for contact in self.contacts:
            floors = np.maximum(floors, contact.floor)
        return floors

    @cached_property
    def blockers(self) -> Floats:
        """(P, P) how much a pose at 1 keeps each other from beginning early.

        A pose blocks those it is constrained with, wholly at the highest it ever gets.
        """
        tied = (self.thresholds < FREE) & ~np.eye(len(self.highest), dtype=bool)
        out: Floats = tied / self.highest
        return out
