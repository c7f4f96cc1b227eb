"""Alignment of recordings with their texts, by the aligners of the language pack.

*Alignment* finds phoneme times of a known text. Its result is a schedule with the sound, for
performance like any other schedule. The aligners of a language are tried in order until one is
sure.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import tee, zip_longest
from pathlib import Path
from typing import NamedTuple, overload

from lipsync_lang.errors import SpeechError
from lipsync_lang.lines.markup import Cleaning
from lipsync_lang.packs.finding import Paths
from lipsync_lang.schedules.schedule import DOUBTFUL, Audio, Schedule
from lipsync_lang.speech.hearing.align.aligners import ALIGNERS, Aligner, BatchAligner
from lipsync_lang.speech.hearing.engine_names import engine_and_model
from lipsync_lang.speech.results import exhaust, next_result, raised
from lipsync_lang.speech.sound import SoundSource, sound_of
from lipsync_lang.speech.speaking.speaker import Speaker
from lipsync_lang.speech.speaking.synthesis import NO_VALUES, PlaceholderValues
from lipsync_lang.speech.speaking.written_text import WrittenText, as_written, silent

MAX_DOUBTFUL_WORDS = 5
"""Maximum number of doubtful words in a remark."""


@overload
def align(  # type: ignore[overload-overlap]  # a str comes first, though iterable too
    audio: SoundSource,
    text: str,
    language: str | Path,
    *,
    aligner: str | None = None,
    values: PlaceholderValues = NO_VALUES,
    paths: Paths = (),
) -> Schedule: ...
@overload
def align(
    audio: Iterable[SoundSource],
    text: Iterable[str],
    language: str | Path,
    *,
    aligner: str | None = None,
    values: PlaceholderValues = NO_VALUES,
    paths: Paths = (),
) -> Iterator[Schedule]: ...
def align(  # noqa: PLR0913 a recording, its text, a language, and options
    audio: SoundSource | Iterable[SoundSource],
    text: str | Iterable[str],
    language: str | Path,
    *,
    aligner: str | None = None,
    values: PlaceholderValues = NO_VALUES,
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
    if isinstance(audio, SoundSource):
        if not isinstance(text, str):
            raise SpeechError("`audio` is one recording, so `text` must be one string")
        return aligned(speaker, audio, text, aligner=aligner)
    if isinstance(text, str):
        raise SpeechError(
            "`audio` is a list of recordings, so `text` must be a list of the same length"
        )
    return map(raised, align_many(speaker, _paired(audio, text), aligner=aligner))


def _paired(
    audio: Iterable[SoundSource], texts: Iterable[str]
) -> Iterator[tuple[SoundSource, str]]:
    for one, text in zip_longest(audio, texts):
        if one is None or text is None:
            more = "texts than recordings" if one is None else "recordings than texts"
            raise SpeechError(f"there are more {more}; give one text for each recording")
        yield one, text


def aligned(
    speaker: Speaker, audio: SoundSource, text: str, *, aligner: str | None = None
) -> Schedule:
    """Align as `align` does, with a prepared language."""
    (found,) = align_many(speaker, [(audio, text)], aligner=aligner)
    return raised(found)


def align_many(
    speaker: Speaker, recordings: Iterable[tuple[SoundSource, str]], *, aligner: str | None = None
) -> Iterator[Schedule | SpeechError]:
    """Align each recording with its text, as `align` does, with a prepared language.

    Models load once in a process. Sound is read when its turn comes.

    Yields
    ------
    For each pair, in order, its schedule, or the error that `align` raises
    """
    try:
        engines = aligners(speaker, aligner)
    except SpeechError as error:
        yield from (error for _ in recordings)
        return
    ours, theirs = tee((partial(sound_of, a), speaker.written(text)) for a, text in recordings)
    sounding = ((sound, text.text) for sound, text in theirs if not text.silent)
    found = engines[0].all(sounding, speaker)
    for sound, text in ours:
        try:
            if text.silent:
                yield silent(text, speaker.manner, sound())
            else:
                yield surest(speaker, sound, text, next_result(found), engines)
        except SpeechError as error:
            yield error
    exhaust(found)


class NamedAligner(NamedTuple):
    """An aligner with its name, and its model of the language."""

    name: str
    aligner: "Aligner"
    model: str | None

    def all(
        self, pairs: Iterable[tuple[Callable[[], Audio], str]], speaker: Speaker
    ) -> Iterator[Schedule | SpeechError]:
        """Yield for each sound and text the schedule, or the error of aligning it."""
        if isinstance(self.aligner, BatchAligner):
            yield from self.aligner.align_many(pairs, speaker, self.model)
            return
        for sound, text in pairs:
            try:
                yield self.aligner.align(sound(), text, speaker, self.model)
            except SpeechError as error:
                yield error


def aligners(speaker: Speaker, named: str | None) -> list[NamedAligner]:
    """Return the language's aligners in order, or the one that is named."""
    stated = speaker.manner.audio
    models = dict.fromkeys(stated.align) | {stated.align[0]: stated.model}
    if named is not None:
        # A pack may state `NAME:MODEL`; the name alone means the pack's model, too.
        names = {one: (one, one.partition(":")[0].strip()) for one in models}
        models = {one: models[one] for one in models if named in names[one]} or {named: None}
    pairs = [engine_and_model(named, one, model) for one, model in models.items()]
    return [NamedAligner(n or "", ALIGNERS.find(n or "", SpeechError), m) for n, m in pairs]


