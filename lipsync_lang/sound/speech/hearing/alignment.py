"""Alignment of recordings with their texts, by the aligners of the language pack.

*Alignment* finds phoneme times of a known text. Its result is a schedule with the sound, for
performance like any other schedule. The aligners of a language are tried in order until one is
sure.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import tee, zip_longest
from math import prod
from pathlib import Path
from typing import NamedTuple, overload

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.packs.finding import Paths
from lipsync_lang.schedules.schedule import DOUBTFUL, OTHER_ORDER, SILENCE, Audio, Schedule
from lipsync_lang.sound.speech.hearing.align.aligners import ALIGNERS, Aligner, BatchAligner
from lipsync_lang.sound.speech.results import WrongTextError, exhaust, next_result, raised, tried
from lipsync_lang.sound.speech.sound import SoundSource, sound_of
from lipsync_lang.sound.speech.speaking.speaker import NO_VALUES, PlaceholderValues, Speaker
from lipsync_lang.sound.speech.speaking.transcripts import SureText, WrittenText, as_written, silent
from lipsync_lang.text.lines.cleaning import Cleaning

MAX_DOUBTFUL_WORDS = 5
"""Maximum number of doubtful words in a remark."""

MAX_WAITING_LINES, MAX_WAITING_SECONDS = 64, 600.0
"""Maximum number and length of lines that wait, so that the next aligner starts once for many."""


def engine_and_model(
    named: str | None, stated: str | None, model: str | None = None
) -> tuple[str | None, str | None]:
    """Return the name of an engine and its model; None for a missing name or model.

    Parameters
    ----------
    named : what the user names, which comes first
    stated : what the language's pack states
    model : the pack's model, for the engine that it states

    Raises
    ------
    SpeechError
        Nothing stands before or after the colon.

    Examples
    --------
    >>> engine_and_model("mfa:german_mfa", "warp")
    ('mfa', 'german_mfa')
    >>> engine_and_model("mfa", "mfa:german_mfa")
    ('mfa', 'german_mfa')
    """
    name, own = _parted(named)
    default, default_model = _parted(stated)
    return (default, own or default_model or model) if name in (None, default) else (name, own)


def _parted(spelling: str | None) -> tuple[str | None, str | None]:
    if spelling is None:
        return None, None
    name, colon, model = (part.strip() for part in spelling.partition(":"))
    if not name or (colon and not model):
        raise SpeechError(f"'{spelling}': write NAME, or NAME:MODEL")
    return name, model or None


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
    A schedule; of several recordings an iterator, which reads one recording at a time, keeps ten
    minutes of them where it asks another aligner, and may take up to 500 texts ahead

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
    return raised(*align_many(speaker, [(audio, text)], aligner=aligner))


def align_many(
    speaker: Speaker, recordings: Iterable[tuple[SoundSource, str]], *, aligner: str | None = None
) -> Iterator[Schedule | SpeechError]:
    """Align each recording with its text, as `align` does, with a prepared language.

    Models load once in a process. Sound is read when its turn comes. Lines wait while one of them
    is to be asked of another aligner.

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
    sounding = ((sound, SureText(*text[:2])) for sound, text in theirs if not text.silent)
    found = engines[0].all(sounding, speaker)
    waiting: list[AlignmentAttempt] = []
    for sound, text in ours:
        rest = tried(partial(_rest, text, speaker))
        first = rest(sound) if text.silent else next_result(found)
        waiting.append(AlignmentAttempt(sound, text, [(engines[0].name, first)]))
        lasting = sum(one.seconds for one in waiting)
        many = len(waiting) >= MAX_WAITING_LINES or lasting > MAX_WAITING_SECONDS
        if many or not any(one.unsure for one in waiting):
            yield from finished(waiting, engines[1:], speaker)
            waiting = []
    yield from finished(waiting, engines[1:], speaker)
    exhaust(found)


def _rest(text: WrittenText, speaker: Speaker, sound: Callable[[], Audio]) -> Schedule:
    """Return silence as long as a recording."""
    return silent(text, speaker.manner, sound())


