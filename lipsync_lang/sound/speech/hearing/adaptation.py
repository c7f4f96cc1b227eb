"""Adaptation of an acoustic model to recordings and their texts, without labels.

Lines are aligned, and the means of the model move towards what is heard; then again, with the new
model. The result counts if lines that were kept out of it became likelier.

The means of Gaussians move towards the frames that they explain, by shifts in their standard
deviations. The shift of all phonemes is the prior of the shift of one phoneme, and that is the
prior of the shift of one Gaussian (structural MAP, Shinoda and Lee 2001)::

    shift' = (tau shift + sum of g (x - m) / s) / (tau + sum of g)

with the posterior probability g of a Gaussian in the aligned state of frame x.
"""

import os
import shutil
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints, Singles
from lipsync_lang.base.errors import OutputError, SpeechError
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.schedules.schedule import DOUBTFUL
from lipsync_lang.sound.speech.hearing import progress
from lipsync_lang.sound.speech.hearing.align.pocketsphinx_aligner import WordReader, unfit
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import (
    FAINTEST_LOG,
    OUTSIDE,
    STATES,
    AcousticModel,
    Listening,
    PhoneContext,
    WordPosition,
)
from lipsync_lang.sound.speech.hearing.sphinx.features import PreparedSound
from lipsync_lang.sound.speech.hearing.sphinx.folder import Models
from lipsync_lang.sound.speech.hearing.sphinx.forced import HeardPhoneme
from lipsync_lang.sound.speech.hearing.sphinx.line_search import best_heard
from lipsync_lang.sound.speech.hearing.sphinx.scheduling import line_confidence
from lipsync_lang.sound.speech.results import raised
from lipsync_lang.sound.speech.sound import read_audio
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.sound.speech.speaking.transcripts import Transcript

LEAST_CONFIDENCES = (0.1, DOUBTFUL)
"""For each alignment of the lines, the least confidence of a line that fits.

The first model may know a voice badly that the next one knows well.
"""

HELD_OUT = 5
"""Number of lines of which one is held out."""

MIN_LINES = 2 * HELD_OUT
"""Least number of lines that fit."""

TEXT_SUFFIXES = (".txt", ".lab")
"""Endings of files with the text of a recording beside them."""

MODEL_FRAMES = 20.0
"""Frames that weigh as much as the prior of a shift: tau."""


class AlignedFrames(NamedTuple):
    """Frames of a recording with their states: (T, S, V) features and (T,) states."""

    features: Floats
    states: Ints


def aligned_frames(
    model: AcousticModel, features: Floats, heard: Sequence[HeardPhoneme]
) -> AlignedFrames:
    """Return the frames of phonemes and silence with their states, without other sound."""
    around = [model.silence if one.phone == OUTSIDE else one.phone for one in heard]
    around = [model.silence, *around, model.silence]
    words = [OUTSIDE, *(one.word for one in heard), OUTSIDE]
    contexts: list[PhoneContext] = []
    for n, one in enumerate(heard):
        begins, ends = words[n] != one.word, words[n + 2] != one.word
        place = WordPosition(WordPosition.BEGIN * begins + WordPosition.END * ends)
        spoken = OUTSIDE not in (one.word, one.phone)
        contexts.append((around[n + 1], around[n], around[n + 2], place if spoken else None))
    states = np.full(len(features), OUTSIDE)
    for one, phone in zip(heard, model.phones(contexts), strict=True):
        if one.phone != OUTSIDE:
            span = slice(one.first, one.stop)
            scores = Listening(model, features[span]).scores([phone])[:, 0]
            states[span] = np.repeat(phone.states, _lengths(scores))
    kept = states != OUTSIDE
    shape = (len(features), len(model.weights), -1)
    return AlignedFrames(features.reshape(shape)[kept], states[kept])


def _lengths(scores: Singles) -> Ints:
    """Return how many frames each of the states has on the likeliest path through all."""
    count = len(scores)
    if count < STATES:
        return np.array([count, 0, 0])
    sums = np.vstack([np.zeros(STATES), np.cumsum(scores, axis=0, dtype=np.float64)])
    cuts = np.arange(1, count)
    early = sums[cuts, 0] - sums[cuts, 1]
    late = sums[cuts, 1] - sums[cuts, 2]
    best = np.maximum.accumulate(early)[:-1] + late[1:]
    second = int(best.argmax()) + 2
    first = int(early[: second - 1].argmax()) + 1
    return np.array([first, second - first, count - second])


