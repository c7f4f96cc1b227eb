"""From eSpeak NG's events to contiguous phonemes and word marks. Times are sample positions.

Deviations from what the library says:

- Stress marks, tone digits and ``(en)`` language flags are dropped. Modifiers that come as events
  of their own (``k``, ``ʲ``) join the phoneme before. Names cut at 8 bytes are completed.
- A short silence between two sounds is the end of the first, not a pause.
- A sound without length, which the library speaks within its neighbour, gets a part of that.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from lipsync_lang.phonology.espeak.names import label_of, modifies
from lipsync_lang.schedules.schedule import SILENCE

SHARE = 0.3
"""The part of its neighbour that a sound without length gets."""

_NAME_BYTES = 8


@dataclass
class SpokenSound:
    """A label from one sample to another."""

    label: str
    start: int
    end: int

    @property
    def silent(self) -> bool:
        """True for a pause."""
        return self.label == SILENCE


def read_events(
    events: Iterable[Sequence[Any]], spelled: Sequence[str], end: int
) -> tuple[list[SpokenSound], list[tuple[int, int]]]:
    """Return the sounds, and for each word mark its text position and its first sound's number.

    `spelled` are the same phonemes by their whole names; `end` is the length in samples.
    """
    names: list[bytes] = []
    times: list[int] = []
    marks: list[tuple[int, int]] = []
    for kind, sample, value in events:
        if kind == "word":
            marks.append((value - 1, len(names)))
        else:
            names.append(value.encode("latin-1"))
            times.append(min(max(sample, times[-1] if times else 0), end))
    labels = [label_of(name) or SILENCE for name in _completed(names, spelled)]
    spans = pairwise([*times, end])
    sounds = [SpokenSound(label, *span) for label, span in zip(labels, spans, strict=True)]
    lead = times[0] if times else end
    marks = [(position, number + 1) for position, number in marks]
    return [SpokenSound(SILENCE, 0, lead), *sounds], marks


def intervals(sounds: Sequence[SpokenSound], pause: int) -> tuple[list[str], list[int], list[int]]:
    """Make contiguous intervals, each of some length, of sounds that may have none.

    Parameters
    ----------
    sounds : contiguous from 0, silences among them
    pause : samples; a shorter silence between two sounds belongs to the first of them

    Returns
    -------
    n labels, n + 1 boundaries, and for each sound, and for their end, the number of intervals
    that begin before it
    """
    joined, first = _joined(sounds)
    kept, second = _settled(joined, pause)
    bounds = [sound.start for sound in kept] + [kept[-1].end] if kept else [0]
    return [sound.label for sound in kept], bounds, [second[n] for n in first]


def _completed(names: Sequence[bytes], spelled: Sequence[str]) -> list[str]:
    """Decode event names; complete those that were cut, in order, from the spelled-out ones."""
    whole: dict[bytes, list[str]] = {}
    for name in {name for name in names if len(name) == _NAME_BYTES}:
        found = [s for s in spelled if s.encode().startswith(name)]
        count = names.count(name)
        if len(set(found)) == 1:
            whole[name] = found[:1] * count
        elif len(found) == count:
            whole[name] = found[::-1]
    return [
        whole[name].pop() if name in whole else name.decode("utf-8", "ignore") for name in names
    ]


def _joined(sounds: Iterable[SpokenSound]) -> tuple[list[SpokenSound], list[int]]:
    """Join modifiers to the sound before, and silences to each other."""
    joined: list[SpokenSound] = []
    index: list[int] = []
    for sound in sounds:
        index.append(len(joined))
        last = joined[-1] if joined else None
        if last and last.silent and sound.silent:
            last.end = sound.end
        elif last and not last.silent and modifies(sound.label):
            last.label += sound.label
            last.end = sound.end
        else:
            joined.append(SpokenSound(sound.label, sound.start, sound.end))
    return joined, [*index, len(joined)]


def _settled(sounds: Sequence[SpokenSound], pause: int) -> tuple[list[SpokenSound], list[int]]:
    """Give short silences to neighbours, and length to sounds that have none."""
    kept: list[SpokenSound] = []
    index: list[int] = []
    for n, sound in enumerate(sounds):
        index.append(len(kept))
        last = kept[-1] if kept else None
        following = sounds[n + 1] if n + 1 < len(sounds) else None
        length = sound.end - sound.start
        if sound.silent:
            if following and following.start == following.end and 0 < length < pause:
                following.start = sound.start  # a closure: the sound's own, which has no length
            elif last and (last.silent or (following and length < pause) or not length):
                last.end = sound.end
            elif length:
                kept.append(sound)
        elif length or _lend(last, sound, following):
            kept.append(sound)
    return kept, [*index, len(kept)]


def _lend(last: SpokenSound | None, sound: SpokenSound, following: SpokenSound | None) -> bool:
    """Give a sound without length a part of its neighbour; tell whether it got one.

    Preferably the end of the one before, for such sounds mostly close a syllable.
    """
    lender = next((s for s in (last, following) if s and not s.silent and s.end > s.start), None)
    if lender is None or lender.label == sound.label:
        return False
    part = int(SHARE * (lender.end - lender.start))
    if lender is last:
        sound.start = lender.end = sound.end - part
    else:
        sound.end = lender.start = sound.start + part
    return part > 0
