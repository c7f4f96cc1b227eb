"""Surround and pair: common phonemes in time, silence on both sides (paper 3.2.1, figure 6).

Conventions: times are seconds; (n,) is phonemes, (n - 1,) the bigrams between neighbours. A bigram
uses at most `Motion.silence_reach` of a silence, so that a mouth rests through a long pause, and
moves for at most `Motion.sound_reach` of a sound, so that a long vowel is reached and held. The
paper stretches bigrams over all of a sound or a silence, however long, and adds none.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.pipeline.levels import Blend
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.tables import Bank, Tables

MOMENT_SECONDS = 1e-9
"""Least silence around the phonemes: a frame's share of it is divided by its length."""

NO_TRIGRAMS: Ints = np.zeros(0, np.intp)
NO_TRIGRAMS.setflags(write=False)


@dataclass(frozen=True, eq=False, repr=False)
class Track:
    """n phonemes, silence first and last, and the n - 1 bigrams between neighbours."""

    ids: Ints
    """(n,) common phonemes."""
    bounds: Floats
    """(n + 1,) seconds."""
    reach: Floats
    """(n,) seconds of each phoneme that a bigram uses: all of a sound, some of a silence."""
    moving: Floats
    """(n,) seconds of these in which bigrams move; the middle of a longer sound is held."""
    rows: Ints
    """(n - 1,) table row of each bigram."""
    even: Floats | None
    """(n - 1,) normalised time of the spoken boundary, where bigrams are stretched evenly onto it;
    None where their own boundary is pinned there."""
    waived: Bools
    """(n,) True where a bigram of the phoneme waives its contacts."""
    source: Ints
    """(n,) index of the scheduled phoneme each came from; -1 for the silence around."""
    start: float
    """Seconds at which the schedule starts: a frame lies there."""
    end: float
    """Seconds at which it ends."""
    trigrams: Ints
    """(k,) bigrams that begin a trigram: their rows, and those of the next, are its halves."""

    def boundary(self, bank: Bank) -> Floats:
        """Return the normalised time of each bigram's phoneme boundary: (n - 1,).

        The boundaries of a trigram are pinned always, so that its halves agree where they overlap.
        """
        own = bank.boundary[self.rows]
        if self.even is None:
            return own
        if not len(self.trigrams):
            return self.even
        even = self.even.copy()
        for halves in (self.trigrams, self.trigrams + 1):
            even[halves] = own[halves]
        return even

    @property
    def mixed(self) -> bool:
        """True if only some of the bigrams are stretched evenly, which the kernel cannot do."""
        return self.even is not None and len(self.trigrams) > 0

    def knots(self, number: int, boundary: float) -> tuple[Floats, Floats]:
        """Return the changes of pace within a bigram: seconds and normalised times, (7,) each.

        Between them time runs evenly. Both middles are listed twice, for a long sound is held.
        """
        middle = self.bounds[number + 1]
        before, after = self.reach[number : number + 2]
        half, other = self.moving[number : number + 2] / 2
        seconds = (-before, half - before, -half, 0.0, other, after - other, after)
        past = (1 + boundary) / 2
        place = (0.0, boundary / 2, boundary / 2, boundary, past, past, 1.0)
        return middle + np.array(seconds), np.array(place)