@dataclass
class GaussianSums:
    """Sums over frames for each Gaussian."""

    model: AcousticModel
    counts: Floats = field(init=False)
    sums: Floats = field(init=False)

    def __post_init__(self) -> None:
        books, streams, size, gaussians = self.model.gaussians.shape
        self.counts = np.zeros((books, streams, gaussians))
        self.sums = np.zeros((books, streams, size // 2, gaussians))

    def add(self, line: AlignedFrames) -> float:
        """Add the frames of a line, and return their mean log likelihood."""
        total = 0.0
        model = self.model
        books = model.books[line.states]
        for book in np.unique(books).tolist():
            here = books == book
            states = line.states[here]
            for stream in range(len(model.weights)):
                frames = line.features[here, stream]
                posterior, likely = _posterior(model, book, stream, frames, states)
                total += float(likely.sum())
                self.counts[book, stream] += posterior.sum(axis=0)
                self.sums[book, stream] += frames.T @ posterior
        return total / max(len(line.states), 1)

    def adapted(self) -> AcousticModel:
        """Return the model with means moved towards the frames."""
        size, precision, means = self.sums.shape[2], *means_of(self.model)
        counts, scale = self.counts[:, :, None], np.sqrt(np.maximum(precision, 1e-30))
        away = (self.sums - counts * means) * scale
        shift = np.zeros(1)
        for below in ((0, 3), (3,), ()):  # all, the codebook of a phoneme, a Gaussian
            frames = MODEL_FRAMES + counts.sum(axis=below, keepdims=True)
            shift = (MODEL_FRAMES * shift + away.sum(axis=below, keepdims=True)) / frames
        moved = means + shift / scale
        gaussians = self.model.gaussians.copy()
        gaussians[:, :, size:-1] = precision * moved
        gaussians[:, :, -1] -= (precision * (moved**2 - means**2)).sum(axis=2) / 2
        return replace(self.model, gaussians=gaussians)


def means_of(model: AcousticModel) -> tuple[Floats, Floats]:
    """Return precisions and means of a model's Gaussians: (books, S, V, Gaussians) each."""
    size = model.gaussians.shape[2] // 2
    precision = -2 * model.gaussians[:, :, :size].astype(np.float64)
    return precision, model.gaussians[:, :, size:-1] / np.maximum(precision, 1e-30)


def _posterior(
    model: AcousticModel, book: int, stream: int, frames: Floats, states: Ints
) -> tuple[Floats, Floats]:
    """Return the posterior of each Gaussian, (T, Gaussians), and the log likelihoods, (T,)."""
    terms = np.hstack([frames * frames, frames, np.ones((len(frames), 1))])
    near = terms @ model.gaussians[book, stream].astype(np.float64)
    most = near.max(axis=1, keepdims=True)
    shares = np.exp(np.maximum(near - most, FAINTEST_LOG)) * model.weights[stream][:, states].T
    whole = shares.sum(axis=1, keepdims=True)
    return shares / whole, np.log(whole[:, 0]) + most[:, 0]


class SpokenFile(NamedTuple):
    """A recording with its text."""

    path: Path
    text: str


class Adaptation(NamedTuple):
    """An adapted model, with the mean log likelihoods of the frames of held-out lines."""

    model: AcousticModel
    before: float
    after: float
    lines: int
    """Number of lines that fit."""
    left_out: tuple[str, ...]
    """Lines that do not fit, with the reason."""

    @property
    def gains(self) -> bool:
        """True if the held-out lines became likelier."""
        return self.after > self.before


def spoken_files(folder: Path) -> list[SpokenFile]:
    """Return the recordings below a folder that have a text of their name beside them.

    A folder without any is a `SpeechError`.
    """
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    texts = {path.with_suffix(""): path for path in files if path.suffix in TEXT_SUFFIXES}
    found = [
        SpokenFile(path, texts[path.with_suffix("")].read_text("utf-8", "replace").strip())
        for path in files
        if path.suffix not in TEXT_SUFFIXES and path.with_suffix("") in texts
    ]
    if not found:
        raise SpeechError(f"{folder}: no recording has its text beside it, as a.wav and a.txt")
    return found


def adapt(speaker: Speaker, lines: Sequence[SpokenFile], models: Models) -> Adaptation:
    """Adapt the model of a language to recordings of a voice, or of several.

    A line whose text does not fit is left out. With fewer than `MIN_LINES` it is a `SpeechError`.
    """
    first, held = models.model, dict[Path, AlignedFrames]()
    for turn in range(len(LEAST_CONFIDENCES)):
        fitting, left_out = _frames(speaker, lines, models, turn)
        if len(fitting) < MIN_LINES:
            raise SpeechError(
                f"{len(fitting)} of {len(lines)} lines fit their text, and adaptation needs "
                f"{MIN_LINES}; {'; '.join(left_out) or 'add more lines'}"
            )
        held = held or {path: fitting[path] for path in [*fitting][::HELD_OUT]}
        evidence = GaussianSums(models.model)
        for path, line in fitting.items():
            if path not in held:
                evidence.add(line)
        model = evidence.adapted()
        models = replace(models, given=model)
    before, after = (
        float(np.mean([*map(GaussianSums(one).add, held.values())])) for one in (first, model)
    )
    for path in held:
        if path in fitting:
            evidence.add(fitting[path])
    return Adaptation(evidence.adapted(), before, after, len(fitting), tuple(left_out))


def _frames(
    speaker: Speaker, lines: Sequence[SpokenFile], models: Models, turn: int
) -> tuple[dict[Path, AlignedFrames], list[str]]:
    """Return the frames of the lines that fit, and the reasons of the other lines."""
    fitting: dict[Path, AlignedFrames] = {}
    left_out: list[str] = []
    read = speaker.transcripts([line.text for line in lines])
    reader = WordReader(models, speaker, [x for x in read if not isinstance(x, SpeechError)])
    for number, (line, one) in enumerate(zip(lines, read, strict=True)):
        progress.tell(turn * len(lines) + number, len(LEAST_CONFIDENCES) * len(lines))
        try:
            fitting[line.path] = _fitting(reader, line.path, raised(one), LEAST_CONFIDENCES[turn])
        except SpeechError as error:
            left_out.append(f"{line.path.name}: {error}")
    return fitting, left_out


def _fitting(reader: WordReader, path: Path, transcript: Transcript, least: float) -> AlignedFrames:
    """Return the frames of a line with their states; a text that does not fit is an error.

    They are those in which the line is aligned: noise that is taken away there is no part of a
    voice.
    """
    ways = [one.ways for one in reader.sayings(transcript.words)]
    audio = read_audio(path)
    heard, features = best_heard(reader.models, PreparedSound.of(audio), ways)
    if not (ways and heard):
        raise SpeechError(unfit(audio, len(transcript.labels)))
    if (sure := line_confidence(heard)) < least:
        raise SpeechError(f"the text hardly fits (confidence {sure:.2f})")
    return aligned_frames(reader.models.model, features[:], heard)


def refuse_folder(models: Models, folder: Path) -> None:
    """Raise an error if `write_adapted` cannot write a model as a folder.

    A model of another form is a `SpeechError`; a folder that exists is an `OutputError`.
    """
    if not (models.acoustic / "means").is_file():
        raise SpeechError(f"{models.acoustic}: only models of CMU Sphinx are written")
    here = Path.cwd()
    if Path(os.path.abspath(folder)).is_relative_to(here):  # noqa: PTH100 a link is not followed
        refuse_outside(folder, here)
    if folder.exists():
        raise OutputError(f"{folder}: exists; name another folder, or delete it")


def write_adapted(models: Models, adapted: AcousticModel, folder: Path) -> None:
    """Write a copy of a model of CMU Sphinx with other means, under the same terms."""
    refuse_folder(models, folder)
    _, means = means_of(adapted)
    values = means.swapaxes(2, 3).astype("<f4")
    books, streams, count, length = values.shape
    sizes = (books, streams, count, *[length] * streams, values.size)
    head = b"s3\nversion 1.0\nendhdr\n" + struct.pack("<I", 0x11223344)
    shutil.copytree(models.acoustic, folder)
    if models.dictionary is not None and models.dictionary.parent != models.acoustic:
        shutil.copy(models.dictionary, folder)
    table = struct.pack(f"<{len(sizes)}i", *sizes) + values.tobytes()
    (folder / "means").write_bytes(head + table)
