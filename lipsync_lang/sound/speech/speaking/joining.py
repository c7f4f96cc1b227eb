"""Phoneme times of a transcript: estimated, or aligned with a voice's output."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules.schedule import SILENCE, Schedule, Word
from lipsync_lang.sound.speech.speaking.transcripts import Transcript
from lipsync_lang.text.phonology.align import align
from lipsync_lang.text.phonology.espeak.process import quoted
from lipsync_lang.text.phonology.labels import LENGTH_MARKS, Notation, normalise
from lipsync_lang.text.phonology.manner import Manner

LONG = 1.5
"""Duration ratio of a long sound to a short one."""


def estimate(transcript: Transcript, manner: Manner, notation: Notation) -> Schedule:
    """Estimate times: each label has the duration of its phoneme class, plus pauses.

    It is a `SpeechError` if no part of the text is readable.
    """
    labels: list[str] = []
    lengths: list[float] = []
    words: list[Word] = []
    for word in transcript.words:
        if word.labels:
            words.append(Word(word.text, len(labels), len(labels) + len(word.labels)))
            labels += word.labels
            for label in word.labels:
                value = notation.find(label) or ()
                kinds = [manner.kinds.get(name, "") for name, _ in value]
                middling = manner.durations["stop"]
                length = sum(manner.durations.get(kind, middling) for kind in kinds) or middling
                if len(kinds) > 1 and not {"vowel", "glide"} & set(kinds):
                    length = manner.durations["affricate"]  # or a cluster of consonants
                long = normalise(label).endswith(tuple(LENGTH_MARKS))
                lengths.append(length * LONG if long else length)
        elif labels and labels[-1] != SILENCE and not word.unread:
            labels.append(SILENCE)
            lengths.append(manner.durations["silence"])
    if labels and labels[-1] == SILENCE:
        labels.pop()
        lengths.pop()
    _refuse_nothing(labels, transcript)
    marks = iter(transcript.stress)  # of the labels without the pauses
    stress = tuple(next(marks, None) if label != SILENCE else None for label in labels)
    stress = stress if transcript.stress else ()
    return Schedule(
        tuple(labels), np.concatenate([[0.0], np.cumsum(lengths)]), words=tuple(words),
        notation=transcript.notation, language=transcript.language, estimated=True,
        source=f"text {quoted(transcript.text)}", unread=transcript.unread, stress=stress,
        remarks=transcript.advice,
    )  # fmt: skip


def _refuse_nothing(labels: Sequence[str], transcript: Transcript) -> None:
    if not labels:
        unread = f"; it cannot read {' '.join(transcript.unread)}" if transcript.unread else ""
        raise SpeechError(
            f"{transcript.language} says nothing for {quoted(transcript.text)}{unread}; "
            + "; ".join(transcript.advice or ("check that the text is in its script",))
        )


def join(
    transcript: Transcript, spoken: Schedule, manner: Manner, notations: Mapping[str, Notation]
) -> Schedule:
    """Assign the times of a voice's output to the labels of a transcript.

    Both sequences are aligned by common phonemes. A sound of the voice alone is merged into the
    sound before; a sound of the transcript alone gets a share of the sound before. Pauses come
    from the voice.

    It is a `SpeechError` if no part of the text is readable.
    """
    _refuse_nothing(transcript.labels, transcript)
    label_of, said = _units(transcript.labels_with_pauses, notations[transcript.notation])
    heard_of, heard = _units(spoken.labels, notations[spoken.notation or transcript.notation])
    found = align(said, heard, manner.kinds, SILENCE)
    # A diphthong or an affricate is one label and several common phonemes: only units align. Those
    # of one label divide its time evenly.
    units = np.array(heard_of, np.intp)
    place, count = np.arange(len(units)) - units.searchsorted(units), np.bincount(units)[units]
    low, high = spoken.times[units], spoken.times[units + 1]
    starts = (low + (high - low) * place / count).tolist()
    rows = _rows(label_of, heard, found, starts, float(spoken.end))
    return _scheduled(transcript, spoken, rows)


def _units(labels: Sequence[str], notation: Notation) -> tuple[list[int], list[str]]:
    """Return the label number of each common phoneme, and the common phonemes."""
    owner: list[int] = []
    names: list[str] = []
    for number, label in enumerate(labels):
        value = notation.find(label) if label != SILENCE else None
        for name in [name for name, _ in value or ()] or [label]:
            owner.append(number)
            names.append(name)
    return owner, names


def _rows(
    label_of: Sequence[int],
    heard: Sequence[str],
    found: npt.NDArray[np.intp],
    starts: Sequence[float],
    end: float,
) -> list[tuple[int, float, float]]:
    """Return (label number, start, end) rows in order of time; -1 is a pause."""
    rows: list[tuple[int, float, float]] = []
    begin: float | None = None
    for unit, (start, stop) in enumerate(pairwise([*starts, end])):
        here = int(found[unit])
        number = -1 if heard[unit] == SILENCE else label_of[here] if here >= 0 else None
        if number is None and not rows:
            begin = start if begin is None else begin
        elif rows and number in (None, rows[-1][0]):
            rows[-1] = (*rows[-1][:2], stop)
        elif number is not None and number >= 0 and rows[-2:-1] and rows[-2][0] == number:
            rows[-2:] = [(number, rows[-2][1], stop)]  # rest within one label
        elif number is not None:
            rows.append((number, start if begin is None else begin, stop))
            begin = None
    return rows


def _scheduled(
    transcript: Transcript, spoken: Schedule, rows: Sequence[tuple[int, float, float]]
) -> Schedule:
    """Build a schedule from the rows; labels without a row share a neighbour's time."""
    flat = transcript.labels_with_pauses
    groups = _groups(flat, {number for number, _, _ in rows})
    numbers: list[int] = []
    times: list[float] = [float(spoken.start)]
    for number, start, stop in rows:
        members = groups.get(number, [-1])  # a pause has no label
        numbers += members
        count = len(members)
        times += (stop - (stop - start) * left / count for left in reversed(range(count)))
    labels = tuple(SILENCE if number < 0 else flat[number] for number in numbers)
    marks = _stress_with_pauses(transcript)
    stress = tuple(None if number < 0 else marks[number] for number in numbers) if marks else ()
    if spoken.stress:
        # The strongest stress of the voice's sounds whose middle is in the interval.
        middles = (spoken.times[:-1] + spoken.times[1:]) / 2
        cuts = middles.searchsorted(np.array(times)).tolist()
        stress = tuple(
            min(filter(None, spoken.stress[low:high]), default=None) for low, high in pairwise(cuts)
        )
    return replace(
        spoken, labels=labels, times=np.array(times), stress=stress,
        words=_words(transcript, numbers), notation=transcript.notation,
        language=transcript.language, unread=transcript.unread,
        remarks=(*spoken.remarks, *transcript.advice),
    )  # fmt: skip