def lay_track(  # noqa: PLR0913, PLR0917 timed phonemes, and the tables of a pair
    ids: Ints,
    times: Floats,
    source: Ints,
    tables: Tables,
    motion: Motion,
    blends: Sequence[Blend] = (),
    *,
    opening: bool = True,
) -> Track:
    """Surround common phonemes with silence and pair neighbours.

    Bigram (p_i, p_i+1) covers (t_i, t_i+2). Silence lends a bigram at most
    `motion.silence_reach`, at the side of the sound. If `motion.ends` is "cut", the silence around
    is a moment, and has no bigrams. Where three phonemes have a trigram, its
    halves take the places of two bigrams; of two trigrams that share a bigram the first plays.

    Parameters
    ----------
    ids : (m,) common phonemes
    times : (m + 1,) boundaries in seconds, rising
    source : (m,) index of each in the schedule
    blends : styles over the neutral bank
    opening : False if phonemes were left out before these, so that no trigram begins with the
        silence put before them
    """
    start, end = float(times[0]), float(times[-1])
    cut = motion.ends == "cut"
    far = max(motion.silence_reach, MOMENT_SECONDS)
    first = 0 if opening or ids[0] == tables.silence else 1
    added = max(motion.added_silence, MOMENT_SECONDS)
    ids, bounds, source = _surrounded(ids, times, source, tables.silence, added)
    length = bounds[1:] - bounds[:-1]
    quiet = ids == tables.silence
    moving = np.minimum(length, np.where(quiet, far, motion.sound_reach))
    reach = np.where(quiet, moving, length)
    rows, begun = tables.pairs[ids[:-1], ids[1:]], NO_TRIGRAMS
    if len(tables.trigrams):
        begun = trigrams_in(ids, tables, first)
        at = tables.trigrams.searchsorted(_codes(ids, tables)[begun])
        rows[begun], rows[begun + 1] = tables.trigram_rows[at].T
    if cut:
        rows[(source[:-1] < 0) | (source[1:] < 0)] = 0  # rest
    even = None if motion.warp == "anchored" else moving[:-1] / (moving[:-1] + moving[1:])
    free = tables.free[rows]
    if blends:
        free = np.logical_and.reduce([bank.free[rows] for bank in _heard(tables, blends)])
    waived = np.zeros(len(ids), bool)
    waived[:-1] |= free
    waived[1:] |= free
    return Track(ids, bounds, reach, moving, rows, even, waived, source, start, end, begun)


def _surrounded(
    ids: Ints, times: Floats, source: Ints, silence: int, far: float
) -> tuple[Ints, Floats, Ints]:
    """Return phonemes with one silence of at least `far` seconds at each end."""
    quiet = ids == silence
    again = quiet[1:] & quiet[:-1]
    if again.any():
        at = again.nonzero()[0] + 1
        ids, source, quiet = (np.delete(a, at) for a in (ids, source, quiet))
        times = np.delete(times, at)
    head, tail = not quiet[0], not quiet[-1]
    bounds = np.empty(len(times) + 2)
    bounds[0], bounds[1:-1], bounds[-1] = times[0] - far, times, times[-1] + far
    bounds = bounds[None if head else 1 : None if tail else -1]
    if not head:
        bounds[0] = min(bounds[0], bounds[1] - far)
    if not tail:
        bounds[-1] = max(bounds[-1], bounds[-2] + far)
    around = np.array([silence])
    nowhere = np.array([-1])
    ids = np.concatenate((around[:head], ids, around[:tail]))
    return ids, bounds, np.concatenate((nowhere[:head], source, nowhere[:tail]))


def trigrams_in(ids: Ints, tables: Tables, first: int = 0) -> Ints:
    """Return the starts of trigrams among common phonemes: (k,) indices of their first phonemes.

    From the left, each is played that shares no bigram with the one before it.

    Parameters
    ----------
    first : index of the first phoneme that may begin one
    """
    known = np.isin(_codes(ids, tables), tables.trigrams).nonzero()[0]
    # a loop, because each choice depends on the one before; trigrams are rare
    begun: list[int] = []
    for at in known[known >= first].tolist():
        if not begun or at > begun[-1] + 1:
            begun.append(at)
    return np.array(begun, np.intp)


def _codes(ids: Ints, tables: Tables) -> Ints:
    """Return the code of each three neighbours, as `Tables.trigrams` has them."""
    size = len(tables.pairs)
    return (ids[:-2] * size + ids[1:-1]) * size + ids[2:]


def _heard(tables: Tables, blends: Sequence[Blend]) -> Iterator[Bank]:
    """Yield the banks with a share at some time, including neutral unless styles take it all."""
    least = sum(float(blend.share.values.min()) for blend in blends)
    if least < 1:
        yield tables.neutral
    for blend in blends:
        if blend.share.values.max() > 0:
            yield tables.styles[blend.style]
