"""Conversion of eSpeak NG events to phonemes and word marks. Times are sample positions.

Corrections to the library's output:

- Stress marks become numbers; tone digits and ``(en)`` language flags are dropped. Modifiers that
  come as events of their own (``k``, ``ʲ``) join the phoneme before. Names cut at 8 bytes are
  completed.
- A short silence between two sounds is the end of the first, not a pause.
- A sound of zero length, spoken within its neighbour, gets a share of the neighbour's time.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from lipsync_lang.phonology.espeak.phoneme_labels import label_of, modifies, stress_of
from lipsync_lang.schedules.schedule import SILENCE

SHARE = 0.3
"""Share of the neighbour's time given to a sound of zero length."""

_NAME_BYTES = 8


@dataclass
class SpokenSound:
    """A label with start and end sample."""

    label: str
    start: int
    end: int
    stress: int | None = None

    @property
    def silent(self) -> bool:
        """True for a pause."""
        return self.label == SILENCE


def read_events(
    events: Iterable[Sequence[Any]], spelled: Sequence[str], end: int
) -> tuple[list[SpokenSound], list[tuple[int, int]]]:
    """Return sounds, and the text position and first sound number of each word mark.

    `spelled` has the same phonemes with complete names; `end` is the length in samples.
    """
    names: list[bytes] = []
    times: list[int] = []
    marks: list[tuple[int, int]] = []
    for kind, sample, value in events:
        if kind == "word":
            marks.append((value - 1, len(names)))
        else:
            names.append(value.encode("latin-1"))
            # The library reports some events out of order, and some after the end of its sound.
            times.append(min(max(sample, times[-1] if times else 0), end))
    # The library cuts names; those are completed from the full spelling, in order.
    whole: dict[bytes, list[str]] = {}
    for name in {name for name in names if len(name) == _NAME_BYTES}:
        found = [s for s in spelled if s.encode().startswith(name)]
        count = names.count(name)
        if len(set(found)) == 1:
            whole[name] = found[:1] * count
        elif len(found) == count:
            # Taken by `pop` from the end, in the order of the text.
            whole[name] = found[::-1]
    completed = [
        whole[name].pop() if name in whole else name.decode("utf-8", "ignore") for name in names
    ]
    sounds = [
        SpokenSound(label_of(name) or SILENCE, *span, stress_of(name))
        for name, span in zip(completed, pairwise([*times, end]), strict=True)
    ]
    lead = times[0] if times else end
    # The silence before the first sound moves all numbers by one.
    marks = [(position, number + 1) for position, number in marks]
    return [SpokenSound(SILENCE, 0, lead), *sounds], marks


def intervals(
    sounds: Sequence[SpokenSound], pause: int
) -> tuple[list[str], list[int], list[int], list[int | None]]:
    """Convert sounds to contiguous intervals of positive length.

    Parameters
    ----------
    sounds : contiguous from 0, with silences
    pause : samples; a shorter silence between two sounds is merged into the first

    Returns
    -------
    n labels, n + 1 boundaries, for each sound, and for their end, the count of intervals before it,
    and n stresses
    """
    joined, first = _joined(sounds)
    kept, second = _settled(joined, pause)
    bounds = [sound.start for sound in kept] + [kept[-1].end] if kept else [0]
    labels, stress = [sound.label for sound in kept], [sound.stress for sound in kept]
    return labels, bounds, [second[n] for n in first], stress


def _joined(sounds: Iterable[SpokenSound]) -> tuple[list[SpokenSound], list[int]]:
    """Merge modifiers into the sound before, and adjacent silences."""
    joined: list[SpokenSound] = []
    index: list[int] = []
    for sound in sounds:
        index.append(len(joined))
        last = joined[-1] if joined else None
        if last and last.silent and sound.silent:
            last.end = sound.end
        elif last and not last.silent and modifies(sound.label):
            last.label += sound.label
            last.stress = last.stress or sound.stress
            last.end = sound.end
        else:
            joined.append(replace(sound))
    return joined, [*index, len(joined)]


def _settled(sounds: Sequence[SpokenSound], pause: int) -> tuple[list[SpokenSound], list[int]]:
    """Merge short silences into neighbours and give length to zero-length sounds."""
    kept: list[SpokenSound] = []
    index: list[int] = []
    for n, sound in enumerate(sounds):
        index.append(len(kept))
        last = kept[-1] if kept else None
        following = sounds[n + 1] if n + 1 < len(sounds) else None
        length = sound.end - sound.start
        if sound.silent:
            if following and following.start == following.end and 0 < length < pause:
                following.start = sound.start  # the silence is the closure of the zero-length sound
            elif last and (last.silent or (following and length < pause) or not length):
                last.end = sound.end
            elif length:
                kept.append(sound)
        elif length or _lend(last, sound, following):
            kept.append(sound)
    return kept, [*index, len(kept)]


def _lend(last: SpokenSound | None, sound: SpokenSound, following: SpokenSound | None) -> bool:
    """Give a zero-length sound a share of its neighbour; return True on success.

    The previous sound is preferred, because zero-length sounds mostly close a syllable.
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
