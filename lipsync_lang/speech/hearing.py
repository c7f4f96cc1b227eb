"""Alignment and recognition of recordings; the language pack selects the engine.

*Alignment* finds phoneme times of a known text; *recognition* finds the text as well. Both return
a schedule with the sound, for performance like any other schedule.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, overload

from lipsync_lang.errors import SpeechError
from lipsync_lang.lines.markup import Cleaning
from lipsync_lang.packs.finding import Paths
from lipsync_lang.schedules.schedule import Audio, Schedule
from lipsync_lang.speech.engine_names import engine_and_model
from lipsync_lang.speech.in_turn import each, in_turn, raised, refused, tried
from lipsync_lang.speech.speaking import NO_VALUES, Speaker, Values
from lipsync_lang.speech.written_text import SilentTextError, WrittenText

if TYPE_CHECKING:
    from lipsync_lang.speech.recognise.recognisers import Recogniser

Recording = str | Path | Audio
"""A sound, or a file of it."""


@overload
def align(  # type: ignore[overload-overlap]  # a str comes first, though iterable too
    audio: Recording,
    text: str,
    language: str | Path,
    *,
    aligner: str | None = None,
    values: Values = NO_VALUES,
    paths: Paths = (),
) -> Schedule: ...
@overload
def align(
    audio: Iterable[Recording],
    text: Iterable[str],
    language: str | Path,
    *,
    aligner: str | None = None,
    values: Values = NO_VALUES,
    paths: Paths = (),
) -> Iterator[Schedule]: ...
def align(  # noqa: PLR0913 a recording, its text, a language, and options
    audio: Recording | Iterable[Recording],
    text: str | Iterable[str],
    language: str | Path,
    *,
    aligner: str | None = None,
    values: Values = NO_VALUES,
    paths: Paths = (),
) -> Schedule | Iterator[Schedule]:
    """Find when each phoneme of a text is said in a recording of it.

    Parameters
    ----------
    audio : the recording, or a file of it; or several
    text : what is said in it; or what is said in each
    language : a language pack's name, tag or file
    aligner : another aligner than the pack's; `NAME:MODEL` names its model as well
    values : of placeholders in the texts, by name
    paths : a folder to search for packs before all others, or several

    Returns
    -------
    A schedule; of several recordings an iterator, which reads one recording at a time, and may take
    up to 500 texts ahead

    Raises
    ------
    SpeechError
        A recording cannot be read, nothing of the text fits it, or there are more recordings than
        texts.

    Examples
    --------
    >>> spoken = ll.speak("Please buy five maps", "english")
    >>> [word.text for word in ll.align(spoken.audio, "Please buy five maps", "english").words]
    ['Please', 'buy', 'five', 'maps']
    """
    speaker = Speaker.of(language, paths, Cleaning(values))
    if isinstance(audio, Recording):
        if not isinstance(text, str):
            raise SpeechError("`audio` is one recording, so `text` must be one string")
        return aligned(speaker, audio, text, aligner=aligner)
    if isinstance(text, str):
        raise SpeechError(
            "`audio` is a list of recordings, so `text` must be a list of the same length"
        )
    return map(raised, align_many(speaker, _paired(audio, text), aligner=aligner))


def _paired(audio: Iterable[Recording], texts: Iterable[str]) -> Iterator[tuple[Recording, str]]:
    for one, text in zip_longest(audio, texts):
        if one is None or text is None:
            more = "texts than recordings" if one is None else "recordings than texts"
            raise SpeechError(f"there are more {more}; give one text for each recording")
        yield one, text


@overload
def recognise(  # type: ignore[overload-overlap]  # as above
    audio: Recording,
    language: str | Path,
    *,
    recogniser: str | None = None,
    paths: Paths = (),
) -> Schedule: ...
@overload
def recognise(
    audio: Iterable[Recording],
    language: str | Path,
    *,
    recogniser: str | None = None,
    paths: Paths = (),
) -> Iterator[Schedule]: ...
def recognise(
    audio: Recording | Iterable[Recording],
    language: str | Path,
    *,
    recogniser: str | None = None,
    paths: Paths = (),
) -> Schedule | Iterator[Schedule]:
    """Find the words of a recording and their times.

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
        The recording cannot be read, or the language has no recogniser.

    Examples
    --------
    >>> spoken = ll.speak("Please buy five maps", "english")
    >>> ll.recognise(spoken.audio, "english").recognised
    True
    """
    speaker = Speaker.of(language, paths)
    if isinstance(audio, Recording):
        return recognised(speaker, audio, recogniser=recogniser)
    return map(raised, recognise_many(speaker, audio, recogniser=recogniser))


def aligned(
    speaker: Speaker, audio: Recording, text: str, *, aligner: str | None = None
) -> Schedule:
    """Align as `align` does, with a prepared language."""
    (found,) = align_many(speaker, [(audio, text)], aligner=aligner)
    return raised(found)


def align_many(
    speaker: Speaker, recordings: Iterable[tuple[Recording, str]], *, aligner: str | None = None
) -> Iterator[Schedule | SpeechError]:
    """Align each recording with its text, as `align` does, with a prepared language.

    Models load once in a process. Sound is read when its turn comes.

    Yields
    ------
    For each pair, in order, its schedule, or the error that `align` raises
    """
    from lipsync_lang.speech.align.choosing import aligners, surest

    try:
        engines = aligners(speaker, aligner)
    except SpeechError as error:
        return refused(recordings, error)
    marked = (_written(speaker, audio, text) for audio, text in recordings)
    # results are wrapped, so that an error keeps its recording for the next aligner
    found = in_turn(
        marked,
        lambda good: ((one,) for one in engines[0].all(((s, t.text) for s, t in good), speaker)),
    )
    heard = each(found, lambda pair: surest(speaker, *pair[0], pair[1][0], engines))
    return map(partial(_or_silence, speaker), heard)


Source = Callable[[], Audio]


class SilentRecordingError(SpeechError):
    """The text of a recording contains only markup."""

    def __init__(self, sound: Source, text: SilentTextError) -> None:
        super().__init__(str(text))
        self.sound, self.text = sound, text


def _written(
    speaker: Speaker, audio: Recording, text: str
) -> tuple[Source, WrittenText] | SilentRecordingError:
    """Return a recording with the part of its text that is said; an error if there is none."""
    sound, found = partial(_sound, audio), speaker.sounding(text)
    return (
        SilentRecordingError(sound, found) if isinstance(found, SilentTextError) else (sound, found)
    )


def _or_silence(speaker: Speaker, result: Schedule | SpeechError) -> Schedule | SpeechError:
    if not isinstance(result, SilentRecordingError):
        return result
    silent = result

    def rest(sound: Source) -> Schedule:
        return raised(speaker.or_silence(silent.text, sound()))

    return tried(rest)(silent.sound)


def recognised(speaker: Speaker, audio: Recording, *, recogniser: str | None = None) -> Schedule:
    """Recognise as `recognise` does, with a prepared language."""
    (found,) = recognise_many(speaker, [audio], recogniser=recogniser)
    return raised(found)


def recognise_many(
    speaker: Speaker, recordings: Iterable[Recording], *, recogniser: str | None = None
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
        return refused(recordings, error)

    def recognise_one(audio: Recording) -> Schedule:
        return chosen.recognise(_sound(audio), speaker, model)

    return map(tried(recognise_one), recordings)


def _recogniser(speaker: Speaker, name: str | None) -> "tuple[Recogniser, str | None]":
    """Return the language's recogniser, or another by name, and its model."""
    from lipsync_lang.speech.recognise.recognisers import RECOGNISERS

    stated = speaker.manner.audio
    name, model = engine_and_model(name, stated.recognise, stated.model)
    if name is None:
        raise SpeechError(
            f"{speaker.manner.language} has no recogniser: give the spoken text as well, or "
            "name a recogniser in its pack (`audio: {recognise: ...}`), such as `whisper:FOLDER`, "
            "or `phones`, which recognises single sounds"
        )
    return RECOGNISERS.find(name, SpeechError), model


def _sound(audio: Recording) -> Audio:
    from lipsync_lang.speech.sound import read_audio

    return audio if isinstance(audio, Audio) else read_audio(audio)
