"""Speech synthesis by Festival, a separate program packaged by Debian and others.

Each text runs in its own process. Text and voice are passed in files, as strings without
evaluation; `festival.scm` processes them. The answer is line-based: the voice's phone set, the
tokens of the text, and each sound with its end time and token number.
"""

import shutil
import subprocess
import sys
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from lipsync_lang import Audio, Schedule, SpeechError
from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.schedules.schedule import SILENCE
from lipsync_lang.sound.speech import speech_engine
from lipsync_lang.sound.speech.speaking.speech_engines import refuse_rate, refuse_unspeakable
from lipsync_lang.sound.speech.speaking.word_spans import find_words
from lipsync_lang.text.phonology.espeak.process import quoted

SCRIPT = Path(__file__).with_name("festival.scm")

NOTATIONS = {"radio": "arpabet", "cmu": "arpabet"}
"""Notation of each Festival phone set."""

STRESS_DIGITS = {"0", "1", "2"}
"""Stress of a syllable in the lexica of these sets."""

PAUSE_PHONES = {"pau", "h#", "brth", "#"}
"""Pause phones of these sets."""

USUAL_WORDS_PER_MINUTE = 185
"""Default speech rate in words per minute."""

MAX_FESTIVAL_CHARS = 5000
"""Text limit in characters; run time grows faster than the text."""

ASCII_LETTERS = dict(zip("‘’“”…–—", "''\"\",,,", strict=True))
"""ASCII replacements of typographic characters unknown to Festival."""

GET_IT = (
    "get it with: apt-get install festival festvox-kallpc16k"
    if sys.platform == "linux"
    else "see festvox.org/festival; Linux systems have packages of it"
)


class Answer(NamedTuple):
    """Parsed output of Festival for one text."""

    phones: str
    """Phone set of the voice."""
    tokens: tuple[str, ...]
    sounds: tuple[tuple[str, float, int, int | None], ...]
    """Phone, end in seconds, token number from 1 (0 for none), and stress of a vowel's syllable."""
    voices: tuple[str, ...]
    """Available voices, if the requested voice is unknown."""


@speech_engine("festival")
@dataclass
class Festival:
    """Festival as a speech engine.

    Parameters
    ----------
    program : the command line of Festival
    patience : timeout in seconds, plus 0.01 s per character
    """

    program: str = "festival"
    patience: float = 30.0

    def speak(self, text: str, voice: str, *, words_per_minute: int | None = None) -> Schedule:
        """Speak a text with a named voice, such as ``kal_diphone``.

        It is a `SpeechError` if the text is empty, the voice is unknown, or the program fails.
        """
        import wave

        written = unicodedata.normalize("NFC", text)
        spoken = _plain(written)
        stretch = 1.0
        if words_per_minute is not None:
            refuse_rate("Festival", words_per_minute)
            stretch = USUAL_WORDS_PER_MINUTE / words_per_minute
        with TemporaryDirectory(prefix="lipsync-lang-") as folder:
            answer = self._ask(Path(folder), spoken, voice, stretch)
            if not answer.sounds:
                hint = did_you_mean(voice, answer.voices)
                raise SpeechError(f"Festival has no voice '{voice}'; {hint}")
            try:
                with wave.open(str(Path(folder) / "sound.wav")) as sound:
                    samples = np.frombuffer(sound.readframes(sound.getnframes()), np.int16)
                    audio = Audio(samples, sound.getframerate())
            except (OSError, EOFError, wave.Error):
                raise SpeechError("Festival wrote no readable sound; try again") from None
        return _schedule(answer, audio, written, voice)

    def voices(self) -> dict[str, str]:
        """Return the installed voices."""
        with TemporaryDirectory(prefix="lipsync-lang-") as folder:
            answer = self._ask(Path(folder), "none", "none", 1.0)
        return {name: name.replace("_", " ") for name in sorted(answer.voices)}

    def _ask(self, folder: Path, text: str, voice: str, stretch: float) -> Answer:
        """Run Festival in a folder for one text."""
        program = shutil.which(self.program)
        if program is None:
            raise SpeechError(
                f"speaking with Festival needs the program '{self.program}', which is not "
                f"installed; {GET_IT}"
            )
        (folder / "text").write_text(text, "ascii")
        # In files, and never in the command: Festival evaluates what it is given as Scheme.
        (folder / "voice").write_text(voice or "none", "utf-8")
        try:
            done = subprocess.run(  # noqa: S603 our own script, no shell
                [program, "--batch", f"(set! stretch {stretch:.4f})", str(SCRIPT)],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                cwd=folder,
                timeout=self.patience + len(text) / 100,
                check=False,
            )
        except subprocess.TimeoutExpired as late:
            raise SpeechError(
                f"Festival did not finish within {late.timeout:.0f} s with {quoted(text)}; "
                "try again, or split the text"
            ) from None
        except OSError as error:
            raise SpeechError(
                f"Festival cannot be started with '{program}': {error.strerror or error}"
            ) from None
        answer = _read(done.stdout.decode("utf-8", "replace"))
        if done.returncode or not (answer.sounds or answer.voices):
            said = done.stderr.decode("utf-8", "replace").strip().splitlines()
            told = f" ({said[-1]})" if said else ""
            raise SpeechError(
                f"Festival failed in the voice '{voice}' with {quoted(text)}{told}; "
                "try a shorter or a plainer text"
            )
        return answer


