"""A listener without an ear: each pose has the loudness of the sound."""

import numpy as np

from lipsync_lang.pipeline.perform import FinalFrames


class FakeListener:
    """Frames at 60 per second, of nine poses, final `delay` seconds after their sound."""

    def __init__(self, rate, delay=0.08, fps=60, poses=9):
        self.rate, self.delay, self.fps, self.poses = rate, delay, fps, poses
        self.delays, self.phones = {"belief": delay}, ("A", "B")
        self.belief = np.array([0.25, 0.75])
        self.sound, self.heard, self.given = np.zeros(0), 0, 0

    def push(self, samples):
        self.sound = np.concatenate([self.sound[-self.rate :], samples])  # a second is enough
        self.heard += len(samples)
        return self._until(self.heard / self.rate - self.delay)

    def finish(self):
        return self._until(self.heard / self.rate)

    def _until(self, seconds):
        count = max(int(seconds * self.fps + 1e-6) + 1, self.given) if seconds >= 0 else self.given
        times = np.arange(self.given, count) / self.fps
        self.given = count
        first = self.heard - len(self.sound)
        at = np.minimum((times * self.rate).astype(int) - first, len(self.sound) - 1)
        return FinalFrames(times, np.tile(np.abs(self.sound[at])[:, None], self.poses))
