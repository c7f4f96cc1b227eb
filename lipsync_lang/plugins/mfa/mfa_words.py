"""Words that the dictionary of the Montreal Forced Aligner lacks.

The aligner finds when such a word is said, and gives it one label for all of it. Where the language
reads text in the notation of the other labels, the word gets its phonemes, spread evenly.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lipsync_lang.base.errors import SpeechError, shortlist
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.labels import recognise

UNKNOWN = "spn"
"""Label of a word that the dictionary lacks."""

SILENCES = frozenset({SILENCE, "sil", "sp", UNKNOWN})
"""Labels without a phoneme."""

MAX_SHOWN_WORDS = 8

Labels = tuple[str, ...]


def with_lacking(schedule: Schedule, speaker: Speaker) -> Schedule:
    """Return a schedule whose unknown words are read by the language, and a remark on them."""
    spans = [schedule.labels[word.first : word.stop] for word in schedule.words]
    lacking = [n for n, span in enumerate(spans) if set(span) == {UNKNOWN}]
    if not lacking:
        return schedule
    names = [schedule.words[n].text for n in lacking]
    # The language reads them if it reads text in the notation of the other labels.
    notation = speaker.manner.notation
    read: dict[str, Labels] = {}
    known = [label for label in schedule.labels if label not in SILENCES]
    if notation in speaker.notations and notation == (
        schedule.notation or (recognise(known, speaker.notations) if known else notation)
    ):
        texts = list(dict.fromkeys(names))
        read = {
            text: one.labels
            for text, one in zip(texts, speaker.transcripts(texts), strict=True)
            if not isinstance(one, SpeechError)
        }
    inside = {n: read[name] for n, name in zip(lacking, names, strict=True) if read.get(name)}
    remarks = [
        _remark([name for name in names if read.get(name)], "the language reads them instead"),
        _remark([name for name in names if not read.get(name)], "the mouth rests there"),
    ]
    filled = _filled(schedule, inside) if inside else schedule
    return replace(
        filled,
        notation=notation if inside else schedule.notation,
        remarks=(*schedule.remarks, *filter(None, remarks)),
    )


def _filled(schedule: Schedule, inside: dict[int, Labels]) -> Schedule:
    """Put labels in the place of those of words, evenly over the time of each."""
    labels: list[str] = []
    times: list[float] = []
    starts = {schedule.words[n].first: n for n in inside}
    moved = [0] * (len(schedule) + 1)
    at = 0
    while at < len(schedule):
        moved[at] = len(labels)
        number = starts.get(at)
        stop = at + 1 if number is None else schedule.words[number].stop
        new = (schedule.labels[at],) if number is None else inside[number]
        edges = np.linspace(schedule.times[at], schedule.times[stop], len(new) + 1)
        labels += new
        times += edges[:-1].tolist()
        at = stop
    moved[len(schedule)] = len(labels)
    words = [
        replace(word, first=moved[word.first], stop=moved[word.stop]) for word in schedule.words
    ]
    return replace(
        schedule,
        labels=tuple(labels),
        times=np.array([*times, schedule.end]),
        words=tuple(words),
        lines=(),
    )


def _remark(names: Sequence[str], what: str) -> str:
    if not names:
        return ""
    listed = shortlist(dict.fromkeys(names), MAX_SHOWN_WORDS)
    return f"the MFA dictionary lacks {listed}: {what}; add the missing words to it"
