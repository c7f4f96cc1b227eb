"""Print how many contacts are missed beside others, and how many of them a curve could keep.

    python benchmarks/crowded_contacts.py [--lines N]

Random lines are performed in two kinds of random pose sets: `any` has 1 to 4 poses, of which each
contact holds some up and keeps some down, and `hinge` has one pose with a floor for some phonemes
and a ceiling for others. A third of the pose sets has no softness.

missed     contacts that lack some of a floor or a ceiling in one of their frames: more than 0.02,
           or any at all without softness
unsoft     missed contacts that a curve of limited speed could keep, without the softening
possible   missed contacts that a softened curve could keep
far        those among them that lack more than 0.1

A linear programme decides what a curve could do. It is about the poses before the softening, and
has the speed limit, rest at both ends, the constraints after the softening, and every contact that
is kept as conditions. A constraint holds as a sum, so a pose that yields all of itself counts as
not possible.
"""

import argparse
from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.random import Generator
from scipy import sparse
from scipy.optimize import linprog

from lipsync_lang.base.arrays import Bools, Ints
from lipsync_lang.pipeline.constrain import FREE
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.perform import Performance, perform
from lipsync_lang.pipeline.prepare import GIVEN
from lipsync_lang.pipeline.tables import RESOLUTION, Contact, Tables
from lipsync_lang.pipeline.track import lay_track

RATES = (24, 25, 30, 50, 60, 100, 120)
LENGTHS = ((0.02, 0.06), (0.05, 0.12), (0.06, 0.25))
PHONEMES = 6
EXACT = 1e-9


def any_contacts(rng: Generator) -> tuple[list[Contact], int]:
    """Return two or three contacts of different phonemes, and the number of poses."""
    poses = int(rng.integers(1, 5))
    owners = rng.integers(0, 4, PHONEMES)
    contacts = []
    for owner in range(rng.integers(2, 4)):
        floor = rng.choice([1, 0.7, *rng.uniform(0.1, 1, 2)], poses) * (rng.random(poses) < 0.5)
        low = rng.choice([0, 0.1, rng.random()])
        ceiling = np.where((floor == 0) & (rng.random(poses) < 0.5), low, 1.0)
        contacts.append(Contact(_owned(owners == owner), floor, ceiling))
    return contacts, poses


def hinge_contacts(rng: Generator) -> tuple[list[Contact], int]:
    """Return a contact that holds the only pose up, and one that keeps it down."""
    up = Contact(_owned(np.arange(PHONEMES) < 3), rng.choice([0.5, 0.7, 0.9, 1], 1), np.ones(1))
    down = Contact(_owned(np.arange(PHONEMES) == 4), np.zeros(1), rng.choice([0, 0.1, 0.3], 1))
    return ([up, down] if rng.random() < 0.5 else [down, up]), 1


def _owned(phonemes: Bools) -> Bools:
    return phonemes & (np.arange(PHONEMES) > 0)  # silence demands nothing


def random_performance(
    rng: Generator, contacts: Sequence[Contact], poses: int, *, sharp: bool
) -> Performance:
    """Perform 2 to 7 phonemes at one of `RATES`."""
    floors = np.max([contact.floor for contact in contacts], axis=0)
    priority = rng.integers(0, 4, poses) + 4.0 * (floors > 0)
    thresholds = np.full((poses, poses), FREE)
    for one, other in zip(*np.triu_indices(poses, 1), strict=True):
        both = any((contact.floor[[one, other]] > 0).all() for contact in contacts)
        low = one if priority[one] < priority[other] else other
        least = floors[one] + floors[other] if both else max(floors[low], 0.05)
        if least < FREE and rng.random() < 0.6:
            thresholds[[one, other], [other, one]] = rng.uniform(least, min(FREE, least + 0.4))
    rows = PHONEMES**2 + 1
    at = np.linspace(0, np.pi, RESOLUTION + 1)[None, :, None]
    curves = rng.random((rows, 1, poses)) * np.sin(at) ** rng.integers(1, 5, (rows, 1, poses))
    curves[0] = 0
    pairs = np.arange(1, rows).reshape(PHONEMES, PHONEMES)
    pairs[0, 0] = 0
    softness = np.zeros(poses) if sharp else rng.choice([0.02, 0.035, 0.04, 0.05], poses)
    opposed = np.zeros((PHONEMES, poses), bool)
    tables = Tables(
        curves.astype(np.float32), np.full(rows, 0.5), np.zeros(rows, bool), pairs, 0,
        tuple(contacts), thresholds, thresholds, priority, softness, np.zeros(poses),
        np.ones(poses), opposed,
    )  # fmt: skip
    ids = rng.integers(1, PHONEMES, rng.integers(2, 8))
    lengths = rng.uniform(*LENGTHS[rng.integers(3)], len(ids))
    times = np.concatenate(([0], np.cumsum(lengths)))
    track = lay_track(ids, times, np.arange(len(ids)), tables, Motion())
    return perform(tables, track, Motion(), float(rng.choice(RATES)))


