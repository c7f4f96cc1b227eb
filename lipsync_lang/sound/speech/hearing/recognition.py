"""Recognition of recordings without a text: their words with times, or their sounds alone."""

from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import overload

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.packs.finding import Paths
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.sound.speech.hearing.alignment import engine_and_model
from lipsync_lang.sound.speech.hearing.recognise.recognisers import (
    RECOGNISERS,
    Recogniser,
    WordRecogniser,
)
from lipsync_lang.sound.speech.results import each, raised, tried
from lipsync_lang.sound.speech.sound import SoundSource, sound_of
from lipsync_lang.sound.speech.speaking.speaker import Speaker


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
    (found,) = recognise_many(speaker, [audio], recogniser=recogniser)
    return raised(found)


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
        chosen, model = _recogniser(speaker, recogniser)
    except SpeechError as error:
        yield from (error for _ in recordings)
        return
    sounds = map(tried(sound_of), recordings)
    yield from each(sounds, partial(chosen.recognise, speaker=speaker, model=model))


def _recogniser(speaker: Speaker, name: str | None) -> tuple[Recogniser, str | None]:
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
