"""Hypothesis strategies: tables, tracks, motions and frame rates."""

from dataclasses import dataclass
from functools import cache
from math import inf

import numpy as np
from hypothesis import strategies as st

from lipsync_lang import resolve
from lipsync_lang.pipeline.curve import bspline
from lipsync_lang.pipeline.levels import Blend, Dial, Level
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.overlay import Overlay
from lipsync_lang.pipeline.perform import perform
from lipsync_lang.pipeline.prepare import GIVEN
from lipsync_lang.pipeline.tables import RESOLUTION, Bank, Contact, Tables
from lipsync_lang.pipeline.track import lay_track

FREE = 2.0
MOST_POSES = 6
SECONDS = st.one_of(st.floats(0.005, 0.3), st.floats(0.005, 3.0), st.just(0.005), st.just(3.0))
"""Lengths of phonemes."""

ON_A_GRID = st.sampled_from([0.05, 0.1, 0.15, 0.2, 0.25, 0.5, 1.0])
"""Lengths from an aligner, whose boundaries lie on frames."""

RATES = st.one_of(
    st.sampled_from([60, 12, 15, 24000 / 1001, 24, 25, 30000 / 1001, 30, 50, 60, 100, 120, 240]),
    st.floats(12, 240),
)


@cache
def real():
    """The performer of a built-in pair."""
    return resolve("english", "facefx", cache=False)


@dataclass(frozen=True, eq=False, repr=False)
class Line:
    """Common phonemes in time, and their tables."""

    tables: Tables
    ids: np.ndarray
    times: np.ndarray
    edits: tuple[tuple[int, int, int], ...] = ()
    """First phoneme, pose and seed of curve edits over two phonemes."""
    shares: tuple[tuple[float, float], ...] = ()
    """For each style of the tables, its share at the line's start and at its end."""
    dials: tuple[tuple[int, float, float], ...] = ()
    """Step between scaled poses, and their level at the line's start and at its end."""

    def _repr_pretty_(self, printer, _):
        made = self.tables
        own = "built-in" if len(made.priority) > MOST_POSES else f"silence={made.silence}"
        printer.text(
            f"Line({own}, ids={self.ids.tolist()}, times={self.times.tolist()}, "
            f"edits={self.edits}, shares={self.shares}, dials={self.dials})"
        )

    def perform(self, motion, fps):
        source = np.arange(len(self.ids))
        blends = tuple(Blend(style, self._level(*ends)) for style, ends in enumerate(self.shares))
        every = np.arange(len(self.tables.priority))
        dials = tuple(Dial(every % nth == 0, self._level(*ends)) for nth, *ends in self.dials)
        track = lay_track(self.ids, self.times, source, self.tables, motion, blends)
        edits = tuple(self.overlays())
        return perform(self.tables, track, motion, fps, overlays=edits, blends=blends, dials=dials)

    def _level(self, first, last):
        return Level(self.times[[0, -1]], np.array([first, last]))

    @property
    def free(self):
        """(B,) True if every bank in use waives a bigram's contacts."""
        shares = zip(self.tables.styles[: len(self.shares)], self.shares, strict=True)
        heard = [style.free for style, share in shares if max(share) > 0]
        if not self.shares or sum(map(min, self.shares)) < 1:
            heard.append(self.tables.free)
        return np.logical_and.reduce(heard)

    def overlays(self):
        for first, pose, seed in self.edits:
            values = random_curves(np.random.default_rng(seed), 1)[:, 0]
            stop = min(first + 2, len(self.ids))
            yield Overlay(float(self.times[first]), float(self.times[stop]), pose, values)


def random_points(rng):
    """Control points of one curve: n from 2 to 9, times never falling, some of them repeated."""
    count = rng.integers(2, 10)
    times = np.sort(rng.random(count))
    if rng.random() < 0.7:
        times[0], times[-1] = 0, 1
    if rng.random() < 0.2:
        times = np.sort(times.round(1))
    values = rng.random(count)
    values[rng.random(count) < 0.3] = rng.integers(0, 2)
    return np.column_stack((times, values))