def _plain(text: str) -> str:
    """Replace letters unknown to Festival, one for one; by a space without an equivalent."""
    plain = "".join(_letter(c) for c in text)
    refuse_unspeakable(plain, quoted(text), " that Festival can read", MAX_FESTIVAL_CHARS)
    return plain


def _letter(character: str) -> str:
    bare = unicodedata.normalize("NFKD", ASCII_LETTERS.get(character, character))[0]
    return bare if bare.isascii() and bare.isprintable() else " "


def _read(answer: str) -> Answer:
    """Parse the lines of an answer; unknown lines are ignored."""
    phones = ""
    tokens: list[str] = []
    sounds: list[tuple[str, float, int, int | None]] = []
    voices: list[str] = []
    for line in answer.splitlines():
        match line.split():
            case ["phones", name]:
                phones = name
            case ["token", name]:
                tokens.append(name)
            case ["sound", name, end, token, stress]:
                mark = int(stress) if stress in STRESS_DIGITS else None
                sounds.append((name, float(end), int(token), mark))
            case ["voice", name]:
                voices.append(name)
    return Answer(phones, tuple(tokens), tuple(sounds), tuple(voices))


def _schedule(answer: Answer, audio: Audio, text: str, voice: str) -> Schedule:
    """Build a schedule from an answer, from 0 to the end of the sound."""
    if answer.phones not in NOTATIONS:
        raise SpeechError(
            f"the Festival voice '{voice}' speaks in the phone set '{answer.phones}', which is "
            f"unknown here; choose a voice with {' or '.join(NOTATIONS)}"
        )
    labels: list[str] = []
    stresses: list[int | None] = []
    ends: list[float] = [0.0]
    first: dict[int, int] = {}
    for phone, end, token, stress in answer.sounds:
        label = SILENCE if phone in PAUSE_PHONES else phone.upper()
        if end <= ends[-1]:
            continue
        if label == SILENCE and labels[-1:] == [SILENCE]:
            ends[-1] = end
            continue
        # Festival answers 0 for a pause, which has no token.
        if token:
            first.setdefault(token, len(labels))
        labels.append(label)
        stresses.append(stress)
        ends.append(end)
    if all(label == SILENCE for label in labels):
        raise SpeechError(
            f"Festival says nothing for {quoted(text)}; write it in the script of the voice"
        )
    # The last pause is longer or shorter than the rest of the sound, which takes its place.
    if labels[-1] == SILENCE:
        labels.pop()
        stresses.pop()
        ends.pop()
    if audio.seconds > ends[-1]:
        labels.append(SILENCE)
        stresses.append(None)
        ends.append(audio.seconds)
    return Schedule(
        tuple(labels),
        np.array(ends),
        words=find_words(text, _marks(answer.tokens, first, _plain(text)), labels),
        notation=NOTATIONS[answer.phones],
        audio=audio,
        source=f"speech {quoted(text)}",
        unread=tuple(dict.fromkeys(c for c in text if c.isalnum() and _letter(c) == " ")),
        stress=tuple(stresses) if any(stresses) else (),
    )


def _marks(tokens: Sequence[str], first: dict[int, int], text: str) -> list[tuple[int, int]]:
    """Return the text position and first sound number of each audible token."""
    marks: list[tuple[int, int]] = []
    at = 0
    for number, token in enumerate(tokens, start=1):
        found = text.find(token, at)
        at = found if found >= 0 else at
        if number in first:
            marks.append((at, first[number]))
        at += len(token) if found >= 0 else 0
    return marks
