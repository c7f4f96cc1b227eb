"""Speech synthesis by eSpeak NG: text to a schedule with sound.

The library reports events at sample positions. They become contiguous phonemes, and words by
`word_spans`. Corrections to its output:

- Stress marks become numbers; tone digits and ``(en)`` language flags are dropped. Modifiers that
  come as events of their own (``k``, ``ʲ``) join the phoneme before. Names cut at 8 bytes are
  completed.
- A short silence between two sounds is the end of the first, not a pause.
- The time of a stop begins with its closure, a silence of all samples, and not with its release.
- A sound of zero length, spoken within its neighbour, gets a share of the neighbour's time.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice, pairwise, tee
from typing import Any

import numpy as np

from lipsync_lang.base.arrays import Bools, Ints
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule
from lipsync_lang.sound.speech.results import each, exhaust, next_result, raised, tried
from lipsync_lang.sound.speech.speaking.speech_engines import (
    refuse_rate,
    refuse_unspeakable,
    speech_engine,
)
from lipsync_lang.sound.speech.speaking.word_spans import find_words
from lipsync_lang.text.phonology.espeak.espeak_stream import FORKS, answers
from lipsync_lang.text.phonology.espeak.process import (
    GARBAGE,
    Bytes,
    EspeakProcess,
    blank,
    label_of,
    modifies,
    quoted,
    stress_of,
)

MAX_ESPEAK_CHARS = 50_000
"""Text limit in characters, about an hour of speech; longer texts need splitting into lines."""

MIN_SILENCE_SECONDS = 0.09
"""Minimum pause in seconds; a shorter silence between sounds counts as articulation."""

MIN_CLOSURE_SECONDS = 0.03
"""Digital silence before stops lasts 0.032 s or longer, before most vowels 0.025 s at most."""

USUAL_LEVEL = -19.0
"""Level of its voices in dBFS over sounds, without pauses: -20.3 to -17.4 in nine languages."""

SHARE = 0.3
"""Share of the neighbour's time given to a sound of zero length."""

_NAME_BYTES = 8


@speech_engine("espeak")
@dataclass
class Espeak(EspeakProcess):
    """eSpeak NG as a speech engine."""

    def speak(self, text: str, voice: str, *, words_per_minute: int | None = None) -> Schedule:
        """Speak a text with a voice of the library: a language code, title or identifier.

        A variant may follow the voice, as in ``en-us+f3``.

        It is a `SpeechError` if the text is empty, the voice is unknown, or the library fails.
        """
        rate = _rate(words_per_minute)
        spoken = _plain(text)
        header, sound = self.ask("speak", text=spoken, voice=voice, rate=rate)
        return _schedule(header, sound, spoken)

    def speak_many(
        self, texts: Iterable[str], voice: str, *, words_per_minute: int | None = None
    ) -> Iterator[Schedule | SpeechError]:
        """Speak texts as `speak` does, by one process; yield the error of each that fails."""
        source = iter(texts)
        first = list(islice(source, 2))
        rate = tried(_rate)(words_per_minute)
        # An impossible rate is the error of each text.
        if len(first) == 1 or not FORKS or isinstance(rate, SpeechError):
            say = partial(self.speak, voice=voice, words_per_minute=words_per_minute)
            yield from map(tried(say), chain(first, source))
            return
        ours, workers = tee(map(tried(_plain), chain(first, source)))
        spoken = answers(self, (one for one in workers if isinstance(one, str)), voice, rate)

        def made(text: str) -> Schedule:
            return _schedule(*raised(next_result(spoken)), text)

        yield from each(ours, made)
        exhaust(spoken)


def _rate(words_per_minute: int | None) -> int:
    if words_per_minute is None:
        return 0
    # Above its limit, the library compresses the sound, but not the times of its events.
    refuse_rate("eSpeak NG", words_per_minute)
    return int(words_per_minute)


def _plain(text: str) -> str:
    """Replace control and invalid characters by spaces, one for one to keep text positions."""
    plain = blank(text)
    if not any(char.isprintable() and not char.isspace() for char in text):
        raise SpeechError("there is no text to speak; write at least one word")
    refuse_unspeakable(plain, quoted(text), "", MAX_ESPEAK_CHARS)
    return plain


