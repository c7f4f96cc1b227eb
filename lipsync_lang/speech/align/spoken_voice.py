"""A text as spoken by the language's voice: the known half of a warp."""

from typing import NamedTuple, Self

import numpy as np

from lipsync_lang.errors import SpeechError
from lipsync_lang.schedules.schedule import SILENCE, Schedule, Word
from lipsync_lang.speech.align.spectrum import Bools, Floats, Ints, Sound, samples_of

TRACTS = (0.88, 0.94, 1.0, 1.06)
"""Candidate vocal tract lengths of the voice; the best fit is used."""

REST_SECONDS = 0.14
"""Least pause of the voice at punctuation; before conjunctions it makes shorter ones."""


class SpokenVoice(NamedTuple):
    """Synthetic speech of a text: phonemes without pauses, and sound."""

    labels: tuple[str, ...]
    words: tuple[Word, ...]
    starts: Floats
    """(n,) start times in seconds."""
    ends: Floats
    """(n,) end times in seconds."""
    samples: Sound
    rests: Ints
    """Numbers of the phonemes before which the voice pauses."""
    schedule: Schedule

    @classmethod
    def of(cls, said: Schedule) -> Self:
        """Take what the language's voice says."""
        if said.audio is None:
            raise SpeechError(
                f"{said.language} has no voice to compare with the recording; add a `tts` "
                "to its pack, or align with another program and give its file (`schedule`)"
            )
        kept = [n for n, label in enumerate(said.labels) if label != SILENCE]
        place = {n: at for at, n in enumerate(kept)}
        spans = [[place[n] for n in range(w.first, w.stop) if n in place] for w in said.words]
        return cls(
            tuple(said.labels[n] for n in kept),
            tuple(
                Word(word.text, span[0], span[-1] + 1)
                for word, span in zip(said.words, spans, strict=True)
                if span
            ),
            said.times[kept],
            said.times[1:][kept],
            samples_of(said.audio),
            np.flatnonzero(said.times[kept][1:] - said.times[1:][kept][:-1] >= REST_SECONDS) + 1,
            said,
        )

    def frames(self, hop: float, count: int) -> tuple[Bools, Ints]:
        """Return the mask of sounding frames (M,) and phoneme starts among these (n,)."""
        times = np.arange(count) * hop
        phone = np.searchsorted(self.starts, times, side="right") - 1
        sounding = (phone >= 0) & (times < self.ends[np.maximum(phone, 0)])
        starts = np.searchsorted(phone[sounding], np.arange(len(self.labels)))
        # a last phoneme shorter than a frame shares the last one
        return sounding, np.minimum(starts, max(int(sounding.sum()) - 1, 0))
