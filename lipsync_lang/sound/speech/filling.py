"""Phonemes of words whose times are known, read by the language's G2P within the given times.

Words between two pauses are read together, because many are said differently alone. A word that the
reader joins to its neighbour, or splits unlike the file, is read alone. The phonemes of a word keep
their proportions, estimated or found in a recording, and fill the word's time.
"""

import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate
from pathlib import Path

import numpy as np

from lipsync_lang.base.errors import SpeechError, shortlist
from lipsync_lang.packs.finding import Paths
from lipsync_lang.schedules.phoneme_changes import excerpt
from lipsync_lang.schedules.schedule import DOUBTFUL, SILENCE, SNAP_SECONDS, Audio, Schedule, Word
from lipsync_lang.schedules.timed_words import TimedWord, TimedWords
from lipsync_lang.schedules.timing_readers import Timings
from lipsync_lang.sound.speech.hearing.alignment import align_many
from lipsync_lang.sound.speech.lacking_words import with_lacking
from lipsync_lang.sound.speech.sound import SoundSource, sound_of, with_sound
from lipsync_lang.sound.speech.speaking.joining import join
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.sound.speech.speaking.speech_engines import NO_ENGINE
from lipsync_lang.text.phonology.g2p.tokens import UNSPACED

PHRASE_PAUSE_SECONDS = 0.2
"""Shortest gap between words that parts them into phrases, which are read one by one."""

PHRASE_MARGIN_SECONDS = 0.05
"""Sound around a phrase that an aligner hears, as given boundaries are not exact."""

_UNSPACED_CHAR = re.compile(f"[{UNSPACED}]")

WordPhonemes = Schedule | SpeechError | None
"""Phonemes of one given word, to fill its time; None if the word must be read alone."""


def fill_words(
    timed: Timings, language: str | Path, *, audio: SoundSource | None = None, paths: Paths = ()
) -> Schedule:
    """Read timed words, and fill the time of each with its phonemes.

    Of a schedule, these are the words that the dictionary of its aligner lacked.

    Parameters
    ----------
    timed : words or a schedule from `read_timings`
    language : a language pack's name, tag or file
    audio : the recording, in which an aligner finds the phonemes of each phrase; None to estimate
        their times
    paths : a folder to search for packs before all others, or several

    Raises
    ------
    SpeechError
        The language reads none of the words, or the recording cannot be read.

    Examples
    --------
    >>> maps = ll.TimedWords((ll.TimedWord("maps", 0.1, 0.6),), "words.csv")
    >>> schedule = ll.fill_words(maps, "english")
    >>> schedule.labels, schedule.start, schedule.end
    (('_', 'm', 'æ', 'p', 's'), 0.0, 0.6)
    """
    return with_phonemes(Speaker.of(language, paths), timed, audio=audio)


def with_phonemes(
    speaker: Speaker, found: Timings, *, audio: SoundSource | None = None
) -> Schedule:
    """Return timings of a file with their sound; the language reads words without phonemes."""
    if isinstance(found, TimedWords):
        return filled(speaker, found, audio=audio)
    schedule = with_lacking(found, speaker)
    return schedule if audio is None else with_sound(schedule, audio)


def filled(speaker: Speaker, timed: TimedWords, *, audio: SoundSource | None = None) -> Schedule:
    """Fill timed words as `fill_words` does, with a prepared language."""
    sound = None if audio is None else sound_of(audio)
    phrases: list[list[TimedWord]] = []
    texts: list[str] = []
    for word in timed.words:
        if not phrases or word.start - phrases[-1][-1].end >= PHRASE_PAUSE_SECONDS:
            phrases.append([word])
            texts.append(word.text)
        else:
            dense = _UNSPACED_CHAR.match(texts[-1][-1]) and _UNSPACED_CHAR.match(word.text)
            phrases[-1].append(word)
            texts[-1] += word.text if dense else f" {word.text}"
    whole: list[Schedule | SpeechError] = list(speaker.speak_many(texts, engine=NO_ENGINE))
    heard = [] if sound is None else [*_heard(speaker, phrases, texts, sound)]
    for number, schedule in heard:
        whole[number] = schedule
    shares = [one for pair in zip(phrases, whole, strict=True) for one in _shares(*pair)]
    alone = [word.text for word, one in zip(timed.words, shares, strict=True) if one is None]
    singly = speaker.speak_many(alone, engine=NO_ENGINE)
    found = [next(singly) if one is None else one for one in shares]
    told = f"{timed.source} has times of words, but not of phonemes; the phonemes are "
    told += f"{'aligned with the recording' if heard else 'estimated'} within each word"
    if 0 < len(heard) < len(phrases):
        unfit = len(phrases) - len(heard)
        told += f" ({unfit} of {len(phrases)} phrases did not fit it and are estimated)"
    made = _filled_schedule(timed, found, told)
    return made if sound is None else with_sound(made, sound)


