"""Recognition of recordings without a text: their words with times, or their sounds alone."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby, pairwise
from pathlib import Path
from typing import overload

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import SpeechError, shortlist
from lipsync_lang.packs.finding import Paths
from lipsync_lang.schedules.phoneme_changes import with_changes
from lipsync_lang.schedules.rows import LabelRow
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule
from lipsync_lang.sound.speech.hearing.alignment import engine_and_model
from lipsync_lang.sound.speech.hearing.recognise.recognisers import (
    RECOGNISERS,
    Recogniser,
    WordRecogniser,
)
from lipsync_lang.sound.speech.results import each, raised, tried
from lipsync_lang.sound.speech.sound import SoundSource, sound_of
from lipsync_lang.sound.speech.speaking.speaker import Speaker

GAP_SECONDS = 0.3
"""Shortest silence beside recognised words in which others are looked for."""

WORDLESS_SECONDS = 0.15
"""Shortest speech in it; the end of a word that is heard a little later is shorter."""

WORDLESS_POWER = 0.03
"""Least power of such speech, as a share of that of the words: 15 dB less."""

HELD_TONE_SECONDS = 0.3
"""Mean length of its sounds beyond which they are tones of music: those of speech have some 0.1."""


@overload
def recognise(  # type: ignore[overload-overlap]  # a path comes first
    audio: SoundSource, language: str | Path, *, recogniser: str | None = None, paths: Paths = ()
) -> Schedule: ...
@overload
def recognise(
    audio: Iterable[SoundSource],
    language: str | Path,
    *,
    recogniser: str | None = None,
    paths: Paths = (),
) -> Iterator[Schedule]: ...
def recognise(
    audio: SoundSource | Iterable[SoundSource],
    language: str | Path,
    *,
    recogniser: str | None = None,
    paths: Paths = (),
) -> Schedule | Iterator[Schedule]:
    """Find the words of a recording and their times, or what its sound alone tells.

    A language whose pack names no recogniser is heard by one of words that is installed and knows
    it, such as Whisper, by pocketsphinx, if the pack names a model of its own, or else by `sound`:
    as phonemes without words.

    Parameters
    ----------
    audio : the recording, or a file of it; or several
    language : a language pack's name, tag or file
    recogniser : another recogniser than the pack's; `NAME:MODEL` names its model as well
    paths : a folder to search for packs before all others, or several

    Returns
    -------
    A schedule; of several recordings an iterator, which reads one at a time

    Raises
    ------
    SpeechError
        The recording cannot be read, or the recogniser is not installed.

    Examples
    --------
    >>> spoken = ll.speak("Please buy five maps", "english")
    >>> ll.recognise(spoken.audio, "english").recognised
    True
    """
    speaker = Speaker.of(language, paths)
    if isinstance(audio, SoundSource):
        return recognised(speaker, audio, recogniser=recogniser)
    return map(raised, recognise_many(speaker, audio, recogniser=recogniser))


def recognised(speaker: Speaker, audio: SoundSource, *, recogniser: str | None = None) -> Schedule:
    """Recognise as `recognise` does, with a prepared language."""
    return raised(*recognise_many(speaker, [audio], recogniser=recogniser))


def recognise_many(
    speaker: Speaker, recordings: Iterable[SoundSource], *, recogniser: str | None = None
) -> Iterator[Schedule | SpeechError]:
    """Recognise each recording, as `recognise` does, with a prepared language.

    Models load once in a thread. Sound is read when its turn comes.

    Yields
    ------
    For each recording, in order, its schedule, or the error that `recognise` raises
    """
    try:
        chosen, model = chosen_recogniser(speaker, recogniser)
    except SpeechError as error:
        yield from (error for _ in recordings)
        return
    sounds = map(tried(sound_of), recordings)
    found = each(sounds, partial(chosen.recognise, speaker=speaker, model=model))
    yield from each(found, partial(with_wordless_speech, speaker))


def with_wordless_speech(speaker: Speaker, found: Schedule) -> Schedule:
    """Let the mouth follow the sound where somebody speaks, but no word was recognised.

    Recognisers miss words; Whisper, for one, does not repeat words without end. The recogniser
    `sound` tells speech from silence, breath and hiss. Speech is nearly as loud as the words, and
    its sounds change, unlike tones of music. A schedule without words stays as it is.
    """
    audio, notation = found.audio, speaker.notations.get(found.notation or "")
    if audio is None or notation is None or not found.words:
        return found
    levels = [_power(audio, one.start, one.end) for one in found.words]
    least = WORDLESS_POWER * float(np.mean(levels))
    gaps = {
        at: (start, end)
        for at, (start, end) in enumerate(pairwise(found.times.tolist()))
        if found.labels[at] == SILENCE
        and end - start >= GAP_SECONDS
        and _power(audio, start, end) * (end - start) >= least * WORDLESS_SECONDS
    }
    try:
        heard = RECOGNISERS.find("sound", SpeechError).recognise(audio, speaker) if gaps else found
    except SpeechError:  # its model is not installed, or the language has no IPA
        return found
    known = speaker.notations[heard.notation or ""]
    # The first label of a sound is the usual one.
    spelled = {value: label for label, value in [*notation.table.items()][::-1]}
    labels = [spelled.get(known.find(label) or (), SILENCE) for label in heard.labels]
    sounds = {at: _sounds(audio, labels, heard.times.clip(*gap), least) for at, gap in gaps.items()}
    spoken = {at: own for at, own in sounds.items() if any(one.label != SILENCE for one in own)}
    return _filled(found, spoken) if spoken else found


def _power(audio: Audio, start: float, end: float) -> float:
    """Return the mean square of the samples between two times."""
    part = audio.samples[round(start * audio.rate) : round(end * audio.rate)]
    return float(np.square(part.astype(np.float64)).mean()) if part.size else 0.0


def _sounds(audio: Audio, labels: Sequence[str], times: Floats, least: float) -> list[LabelRow]:
    """Return the sounds of a gap, outside of which all `times` are equal; silence is one of them.

    Stretches that are too short, too faint or too steady for speech are silence.
    """
    edges = times.tolist()
    inside = np.flatnonzero(np.diff(times) > 0).tolist()
    heard = [LabelRow(labels[at], edges[at], edges[at + 1]) for at in inside]
    found: list[LabelRow] = []
    for silent, some in groupby(heard, key=lambda one: one.label == SILENCE):
        run = list(some)
        start, end = run[0].start, run[-1].end
        speech = (
            not silent
            and WORDLESS_SECONDS <= end - start <= HELD_TONE_SECONDS * len(run)
            and _power(audio, start, end) >= least
        )
        if not speech and found and found[-1].label == SILENCE:
            run = [LabelRow(SILENCE, found.pop().start, end)]
        elif not speech:
            run = [LabelRow(SILENCE, start, end)]
        found += run
    return found


def _filled(found: Schedule, sounds: Mapping[int, Sequence[LabelRow]]) -> Schedule:
    """Return a schedule with sounds in the place of some of its silences."""
    changes = [(at, (SILENCE,), [one.label for one in own]) for at, own in sounds.items()]
    inner = {at: [one.start for one in own[1:]] for at, own in sounds.items()}
    times = [t for at, time in enumerate(found.times) for t in (time, *inner.get(at, ()))]
    speech = [[one for one in own if one.label != SILENCE] for own in sounds.values()]
    told = shortlist([f"{own[0].start:.1f} to {own[-1].end:.1f} s" for own in speech])
    wordless = sum(one.end - one.start for own in speech for one in own)
    words = sum(word.end - word.start for word in found.words)
    sure = found.confidence
    return replace(
        with_changes(found, changes),
        times=np.array(times),
        remarks=(*found.remarks, f"speech without words, whose mouth follows the sound: {told}"),
        confidence=None if sure is None else sure * words / (words + wordless),
    )


def chosen_recogniser(speaker: Speaker, name: str | None) -> tuple[Recogniser, str | None]:
    """Return the language's recogniser, or another by name, and its model."""
    stated = speaker.manner.audio
    if name is None and stated.recognise is None:
        for one in RECOGNISERS.values():
            if isinstance(one, WordRecogniser) and one.knows(speaker):
                return one, None
    # a model with a notation is of the language itself
    otherwise = "pocketsphinx" if stated.model and stated.notation else "sound"
    found, model = engine_and_model(name, stated.recognise or otherwise, stated.model)
    return RECOGNISERS.find(found or otherwise, SpeechError), model