@cache
def pool():
    """Cached curves, (500, RESOLUTION + 1), since each takes as long as a whole line."""
    rng, at = np.random.default_rng(0), np.linspace(0, 1, RESOLUTION + 1)
    return np.stack([bspline(random_points(rng)[None], at)[0].clip(0, 1) for _ in range(500)])


def random_curves(rng, poses):
    """Tabulated curves of one bigram: (RESOLUTION + 1, P)."""
    out = np.zeros((RESOLUTION + 1, poses), np.float32)
    shown = rng.random(poses) < 0.7
    out[:, shown] = pool()[rng.integers(len(pool()), size=np.count_nonzero(shown))].T
    return out


@st.composite
def tables(draw, *, loose=False):
    """Random tables with the guarantees of packs.

    Contact poses outrank what they are constrained with, two of them have room for both floors,
    no ceiling lies on a pose that is held up, and `at_most` runs in no circle.

    Loose tables guarantee only that each contact is possible by itself: a phoneme has one contact
    at most, and contacts of different phonemes may exclude each other.
    """
    poses, phonemes = draw(st.integers(1, 6)), draw(st.integers(2, 8))
    kept = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(kept)
    silence = draw(st.sampled_from([0, phonemes - 1]))
    pairs = np.zeros((phonemes, phonemes), np.intp)
    rows = 0
    for a in range(phonemes):
        for b in range(phonemes):
            if not a == b == silence and rng.random() < 0.9:
                rows += 1
                pairs[a, b] = rows
    curves = np.stack([random_curves(rng, poses) for _ in range(rows + 1)])
    curves[0] = 0
    boundary = np.where(rng.random(rows + 1) < 0.5, 0.5, rng.uniform(0.1, 0.9, rows + 1))
    share = draw(st.sampled_from([0, 0, 0.02, 0.3, 1]))
    codes, halves, edges = _trigrams(rng, phonemes, silence, poses, share)
    trigram_rows = rows + 1 + np.arange(2 * len(codes)).reshape(-1, 2)
    curves, boundary = np.concatenate((curves, halves)), np.concatenate((boundary, edges))
    rows += len(edges)
    free = rng.random(rows + 1) < draw(st.sampled_from([0, 0, 0.1]))
    free[0] = False

    held = rng.random(poses) < (0.7 if loose else draw(st.sampled_from([0, 0.4, 0.4])))
    made = _contacts(rng, held, phonemes, silence, loose=loose) if held.any() else ()
    contacts = tuple(made)
    floors = np.max([np.zeros(poses), *(c.floor for c in contacts)], axis=0)
    priority = rng.integers(0, 4, poses).astype(float)
    priority[rng.random(poses) < 0.2] = np.inf
    raised = held & np.isfinite(priority)
    priority[raised] += rng.integers(0, 5)
    thresholds = np.full((poses, poses), FREE)
    for a in range(poses):
        for b in range(a):
            low = min((a, b), key=lambda pose: priority[pose])
            least = 0.05
            if loose:
                both = any((contact.floor[[a, b]] > 0).all() for contact in contacts)
                least = floors[a] + floors[b] if both else max(floors[low], 0.05)
            elif held[a] and held[b]:
                least = floors[a] + floors[b]
            elif held[low]:
                continue
            if least < FREE and rng.random() < 0.6:
                most = min(FREE, 1.2 * least) if loose else FREE
                thresholds[a, b] = thresholds[b, a] = rng.uniform(least, most)
    order = np.argsort(-priority, kind="stable")
    at_most = tuple(
        (int(pose), int(other))
        for place, pose in enumerate(order)
        for other in order[:place]
        if not held[pose] and rng.random() < 0.15
    )
    styles = tuple(_style(rng, curves, free) for _ in range(draw(st.sampled_from([0, 0, 1, 2]))))
    paper = np.where(thresholds < FREE, np.minimum(thresholds, 0.5), thresholds)
    paper = np.minimum(thresholds, np.maximum(paper, _needed(contacts, priority)))
    softness = rng.choice([0, 0.02, 0.035, 0.05], poses)
    early = np.where(rng.random(poses) < 0.4, rng.choice([0.05, 0.12, 0.4], poses), 0)
    highest = rng.uniform(0.1, 1, poses)
    opposed = rng.random((phonemes, poses)) < 0.1
    return Tables(
        curves, boundary, free, pairs, silence, contacts, thresholds, paper, priority, softness,
        early, highest, opposed, at_most, styles, codes, trigram_rows,
    )  # fmt: skip


