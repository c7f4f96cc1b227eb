"""eSpeak NG in a process of its own: its voices, and text to phonemes without sound.

A process of its own keeps the library's licence, its crashes and its memory apart from ours; one
for each text makes the same text sound the same, byte for byte. `espeak_stream` speaks many.
"""

import io
import json
import re
import signal
import subprocess
import sys
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lipsync_lang.base.errors import SpeechError, did_you_mean
from lipsync_lang.base.extras import needing

_NAME_MARKS = "ˈˌ0123456789"
STRESS_LEVELS = {"ˈ": 1, "ˌ": 2}
"""Stress by mark: primary and secondary."""

VOICE_PAUSE = "_"
"""Label of a pause within a clause."""

_STRESSED = re.compile("([ˈˌ])")


def words_of(clause: str) -> list[tuple[str, ...]]:
    """Return the labels of each word of a clause, as events have them, after their stress marks.

    `clause` has phonemes joined by ``_`` and words by spaces. `VOICE_PAUSE` ends a word before a
    dash, a bracket or a quotation mark at which the voice pauses.

    >>> words_of("h_ə_lˈoʊ__ w_ɜː_l_d")
    [('h', 'ə', 'l', 'ˈoʊ', '_'), ('w', 'ɜː', 'l', 'd')]
    """
    words = []
    for word in clause.split():
        labels: list[str] = []
        for name in _STRESSED.sub(r"_\1", word).split("_"):
            label = label_of(name)
            if label and labels and modifies(label):
                labels[-1] += label
            elif label:
                labels.append(name[0] + label if name[0] in STRESS_LEVELS else label)
        if labels:
            pause = [VOICE_PAUSE] if word.rstrip(":").endswith("__") else []
            words.append((*labels, *pause))
    return words


def label_of(name: str) -> str:
    """Return the bare sound of a name; empty for flags and marks."""
    return "" if name.startswith("(") else name.strip(_NAME_MARKS)


def stress_of(name: str) -> int | None:
    """Return the stress that a name is marked with: 1, 2 or None."""
    return next((level for mark, level in STRESS_LEVELS.items() if mark in name), None)


def modifies(label: str) -> bool:
    """Return True for a label that is only a modifier letter or a combining mark."""
    return 0x2B0 <= ord(label[0]) <= 0x36F  # noqa: PLR2004 the two blocks in Unicode


Bytes = bytes | bytearray
"""Bytes of an answer: read at once, or into one buffer."""

FRAME_MAGIC = b"lipsync1"
WORKER = Path(__file__).with_name("espeak_worker.py")

GARBAGE = "eSpeak NG gave an unreadable answer; try again"
"""Message for an answer with an invalid frame."""

WORKER_TEXTS = 2000
"""Maximum number of texts for one process."""

_QUOTED_CHARS = 60
_DOTS = re.compile(r"(?:\.{2,}|…)([!?]*)")
"""An ellipsis with the marks behind it, which some voices would read out by name."""
_ORDER = (
    (re.compile("([\u064b-\u0650])\u0651"), "\u0651\\1"),
    (re.compile("([\u05b0-\u05bb\u05c7]+)([\u05bc\u05c1\u05c2]+)"), r"\2\1"),
    (re.compile("(?<=[\u0400-\u04ff])\u0301"), ""),
    (re.compile(r"(?<=[\w!?])!(?=[!?]{,9}[\w¡-])"), "！"),
    (re.compile(r"(?<=[\w!?！])\?(?=[!?！]{,9}(?!\d)[\w¿])"), "？"),
)
"""Marks that the library reads only in the opposite of the Unicode order, or not at all.

It knows no word with the stress mark of Cyrillic, and joins or names the marks within `No?No!No!`.
"""

_BLANKED = frozenset("«»‹›„“”‟\u00ad\u200b\u200e\u200f\u2060\ufeff")
_BLANKED |= {chr(code) for code in (*range(0x202A, 0x202F), *range(0x2066, 0x206A))}
"""Quotation marks, and characters that are hidden or turn the direction of writing."""

