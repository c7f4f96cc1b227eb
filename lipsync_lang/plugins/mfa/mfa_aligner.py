"""Forced alignment by the Montreal Forced Aligner, with models and dictionaries of its user.

All recordings of a batch are one corpus, because the program starts slowly. Each is a speaker of
its own there, so that its times do not depend on the others of the batch. Files have numbers for
names. The answers are TextGrids.

Labels are those of the dictionary. Their notation is the pack's `audio.notation` if this aligner is
the pack's first; otherwise the language recognises it by the labels, as in a file of timings.

Words that the dictionary lacks are read by the language.
"""

import os
import wave
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from lipsync_lang import Audio, Schedule, ScheduleError, SpeechError, read_schedule
from lipsync_lang.plugins.mfa.mfa_command import MfaModels, run_mfa
from lipsync_lang.schedules.schedule import SILENCE, SNAP_SECONDS
from lipsync_lang.sound.speech.hearing.align.aligners import BatchAligner, aligner
from lipsync_lang.sound.speech.hearing.alignment import engine_and_model
from lipsync_lang.sound.speech.lacking_words import with_lacking
from lipsync_lang.sound.speech.results import batches, each, tried
from lipsync_lang.sound.speech.speaking.speaker import Speaker

NAME = "mfa"

Given = tuple[Callable[[], Audio], str]
"""A function that reads a recording, and the text that is said in it."""

UNKNOWN = "spn"
"""Label of a word that the dictionary lacks."""

SILENCES = frozenset({SILENCE, "sil", "sp", UNKNOWN})
"""Labels without a phoneme."""

Labels = tuple[str, ...]


@aligner(NAME)
class MfaAligner(BatchAligner):
    """Aligner for any language that has an acoustic model and a dictionary of MFA.

    `model` is `MODEL` or `MODEL,DICTIONARY`, each a name that MFA knows, or a file.
    """

    def align_many(
        self, recordings: Iterable[Given], speaker: Speaker, model: str | None = None
    ) -> Iterator[Schedule | SpeechError]:
        """Align as `align` does; MFA starts once for up to 500 recordings, each read twice."""
        audio = speaker.manner.audio
        engines = [engine_and_model(None, one) for one in audio.align]
        notation = audio.notation if engines and engines[0][0] == NAME else ""
        stated = {own for name, own in engines if name == NAME} | {audio.model}
        try:
            # MFA runs code of the model files that it is given: those are the user's to name.
            models = MfaModels.of(model, files=model not in stated)
        except SpeechError as error:
            yield from (error for _ in recordings)
            return

        def whole(found: Schedule) -> Schedule:
            stated = replace(found, notation=notation or None, language=speaker.manner.language)
            return with_lacking(stated, speaker, "the MFA dictionary")

        for batch in batches(recordings):
            yield from each(_aligned(batch, models), whole)


def _aligned(batch: Sequence[Given], models: MfaModels) -> Iterator[Schedule | SpeechError]:
    """Align a batch in a folder that is deleted afterwards."""
    with TemporaryDirectory(prefix="lipsync-lang-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        output = folder / "output"
        # MFA adapts to each speaker, that is, to each folder; these recordings may be of anybody.
        write = tried(partial(_written, folder / "corpus"))
        lasts = [write(one) for one in enumerate(batch)]
        sounds = [seconds for seconds in lasts if not isinstance(seconds, SpeechError)]
        jobs = max(1, min(len(sounds), os.cpu_count() or 1))
        try:
            if sounds:
                run_mfa(folder / "corpus", models, output, seconds=sum(sounds), jobs=jobs)
        except SpeechError as error:
            yield from (one if isinstance(one, SpeechError) else error for one in lasts)
            return
        numbers = (
            one if isinstance(one, SpeechError) else number for number, one in enumerate(lasts)
        )
        yield from each(numbers, lambda number: _read(output, number, *batch[number]))


def _written(corpus: Path, numbered: tuple[int, Given]) -> float:
    """Write a sound and its text as a speaker of the corpus; return the length in seconds."""
    number, (sound, text) = numbered
    if not any(map(str.isalnum, text)):
        raise SpeechError(f"'{text[:60]}' has no words to align; give the spoken text")
    audio = sound()
    place = corpus / f"{number:05d}"
    place.mkdir(parents=True)
    with wave.open(str(place / f"{place.name}.wav"), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(audio.samples.dtype.itemsize)
        file.setframerate(audio.rate)
        file.writeframes(audio.samples.astype("<i2", copy=False).tobytes())
    spoken = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    (place / f"{place.name}.lab").write_text(spoken, "utf-8")
    return audio.seconds


def _read(output: Path, number: int, sound: Callable[[], Audio], text: str) -> Schedule:
    """Read the answer for a recording."""
    file = next(output.rglob(f"{number:05d}.TextGrid"), None)
    if file is None:
        raise SpeechError(_unfit(text))
    try:
        read = read_schedule(file, read_as="textgrid")
    except ScheduleError as error:
        told = str(error).replace(str(file), "TextGrid")
        raise SpeechError(f"the answer of MFA for '{text[:60]}' cannot be read: {told}") from None
    if all(label in SILENCES for label in read.labels) and UNKNOWN not in read.labels:
        raise SpeechError(_unfit(text))
    audio = sound()
    seconds = audio.seconds
    # The answer ends with its sound, and has no label after that.
    kept = read.times[:-1] < seconds - SNAP_SECONDS
    labels = [label for label, keep in zip(read.labels, kept, strict=True) if keep]
    times = [*read.times[:-1][kept], min(read.end, seconds)]
    if seconds - times[-1] < SNAP_SECONDS or labels[-1] in SILENCES:
        times[-1] = seconds
    else:
        labels.append(SILENCE)
        times.append(seconds)
    # MFA writes small letters; the words get the capitals of the text.
    small = text.lower()
    # Some capitals have small forms of two letters, which would shift all places after them.
    small = small if len(small) == len(text) else text
    words = []
    at = 0
    for word in (w for w in read.words if w.stop <= len(labels)):
        start = small.find(word.text.lower(), at)
        at = start + len(word.text) if start >= 0 else at
        words.append(replace(word, text=text[start:at]) if start >= 0 else word)
    return replace(
        read,
        labels=tuple(labels),
        times=np.array(times),
        words=tuple(words),
        lines=(),
        audio=audio,
        source="recording",
    )


def _unfit(text: str) -> str:
    return (
        f"MFA aligned nothing of '{text[:60]}' with the recording; check that the text "
        "is right and that the recording is complete"
    )