def _trigrams(rng, phonemes, silence, poses, share):
    """Return the codes of some trigrams, with curves and boundaries of their halves."""
    codes = np.array([c for c in range(phonemes**3) if c // phonemes % phonemes != silence], int)
    codes = codes[rng.random(len(codes)) < share][:40]
    curves, edges = [np.zeros((0, RESOLUTION + 1, poses), np.float32)], []
    at = np.linspace(0, 1, RESOLUTION + 1)
    for _ in codes:
        whole, (first, second) = random_curves(rng, poses), np.sort(rng.uniform(0.1, 0.9, 2))
        for start, end, middle in ((0, second, first), (first, 1, second)):
            half = [np.interp(start + (end - start) * at, at, curve) for curve in whole.T]
            curves.append(np.stack(half, axis=1, dtype=np.float32)[None])
            edges.append((middle - start) / (end - start))
    return codes, np.concatenate(curves), np.array(edges)


def _needed(contacts, priority):
    """Return the minimum threshold of each pair that allows all contacts: (P, P)."""
    floors = np.max([c.floor for c in contacts] or [np.zeros(len(priority))], axis=0)
    yields = np.where(priority[:, None] < priority, floors[:, None], floors)
    both = (floors[:, None] > 0) & (floors > 0)
    return np.where(both, floors[:, None] + floors, yields)


def _style(rng, curves, free):
    """A style, which changes some of the bigrams."""
    own = rng.random(len(curves)) < 0.6
    own[0] = False
    changed = curves.copy()
    for row in np.flatnonzero(own):
        changed[row] = random_curves(rng, curves.shape[2])
    boundary = np.where(own, rng.uniform(0.1, 0.9, len(curves)), 0.5)
    return Bank(changed, boundary, np.where(own, rng.random(len(curves)) < 0.1, free))


def _contacts(rng, held, phonemes, silence, *, loose):
    taken = np.zeros(phonemes, bool)
    for _ in range(rng.integers(2, 4) if loose else rng.integers(1, 3)):
        floor = rng.choice([1, *rng.uniform(0.1, 1, 3)], len(held))
        floor[~held | (rng.random(len(held)) < 0.3)] = 0
        low = rng.choice([0, 0.1, rng.random()])
        free = floor == 0 if loose else ~held
        ceiling = np.where(free & (rng.random(len(held)) < 0.4), low, 1.0)
        wanted = rng.random(phonemes) < 0.5
        wanted[silence] = False
        if loose:
            wanted &= ~taken
            taken |= wanted
        yield Contact(wanted, floor, ceiling)


@st.composite
def lines(  # noqa: PLR0913 what a line may have
    draw, known=None, *, pauses=True, longest=12, steady=False, two_dials=False, loose=False
):
    """Phonemes from 5 ms to 3 s over random tables, or over those of the built-in pair."""
    made = draw(tables(loose=loose)) if known is None else known
    sounds = [i for i in range(len(made.pairs)) if i != made.silence]
    of = st.sampled_from([*sounds, made.silence] if pauses else sounds)
    ids = draw(st.lists(of, min_size=1, max_size=longest))
    seconds = draw(st.sampled_from([SECONDS, SECONDS, ON_A_GRID]))
    lengths = draw(st.lists(seconds, min_size=len(ids), max_size=len(ids)))
    start = draw(st.sampled_from([0.0, 0.0, 0.137, 100.0, -3.3]))
    first, pose = st.integers(0, len(ids) - 1), st.integers(0, len(made.priority) - 1)
    edit = st.tuples(first, pose, st.integers(0, 2**32 - 1))
    edits = draw(st.one_of(st.just([]), st.just([]), st.lists(edit, max_size=3)))
    times = start + np.concatenate(([0.0], np.cumsum(lengths)))
    share, level = st.sampled_from([0, 0.3, 1]), st.sampled_from([0, 0.5, 1, 2])
    shares = [(draw(share), draw(share)) for _ in made.styles]
    dial = st.tuples(st.integers(1, 3), level, level)
    some = st.lists(dial, min_size=2, max_size=2) if two_dials else st.just([draw(dial)])
    dials = draw(st.one_of(st.just([]), st.just([]), some))
    if steady:
        shares = [(first, first) for first, _ in shares]
        dials = [(nth, first, first) for nth, first, _ in dials]
    return Line(made, np.array(ids), times, tuple(edits), tuple(shares), tuple(dials))


def any_lines(**how):
    """Lines over random tables and over the built-in pair alike."""
    return st.one_of(lines(**how), st.deferred(lambda: lines(real().compiled.tables, **how)))


def motions(**fixed):
    """Motion settings, some of them fixed; each field is drawn, or the default."""
    drawn = {
        "stitch": st.sampled_from(["max", "crossfade"]),
        "warp": st.sampled_from(["anchored", "linear"]),
        "smooth": st.sampled_from(["none", "none", "closing", "chord"]),
        "window": st.one_of(st.just(0.13), st.floats(0, 0.4)),
        "anticipate": st.sampled_from([1, 1, 0, 2]),
        "softness": st.sampled_from([1, 1, 0, 0.5, 3]),
        "thresholds": st.sampled_from(["own", "own", "own", "paper"]),
        "speed_limit": st.one_of(st.just(15.0), st.floats(0.5, 60)),
        "silence_reach": st.one_of(st.just(0.25), st.just(0.0), st.floats(0.01, 0.6)),
        "sound_reach": st.one_of(st.just(0.3), st.just(inf), st.floats(0.05, 0.6)),
        "contacts": st.sampled_from(["hold", "hold", "free"]),
        "limit": st.sampled_from(["before", "after"]),
        "hold": st.sampled_from([0, 0, 0, 0.12, 0.4]),
    }
    chosen = {**drawn, **{name: st.just(value) for name, value in fixed.items()}}
    return st.one_of(st.just(Motion(**fixed)), st.builds(Motion, **chosen))


def undisturbed(performance, seconds=0.1):
    """Yield each contact with the frames that hold it, far from contacts that exclude it.

    A lip that presses lets go of the teeth: a contact whose floors pass the threshold with those of
    a contact of higher priority may be missed beside that.
    """
    tables, reach = performance.tables, int(np.ceil(seconds * performance.frames.fps)) + 2
    held = [frames for _, frames in performance.held]
    for contact, frames in zip(tables.contacts, held, strict=True):
        near = np.zeros(len(frames) + 2 * reach, bool)
        for other, others in zip(tables.contacts, held, strict=True):
            excluded = any(
                contact.floor[cap.low] > 0
                and contact.floor[cap.low] + other.floor[cap.high] > cap.threshold
                and other.floor[cap.high] > 0
                for cap in tables.caps
            )
            for frame in np.flatnonzero(others) if excluded else ():
                near[frame : frame + 2 * reach + 1] = True
        near = near[reach : reach + len(frames)]
        kept = np.zeros(len(frames), bool)
        edges = np.flatnonzero(np.diff(frames, prepend=False, append=False))
        for start, stop in edges.reshape(-1, 2):
            kept[start:stop] = not near[start:stop].any()
        yield contact, kept


def assert_promises(performance):
    """Check that poses keep to their speed, and that every undisturbed contact is made."""
    weights, fps = performance.weights(), performance.frames.fps
    assert np.abs(np.diff(weights, axis=0)).max() <= performance.motion.speed_limit / fps + 1e-9
    for contact, frames in undisturbed(performance):
        kept = (weights >= contact.floor - GIVEN - 1e-9).all(axis=1)
        kept &= (weights <= contact.ceiling + GIVEN + 1e-9).all(axis=1)
        starts = np.flatnonzero(np.diff(frames, prepend=False, append=False))
        assert all(kept[start:stop].any() for start, stop in starts.reshape(-1, 2))