def demands(performance: Performance) -> Iterator[tuple[Contact, Ints]]:
    """Yield each phoneme's contact, and the frames that hold it for this phoneme."""
    times, fps, track = performance.frames.times(), performance.frames.fps, performance.track
    reach = max(0.042, 1 / fps) / 2
    for contact, (wanted, held) in zip(performance.tables.contacts, performance.held, strict=True):
        for start, end in zip(track.bounds[:-1][wanted], track.bounds[1:][wanted], strict=True):
            middle = (start + end) / 2
            low, high = min(start + 0.03, middle - reach), max(end - 0.03, middle + reach)
            inside = (times >= low - EXACT) & (times <= high + EXACT)
            yield contact, np.flatnonzero(held & inside)


def possible(
    performance: Performance, kept: Sequence[tuple[Contact, Ints]], given: float, *, soft: bool
) -> bool:
    """Return True if some curves keep all of these contacts."""
    prepared, tables = performance.prepared, performance.tables
    poses, count = len(tables.priority), performance.frames.count
    weights = [sparse.identity(count, format="csr")] * poses
    for blur in prepared.shared if soft else ():
        reach = min(len(blur.kernel) // 2, count - 1)
        middle = len(blur.kernel) // 2
        bands = [
            np.full(count, weight) for weight in blur.kernel[middle - reach :][: 2 * reach + 1]
        ]
        matrix = sparse.dia_matrix((bands, range(-reach, reach + 1)), (count, count)).tocsr()
        for pose in blur.poses:
            weights[pose] = matrix

    def of(pose: int, rows: sparse.spmatrix) -> sparse.spmatrix:
        parts = [sparse.csr_matrix((rows.shape[0], count))] * poses
        return sparse.hstack([*parts[:pose], rows, *parts[pose + 1 :]], format="csr")

    steps = sparse.diags([-np.ones(count - 1), np.ones(count - 1)], [0, 1], (count - 1, count))
    moves = sparse.block_diag([steps] * poses, format="csr")
    sides, limits = [moves, -moves], [np.full(moves.shape[0], prepared.step)] * 2
    for low, high, threshold in tables.caps:
        sides.append(of(low, weights[low]) + of(high, weights[high]))
        limits.append(np.full(count, threshold))
    for contact, frames in kept:
        for pose in contact.raised:
            sides.append(-of(pose, weights[pose][frames]))
            limits.append(np.full(len(frames), given - contact.floor[pose]))
        for pose in contact.lowered:
            sides.append(of(pose, weights[pose][frames]))
            limits.append(np.full(len(frames), given + contact.ceiling[pose]))
    top, ramp = np.ones((poses, count)), prepared.ramps[:, :count]
    top[:, : ramp.shape[1]] = ramp
    top[:, -ramp.shape[1] :] = np.minimum(top[:, -ramp.shape[1] :], ramp[:, ::-1])
    bounds = np.column_stack((np.zeros(poses * count), np.minimum(top, 1).ravel()))
    limit = np.concatenate(limits) + EXACT
    found = linprog(
        np.zeros(len(bounds)), sparse.vstack(sides), limit, bounds=bounds, method="highs"
    )
    return found.status == 0


def count(performance: Performance, totals: Counter[tuple[str, str]]) -> None:
    """Add the contacts of a performance to the totals."""
    weights, soft = performance.weights(), bool(performance.prepared.shared)
    given, kind = (GIVEN, "soft") if soft else (0, "sharp")
    kept: list[tuple[Contact, Ints, float]] = []
    missed: list[tuple[Contact, Ints, float]] = []
    for contact, frames in demands(performance):
        shown = weights[frames]
        short = max((contact.floor - shown).max(), (shown - contact.ceiling).max())
        (kept if short <= given + EXACT else missed).append((contact, frames, short))
    totals[kind, "contacts"] += len(kept) + len(missed)
    totals[kind, "missed"] += len(missed)
    others = [(contact, frames) for contact, frames, _ in kept]
    for contact, frames, short in missed:
        asked = [*others, (contact, frames)]
        able = possible(performance, asked, given, soft=soft)
        totals[kind, "possible"] += able
        totals[kind, "far"] += able and short > 0.1
        totals[kind, "unsoft"] += soft and possible(performance, asked, given, soft=False)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description="Print how many contacts are missed beside others."
    )
    parser.add_argument("--lines", type=int, default=3000, help="of each kind [%(default)s]")
    lines = parser.parse_args().lines
    columns = ("contacts", "missed", "unsoft", "possible", "far")
    print(f"{'':14}" + "".join(f"{name:>10}" for name in columns))
    for name, contacts in (("any", any_contacts), ("hinge", hinge_contacts)):
        totals: Counter[tuple[str, str]] = Counter()
        for seed in range(lines):
            rng = np.random.default_rng(seed)
            count(random_performance(rng, *contacts(rng), sharp=seed % 3 == 0), totals)
        for kind in ("sharp", "soft"):
            row = "".join(f"{totals[kind, column]:>10,}" for column in columns)
            print(f"{name:6} {kind:7}{row}")


if __name__ == "__main__":
    main()
