"""Belief: the probability of each phone at each frame, from scores of a phone loop.

A phone passes through a first, a middle and a last state, and then any phone begins. Its first
state depends on the group of the phone before it, and its last one on the group of the phone after
it (`neighbours` in the pack of the IPA). So a row of S = 2 G + 1 columns has the states of a phone:
G first ones, the middle one, and G last ones.

Scores are scaled down: neighbouring frames are not independent, so that unscaled scores would be
much too sure.

T frames, N phones, G groups.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints, Singles

STAY = 0.6
"""Probability of staying in a state for another frame."""

SCORE_SHARE = 0.25
"""Factor of the log likelihoods."""


@dataclass(frozen=True, eq=False)
class PhoneLoop:
    """A loop of phones.

    Parameters
    ----------
    groups : (N,) group of each phone
    quiet : (N,) True for silence and noises, which a sound begins with
    """

    groups: Ints
    quiet: Bools
    stay: float = STAY
    scale: float = SCORE_SHARE

    @cached_property
    def _member(self) -> Floats:
        """(N, G) 1 for the group of each phone."""
        return np.eye(int(self.groups.max()) + 1)[self.groups]

    @cached_property
    def _entry(self) -> Floats:
        """(N, G) probability of leaving a state for each phone, given its group."""
        return (1 - self.stay) * self._member / self._member.sum(axis=0)

    @cached_property
    def _next(self) -> Floats:
        """(1, G) probability of leaving a middle state for a last one before each group."""
        return (1 - self.stay) * self._member.mean(axis=0, keepdims=True)

    def likelihoods(self, scores: Singles) -> Floats:
        """Return scaled likelihoods of scores (T, N, S), relative to each frame's best."""
        scaled = self.scale * scores.astype(np.float64)
        return np.exp(scaled - scaled.max(axis=(1, 2), keepdims=True))

    @cached_property
    def start(self) -> Floats:
        """(N, S) belief before the first frame."""
        states = 2 * self._member.shape[1] + 1
        return np.repeat(self.quiet[:, None] / (self.quiet.sum() * states), states, axis=1)

    def calmed(self, belief: Floats, voiced: Floats) -> Floats:
        """Return a belief (T, N, S) that is quiet as far as a sound is no voice, (T,)."""
        if (voiced == 1).all():
            return belief
        share = voiced[:, None, None]
        return share * belief + (1 - share) * self.start

    def forward(self, before: Floats, likely: Floats) -> Floats:
        """Return the belief after one frame more, (N, S), given that before and likelihoods."""
        count = self._member.shape[1]
        now = self.stay * before
        # (group of the phone that begins, group of the one that ends)
        passed = before[:, count + 1 :].T @ self._member
        now[:, :count] += self._entry @ passed
        now[:, count] += (1 - self.stay) * before[:, :count].sum(axis=1)
        now[:, count + 1 :] += before[:, count, None] * self._next
        now *= likely
        now /= now.sum()
        return now

    def backward(self, after: Floats, likely: Floats) -> Floats:
        """Return how well each state, (N, S), explains what follows it.

        Parameters
        ----------
        after : the same for the frame after, up to a factor
        likely : likelihoods of that frame
        """
        count = self._member.shape[1]
        seen = after * likely
        out = self.stay * seen
        out[:, :count] += (1 - self.stay) * seen[:, count, None]
        out[:, count] += seen[:, count + 1 :] @ self._next[0]
        # (group of the phone that ended, group of the one that begins)
        begun = seen[:, :count].T @ self._entry
        out[:, count + 1 :] += self._member @ begun
        out /= out.sum()
        return out


def thirds(belief: Floats) -> Floats:
    """Return the belief in the first, the middle and the last state of each phone: (T, N, 3)."""
    count = belief.shape[-1] // 2
    return np.add.reduceat(belief, (0, count, count + 1), axis=-1)


class Smoother:
    """Belief with a fixed look-ahead, for frames that arrive in parts.

    Parameters
    ----------
    lag : frames of look-ahead
    """

    def __init__(self, loop: PhoneLoop, lag: int) -> None:
        self.loop, self.lag = loop, lag
        self._now = loop.start
        self._beliefs: list[Floats] = []
        self._likely: list[Floats] = []

    def push(self, scores: Singles) -> Floats:
        """Return the belief of the frames that are `lag` before the newest: (k, N, S)."""
        found = []
        for likely in self.loop.likelihoods(scores):
            self._now = self.loop.forward(self._now, likely)
            self._beliefs.append(self._now)
            self._likely.append(likely)
            if len(self._beliefs) > self.lag:
                found.append(self._oldest())
        return np.reshape(found, (-1, *self._now.shape))

    def finish(self) -> Floats:
        """Return the belief of the last frames."""
        found = [self._oldest() for _ in range(len(self._beliefs))]
        return np.reshape(found, (-1, *self._now.shape))

    def _oldest(self) -> Floats:
        belief = self._beliefs.pop(0)
        later = self._likely[:0:-1]
        self._likely.pop(0)
        if not later:
            return belief
        after = np.ones_like(belief)
        for likely in later:
            after = self.loop.backward(after, likely)
        belief = belief * after
        return belief / belief.sum()


def smoothed(loop: PhoneLoop, scores: Singles) -> Floats:
    """Return the belief at each frame of a whole sound, by forward-backward.

    Parameters
    ----------
    scores : (T, N, S)

    Returns
    -------
    (T, N, S); each frame adds up to 1
    """
    likely = loop.likelihoods(scores)
    belief = np.empty_like(likely)
    now = loop.start
    for number, here in enumerate(likely):
        belief[number] = now = loop.forward(now, here)
    after = np.ones_like(now)
    for number in range(len(likely) - 2, -1, -1):
        after = loop.backward(after, likely[number + 1])
        belief[number] *= after
        belief[number] /= belief[number].sum()
    return belief