_NAMED_MARKS = re.compile("[!?:;।॥؟؛۔။。！？：；]")
_LONE_MARKS = re.compile(
    r"(?:^|(?<=[.…,!?:;—।॥؟،؛۔။。、，！？：；]\s))[^\w\s]*(?:\s+[^\w\s]+)*"
    r"|(?<=[^\W\d_A-Z]{3}):(?=[^\W\d_])"
)
"""Marks without a word before them, and colons within words, which some voices read out by name."""

_UNREAD_CATEGORIES = frozenset({"Cc", "Cs", "Co", "Cn"})
"""Control characters, lone surrogates, and characters without a meaning in Unicode."""


@dataclass
class EspeakProcess:
    """The library behind a process boundary: `python` runs the script `worker`.

    Name an interpreter where this one is embedded in a host. `patience` are seconds to wait for an
    answer, beyond a hundredth of one per character.
    """

    python: str = sys.executable
    worker: Path = WORKER
    patience: float = 20.0

    def transcribe(self, texts: Sequence[str], voice: str) -> Iterator[list[list[tuple[str, ...]]]]:
        """Convert texts to phonemes without sound.

        Yield for each text its clauses, of each its words, of each its labels in IPA, as `speak`
        has them, after their stress marks.
        """
        for start in range(0, len(texts), WORKER_TEXTS):
            batch = [blank(text) for text in texts[start : start + WORKER_TEXTS]]
            request, folder = self.request("transcribe", voice=voice)
            done = self._run({**request, "texts": batch}, folder, batch)
            stream = io.BytesIO(done.stdout)
            headers = []
            while stream.tell() < len(done.stdout):
                headers.append(read_frame(stream.read)[0])
            if headers and "error" in headers[0]:
                raise SpeechError(refusal(headers[0], voice))
            for header in headers[1:]:
                yield [words_of(clause) for clause in header["clauses"]]
            if len(headers) != len(batch) + 1:
                # It ended at the first text without an answer.
                at = max(len(headers) - 1, 0)
                raise SpeechError(ending(done.returncode, done.stderr, batch[at], voice))

    def voices(self) -> dict[str, str]:
        """Return the voices of the library: language code and title."""
        header, _ = self.ask("voices")
        return {str(name): str(title) for name, title in header["voices"].items()}

    def missing(self, voices: Sequence[str]) -> dict[str, str]:
        """Map each voice that the library lacks to a hint with similar voices."""
        header, _ = self.ask("missing", text="\n".join(voices))
        return {str(voice): did_you_mean(voice, header["voices"]) for voice in header["missing"]}

    def ask(self, task: str, text: str = "", voice: str = "", rate: int = 0) -> tuple[Any, Bytes]:
        """Run the worker for one request and return its answer's header and sound."""
        request, folder = self.request(task, text, voice, rate)
        done = self._run(request, folder, [text])
        if done.returncode:
            raise SpeechError(ending(done.returncode, done.stderr, text, voice))
        answer = io.BytesIO(done.stdout)
        header, sound = read_frame(answer.read)
        if answer.read(1):
            raise SpeechError(GARBAGE)
        if "error" in header:
            raise SpeechError(refusal(header, voice))
        return header | {"said": last_line(done.stderr)}, sound

    @property
    def command(self) -> list[str]:
        """The command line of the worker."""
        # The standard library is enough; without the user's packages it starts faster.
        return [self.python, "-I", "-S", str(self.worker)]

    def request(
        self, task: str, text: str = "", voice: str = "", rate: int = 0
    ) -> tuple[dict[str, Any], Path]:
        """Return a request to the worker, and the folder to run it in.

        The library and its data are found without loading either.
        """
        what = "speaking text needs eSpeak NG, which is not installed; get it with:"
        with needing(SpeechError, what, "speech"):
            import espeakng_loader
        broken = "eSpeak NG is not installed whole"
        try:
            library = espeakng_loader.get_library_path()
            data = Path(espeakng_loader.get_data_path())
        except RuntimeError as error:
            raise SpeechError(f"{broken}: {error}; install it again") from None
        for path in (Path(library), data):
            if not path.exists():
                raise SpeechError(f"{broken}: no {path}; install it again")
        request = {"library": library, "data": data.name, "task": task}
        return {**request, "text": text, "voice": voice, "rate": rate}, data.parent

    def limit(self, texts: Sequence[str]) -> float:
        """Return the seconds to wait for an answer to texts."""
        return self.patience + sum(map(len, texts)) / 100

    def _run(
        self, request: object, folder: Path, texts: Sequence[str]
    ) -> "subprocess.CompletedProcess[bytes]":
        """Run a worker for one request."""
        try:
            return subprocess.run(  # noqa: S603 our own script, no shell
                self.command,
                input=json.dumps(request).encode("ascii"),
                capture_output=True,
                cwd=folder,
                timeout=self.limit(texts),
                check=False,
            )
        except subprocess.TimeoutExpired as late:
            raise SpeechError(unfinished(late.timeout, texts[0])) from None
        except OSError as error:
            raise self.unstarted(error) from None

    def unstarted(self, error: OSError) -> SpeechError:
        """Return the error of an interpreter that cannot be started."""
        why = error.strerror or error
        return SpeechError(f"eSpeak NG cannot be started with '{self.python}': {why}")


