"""Text to phonemes and speech, for Python: `transcribe` and `speak`."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, overload

from lipsync_lang.packs.finding import Paths
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.sound.speech.results import raised
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.sound.speech.speaking.transcripts import Transcript
from lipsync_lang.text.lines.markup import Cleaning

PlaceholderValues = Mapping[str, str]
"""Values of placeholders, by name."""

NO_VALUES: PlaceholderValues = MappingProxyType({})


@overload
def transcribe(  # type: ignore[overload-overlap]  # a str comes first, though iterable too
    text: str, language: str | Path, *, values: PlaceholderValues = NO_VALUES, paths: Paths = ()
) -> Transcript: ...
@overload
def transcribe(
    text: Iterable[str],
    language: str | Path,
    *,
    values: PlaceholderValues = NO_VALUES,
    paths: Paths = (),
) -> Iterator[Transcript]: ...
def transcribe(
    text: str | Iterable[str],
    language: str | Path,
    *,
    values: PlaceholderValues = NO_VALUES,
    paths: Paths = (),
) -> Transcript | Iterator[Transcript]:
    """Convert text to phonemes with the `g2p` of the language pack.

    Parameters
    ----------
    text : what to read; of several texts, each in its turn
    language : a language pack's name, tag or file
    values : of placeholders such as ``[player]``, by name
    paths : a folder to search for packs before all others, or several

    Returns
    -------
    A transcript; of several texts an iterator, which yields one for each, in order

    Raises
    ------
    SpeechError
        The language does not read text, or its engine failed.

    Examples
    --------
    >>> ll.transcribe("map", "english").phonemes
    ('bmp', 'ae', 'bmp')
    >>> ll.transcribe("<b>[what]</b>", "english", values={"what": "map"}).text
    'map'
    >>> [one.text for one in ll.transcribe(["map", "moon"], "english")]
    ['map', 'moon']
    """
    speaker = Speaker.of(language, paths, Cleaning(values))
    if isinstance(text, str):
        return next(speaker.transcribe([text]))
    return speaker.transcribe(text)


@overload
def speak(  # type: ignore[overload-overlap]  # as above
    text: str,
    language: str | Path,
    *,
    engine: str | None = None,
    words_per_minute: int | None = None,
    values: PlaceholderValues = NO_VALUES,
    paths: Paths = (),
) -> Schedule: ...
@overload
def speak(
    text: Iterable[str],
    language: str | Path,
    *,
    engine: str | None = None,
    words_per_minute: int | None = None,
    values: PlaceholderValues = NO_VALUES,
    paths: Paths = (),
) -> Iterator[Schedule]: ...
def speak(  # noqa: PLR0913 a text, a language, and options by keyword
    text: str | Iterable[str],
    language: str | Path,
    *,
    engine: str | None = None,
    words_per_minute: int | None = None,
    values: PlaceholderValues = NO_VALUES,
    paths: Paths = (),
) -> Schedule | Iterator[Schedule]:
    """Speak text with the voice of its language pack.

    Parameters
    ----------
    text : what to say; of several texts, each in its turn; ``*word*`` emphasises a word
    language : a language pack's name, tag or file
    engine : another speech engine than the pack's; `none` for estimated times without sound
    words_per_minute : the speed of speech; None is the engine's own
    values : of placeholders such as ``[player]``, by name
    paths : a folder to search for packs before all others, or several

    Returns
    -------
    A schedule; of several texts an iterator, which may take up to 500 texts ahead

    Raises
    ------
    SpeechError
        There is nothing to say, the language can neither read nor speak it, or the engine failed.

    Examples
    --------
    >>> schedule = ll.speak("map", "english")
    >>> schedule.labels, schedule.words[0].text
    (('m', 'æ', 'p', '_'), 'map')
    """
    speaker = Speaker.of(language, paths, Cleaning(values))
    how: dict[str, Any] = {"engine": engine, "words_per_minute": words_per_minute}
    if isinstance(text, str):
        return speaker.speak(text, **how)
    return map(raised, speaker.speak_many(text, **how))
