"""Forced alignment by a pocketsphinx acoustic model and dictionary.

Each word has pronunciation variants from the dictionary and from the language's G2P. The `sphinx`
package selects the most likely variant and its times.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property, partial
from itertools import chain, islice, product, repeat

from lipsync_lang.base.errors import SpeechError, shortlist
from lipsync_lang.packs.finding import IPA
from lipsync_lang.schedules.schedule import DOUBTFUL, Audio, Schedule
from lipsync_lang.sound.speech.hearing.align.aligners import BatchAligner, UnreadRecordings, aligner
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import OUTSIDE, STATES
from lipsync_lang.sound.speech.hearing.sphinx.decoders import decoded_words
from lipsync_lang.sound.speech.hearing.sphinx.features import (
    FRAME_SECONDS,
    HOP_SAMPLES,
    PreparedSound,
)
from lipsync_lang.sound.speech.hearing.sphinx.folder import Models, find_models
from lipsync_lang.sound.speech.hearing.sphinx.forced import Pronunciations, SureWord
from lipsync_lang.sound.speech.hearing.sphinx.line_search import found_line
from lipsync_lang.sound.speech.hearing.sphinx.scheduling import (
    Saying,
    confidence,
    doubts,
    timed_labels,
)
from lipsync_lang.sound.speech.results import WrongTextError, batches, raised, tried
from lipsync_lang.sound.speech.sound import SPEECH_RATE
from lipsync_lang.sound.speech.speaking.joining import stress_read
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.sound.speech.speaking.transcripts import SureText, Transcript
from lipsync_lang.text.phonology.emphasis import touched
from lipsync_lang.text.phonology.g2p.g2p_engines import SpokenWord
from lipsync_lang.text.phonology.g2p.tokens import plain
from lipsync_lang.text.phonology.labels import Notation, Value

MAX_HEARD_FRAMES = 15 * SPEECH_RATE // HOP_SAMPLES
"""Length of the part of a recording that is recognised to say what was heard."""

MAX_SHOWN_TEXT = 60
"""Maximum characters of a text in a message."""

MAX_WAYS = 8
"""Most pronunciations of a word whose labels are said in two ways."""

MIN_AGREEMENT = 0.12
"""Share of phonemes borne out by the sound that chance alone reaches."""


@aligner("pocketsphinx")
class PocketsphinxAligner(BatchAligner):
    """Aligner for languages with a pocketsphinx model.

    `model` is the name of a pocketsphinx model, or the folder of an acoustic model.
    """

    def align_many(
        self, recordings: UnreadRecordings, speaker: Speaker, model: str | None = None
    ) -> Iterator[Schedule | SpeechError]:
        """Align as `align` does, with many texts read at once."""
        try:
            models = models_of(model)
        except SpeechError as error:
            yield from (error for _ in recordings)
            return
        for batch in batches(recordings):
            # All texts of a batch are read before the first sound: G2P engines start slowly.
            read = speaker.transcripts([text for _, text in batch])
            reader = WordReader(
                models, speaker, [one for one in read if not isinstance(one, SpeechError)]
            )
            lines = ((sound, text, own) for (sound, text), own in zip(batch, read, strict=True))
            yield from map(tried(partial(self._aligned, reader)), lines)

    def _aligned(
        self,
        reader: "WordReader",
        one: tuple[Callable[[], Audio], str, Transcript | SpeechError],
    ) -> Schedule:
        """Align a text that is read, or raise the error of its reading."""
        transcript = raised(one[2])
        models, speaker, text = reader.models, reader.speaker, transcript.text
        sayings = reader.sayings(transcript.words)
        if not sayings:
            raise SpeechError(
                f"'{text[:MAX_SHOWN_TEXT]}' has no words to align; give the spoken text"
            )
        audio = one[0]()
        sound = PreparedSound.of(audio)
        texts = [saying.text for saying in sayings]
        ways: list[Pronunciations] = [saying.ways for saying in sayings]
        if isinstance(one[1], SureText) and one[1].spans:
            said = touched(texts, one[1], one[1].spans)
            ways = [SureWord(way) if own else way for way, own in zip(ways, said, strict=True)]
        heard, sure, moved, unwritten = found_line(models, sound, ways, texts)
        if not heard:
            raise SpeechError(unfit(audio, sum(len(word.labels) for word in transcript.words)))
        agreeing = confidence(models, heard)
        told = [] if moved is None else [moved.told(texts)]
        if unwritten:
            places = shortlist([one.told(texts) for one in unwritten])
            told.append(f"a word may be said that the text does not have: {places}")
        doubted = agreeing < MIN_AGREEMENT or sure < DOUBTFUL
        if reader.own and models.language_model and doubted:
            decoded = decoded_words(models, sound.part(0, MAX_HEARD_FRAMES).samples())
            words = (" ".join(word.text for word in decoded) or "no word")[:MAX_SHOWN_TEXT]
            told.append(f"heard instead: '{words}'")
        if agreeing < MIN_AGREEMENT:
            raise WrongTextError(
                f"the text does not fit the recording ({agreeing:.0%} of its phonemes, confidence "
                f"{sure:.2f}{''.join(f'; {one}' for one in told)}): '{text[:MAX_SHOWN_TEXT]}'; "
                "check the text, the language and the loudness of the voice, or try another "
                "aligner (`aligner`)"
            )
        beside = {number for one in unwritten for number in (one.before - 1, one.before)}
        found = timed_labels(models, heard, sayings, audio.seconds, beside)
        manner = speaker.manner
        notation = manner.audio.notation if reader.own else manner.notation
        return Schedule(
            *found, notation=notation, language=manner.language, audio=audio, source="recording",
            unread=transcript.unread, remarks=(*told, *doubts(heard, sayings)), confidence=sure,
            stress=stress_read(transcript, found.labels, notation, manner, speaker.notations),
            left_out=tuple(texts[one.word] for one in heard if one.phone == OUTSIDE != one.word),
        )  # fmt: skip


def models_of(name: str | None) -> Models:
    """Find models by name or folder; None for those that hear every language."""
    from lipsync_lang.resolver.nearest_phonemes import model_phones

    if not name:
        known = model_phones()
        name = known.model if known else None
    return find_models(name)


def unfit(audio: Audio, phonemes: int) -> str:
    """Return the reason why words cannot be aligned, with a cure."""
    why = "more than can be said in it; check that both are complete"
    if phonemes * STATES * FRAME_SECONDS <= audio.seconds:
        why = "the aligner lost the text in it; check that the recording has all of the text, "
        why += "or align shorter parts"
    return f"the text has {phonemes} phonemes, and the recording {audio.seconds:.2f} s: {why}"


class WordReader:
    """Pronunciation lookup for words of a language.

    Parameters
    ----------
    transcripts : texts whose words will be asked for; words that the G2P joined are read apart here
    """

    def __init__(
        self, models: Models, speaker: Speaker, transcripts: Iterable[Transcript] = ()
    ) -> None:
        self.models = models
        self.speaker = speaker
        manner = speaker.manner
        own = speaker.notations.get(manner.audio.notation or "")
        # a model of other phones than those of the pack's notation is heard as a foreign one
        self.own = own is not None and all(map(own.find, models.numbers))
        self.labels = speaker.notations.get(manner.notation, Notation({}))
        ipa = speaker.notations.get(IPA)
        self.typical = {
            value: name for name, value in reversed([*ipa.table.items()] if ipa else [])
        }
        self.stated, self.others = (
            Notation(
                {
                    label: tuple((name, 1 / len(names)) for name in names)
                    for label, names in phones.items()
                }
            )
            for phones in (manner.audio.phones, manner.audio.also)
        )
        joined = [s.text.split() for one in transcripts for s in one.words if _is_joined(s)]
        parts = sorted({part for texts in joined for part in texts})
        self.apart = dict(zip(parts, speaker.transcripts(parts), strict=True)) if parts else {}

    def sayings(self, words: Sequence[SpokenWord]) -> list[Saying]:
        """Return words with their pronunciation variants, split where the G2P joined them."""
        apart: list[SpokenWord] = []
        for said in words:
            if _is_joined(said):
                for part in said.text.split():
                    read = self.apart[part]
                    if isinstance(read, SpeechError):
                        raise read
                    apart += read.words
            else:
                apart.append(said)
        own = self.models.ways([plain(said.text) for said in apart]) if self.own else repeat(())
        sayings = map(self.saying, apart, own)
        return [saying for saying in sayings if saying.ways]

    def saying(self, said: SpokenWord, own: tuple[tuple[int, ...], ...]) -> Saying:
        """Return a word with its pronunciations.

        In the model's own language the dictionary comes first (`own`); elsewhere the G2P alone
        counts.
        """
        numbers = [self.numbers(label) for label in said.labels]
        for at, (before, after) in enumerate(zip(numbers, numbers[2:], strict=False), 1):
            if before and after and {before[-1], after[0]} <= self.vowels:
                numbers[at] = self.numbers(said.labels[at], between_vowels=True)
        read = tuple(number for some in numbers for number in some)
        if not read:
            return Saying(said.text, ())
        if self.own:
            return Saying(said.text, tuple(dict.fromkeys([*own, read])))
        choices = [
            (some, *([self._named(other)] if (other := self.others.find(label)) else []))
            for label, some in zip(said.labels, numbers, strict=True)
        ]
        spelled = {
            tuple(chain(*way)): tuple(
                (label, len(some)) for label, some in zip(said.labels, way, strict=True) if some
            )
            for way in islice(product(*choices), MAX_WAYS)
        }
        return Saying(said.text, tuple(spelled), tuple(spelled.values()))

    def numbers(self, label: str, *, between_vowels: bool = False) -> list[int]:
        """Map a G2P label to phoneme numbers of the model.

        Without an entry in the pack: the phones that sound most like the label, or, where that is
        not in IPA, like the IPA of its common phonemes.
        """
        found = self.stated.find(label)
        if found is None:
            said = [label]
            if self.speaker.manner.notation != IPA:
                common = self.labels.find(label) or ()
                said = [self.typical.get(((name, 1.0),), "") for name, _ in common]
            known = self.models.phones
            if known is None:
                raise SpeechError(
                    f"{self.models.acoustic}: no phone of the model is known for '{label}': write "
                    f"{self.models.acoustic / 'phones.yaml'} with a line `PHONE: LETTERS` for each "
                    "phone, or `audio: {phones: ...}` in the language's pack"
                )
            # Signs that are no IPA are mute.
            near = known.between if between_vowels else known.nearest
            found = tuple(one for ipa in said for one in near.nearest(ipa).value)
        return self._named(found)

    def _named(self, phones: Value) -> list[int]:
        return [self.models.numbers[name] for name, _ in phones if name in self.models.numbers]

    @cached_property
    def vowels(self) -> frozenset[int]:
        """The model's phones that are vowels."""
        known = self.models.phones
        names = known.vowels if known else ()
        return frozenset(self.models.numbers[name] for name in names if name in self.models.numbers)


def _is_joined(said: SpokenWord) -> bool:
    """Return True for several words that the G2P reads as one."""
    return bool(said.labels) and len(said.text.split()) > 1
