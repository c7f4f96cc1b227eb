"""Belief: the probability of each phone at each frame, from scores of a phone loop.

Each phone passes through three states. From the last one the loop enters any phone, each as likely
as its share. Scores are scaled down first: neighbouring frames are not independent, so that
unscaled scores would be much too sure.

T frames, N phones, three states; S = 3 N.
"""

from dataclasses import dataclass

import numpy as np

from lipsync_lang.arrays import Floats, Singles

STAY = 0.75
"""Probability of staying in a state for another frame: a phone lasts for 120 ms in the mean."""

SCORE_SHARE = 0.35
"""Factor of the log likelihoods."""


@dataclass(frozen=True, eq=False)
class PhoneLoop:
    """A loop of phones.

    Parameters
    ----------
    shares : (N,) probability of each phone after another
    stay : probability of staying in a state for another frame
    scale : factor of the scores
    """

    shares: Floats
    stay: float = STAY
    scale: float = SCORE_SHARE

    def likelihoods(self, scores: Singles) -> Floats:
        """Return scaled likelihoods of scores (T, N, 3), relative to each frame's best."""
        scaled = self.scale * scores.astype(np.float64)
        likely: Floats = np.exp(scaled - scaled.max(axis=(1, 2), keepdims=True))
        return likely

    def start(self) -> Floats:
        """Return the belief before the first frame: (N, 3)."""
        return np.repeat(self.shares[:, None] / 3, 3, axis=1)

    def forward(self, before: Floats, likely: Floats) -> Floats:
        """Return the belief after one frame more, (N, 3), given that before and likelihoods."""
        now = self.stay * before
        now[:, 1:] += (1 - self.stay) * before[:, :-1]
        now[:, 0] += (1 - self.stay) * before[:, -1].sum() * self.shares
        now *= likely
        now /= now.sum()
        return now

    def backward(self, after: Floats, likely: Floats) -> Floats:
        """Return how well each state, (N, 3), explains what follows it.

        Parameters
        ----------
        after : the same for the frame after, up to a factor
        likely : likelihoods of that frame
        """
        seen = after * likely
        out = self.stay * seen
        out[:, :-1] += (1 - self.stay) * seen[:, 1:]
        out[:, -1] += (1 - self.stay) * (self.shares @ seen[:, 0])
        out /= out.sum()
        return out


class Smoother:
    """Belief with a fixed look-ahead, for frames that arrive in parts.

    Parameters
    ----------
    lag : frames of look-ahead
    """

    def __init__(self, loop: PhoneLoop, lag: int) -> None:
        self.loop, self.lag = loop, lag
        self._now = loop.start()
        self._beliefs: list[Floats] = []
        self._likely: list[Floats] = []

    def push(self, scores: Singles) -> Floats:
        """Return the belief of the frames that are `lag` before the newest: (k, N, 3)."""
        found = []
        for likely in self.loop.likelihoods(scores):
            self._now = self.loop.forward(self._now, likely)
            self._beliefs.append(self._now)
            self._likely.append(likely)
            if len(self._beliefs) > self.lag:
                found.append(self._oldest())
        return np.stack(found) if found else np.zeros((0, *self._now.shape))

    def finish(self) -> Floats:
        """Return the belief of the last frames."""
        found = []
        while self._beliefs:
            found.append(self._oldest())
        return np.stack(found) if found else np.zeros((0, *self._now.shape))

    def _oldest(self) -> Floats:
        after = np.ones_like(self._now)
        for likely in self._likely[:0:-1]:
            after = self.loop.backward(after, likely)
        belief = self._beliefs.pop(0) * after
        self._likely.pop(0)
        out: Floats = belief / belief.sum()
        return out


def smoothed(loop: PhoneLoop, scores: Singles) -> Floats:
    """Return the belief at each frame of a whole sound, by forward-backward.

    Parameters
    ----------
    scores : (T, N, 3)

    Returns
    -------
    (T, N, 3); each frame adds up to 1
    """
    likely = loop.likelihoods(scores)
    belief = np.empty_like(likely)
    now = loop.start()
    for number, here in enumerate(likely):
        belief[number] = now = loop.forward(now, here)
    after = np.ones_like(now)
    for number in range(len(likely) - 2, -1, -1):
        after = loop.backward(after, likely[number + 1])
        belief[number] *= after
        belief[number] /= belief[number].sum()
    return belief
