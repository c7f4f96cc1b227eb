"""Lookup tables of a performance, compiled to arrays.

Conventions: N common phonemes, P poses, B bigram rows, of which row 0 is rest; times within a
bigram are normalised to [0, 1]. Curves are tabulated once, at `RESOLUTION` steps. Contacts,
styles and anticipation are not in the paper.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache
from math import prod
from typing import Any, NamedTuple, Self
from zlib import compress, decompress

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints, Singles
from lipsync_lang.pipeline.constrain import FREE, Bound, Cap, caps, together

RESOLUTION = 128
"""Steps of normalised time at which a bigram's curves are tabulated."""


@dataclass(frozen=True, eq=False)
class Contact:
    """A contact of some phonemes: poses with a floor, and poses with a ceiling."""

    phonemes: Bools
    """(N,) True for the common phonemes that demand the contact."""
    floor: Floats
    """(P,) minimum weight while held; 0 has no effect."""
    ceiling: Floats
    """(P,) maximum weight while held; 1 has no effect."""

    @cached_property
    def raised(self) -> list[int]:
        """Poses that the contact holds up."""
        return [int(pose) for pose in np.flatnonzero(self.floor > 0)]

    @cached_property
    def lowered(self) -> list[int]:
        """Poses that the contact keeps down."""
        return [int(pose) for pose in np.flatnonzero(self.ceiling < 1)]


class Bank(NamedTuple):
    """Curves of every bigram in one manner of speaking; row 0 is rest."""

    curves: Singles
    """(B, RESOLUTION + 1, P) weights over normalised time."""
    boundary: Floats
    """(B,) where in normalised time the first phoneme ends."""
    free: Bools
    """(B,) True where a bigram waives the contacts of its two phonemes."""


@dataclass(frozen=True, eq=False, repr=False)
class Tables:
    """A language and a character, compiled for performance."""

    curves: Singles
    """(B, RESOLUTION + 1, P) weights over normalised time; row 0 is rest."""
    boundary: Floats
    """(B,) where in normalised time the first phoneme ends."""
    free: Bools
    """(B,) True where a bigram waives the contacts of its two phonemes."""
    pairs: Ints
    """(N, N) row of each ordered pair of common phonemes."""
    silence: int
    """Index of the common phoneme for silence."""
    contacts: tuple[Contact, ...]
    thresholds: Floats
    """(P, P) symmetric, in (0, 2]."""
    paper: Floats
    """(P, P) the same with the paper's thresholds."""
    priority: Floats
    """(P,) larger wins; infinite never yields."""
    softness: Floats
    """(P,) seconds from the middle of a pose's kernel to its end; 0 leaves corners."""
    anticipate: Floats
    """(P,) seconds by which a pose begins early; 0 for those that do not."""
    highest: Floats
    """(P,) maximum weight of a pose in any target; 1 without a target."""
    opposed: Bools
    """(N, P) True for phonemes that prevent the anticipation of a pose."""
    at_most: tuple[tuple[int, int], ...] = ()
    """(pose, other): pose never above other, in an order in which each other is final."""
    styles: tuple[Bank, ...] = ()
    """Other manners of speaking, row by row like the neutral one."""
    trigrams: Ints = field(default_factory=lambda: np.zeros(0, np.intp))
    """(K,) the code (a N + b) N + c of each three common phonemes that play a trigram, rising."""
    trigram_rows: Ints = field(default_factory=lambda: np.zeros((0, 2), np.intp))
    """(K, 2) the rows of its first two phonemes and of its last two."""

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
    def binding(self) -> tuple[Bound, ...]:
        """The same constraints, joined by yielding pose and threshold."""
        return together(self.caps)

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
        """(P, P) share by which a pose at 1 prevents the anticipation of each other pose.

        A pose blocks those it is constrained with, wholly at the highest it ever gets.
        """
        tied = (self.thresholds < FREE) & ~np.eye(len(self.highest), dtype=bool)
        return tied / self.highest

    @cached_property
    def prepared(self) -> dict[Any, Any]:
        """Values that `prepare` derived from these tables, by motion and frame rate."""
        return {}

    @property
    def arrays(self) -> dict[str, np.ndarray[Any, Any]]:
        """Every array by name; those of contacts and styles are numbered, as `style.0.free`."""
        own = {f.name: getattr(self, f.name) for f in fields(self)}
        found = {name: value for name, value in own.items() if isinstance(value, np.ndarray)}
        for number, contact in enumerate(self.contacts):
            parts = {f.name: getattr(contact, f.name) for f in fields(contact)}
            found |= {f"contact.{number}.{part}": array for part, array in parts.items()}
        for number, bank in enumerate(self.styles):
            found |= {f"style.{number}.{part}": array for part, array in bank._asdict().items()}
        return found

    @classmethod
    def of(
        cls, arrays: Mapping[str, Any], silence: int, at_most: tuple[tuple[int, int], ...]
    ) -> Self:
        """Return the tables of named arrays, in the order of `arrays`."""
        owners: dict[tuple[str, ...], dict[str, Any]] = {}
        for name, array in arrays.items():
            *owner, part = name.split(".")
            owners.setdefault(tuple(owner), {})[part] = array
        own = owners.pop(()) | {"silence": silence, "at_most": at_most}
        contacts = (Contact(**parts) for (kind, _), parts in owners.items() if kind == "contact")
        styles = (Bank(**parts) for (kind, _), parts in owners.items() if kind == "style")
        return cls(**own, contacts=tuple(contacts), styles=tuple(styles))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle to a third of the size; the compressed bytes are cached."""
        return _unpacked, self._packed

    @cached_property
    def _packed(self) -> tuple[Any, ...]:
        arrays = self.arrays
        # padded, so that the array after each is aligned, as in the cache
        content = b"".join(a.tobytes() + b"\0" * (-a.nbytes % 64) for a in arrays.values())
        layout = tuple((name, array.dtype.str, array.shape) for name, array in arrays.items())
        return compress(content, 1), layout, self.silence, self.at_most


@lru_cache(maxsize=8)
def _unpacked(
    packed: bytes,
    layout: tuple[tuple[str, str, tuple[int, ...]], ...],
    silence: int,
    at_most: tuple[tuple[int, int], ...],
) -> Tables:
    """Unpickle tables, read-only: the animations that other processes send share them."""
    content = decompress(packed)
    arrays: dict[str, Any] = {}
    offset = 0
    for name, dtype, shape in layout:
        arrays[name] = np.frombuffer(content, dtype, prod(shape), offset).reshape(shape)
        offset += -(-arrays[name].nbytes // 64) * 64
    tables = Tables.of(arrays, silence, at_most)
    vars(tables)["_packed"] = packed, layout, silence, at_most
    return tables