def _stress_with_pauses(transcript: Transcript) -> list[int | None]:
    """Return the stress of a transcript's labels, with one place for each pause."""
    if not any(word.stress for word in transcript.words):
        return []
    return [
        mark
        for word in transcript.words
        for mark in word.stress or (None,) * max(len(word.labels), 1)
    ]


def stress_read(
    transcript: Transcript,
    labels: Sequence[str],
    notation: str,
    manner: Manner,
    notations: Mapping[str, Notation],
) -> tuple[int | None, ...]:
    """Return the stress that a transcript states for labels aligned with the same text.

    The labels come from elsewhere, such as a dictionary, and are aligned with the transcript's by
    common phonemes.

    Parameters
    ----------
    labels, notation : labels with pauses, and the name of their notation

    Returns
    -------
    The stress of each label; empty if the transcript states none, or the labels carry their own
    """
    stated = _stress_with_pauses(transcript)
    if not stated or any(notations[notation].stress(label) is not None for label in labels):
        return ()
    label_of, said = _units(transcript.labels_with_pauses, notations[transcript.notation])
    heard_of, heard = _units(labels, notations[notation])
    stress: list[int | None] = [None] * len(labels)
    for unit, at in enumerate(align(said, heard, manner.kinds, SILENCE).tolist()):
        number = label_of[at] if at >= 0 else -1
        if number >= 0 and stated[number] is not None:
            # The mark belongs to the first sound alone: the r of a vowel with r has none.
            stress[heard_of[unit]], stated[number] = stated[number], None
    return tuple(stress)


def _groups(flat: Sequence[str], present: Collection[int]) -> dict[int, list[int]]:
    """Group labels without a time under the timed label before, or else under the first."""
    groups: dict[int, list[int]] = {}
    first = next((n for n, label in enumerate(flat) if n in present and label != SILENCE), None)
    owner = first
    for number, label in enumerate(flat):
        if label == SILENCE:
            continue
        owner = number if number in present else owner
        if owner is not None:
            groups.setdefault(owner, []).append(number)
    return groups


def _words(transcript: Transcript, numbers: Sequence[int]) -> tuple[Word, ...]:
    """Return the words of a transcript with their new label positions."""
    place = {number: index for index, number in enumerate(numbers) if number >= 0}
    words: list[Word] = []
    number = 0
    for word in transcript.words:
        count = max(len(word.labels), 1)
        places = [place[n] for n in range(number, number + count) if n in place and word.labels]
        if places:
            words.append(Word(word.text, places[0], places[-1] + 1))
        number += count
    return tuple(words)