class NamedAligner(NamedTuple):
    """An aligner with its name, and its model of the language."""

    name: str
    aligner: Aligner
    model: str | None

    def all(
        self, pairs: Iterable[tuple[Callable[[], Audio], str]], speaker: Speaker
    ) -> Iterator[Schedule | SpeechError]:
        """Yield for each sound and text the schedule, or the error of aligning it."""
        if isinstance(self.aligner, BatchAligner):
            yield from self.aligner.align_many(pairs, speaker, self.model)
            return

        def align(one: tuple[Callable[[], Audio], str]) -> Schedule:
            return self.aligner.align(one[0](), one[1], speaker, self.model)

        yield from map(tried(align), pairs)


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


@dataclass
class AlignmentAttempt:
    """A line with the results of the aligners that were asked, by name."""

    sound: Callable[[], Audio]
    text: WrittenText
    results: list[tuple[str, Schedule | SpeechError]]

    @property
    def kept(self) -> tuple[str, Schedule | SpeechError]:
        """The result whose times are kept: the first if its words fit, else the most confident."""
        words = getattr(self.results[0][1], "words", ())
        sure = sorted(word.confidence for word in words if word.confidence is not None)
        fits = sure and sure[len(sure) // 2] >= DOUBTFUL
        return self.results[0] if fits else max(self.results, key=lambda one: _sureness(one[1]))

    @property
    def unsure(self) -> bool:
        """True if the next aligner should be asked."""
        told = [one for _, found in self.results for one in getattr(found, "remarks", ())]
        if self.text.silent or any(OTHER_ORDER in one for one in told):
            return False
        return all(_sureness(found) < DOUBTFUL for _, found in self.results)

    @property
    def seconds(self) -> float:
        """Length of the sound in memory."""
        sounds = [one.audio for _, one in self.results if isinstance(one, Schedule)]
        return sum(sound.seconds for sound in sounds if sound is not None)

    @property
    def surest(self) -> Schedule | SpeechError:
        """The result that is kept with the doubts about it, and with the markup of the text."""
        (kept, schedule), first = self.kept, self.results[0][1]
        if isinstance(schedule, SpeechError) or self.text.silent:
            return schedule
        if len(self.results) == 1:
            return as_written(self.text, _doubted(schedule))
        rates = [(name, _sureness(one)) for name, one in self.results]
        asked = ", ".join(f"{n} {'failed' if rate < 0 else f'{rate:.2f}'}" for n, rate in rates)
        failed = f" ({first})" if isinstance(first, SpeechError) else ""
        remark = f"aligned by {kept}; confidence by aligner: {asked}{failed}"
        # a wrong text that is like the sound to one aligner is seldom so to another
        known = [min(max(rate, 0.01), 0.995) for _, rate in rates if rate >= 0]
        odds = prod(rate / (1 - rate) for rate in known) ** (1 / len(known))
        schedule = _doubted(replace(schedule, confidence=odds / (1 + odds)))
        schedule = replace(schedule, remarks=(*schedule.remarks, remark))
        return as_written(self.text, schedule)


def finished(
    lines: Sequence[AlignmentAttempt], others: Sequence[NamedAligner], speaker: Speaker
) -> Iterator[Schedule | SpeechError]:
    """Ask each further aligner about all unsure lines at once, and yield the surest results."""
    for engine in others:
        if unsure := [one for one in lines if one.unsure]:
            pairs = [(one.sound, SureText(*one.text[:2])) for one in unsure]
            answers = engine.all(pairs, speaker)
            for one in unsure:
                one.results.append((engine.name, next_result(answers)))
            exhaust(answers)
    return (one.surest for one in lines)


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
    pace = sum(label != SILENCE for label in schedule.labels) / schedule.end
    told = (
        f"the text hardly fits the recording (confidence {sure:.2f}, {pace:.1f} phonemes a second, "
        f"where 8 to 16 are usual); check that it is the right text, in {schedule.language}"
        + (f"; in doubt: {', '.join(least)}" if least else "")
    )
    return replace(schedule, remarks=(told, *schedule.remarks))


def _sureness(result: Schedule | SpeechError) -> float:
    """Return the confidence of a result: 1 if none is stated, 0 for a wrong text, else -1."""
    if isinstance(result, SpeechError):
        return 0.0 if isinstance(result, WrongTextError) else -1.0
    return 1.0 if result.confidence is None else result.confidence
