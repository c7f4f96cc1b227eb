"""Viterbi search for the likeliest path through a phoneme graph."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.arrays import Floats, Singles
from lipsync_lang.speech.hearing.sphinx.acoustic_model import STATES

SOUND_START = -1
"""Predecessor of a phoneme at the start of the sound."""

NEVER = np.float32(-1e30)


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
