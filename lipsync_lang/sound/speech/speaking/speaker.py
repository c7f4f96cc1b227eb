"""A language that is prepared for reading and speaking, by the engines of its pack.

A text is *transcribed* by the pack's G2P engine and *spoken* by its voice. If both are the same
engine, the spoken phonemes are the transcript. Otherwise the voice supplies times and the G2P
phonemes, joined by alignment. Without a voice, times are estimated from durations by phoneme
class.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import tee, zip_longest
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol, overload

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.base.json_object import Json
from lipsync_lang.packs.finding import IPA, Paths, located
from lipsync_lang.packs.library import Library
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.sound.speech import ENGINES, speak_many
from lipsync_lang.sound.speech.results import batches, each, exhaust, next_result, raised
from lipsync_lang.sound.speech.speaking.speech_engines import NO_ENGINE
from lipsync_lang.sound.speech.speaking.transcripts import (
    Transcript,
    WrittenText,
    as_written,
    silent,
)
from lipsync_lang.text.lines.cleaning import AS_WRITTEN, Cleaning
from lipsync_lang.text.lines.markup import spoken
from lipsync_lang.text.phonology.emphasis import emphasised
from lipsync_lang.text.phonology.g2p import SpokenWord, engine
from lipsync_lang.text.phonology.g2p.censored import unstressed
from lipsync_lang.text.phonology.g2p.g2p_engines import G2PEngine
from lipsync_lang.text.phonology.g2p.orthography_profile import lacking
from lipsync_lang.text.phonology.g2p.rare_letters import RareLetters
from lipsync_lang.text.phonology.g2p.tokens import plain
from lipsync_lang.text.phonology.g2p.utterances import Utterances
from lipsync_lang.text.phonology.labels import Notation
from lipsync_lang.text.phonology.manner import Manner

if TYPE_CHECKING:
    from lipsync_lang.text.phonology.nearest import NearestPhonemes

PlaceholderValues = Mapping[str, str]
"""Values of placeholders, by name."""

NO_VALUES: PlaceholderValues = MappingProxyType({})


class KnownReadings(Protocol):
    """Words of texts that were read before: a dictionary, or a file."""

    def get(self, text: str, /) -> tuple[SpokenWord, ...] | None:
        """Return the words of a text; None if it was not read yet."""

    def update(self, read: Mapping[str, tuple[SpokenWord, ...]], /) -> None:
        """Keep the words of texts."""


@dataclass(eq=False)
class Speaker:
    """A language prepared for reading and speaking texts.

    Parameters
    ----------
    manner : reading and speaking settings
    notations : its notations, by name
    near : lookup of the nearest known label, in automatic languages
    read : words of texts that were read before with the same settings; it grows
    cleaning : values of placeholders, and what a project's scripts do not speak
    """

    manner: Manner
    notations: Mapping[str, Notation]
    near: "NearestPhonemes | None" = None
    read: KnownReadings | None = None
    cleaning: Cleaning = AS_WRITTEN

    def __post_init__(self) -> None:
        self.cleaning = replace(self.cleaning, asides=self.manner.asides)

    @classmethod
    def of(
        cls, language: str | Path, paths: Paths = (), cleaning: Cleaning = AS_WRITTEN
    ) -> "Speaker":
        """Prepare a language by name, tag or file, with `paths` searched first."""
        from lipsync_lang.resolver.language_tables import manner_of, notations_of
        from lipsync_lang.resolver.nearest_phonemes import among

        (name,), folders = located(paths, language=language)
        library: Library = Library(folders)
        pack, common = library.language(name), library.common().model
        near = among(library, pack) if pack.model.automatic else None
        manner = manner_of(pack, common)
        return cls(manner, notations_of(library, pack), near, cleaning=cleaning)

    def written(self, text: str) -> WrittenText:
        """Return the part of a text that is read, with its emphasis."""
        said = spoken(text, self.cleaning)
        text = unstressed(said.text, self.manner.forms)
        for letter, instead in self.manner.letters.items():
            text = text.replace(letter, instead)
        clear = emphasised(text)
        return WrittenText(*clear, said.dropped, said.remarks)

    def transcribe(self, texts: Iterable[str]) -> Iterator[Transcript]:
        """Convert texts to phonemes, one after the other; markup and emphasis are left out.

        Raises SpeechError if the pack has no G2P settings, or its engine failed.
        """
        return map(raised, self.transcribe_many(texts))

    def transcribe_many(self, texts: Iterable[str]) -> Iterator[Transcript | SpeechError]:
        """Yield for each text its transcript, or the error of its reading."""
        for batch in batches(texts):
            yield from self.transcripts(batch)

    def transcripts(self, texts: Sequence[str]) -> list[Transcript | SpeechError]:
        """Return for each text its transcript, or the error of its reading, all read at once."""
        written = [self.written(text) for text in texts]
        return [
            found if isinstance(found, SpeechError) else self._transcript(one, found)
            for one, found in zip(written, self._read([w.text for w in written]), strict=True)
        ]

    def _read(self, texts: Sequence[str]) -> list[tuple[SpokenWord, ...] | SpeechError]:
        """Return the words of texts, all read at once, and a repeated one once."""
        known: KnownReadings = {} if self.read is None else self.read
        kept = {text: known.get(text) for text in texts}
        new = [text for text, words in kept.items() if words is None]
        if not new:
            read = []
        elif self.manner.engine in (None, IPA):
            read = self._read_plainly(new)
        else:
            read = self._utterances.read(new, self._read_plainly)
        found = dict(zip(new, read, strict=True))
        # An error is not kept: the engine may be there the next time.
        known.update({t: w for t, w in found.items() if not isinstance(w, SpeechError)})
        return [found[text] if (words := kept[text]) is None else words for text in texts]

    @cached_property
    def _utterances(self) -> Utterances:
        """Reader of interjections, stutters and similar sounds, created once."""

        def is_vowel(label: str) -> bool:
            value = self.notations[self.manner.notation].find(label) or ()
            return any(self.manner.kinds.get(name) == "vowel" for name, _ in value)

        return Utterances(self.manner.forms, self.manner.words, is_vowel, self._rare)

    @cached_property
    def _rare(self) -> RareLetters:
        """Finder of letters that the engine lacks, created once."""

        def count(words: Sequence[str]) -> list[int | None]:
            return [
                None
                if isinstance(read, SpeechError) or any(one.unread for one in read)
                else sum(len(one.labels) for one in read)
                for read in self._read_plainly(words)
            ]

        return RareLetters(count)

    def has_entry(self, word: str) -> bool:
        """Return True for a word, perhaps inflected, with a reading of the pack or character."""
        return plain(word) in self.manner.words or self._utterances.has_entry(word)

    def _read_plainly(self, texts: Sequence[str]) -> list[tuple[SpokenWord, ...] | SpeechError]:
        """Return the words of texts as the engine reads them.

        Words that it joins may hide a word of the pack: the voice separates those.
        """
        try:
            read = self._engine
        except SpeechError as error:
            return [error] * len(texts)
        found: list[tuple[SpokenWord, ...] | SpeechError] = []
        while len(found) < len(texts):
            rest = texts[len(found) :]
            try:
                for _, words in zip(rest, read(rest), strict=True):
                    found.append(tuple(words))
            except SpeechError as error:
                # An engine that fails at two different texts in the same words fails at all.
                last = found[-1] if found else None
                again = isinstance(last, SpeechError) and str(last) == str(error)
                found += [error] * (len(texts) - len(found) if again else 1)
        hidden = [text for text, words in zip(texts, found, strict=True) if self._hides(words)]
        if not hidden:
            return found
        voice, name = self.manner.settings.voice or "", self.manner.engine or ""
        heard = each(speak_many(hidden, voice, engine=name), _separate_words)
        return [next(heard) if self._hides(words) else words for words in found]

    @cached_property
    def _engine(self) -> G2PEngine:
        """The language's G2P engine, made once."""
        manner = self.manner
        if manner.engine is None:
            raise SpeechError(
                f"{manner.language} does not read text: add a `g2p` to its pack, "
                "or give timed phonemes (`schedule`)"
            )
        if manner.notation not in self.notations:
            raise SpeechError(
                f"{manner.language} has no notation '{manner.notation}' for what its `g2p` writes"
            )
        return engine(manner.engine, manner.settings)

    def _hides(self, words: Sequence[SpokenWord] | SpeechError) -> bool:
        """Return True if a custom word of the pack may be inside words joined by the engine."""
        if isinstance(words, SpeechError) or not self.manner.words:
            return False
        return any(
            plain(part.strip(".,;:!?…\"'()")) in self.manner.words
            for word in words
            if any(map(str.isspace, word.text))
            for part in word.text.split()
        )

    def _told(self, text: str) -> Iterator[str]:
        """Yield a remark on letters that the engine lacks."""
        if self.manner.engine is not None and (others := self._rare.instead(text)):
            pairs = ", ".join(f"'{one}' as '{other}'" for one, other in others.items())
            yield f"{self.manner.language} lacks letters of this text, and reads {pairs}"

    def _transcript(self, written: WrittenText, words: Sequence[SpokenWord]) -> Transcript:
        notation = self.notations[self.manner.notation]
        while words and not words[-1].labels and not words[-1].unread:
            words = words[:-1]
        phonemes: list[str] = []
        unmapped: list[str] = []
        gaps: list[int] = []
        for word in words:
            own = self.manner.words.get(plain(word.text)) if word.labels else (SILENCE,)
            start = len(phonemes)
            if own is not None and (word.labels or not word.unread):
                phonemes += own
                continue
            for label in word.labels:
                value = notation.find(label)
                gaps += [len(phonemes)] if value is None else []
                phonemes += [name for name, _ in value or ()]
                unmapped += [label] if value is None else []
            gaps += range(start, len(phonemes) + 1) if word.unread else ()
        unread = tuple(dict.fromkeys(c for word in words for c in word.unread))
        return Transcript(
            written.text,
            self.manner.language,
            self.manner.notation,
            tuple(words),
            tuple(phonemes),
            tuple(dict.fromkeys(unmapped)),
            unread,
            tuple(sorted(set(gaps))),
            written.dropped,
            written.remarks,
            (*lacking(self.manner.settings, unread), *self._told(written.text)),
        )

    def to_json(self, transcript: Transcript) -> Json:
        """Convert a transcript to JSON data, with the common phonemes of each label.

        `automatic` has the labels mapped by features alone, and the features lost in each.
        """
        notation = self.notations[self.manner.notation]
        words: list[Json] = []
        for word in transcript.words:
            labels = [
                {"label": label, "common": [name for name, _ in notation.find(label) or ()]}
                | ({} if mark is None else {"stress": mark})
                for label, mark in zip_longest(word.labels, word.stress)
            ]
            own = self.manner.words.get(plain(word.text))
            words.append(
                {"text": word.text, "labels": labels}
                | ({"pronounced": list(own)} if own and labels else {})
                | ({"unread": word.unread} if word.unread else {})
            )
        automatic: dict[str, Json] = {}
        if self.near is not None and notation.nearest is not None:
            for label in dict.fromkeys(transcript.labels):
                if notation.stated(label) is None:
                    near = self.near.nearest(label)
                    common = [name for name, _ in near.value]
                    found = {"common": common, "distance": near.distance, "loses": [*near.losses]}
                    automatic[label] = found
        whole = {name: getattr(transcript, name) for name in ("text", "language", "notation")}
        whole |= {"words": words, "phonemes": list(transcript.phonemes), "automatic": automatic}
        more = {name: list(getattr(transcript, name)) for name in ("unmapped", "unread", "dropped")}
        return whole | more

    def speak(
        self, text: str, *, engine: str | None = None, words_per_minute: int | None = None
    ) -> Schedule:
        """Speak a text as the function `speak` does, which explains the options and the errors."""
        (result,) = self.speak_many([text], engine=engine, words_per_minute=words_per_minute)
        return raised(result)

    def speak_many(
        self,
        texts: Iterable[str],
        *,
        engine: str | None = None,
        words_per_minute: int | None = None,
    ) -> Iterator[Schedule | SpeechError]:
        """Speak texts as `speak` does, at a fraction of the cost.

        The engine starts once, and texts that are read apart from the voice are read at most
        `BATCH_TEXTS` at once; so many texts are taken ahead.

        Yields
        ------
        For each text, in order, its schedule, or the error that `speak` raises
        """
        ours, engines = tee(map(self.written, texts))
        sounding = (one.text for one in engines if not one.silent)
        spoken = self._spoken(sounding, engine, words_per_minute)
        for written in ours:
            if written.silent:
                yield silent(written, self.manner)
                continue
            yield from each([next_result(spoken)], partial(as_written, written))
        exhaust(spoken)

    def _spoken(
        self, texts: Iterable[str], engine: str | None, words_per_minute: int | None
    ) -> Iterator[Schedule | SpeechError]:
        """Speak texts with a voice; join what the G2P engine reads, if that is another."""
        from lipsync_lang.sound.speech.speaking.joining import join

        manner = self.manner
        if engine == NO_ENGINE or (engine is None and manner.voice is None):
            yield from self._estimated(texts)
            return
        try:
            name, voice = self._voice(engine)
        except SpeechError as error:
            yield from (error for _ in texts)
            return
        direct = manner.direct or manner.voice is None or name != manner.voice[0]
        read = self._for_direct_voice(texts) if direct else self.transcribe_many(texts)
        ours, engines = tee(read)
        spellings = (
            # In the engine's own spelling if the text has one.
            " ".join(word.respelled or word.text for word in one.words)
            if any(word.respelled for word in one.words)
            else one.text
            for one in engines
            if isinstance(one, Transcript)
        )
        said = iter(speak_many(spellings, voice, engine=name, words_per_minute=words_per_minute))

        def timed(transcript: Transcript) -> Schedule:
            spoken = raised(next_result(said))
            if transcript.words:
                return join(transcript, spoken, manner, self.notations)
            # The voice's own phonemes are the transcript where nothing else reads the text.
            return replace(spoken, language=manner.language)

        yield from each(ours, timed)
        exhaust(said)

    def _for_direct_voice(self, texts: Iterable[str]) -> Iterator[Transcript | SpeechError]:
        """Yield transcripts of texts that the pack reads; texts for the voice have no words."""
        for batch in batches(texts):
            whole = self.manner.engine is None
            odd = [text for text in batch if not (whole or self._utterances.ordinary(text))]
            read = dict(zip(odd, self.transcripts(odd), strict=True))
            for text in batch:
                yield read.get(text) or Transcript(text, self.manner.language, "", ())

    def _voice(self, engine: str | None) -> tuple[str, str]:
        """Return engine and voice: the pack's default, or its voice for the given engine."""
        manner = self.manner
        if manner.voice is not None and engine in (None, manner.voice[0]):
            return manner.voice
        name = engine or ""
        reads = manner.settings.voice if name == manner.engine else None
        voice = manner.others.get(name, reads)
        if voice is None:
            ENGINES.find(name, SpeechError)
            raise SpeechError(
                f"{manner.language} has no voice of {name}; add to its pack "
                f"`tts: {{others: {{{name}: VOICE}}}}` (lipsync-lang voices {name} lists them)"
            )
        return name, voice

    def _estimated(self, texts: Iterable[str]) -> Iterator[Schedule | SpeechError]:
        """Read texts, and estimate their times."""
        from lipsync_lang.sound.speech.speaking.joining import estimate

        manner = self.manner
        if manner.engine is None:
            error = SpeechError(
                f"{manner.language} has no voice: add a `tts` to its pack, or a `g2p` to "
                "estimate times, or give timed phonemes (`schedule`)"
            )
            return (error for _ in texts)
        return each(
            self.transcribe_many(texts),
            lambda read: estimate(read, manner, self.notations[manner.notation]),
        )


def _separate_words(schedule: Schedule) -> tuple[SpokenWord, ...]:
    """Return the words and pauses of a schedule, each word by itself."""
    words: list[SpokenWord] = []
    at = 0
    for word in schedule.words:
        if words and SILENCE in schedule.labels[at : word.first]:
            words.append(SpokenWord(",", ()))
        span = slice(word.first, word.stop)
        words.append(SpokenWord(word.text, schedule.labels[span], stress=schedule.stress[span]))
        at = word.stop
    return tuple(words)


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