def _heard(
    speaker: Speaker, phrases: Sequence[Sequence[TimedWord]], texts: Sequence[str], sound: Audio
) -> Iterator[tuple[int, Schedule]]:
    """Align each phrase with its part of the sound, and yield the results by number."""
    cuts = []
    for words, text in zip(phrases, texts, strict=True):
        low = max(words[0].start - PHRASE_MARGIN_SECONDS, 0.0) * sound.rate
        high = (words[-1].end + PHRASE_MARGIN_SECONDS) * sound.rate
        cuts.append((replace(sound, samples=sound.samples[round(low) : round(high)]), text))
    for number, one in enumerate(align_many(speaker, cuts)):
        if isinstance(one, SpeechError) or (
            one.confidence is not None and one.confidence < DOUBTFUL
        ):
            continue
        if one.notation != speaker.manner.notation:
            # An aligner may have labels of its own; the words of a phrase have one notation.
            (read,) = speaker.transcribe([texts[number]])
            one = join(read, one, speaker.manner, speaker.notations)  # noqa: PLW2901
        yield number, one


def _shares(words: Sequence[TimedWord], read: Schedule | SpeechError) -> list[WordPhonemes]:
    """Return the part of each word in a phrase's schedule, by letters; None if the words differ."""
    if isinstance(read, SpeechError):
        return [read] * len(words) if len(words) == 1 else [None] * len(words)
    given = [_letters(word.text) for word in words]
    spoken = [_letters(word.text) for word in read.words]
    if "".join(given) != "".join(spoken):
        return [None] * len(words)
    ends = [*accumulate(map(len, spoken), initial=0)]
    starts = {end: number for number, end in reversed([*enumerate(ends)])}
    shares: list[WordPhonemes] = []
    for at, letters in zip(accumulate(map(len, given), initial=0), given, strict=False):
        first, stop = starts.get(at), starts.get(at + len(letters))
        if not letters or first is None or stop is None:
            shares.append(None)
        else:
            shares.append(_part(read, read.words[first:stop]))
    return shares


def _letters(text: str) -> str:
    """Return letters and digits in one spelling, for comparison."""
    return "".join(c for c in unicodedata.normalize("NFKD", text.casefold()) if c.isalnum())


def _part(schedule: Schedule, words: Sequence[Word]) -> Schedule:
    """Return the phonemes of successive words, with their pauses."""
    return replace(excerpt(schedule, words[0].first, words[-1].stop), audio=None)


@dataclass
class _Layout:
    """Rows of the schedule in the making."""

    labels: list[str] = field(default_factory=list)
    times: list[float] = field(default_factory=lambda: [0.0])
    stress: list[int | None] = field(default_factory=list)
    words: list[Word] = field(default_factory=list)
    notation: str | None = None
    language: str | None = None
    unread: list[str] = field(default_factory=list)

    def rest(self, until: float) -> None:
        """Add silence up to a time, if there is any between."""
        if until - self.times[-1] <= SNAP_SECONDS:
            return
        if self.labels[-1:] == [SILENCE]:
            self.times[-1] = until
            return
        self.labels.append(SILENCE)
        self.stress.append(None)
        self.times.append(until)

    def lay(self, word: TimedWord, share: Schedule) -> None:
        """Add a word, its phonemes stretched over its time."""
        self.rest(word.start)
        at, start = len(self.labels), self.times[-1]
        steps = (share.times[1:] - share.start) / (share.end - share.start)
        self.labels += share.labels
        self.times += (start + steps * (word.end - start)).tolist()
        self.stress += share.stress or (None,) * len(share)
        for read in share.words:
            text = word.text if len(share.words) == 1 else read.text
            first, stop = at + read.first, at + read.stop
            made = replace(read, text=text, first=first, stop=stop, confidence=word.confidence)
            self.words.append(made)
        self.notation, self.language = share.notation, share.language
        self.unread += share.unread


def _filled_schedule(
    timed: TimedWords, shares: Iterable[Schedule | SpeechError], told: str
) -> Schedule:
    """Place the phonemes of all words in their times; a word without phonemes is silence."""
    layout, mute = _Layout(), []
    error: SpeechError | None = None
    for word, share in zip(timed.words, shares, strict=True):
        if isinstance(share, Schedule) and share.words:
            layout.lay(word, _part(share, share.words))
            continue
        error = error or (share if isinstance(share, SpeechError) else None)
        mute.append(word.text)
        layout.rest(word.end)
    if not layout.words:
        raise error or SpeechError(f"{timed.source}: no word can be read")
    remarks = [*timed.remarks, told]
    if mute:
        shown = shortlist(map(repr, mute))
        remarks.append(f"{timed.source}: the mouth rests during words that cannot be read: {shown}")
    return Schedule(
        tuple(layout.labels),
        np.array(layout.times),
        tuple(layout.words),
        notation=layout.notation,
        language=layout.language,
        source=timed.source,
        unread=tuple(dict.fromkeys(layout.unread)),
        remarks=tuple(remarks),
        stress=tuple(layout.stress) if any(s is not None for s in layout.stress) else (),
    )
