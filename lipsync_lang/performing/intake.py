"""Intake: reads labels and parts of schedules for a stream. Times are seconds."""

from dataclasses import replace
from itertools import pairwise
from math import isfinite, nan
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.base.errors import LipsyncError, ScheduleError, did_you_mean
from lipsync_lang.packs.finding import IPA
from lipsync_lang.performing.edits import overlays
from lipsync_lang.performing.heard import FedWord, HeardLabel, HeardWord
from lipsync_lang.performing.stress import RAMP_SECONDS
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.text.phonology.g2p.tokens import plain

if TYPE_CHECKING:
    from lipsync_lang.performing.played_pair import PlayedPair
    from lipsync_lang.pipeline.overlay import Overlay
    from lipsync_lang.schedules.schedule import Word
    from lipsync_lang.text.phonology.labels import Value

MAX_STEP_SECONDS = 3600.0
"""Longest phoneme or gap between phonemes; a longer one must be in another unit."""

MAX_LABELS = 4096
"""Maximum number of labels in memory, since a client may send any number of them."""


class Intake:
    """Reads the labels of one stream.

    Parameters
    ----------
    notation : notation of single labels; None for the notation of the language's texts
    emphasis : True if words with emphasis are expected
    """

    def __init__(self, performer: "PlayedPair", notation: str | None, *, emphasis: bool) -> None:
        self.performer, self.emphasis = performer, emphasis
        known = performer.labels.notations
        name = notation or performer.compiled.manner["notation"] or IPA
        if name not in known:
            raise ScheduleError(
                f"{performer.language} has no notation '{name}'; {did_you_mean(name, known)}"
            )
        self.notation: str = name
        self.known: dict[str, tuple[Value, int | None]] = {}

    def label(self, label: object, start: float, end: float | None) -> HeardLabel:
        """Read a label in the stream's notation."""
        if not isinstance(label, str):
            raise ScheduleError(f"{label!r} is not a label; use text")
        if label not in self.known:
            if len(self.known) >= MAX_LABELS:
                self.known.clear()
            place = f"stream at {start:g} s"
            one = Schedule((label,), np.array([0.0, 1.0]), notation=self.notation, source=place)
            reader = self.performer.labels
            mark = reader.notation(one).stress(label)
            self.known[label] = reader.values(one)[0], mark
        value, mark = self.known[label]
        return self._heard(label, start, end, value, mark)._replace(marked=mark is not None)

    def part(
        self, part: Schedule, moved: float
    ) -> tuple[list[HeardLabel], list[HeardWord], list[FedWord]]:
        """Read a part of a schedule; its words count the labels of the part."""
        reader, compiled = self.performer.labels, self.performer.compiled
        named = part if part.notation is not None else replace(part, notation=self.notation)
        values = reader.values(named)
        marks = part.stress or tuple(map(reader.notation(named).stress, part.labels))
        marked = any(mark is not None for mark in marks)
        times = (part.times + moved).tolist()
        labels = [
            self._heard(text, start, end, value, mark)._replace(marked=marked)
            for text, (start, end), value, mark in zip(
                part.labels, pairwise(times), values, marks, strict=True
            )
        ]
        silent = [not label.kind for label in labels]
        words = []
        for word in part.words:
            found = self._word(part, word, silent, moved)
            own = part.language == compiled.language and plain(word.text) in compiled.words
            if found is not None or own:
                for index in range(word.first, word.stop):
                    labels[index] = labels[index]._replace(whole=times[word.first])
            words += [] if found is None else [found]
        spoken = [
            FedWord(word.first, word.stop, times[word.first], word.text, bool(word.emphasis))
            for word in part.words
        ]
        return labels, words, spoken

    def _heard(
        self, text: str, start: float, end: float | None, value: "Value", mark: int | None
    ) -> HeardLabel:
        reader = self.performer.labels
        sounds = tuple((reader.numbers[name], share) for name, share in value)
        kind = reader.kinds[sounds[0][0]] if sounds else ""
        return HeardLabel(start, end, sounds, kind, mark, text=text)

    def _word(
        self, part: Schedule, word: "Word", silent: list[bool], moved: float
    ) -> HeardWord | None:
        """Return the curves and the emphasis of a word; None if it has neither."""
        compiled = self.performer.compiled
        stated = compiled.intensity
        if word.emphasis and stated is not None and not self.emphasis:
            raise LipsyncError(
                f"word {word.text!r} has emphasis; open the stream with `emphasis=True`"
            )
        laid: tuple[Overlay, ...] = ()
        if compiled.word_edits:
            laid = overlays(compiled, replace(part, words=(word,)), silent, None)
        high = word.emphasis * (stated["emphasised"] - 1) if stated is not None else 0.0
        if not laid and not word.emphasis:
            return None
        start, end = (float(part.times[index]) + moved for index in (word.first, word.stop))
        ramp = (start - RAMP_SECONDS, start, end, end + RAMP_SECONDS)
        later = tuple(one._replace(start=one.start + moved, end=one.end + moved) for one in laid)
        return HeardWord(word.first, ramp, high, later)


def second(here: str, value: object) -> float:
    """Return a time as a float; other values are errors."""
    is_number = isinstance(value, (int, float, np.integer, np.floating))
    try:
        number = float(value) if is_number and not isinstance(value, bool) else nan  # type: ignore[arg-type]  # a number
    except OverflowError:
        number = nan
    if not isfinite(number):
        raise ScheduleError(f"{here}: {value!r} is not a time; times are finite numbers of seconds")
    return number


def refuse_jump(here: str, start: float, end: float) -> None:
    """Refuse a step that is longer than any phoneme or pause."""
    if end - start > MAX_STEP_SECONDS:
        raise ScheduleError(
            f"{here}: {start:g} to {end:g} s is longer than {MAX_STEP_SECONDS:g} s; if the times "
            "are in milliseconds, convert them to seconds"
        )
