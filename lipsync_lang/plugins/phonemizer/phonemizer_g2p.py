"""Text to phonemes with phonemizer: by an orthography profile, by Festival, or by eSpeak NG.

phonemizer runs in a process of its own, one for each backend and language (`phonemizer_worker`).
Its folder for temporary files goes with it, whichever of the two processes is killed.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import weakref
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from subprocess import DEVNULL, PIPE
from typing import Any
from unicodedata import normalize

from lipsync_lang import SpeechError
from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.base.extras import install_line
from lipsync_lang.base.files.temporary import sweep, temporary_name
from lipsync_lang.text.phonology.espeak.process import words_of
from lipsync_lang.text.phonology.g2p.espeak_g2p import LabelledWords, by_clauses, label_splitter
from lipsync_lang.text.phonology.g2p.g2p_engines import (
    G2P_ENGINES,
    G2PEngine,
    MissingReaderError,
    Settings,
    SpokenWord,
)
from lipsync_lang.text.phonology.g2p.orthography_profile import BY_PROFILE, SOUNDS, read_profile
from lipsync_lang.text.phonology.g2p.tokens import pieces, read_words, unmarked

PHONEMIZER_WORKER = Path(__file__).with_name("phonemizer_worker.py")

BY_FESTIVAL, BY_ESPEAK = "festival", "espeak"

MAX_WORKERS = 4
"""Maximum number of workers that one process keeps."""

WORKER_SECONDS, SECONDS_PER_CHARACTER = 120.0, 0.01
"""Seconds to wait for an answer."""


@G2P_ENGINES.register("phonemizer")
def engine(settings: Settings) -> G2PEngine:
    """Read text with a backend of phonemizer."""
    if find_spec("phonemizer") is None or find_spec("segments") is None:
        raise MissingReaderError(
            f"{settings.language} is read by phonemizer, which is not installed; "
            f"get it with: {install_line('phonemizer')}"
        )
    return _by_voice(settings) if settings.backend != BY_PROFILE else _by_profile(settings)


def _by_profile(settings: Settings) -> G2PEngine:
    if settings.file is None:
        raise SpeechError(
            f"{settings.language} reads by an orthography profile, but names none: state it as "
            "`g2p: {engine: phonemizer, file: profile.tsv}`"
        )
    graphemes = read_profile(settings.file, settings.column or SOUNDS)
    sounds = [*graphemes.sounds.values()]
    # phonemizer knows one sound for each grapheme, which is here the number of its sounds.
    profile = tuple(f"{grapheme} {number}" for number, grapheme in enumerate(graphemes.sounds))

    def read(texts: Sequence[str]) -> Iterator[tuple[SpokenWord, ...]]:
        found = {p.text for text in texts for p in pieces(text) if p.kind == "word"}
        cut = {word: graphemes.cut(word) for word in sorted(found)}
        # Each grapheme goes as a word: the search takes seconds for a word of 30 letters.
        numbers = _said(BY_PROFILE, "", profile, [" ".join(parts) for parts, _ in cut.values()])
        words = {
            word: SpokenWord(
                word,
                tuple(
                    sound for number in re.findall(r"\d+", said) for sound in sounds[int(number)]
                ),
                unread=unread,
            )
            for (word, (_, unread)), said in zip(cut.items(), numbers, strict=True)
        }
        for text in texts:
            yield read_words(text, words.__getitem__)

    return read


def _by_voice(settings: Settings) -> G2PEngine:
    voice = settings.code or settings.voice or ""
    if settings.backend == BY_FESTIVAL and shutil.which("festival") is None:
        raise SpeechError(
            f"{settings.language} is read by the program festival, which is not installed "
            "(Debian, Ubuntu: apt install festival festvox-kallpc16k)"
        )

    def transcribe(texts: Sequence[str]) -> Iterator[Sequence[LabelledWords]]:
        clauses = [list(_clauses(text, settings.backend)) for text in texts]
        lines = sorted({clause for found in clauses for clause in found})
        said = dict(zip(lines, _said(settings.backend, voice, (), lines), strict=True))
        yield from ([words_of(said[clause]) for clause in found] for found in clauses)

    read, split = by_clauses(transcribe), label_splitter(settings.labels)
    return lambda texts: (tuple(map(split, words)) for words in read(texts))


def _clauses(text: str, backend: str) -> Iterator[str]:
    """Yield the parts of a text between its pauses, which phonemizer itself forgets."""
    words: list[str] = []
    for piece in (*pieces(text), None):
        if piece is not None and piece.kind != "pause":
            words.append(piece.text)
            continue
        clause = " ".join(words)
        if backend == BY_FESTIVAL:  # which crashes at some characters beyond ASCII
            clause = unmarked(normalize("NFD", clause)).encode("ascii", "ignore").decode()
        if any(map(str.isalnum, clause)):
            yield clause
        words = []


def _said(backend: str, language: str, profile: tuple[str, ...], texts: list[str]) -> list[str]:
    """Return what a backend says for each text."""
    if not texts:
        return []
    try:
        reply = worker(os.getpid(), backend, language, profile).ask(texts)
    except OSError:
        worker.cache_clear()
        raise SpeechError(
            f"phonemizer ended without an answer for {len(texts)} texts, of which the first is "
            f"{texts[0][:60]!r}; try again, or split the texts"
        ) from None
    if isinstance(reply, list):
        return reply
    if "known" in reply:
        hint = did_you_mean(language, reply["known"])
        raise SpeechError(f"phonemizer's {backend} has no language '{language}'; {hint}")
    raise SpeechError(f"phonemizer cannot read with {backend}: {reply['error']}")


@lru_cache(MAX_WORKERS)
def worker(process: int, backend: str, language: str, profile: tuple[str, ...]) -> "Worker":
    """Return the worker for a backend and language; a forked process makes its own."""
    return Worker(process, backend, language, profile)


class Worker:
    """A worker, and the folder of its temporary files."""

    def __init__(self, owner: int, backend: str, *request: Any) -> None:
        environment = dict(os.environ)
        if backend == BY_ESPEAK:
            from lipsync_lang.text.phonology.espeak.process import EspeakProcess

            library, folder = EspeakProcess().request("")
            environment["PHONEMIZER_ESPEAK_LIBRARY"] = library["library"]
            environment["PHONEMIZER_ESPEAK_DATA_PATH"] = str(folder / library["data"])
        temporary = Path(tempfile.gettempdir())
        sweep(temporary)
        self.folder = temporary / temporary_name("phonemizer")
        self.folder.mkdir(mode=0o700)
        self.process = subprocess.Popen(  # noqa: S603 our own script, no shell
            [sys.executable, "-P", PHONEMIZER_WORKER, self.folder],
            stdin=PIPE, stdout=PIPE, stderr=DEVNULL, env=environment,
        )  # fmt: skip
        weakref.finalize(self, _end, owner, self.process, self.folder)
        self._lock = threading.Lock()
        self._first: Iterable[object] = [(backend, *request)]

    def ask(self, texts: list[str]) -> Any:
        """Return the answer to some texts; raise OSError if there is none."""
        assert self.process.stdin is not None  # noqa: S101 for the type checker
        assert self.process.stdout is not None  # noqa: S101
        limit = WORKER_SECONDS + SECONDS_PER_CHARACTER * sum(map(len, texts))
        with self._lock:
            watch = threading.Timer(limit, self.process.kill)
            watch.start()
            try:
                for request in (*self._first, texts):
                    self.process.stdin.write(json.dumps(request).encode("ascii") + b"\n")
                self.process.stdin.flush()
                self._first = ()
                answer = self.process.stdout.readline()
            finally:
                watch.cancel()
        if not answer.endswith(b"\n"):
            raise BrokenPipeError
        return json.loads(answer)


def _end(owner: int, process: "subprocess.Popen[bytes]", folder: Path) -> None:
    """End a worker, and delete its folder, unless this process is a fork of its owner."""
    if os.getpid() != owner:
        return
    process.kill()
    process.communicate()
    shutil.rmtree(folder, ignore_errors=True)
