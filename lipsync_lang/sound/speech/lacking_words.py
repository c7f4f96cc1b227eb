"""Words that an aligner found without their phonemes, because its dictionary lacks them.

The aligner finds when such a word is said, and gives it one label for all of it, as for noise. The
language reads the word, and its phonemes fill the time of the word in their estimated proportions.
They are spelled in the notation of the other labels.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from lipsync_lang.base.errors import SpeechError, shortlist
from lipsync_lang.schedules.rows import is_pause
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.timed_words import words_without_phonemes
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.sound.speech.speaking.speech_engines import NO_ENGINE
from lipsync_lang.text.phonology.labels import Notation, recognise


def with_lacking(
    schedule: Schedule, speaker: Speaker, dictionary: str = "the dictionary of the aligner"
) -> Schedule:
    """Return a schedule whose lacking words are read by the language, and a remark on them."""
    numbers = words_without_phonemes(schedule)
    if not numbers:
        return schedule
    names = [schedule.words[number].text for number in numbers]
    known = [label for label in schedule.labels if not is_pause(label)]
    notation = schedule.notation or speaker.manner.notation
    if schedule.notation is None and known and speaker.notations:
        notation = recognise(known, speaker.notations)
    texts = list(dict.fromkeys(names))
    read: dict[str, Schedule] = {}
    if notation in speaker.notations:
        for text, one in zip(texts, speaker.speak_many(texts, engine=NO_ENGINE), strict=True):
            if not isinstance(one, SpeechError):
                spelled = _spelled(one, notation, speaker.notations)
                read |= {text: spelled} if spelled is not None else {}
    fates = {True: "the language reads them instead", False: "the mouth rests there"}
    lacks = {fate: [text for text in texts if (text in read) is fate] for fate in fates}
    told = [
        f"{dictionary} lacks {shortlist(some)}: {fates[fate]}; add the missing words to it"
        for fate, some in lacks.items()
        if some
    ]
    inside = {n: read[name] for n, name in zip(numbers, names, strict=True) if name in read}
    filled = replace(_filled(schedule, inside), notation=notation) if inside else schedule
    return replace(filled, remarks=(*schedule.remarks, *told))


def _spelled(word: Schedule, to: str, notations: Mapping[str, Notation]) -> Schedule | None:
    """Spell the labels of a word in another notation; None if it has none of the sounds."""
    if word.notation == to:
        return word
    labels: dict[tuple[str, ...], str] = {}
    for label, value in notations[to].table.items():
        labels.setdefault(tuple(name for name, _ in value), label)
    spans: list[tuple[str, float, float]] = []
    for label, start, end in zip(word.labels, word.times, word.times[1:], strict=False):
        value = notations[str(word.notation)].find(label) or ()
        sounds = tuple(name for name, _ in value)
        parts = [sounds] if sounds in labels else [(one,) for one in sounds if (one,) in labels]
        edges = np.linspace(start, end, len(parts) + 1).tolist()
        pairs = zip(parts, edges, edges[1:], strict=False)
        spans += [(labels[part], first, stop) for part, first, stop in pairs]
    if not spans:
        return None
    times = [spans[0][1], *(stop for _, _, stop in spans)]
    names = tuple(label for label, _, _ in spans)
    return replace(word, labels=names, times=np.array(times), words=(), stress=(), notation=to)


def _filled(schedule: Schedule, inside: Mapping[int, Schedule]) -> Schedule:
    """Replace the labels of words, each over the time of its word."""
    labels, times = [*schedule.labels], schedule.times.tolist()
    stress = [*(schedule.stress or (None,) * len(schedule))]
    moved = np.arange(len(times))
    # From the last on, so that the numbers of those before still count.
    for number, word in sorted(inside.items(), reverse=True):
        first, stop = schedule.words[number].first, schedule.words[number].stop
        begin, end = schedule.times[[first, stop]]
        steps = (word.times[:-1] - word.start) / (word.end - word.start)
        times[first:stop] = (begin + steps * (end - begin)).tolist()
        labels[first:stop], stress[first:stop] = word.labels, word.stress or (None,) * len(word)
        moved[stop:] += len(word) - (stop - first)
    at = moved.tolist()
    words = (replace(one, first=at[one.first], stop=at[one.stop]) for one in schedule.words)
    return replace(
        schedule,
        labels=tuple(labels),
        times=np.array(times),
        words=tuple(words),
        stress=tuple(stress) if any(mark is not None for mark in stress) else (),
        lines=(),
    )