def surest(
    speaker: Speaker,
    sound: Callable[[], Audio],
    text: WrittenText,
    first: Schedule | SpeechError,
    engines: Sequence[NamedAligner],
) -> Schedule:
    """Return the most confident result of a language's aligners, tried until one is sure."""
    best, results = first, [(engines[0].name, _sureness(first))]
    for engine in engines[1:]:
        # Most words fit where only other sound beside them makes the line doubtful.
        words = best.words if isinstance(best, Schedule) else ()
        sure = sorted(word.confidence for word in words if word.confidence is not None)
        if _sureness(best) >= DOUBTFUL or (sure and sure[len(sure) // 2] >= DOUBTFUL):
            break
        (other,) = engine.all([(sound, text.text)], speaker)
        results.append((engine.name, _sureness(other)))
        if _sureness(other) > _sureness(best):
            best = other
    if isinstance(best, SpeechError):
        raise best
    schedule = _doubted(best)
    if len(results) > 1:
        asked = ", ".join(
            f"{name} {'failed' if rate < 0 else f'{rate:.2f}'}" for name, rate in results
        )
        kept = max(results, key=lambda one: one[1])[0]
        remark = f"aligned by {kept}, the most confident of: {asked}"
        if isinstance(first, SpeechError):
            remark += f" ({first})"
        schedule = replace(schedule, remarks=(*schedule.remarks, remark))
    return as_written(text, schedule)


def _doubted(schedule: Schedule) -> Schedule:
    """Return a schedule with a remark if it is in doubt, and the words that are least sure."""
    sure = schedule.confidence
    if sure is None or sure >= DOUBTFUL:
        return schedule
    words = [
        (word.confidence, f"'{word.text}' at {schedule.times[word.first]:.1f} s")
        for word in schedule.words
        if word.confidence is not None and word.confidence < DOUBTFUL
    ]
    least = [place for _, place in sorted(words)[:MAX_DOUBTFUL_WORDS]]
    told = (
        f"the text hardly fits the recording (confidence {sure:.2f}); check that it is the right "
        f"text, in {schedule.language}" + (f"; in doubt: {', '.join(least)}" if least else "")
    )
    return replace(schedule, remarks=(told, *schedule.remarks))


def _sureness(result: Schedule | SpeechError) -> float:
    """Return the confidence of a result: -1 for an error, 1 if the aligner states none."""
    if isinstance(result, SpeechError):
        return -1.0
    return 1.0 if result.confidence is None else result.confidence
