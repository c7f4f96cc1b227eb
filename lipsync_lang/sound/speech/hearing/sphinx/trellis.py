"""Viterbi search for the likeliest path through a phoneme graph."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Floats, Singles
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import STATES

SOUND_START = -1
"""Predecessor of a phoneme at the start of the sound."""

NEVER = np.float32(-1e30)

ACOUSTIC_SCALE = 0.1
"""Weight of a frame's log likelihood where paths are weighed against each other.

Frames that overlap and belong to one sound are no independent evidence.
"""

NEAR_FRAMES = 10
"""Most frames between a boundary and that of the likeliest path."""


class Run(NamedTuple):
    """A phoneme on the path: node number, first frame, and first frame after it."""

    phone: int
    first: int
    stop: int


def likeliest_way(
    scores: Singles,
    stay: Floats,
    before: Sequence[Sequence[int]],
    ends: Sequence[int] | None = None,
    turns: Floats | None = None,
) -> list[Run] | None:
    """Find the likeliest path with every phoneme passing through all its states (Viterbi).

    Parameters
    ----------
    scores : (T, P, `STATES`) log likelihood of each frame in each state
    stay : (P, `STATES`) log probability of staying in a state for another frame
    before : permitted predecessors of each phoneme; `SOUND_START` for the start of the sound
    ends : permitted last phonemes; None for any
    turns : (P,) log score added on entering a phoneme; zero by default

    Returns
    -------
    Phonemes in order, from frame 0 to T; None if every path is longer than the sound
    """
    count, phones = scores.shape[:2]
    held = stay.astype(np.float32)
    # log(1 - exp(stay)), without the loss of digits where `stay` is near 0.
    left = np.log(-np.expm1(stay)).astype(np.float32)
    entered = np.zeros(phones, np.float32) if turns is None else turns.astype(np.float32)
    starts = [number for number, others in enumerate(before) if SOUND_START in others]
    # Rows of predecessors, filled up with the number of phonemes.
    follows = np.full((phones, max(map(len, before))), phones)
    for number, others in enumerate(before):
        real = [other for other in others if other != SOUND_START]
        follows[number, : len(real)] = real
    now = np.full((phones, STATES), NEVER, np.float32)
    now[starts, 0] = scores[0, starts, 0] + entered[starts]
    # One place more: phonemes with few predecessors are filled up with a number that never wins.
    out = np.full(phones + 1, NEVER, np.float32)
    come = np.empty_like(now)
    came = np.zeros((count, phones), np.int32)
    moved = np.zeros((count, phones, STATES), bool)
    rows = np.arange(phones)
    for frame in range(1, count):
        np.add(now[:, -1], left[:, -1], out=out[:phones])
        ways = out[follows]
        choice = ways.argmax(axis=1)
        came[frame] = follows[rows, choice]
        np.add(ways[rows, choice], entered, out=come[:, 0])
        np.add(now[:, :-1], left[:, :-1], out=come[:, 1:])
        now += held
        # Staying wins a tie, so that a phoneme lasts as long as it is no worse.
        np.greater(come, now, out=moved[frame])
        np.maximum(come, now, out=now)
        now += scores[frame]
    if ends is None:
        phone, state = divmod(int(now.argmax()), STATES)
    else:
        phone, state = max(ends, key=lambda number: float(now[number, -1])), STATES - 1
    # Sums of real scores stay far above half of this; below it, no path reaches the end.
    if now[phone, state] <= NEVER / 2:
        return None
    return _traced(moved, came, phone, state)


def _traced(
    moved: npt.NDArray[np.bool_], came: npt.NDArray[np.int32], phone: int, state: int
) -> list[Run]:
    """Return the path that ends in a state, from each frame's entered states and predecessors."""
    runs: list[Run] = []
    stop = len(moved)
    # Backwards, from the last state to the one that entered it.
    for frame in range(stop - 1, 0, -1):
        if moved[frame, phone, state]:
            if state:
                state -= 1
            else:
                runs.append(Run(phone, frame, stop))
                stop, phone, state = frame, int(came[frame, phone]), STATES - 1
    return [*runs, Run(phone, 0, stop)][::-1]


def median_starts(scores: Singles, stay: Floats, runs: Sequence[Run]) -> Floats:
    """Return the median start of each phoneme over all paths near the likeliest one.

    The likeliest path alone jumps where two places of a boundary are nearly as likely. The median
    has the least expected error, and lies between frames.

    Parameters
    ----------
    scores : (T, P, `STATES`) log likelihood of each frame in each state of the P runs
    stay : (P, `STATES`) log probability of staying in a state for another frame
    runs : the likeliest path, from frame 0 to T

    Returns
    -------
    (P,) starts in frames, ascending
    """
    count, phones = scores.shape[:2]
    frames = np.arange(count)[:, None]
    firsts, stops = np.array([[run.first, run.stop] for run in runs]).T
    near = (frames >= firsts - NEAR_FRAMES) & (frames < stops + NEAR_FRAMES)
    likely = np.where(near[..., None], scores * ACOUSTIC_SCALE, NEVER).reshape(count, -1)
    held = stay.ravel()
    left = np.log(-np.expm1(held))
    # Log probabilities of all paths to a state, and from it on. The path so far ends in `[1:]`.
    past = np.full((count, 1 + len(held)), float(NEVER))
    past[0, 1] = likely[0, 0]
    for frame in range(1, count):
        before = past[frame - 1]
        come = before[:-1] + np.append(NEVER, left[:-1])
        past[frame, 1:] = np.logaddexp(before[1:] + held, come) + likely[frame]
    rest = np.full((count, len(held) + 1), float(NEVER))
    rest[-1, -2] = 0.0
    for frame in range(count - 2, -1, -1):
        after = rest[frame + 1, :-1] + likely[frame + 1]
        rest[frame, :-1] = np.logaddexp(after + held, np.append(after[1:] + left[:-1], NEVER))
    whole = past[:, 1:] + rest[:, :-1]
    share = np.exp(whole - whole[-1, -1]).reshape(count, phones, STATES).sum(axis=2)
    # The share of the paths that are in a phoneme or a later one grows from frame to frame.
    begun = np.cumsum(share[:, ::-1], axis=1)[:, ::-1]
    middles = np.arange(count) + 0.5
    later = [np.interp(0.5, begun[:, n], middles) for n in range(1, phones)]
    return np.array([0.0, *later])
