"""The likeliest way of a sound through phonemes that may follow each other."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.speech.sphinx.acoustic_model import STATES, Floats, Singles

START = -1
"""What stands before a phoneme that the sound may start with."""

NEVER = np.float32(-1e30)


class Run(NamedTuple):
    """A phoneme on the way: its number among those given, its first frame, and the next's."""

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
    """Find the likeliest way, on which every phoneme goes through all its states (Viterbi).

    Parameters
    ----------
    scores : (T, P, `STATES`) logarithm of how likely each state of each phoneme is in each frame
    stay : (P, `STATES`) logarithm of how likely a state lasts another frame
    before : for each phoneme, those that it may follow; `START` for one that may be the first
    ends : phonemes that it must end with; None for anywhere
    turns : (P,) what entering a phoneme adds; nothing unless stated

    Returns
    -------
    Phonemes in order, from frame 0 to T; None where every way is longer than the sound
    """
    count, phones = scores.shape[:2]
    held = stay.astype(np.float32)
    left = np.log(-np.expm1(stay)).astype(np.float32)
    entered = np.zeros(phones, np.float32) if turns is None else turns.astype(np.float32)
    starts = [number for number, others in enumerate(before) if START in others]
    follows = np.full((phones, max(map(len, before))), phones)
    for number, others in enumerate(before):
        real = [other for other in others if other != START]
        follows[number, : len(real)] = real
    now = np.full((phones, STATES), NEVER, np.float32)
    now[starts, 0] = scores[0, starts, 0] + entered[starts]
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
        np.greater(come, now, out=moved[frame])
        np.maximum(come, now, out=now)
        now += scores[frame]
    if ends is None:
        phone, state = divmod(int(now.argmax()), STATES)
    else:
        phone, state = max(ends, key=lambda number: float(now[number, -1])), STATES - 1
    if now[phone, state] <= NEVER / 2:
        return None
    runs: list[Run] = []
    stop = count
    for frame in range(count - 1, 0, -1):
        if moved[frame, phone, state]:
            if state:
                state -= 1
            else:
                runs.append(Run(phone, frame, stop))
                stop, phone, state = frame, int(came[frame, phone]), STATES - 1
    return [*runs, Run(phone, 0, stop)][::-1]
