"""Alignment and recognition of recordings; the language pack selects the engine.

*Alignment* finds phoneme times of a known text; *recognition* finds the text as well. Both return
a schedule with the sound, for performance like any other schedule.
"""

from pathlib import Path

from lipsync_lang.errors import SpeechError
from lipsync_lang.packs.finding import Paths
from lipsync_lang.phonology.emphasis import emphasised
from lipsync_lang.schedules.schedule import Audio, Schedule
from lipsync_lang.speech.speaking import Speaker, with_emphasis


def align(
    audio: str | Path | Audio,
    text: str,
    language: str | Path,
    *,
    aligner: str | None = None,
    paths: Paths = (),
) -> Schedule:
    """Find when each phoneme of a text is said in a recording of it.

    Parameters
    ----------
    audio : the recording, or a file of it
    text : what is said in it
    language : a language pack's name, tag or file
    aligner : another aligner than the pack's
    paths : a folder to search for packs before all others, or several

    Raises
    ------
    SpeechError
        The recording cannot be read, or nothing of the text fits it.

    Examples
    --------
    >>> spoken = ll.speak("Please buy five maps", "english")
    >>> [word.text for word in ll.align(spoken.audio, "Please buy five maps", "english").words]
    ['Please', 'buy', 'five', 'maps']
    """
    return aligned(Speaker.of(language, paths), audio, text, aligner=aligner)


def recognise(
    audio: str | Path | Audio,
    language: str | Path,
    *,
    recogniser: str | None = None,
    paths: Paths = (),
) -> Schedule:
    """Find the words of a recording and their times.

    Parameters
    ----------
    audio : the recording, or a file of it
    language : a language pack's name, tag or file
    recogniser : another recogniser than the pack's
    paths : a folder to search for packs before all others, or several

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
    return recognised(Speaker.of(language, paths), audio, recogniser=recogniser)


def aligned(
    speaker: Speaker, audio: str | Path | Audio, text: str, *, aligner: str | None = None
) -> Schedule:
    """Align as `align` does, with a prepared language."""
    from lipsync_lang.speech.align.aligners import ALIGNERS

    stated = speaker.manner.audio
    name = aligner or stated.align
    chosen = ALIGNERS.find(name, SpeechError)
    model = stated.model if name == stated.align else None
    marked = emphasised(text)
    return with_emphasis(marked, chosen.align(_sound(audio), marked.text, speaker, model))


def recognised(
    speaker: Speaker, audio: str | Path | Audio, *, recogniser: str | None = None
) -> Schedule:
    """Recognise as `recognise` does, with a prepared language."""
    from lipsync_lang.speech.recognise.recognisers import RECOGNISERS

    stated = speaker.manner.audio
    name = recogniser or stated.recognise
    if name is None:
        raise SpeechError(
            f"{speaker.manner.language} has no recogniser: give the text that is said as well, or "
            "name a recogniser in its pack (`audio: {recognise: ...}`)"
        )
    chosen = RECOGNISERS.find(name, SpeechError)
    model = stated.model if name == stated.recognise else None
    return chosen.recognise(_sound(audio), speaker, model)


def _sound(audio: str | Path | Audio) -> Audio:
    from lipsync_lang.speech.sound import read_audio

    return audio if isinstance(audio, Audio) else read_audio(audio)