def blank(text: str) -> str:
    """Replace characters that control the library, or that some voices read out by name."""
    for marks, order in _ORDER:
        text = marks.sub(order, text)
    text = _LONE_MARKS.sub(lambda found: _NAMED_MARKS.sub(" ", found[0]), text)
    dotted = _DOTS.sub(lambda dots: (dots[1] or ",").ljust(len(dots[0])), text)
    return "".join(
        " " if c in _BLANKED or (unicodedata.category(c) in _UNREAD_CATEGORIES and c != "\n") else c
        for c in dotted
    )


def quoted(text: str) -> str:
    """Return a text in quotes, shortened for a message."""
    return repr(text if len(text) <= _QUOTED_CHARS else text[: _QUOTED_CHARS - 3] + "...")


def ending(code: int, stderr: bytes, text: str, voice: str) -> str:
    """Return the error for a worker that ended, with a cure."""
    how = f"ended with code {code}"
    if code < 0:
        names = {int(s): s.name for s in signal.Signals}
        how = f"crashed ({names.get(-code, f'signal {-code}')})"
    return (
        f"eSpeak NG {how} in the voice '{voice}' with {quoted(text)}"
        + last_line(stderr)
        + "; try another voice, or a shorter text"
    )


def unfinished(seconds: float, text: str) -> str:
    """Return the error for a text that took too long."""
    return (
        f"eSpeak NG did not finish within {seconds:.0f} s with {quoted(text)}; "
        "try again, or split the text"
    )


def last_line(stderr: bytes) -> str:
    """Return the last line that the library printed, as the end of a sentence."""
    lines = stderr.decode("utf-8", "replace").strip().splitlines()
    return f" ({lines[-1].strip()})" if lines else ""


def read_frame(read: Callable[[int], Bytes]) -> tuple[Any, Bytes]:
    """Read and check the header and the sound of an answer.

    `read` returns so many bytes, fewer at the end of the answer.
    """
    start = read(len(FRAME_MAGIC) + 4)
    length = int.from_bytes(start[len(FRAME_MAGIC) :], "little")
    raw = read(length) if start.startswith(FRAME_MAGIC) else b""
    try:
        header = json.loads(raw)
    except ValueError:
        raise SpeechError(GARBAGE) from None
    size = header.get("bytes", 0) if isinstance(header, dict) else -1
    if not isinstance(size, int) or size < 0:
        raise SpeechError(GARBAGE)
    sound = read(size)
    if len(sound) != size:
        raise SpeechError(GARBAGE)
    return header, sound


def refusal(header: dict[str, Any], voice: str) -> str:
    """Return the error for a library that does not speak."""
    match header["error"]:
        case "voice":
            return f"eSpeak NG has no voice '{voice}'; {did_you_mean(voice, header['known'])}"
        case "variant":
            variant = voice.partition("+")[2]
            hint = did_you_mean(variant, header["known"])
            return f"eSpeak NG has no voice variant '{variant}'; {hint}"
        case "data":
            return "eSpeak NG cannot read its data; install it again"
        case _:
            return f"eSpeak NG could not speak the text (status {header.get('status')})"