def _schedule(header: dict[str, Any], sound: Bytes, text: str) -> Schedule:
    """Build a schedule from the worker's answer."""
    try:
        samples = np.frombuffer(sound, dtype=np.int16)
        rate = int(header["rate"])
        sounds, marks = read_events(header["events"], header["spelled"], len(samples))
        labels, bounds, index, stress = intervals(sounds, int(MIN_SILENCE_SECONDS * rate))
        bounds = closed(labels, bounds, samples, int(MIN_CLOSURE_SECONDS * rate))
    except (KeyError, ValueError, TypeError, AttributeError):
        raise SpeechError(GARBAGE) from None
    if all(label == SILENCE for label in labels):
        raise SpeechError(
            f"eSpeak NG says nothing for {quoted(text)} in this voice{header['said']}; "
            "check that the text is in the script of the voice"
        )
    return Schedule(
        tuple(labels), np.array(bounds) / rate, notation="ipa", source=f"speech {quoted(text)}",
        words=find_words(text, [(at, index[number]) for at, number in marks], labels),
        audio=Audio(samples, rate, USUAL_LEVEL), stress=tuple(stress) if any(stress) else (),
    )  # fmt: skip


def closed(labels: Sequence[str], bounds: Sequence[int], samples: Ints, least: int) -> list[int]:
    """Move the start of each sound to that of a digital silence before it, of `least` samples.

    The sound before keeps `SHARE` of its time; if none of it sounds, the silence is its own.
    """
    moved, inner = list(bounds), np.array(bounds[1:-1], dtype=int)
    # Few sounds are silent at both ends of the least silence: those alone are searched.
    ends = samples[np.maximum((inner - 1, inner - least), 0)]
    for n in (np.flatnonzero(~_loud(ends).any(axis=0)) + 1).tolist():
        start = bounds[n - 1]
        loud = np.flatnonzero(_loud(samples[start : bounds[n]]))
        end = start + int(loud[-1]) + 1 if len(loud) else start
        if SILENCE not in labels[n - 1 : n + 1] and start < end <= bounds[n] - least:
            moved[n] = max(end, start + round(SHARE * (bounds[n] - start)))
    return moved


def _loud(samples: Ints) -> Bools:
    """Return which samples are no digital silence."""
    return (samples > 1) | (samples < -1)


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
    # Modifiers join the sound before, and silences each other.
    joined: list[SpokenSound] = []
    first: list[int] = []
    for sound in sounds:
        first.append(len(joined))
        last = joined[-1] if joined else None
        if last and last.silent and sound.silent:
            last.end = sound.end
        elif last and not last.silent and modifies(sound.label):
            last.label += sound.label
            last.stress = last.stress or sound.stress
            last.end = sound.end
        else:
            joined.append(SpokenSound(sound.label, sound.start, sound.end, sound.stress))
    first.append(len(joined))
    kept, second = _settled(joined, pause)
    bounds = [sound.start for sound in kept] + [kept[-1].end] if kept else [0]
    labels, stress = [sound.label for sound in kept], [sound.stress for sound in kept]
    return labels, bounds, [second[n] for n in first], stress


def _settled(sounds: Sequence[SpokenSound], pause: int) -> tuple[list[SpokenSound], list[int]]:
    """Merge short silences into neighbours and give length to zero-length sounds."""
    kept: list[SpokenSound] = []
    index: list[int] = []
    for n, sound in enumerate(sounds):
        index.append(len(kept))
        last = kept[-1] if kept else None
        following = sounds[n + 1] if n + 1 < len(sounds) else None
        length = sound.end - sound.start
        if sound.silent and following and following.start == following.end and 0 < length < pause:
            following.start = sound.start  # the silence is the closure of the zero-length sound
        elif sound.silent and last and (last.silent or (following and length < pause)):
            last.end = sound.end
        elif length:
            kept.append(sound)
        elif not sound.silent:
            # Rather the sound before lends some time: those without any mostly close a syllable.
            beside = (s for s in (last, following) if s and not s.silent and s.end > s.start)
            lender = next(beside, None)
            if lender is None or lender.label == sound.label:
                continue
            part = int(SHARE * (lender.end - lender.start))
            if lender is last:
                sound.start = lender.end = sound.end - part
            else:
                sound.end = lender.start = sound.start + part
            if part > 0:
                kept.append(sound)
    return kept, [*index, len(kept)]
