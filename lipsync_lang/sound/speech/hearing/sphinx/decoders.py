"""Decoders of pocketsphinx: the words of a sound.

A sound is decoded in parts, cut at the quietest frames.
"""

import json
import re
import subprocess
import sys
from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from pathlib import Path
from subprocess import DEVNULL, PIPE
from threading import Timer, local
from time import monotonic
from typing import Any, NamedTuple, TypeVar
from weakref import finalize

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.sound.speech.hearing.sphinx.features import HOP_SAMPLES
from lipsync_lang.sound.speech.hearing.sphinx.folder import Models
from lipsync_lang.sound.speech.sound import SPEECH_RATE

MIN_PART_SAMPLES, MAX_PART_SAMPLES = 10 * SPEECH_RATE, 20 * SPEECH_RATE
"""Target part length in samples."""

QUIET_FRAMES = 20
"""Window of the loudness measure in frames."""

MAX_ACTIVE_STATES = 3000
"""Most states that are followed at once.

A tenth of the usual number takes half the time, and errs in 67 of 100 words of natural speech
instead of 64.
"""

VARIANT = re.compile(r"\(\d+\)$")
"""Number of a further pronunciation, after a word of the dictionary."""

DECODER_SCRIPT = Path(__file__).with_name("sphinx_worker.py")

LOADING_SECONDS, PATIENCE = 30.0, 10.0
"""Seconds to wait for a decoder, and for each second of its sound."""

ReadAnswer = TypeVar("ReadAnswer")

threads = local()
"""Decoders; each takes a second to load and some 100 MB, and serves one thread at a time."""


class DecodedWord(NamedTuple):
    """A word of the dictionary with its posterior probability."""

    text: str
    posterior: float


def parts(
    sound: Floats | npt.NDArray[np.int16],
    shortest: int = MIN_PART_SAMPLES,
    longest: int = MAX_PART_SAMPLES,
) -> Iterator[tuple[int, int]]:
    """Yield start and stop samples of parts: whole frames, cut at the quietest frames."""
    start = 0
    while len(sound) - start > longest:
        # Energy of a window from the difference of running sums; every sum at a frame's start.
        energy = np.cumsum(np.square(sound[start + shortest : start + longest], dtype=np.float64))[
            ::HOP_SAMPLES
        ]
        quietest = int((energy[QUIET_FRAMES:] - energy[:-QUIET_FRAMES]).argmin())
        stop = start + shortest + (quietest + QUIET_FRAMES // 2) * HOP_SAMPLES
        yield start, stop
        start = stop
    yield start, len(sound)


def decoded_words(models: Models, sound: Floats) -> list[DecodedWord]:
    """Return the recognised words, by this thread's decoder, which is loaded once."""
    loaded: dict[Models, ModelProcess] = threads.__dict__.setdefault("loaded", {})
    if models not in loaded:
        model = models.acoustic
        paths = {"hmm": model, "dict": models.dictionary, "lm": models.language_model}
        settings: dict[str, Any] = {name: str(path) for name, path in paths.items()}
        settings["maxhmmpf"] = MAX_ACTIVE_STATES
        loaded[models] = ModelProcess(DECODER_SCRIPT, "pocketsphinx", model, settings)
    # a peak above full scale would wrap round
    samples = np.clip(np.rint(sound), -(2**15), 2**15 - 1).astype(np.int16).tobytes()
    patience = LOADING_SECONDS + PATIENCE * len(samples) / 2 / SPEECH_RATE
    request = b"%d\n" % len(samples) + samples
    try:
        with closing(loaded[models].answers(request, patience, _read)) as given:
            found = next(given)
    except SpeechError:
        del loaded[models]
        raise
    # entries outside the dictionary are pauses or noises
    ways = models.ways(word.text for word in found)
    return [word for word, known in zip(found, ways, strict=True) if known]


class ModelProcess:
    """A model that native code reads in a process of its own, which ends with this object.

    Its script reads `settings` and the path of imports as a line of JSON, and then requests. Each
    answer is a line of JSON.
    """

    def __init__(self, script: Path, program: str, model: Path, settings: dict[str, Any]) -> None:
        self._program, self._model = program, model
        command = [sys.executable, "-I", "-S", str(script)]  # our own script, no shell
        self._worker = subprocess.Popen(command, stdin=PIPE, stdout=PIPE, stderr=DEVNULL)  # noqa: S603
        finalize(self, _end, self._worker)
        self._start = json.dumps({"path": sys.path, "settings": settings}).encode() + b"\n"

    def answers(
        self, request: bytes, patience: float, read: Callable[[Any], ReadAnswer]
    ) -> Generator[ReadAnswer]:
        """Yield all answers to a request within `patience` seconds, as `read` returns them."""
        sent, given = self._worker.stdin, self._worker.stdout
        assert sent is not None and given is not None  # noqa: S101, PT018 both are pipes
        late, began = Timer(patience, self._worker.kill), monotonic()
        late.start()
        try:
            sent.write(self._start + request)
            sent.flush()
            self._start = b""
            while True:
                yield read(json.loads(given.readline()))
        except (OSError, ValueError, TypeError):
            hung = monotonic() - began >= patience
            how = f"did not answer in {patience:.0f} s" if hung else "ended"
            raise SpeechError(
                f"{self._program} {how} with the model {self._model}, which may be damaged; "
                "copy its folder again, or name another model"
            ) from None
        finally:
            late.cancel()


def _end(worker: "subprocess.Popen[bytes]") -> None:
    worker.kill()
    worker.communicate()


def _read(answer: Any) -> list[DecodedWord]:
    return [DecodedWord(VARIANT.sub("", word), min(float(prob), 1.0)) for word, prob in answer]
