"""Run the Montreal Forced Aligner, a separate program of versions 2 and 3.

The command is `mfa align CORPUS DICTIONARY MODEL OUTPUT`. It runs in a folder of its own, without a
shell, in a profile of its own, so that the settings of its user stay as they are. It has a session
of its own as well: at an interrupt or after too long a time, its workers end with it.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from lipsync_lang import SpeechError
from lipsync_lang.base.errors import did_you_mean

PROGRAM = "mfa"

PATIENCE_SECONDS = 900.0
"""Time to start, to load models and to compile the words."""

PATIENCE_FACTOR = 10.0
"""Further seconds for each second of sound."""

MAX_LOG_BYTES = 65_536
"""Bytes from the end of what the program says that are searched for its error."""

MAX_SHOWN_CHARS = 400
"""Characters of the program's own words in a message."""

MAX_SHOWN_LINES = 3

PROFILE = "lipsync-lang"

GET_MODEL = "get one with: mfa model download acoustic NAME, mfa model download dictionary NAME"

_NAME = re.compile(r"\w[\w.+-]*")
_COLOUR = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
_FRAME = re.compile(r"[\u2500-\u257f]+")
_BAR = re.compile(r"\d+%\||it/s\]|^INFO\b")
_UNKNOWN = re.compile(r'Could not find a model named "(?P<name>[^"]*)"(?: for (?P<kind>\w+))?')


class MfaModels(NamedTuple):
    """An acoustic model and a dictionary: names of downloaded ones, or paths."""

    acoustic: str
    dictionary: str

    @classmethod
    def of(cls, spelling: str | None, *, files: bool = True) -> "MfaModels":
        """Parse `MODEL` or `MODEL,DICTIONARY`; the dictionary has the model's name unless stated.

        Parameters
        ----------
        files : False to accept names of downloaded models only

        Raises
        ------
        SpeechError
            Nothing is named, or a file is missing or may not be named here.
        """
        if spelling is None:
            raise SpeechError(
                "MFA needs the name of its model, and of its dictionary if that is another: "
                f"`aligner='mfa:MODEL'` or `aligner='mfa:MODEL,DICTIONARY'`; {_downloaded()}"
            )
        acoustic, comma, dictionary = (part.strip() for part in spelling.partition(","))
        if not acoustic or (comma and not dictionary):
            raise SpeechError(f"'mfa:{spelling}': write mfa:MODEL or mfa:MODEL,DICTIONARY")
        if not comma and _is_path(acoustic):
            raise SpeechError(
                f"'mfa:{spelling}' is a file, and no dictionary has its name: write "
                "mfa:MODEL,DICTIONARY"
            )
        return cls(_located(acoustic, files=files), _located(dictionary or acoustic, files=files))


def _located(name: str, *, files: bool) -> str:
    """Return a name as it is, and a path as absolute one."""
    if not _is_path(name):
        if not _NAME.fullmatch(name):
            raise SpeechError(f"'{name}' is not the name of an MFA model; {_downloaded()}")
        return name
    if not files:
        raise SpeechError(
            f"'{name}': a language pack names downloaded models of MFA; for a file, write "
            "`aligner='mfa:MODEL,DICTIONARY'`"
        )
    path = Path(name).expanduser().absolute()
    if not path.exists():
        raise SpeechError(f"{name}: no such MFA model or dictionary; check the path")
    if path.suffix.lower() in {".yaml", ".yml"}:
        raise SpeechError(
            f"{name}: lists a dictionary for each speaker, but recordings have no speaker; name "
            "one of the dictionaries"
        )
    return str(path)


def _is_path(name: str) -> bool:
    suffix = Path(name).suffix.lower()
    return any(sign in name for sign in "/\\~") or suffix in {".zip", ".dict", ".txt", ".yaml"}


def _downloaded(name: str = "") -> str:
    """Return a hint with the user's own models."""
    known = downloaded_models()
    if known:
        return did_you_mean(name, known) if name else f"known: {', '.join(known)}"
    return GET_MODEL


def downloaded_models() -> list[str]:
    """Return the names of the user's own acoustic models."""
    root = Path(os.environ.get("MFA_ROOT_DIR") or "~/Documents/MFA").expanduser()
    try:
        return sorted(path.stem for path in (root / "pretrained_models/acoustic").glob("*.zip"))
    except OSError:
        return []


def run_mfa(corpus: Path, models: MfaModels, output: Path, *, seconds: float, jobs: int) -> None:
    """Align all recordings of a corpus.

    Parameters
    ----------
    corpus : a folder of sounds with texts
    output : for the TextGrids; the folder that holds it gets all other files
    seconds : length of all sounds
    jobs : processes at once

    Raises
    ------
    SpeechError
        The program is missing, cannot be started, failed, or took too long.
    """
    program = shutil.which(PROGRAM)
    if program is None:
        raise SpeechError(
            f"the program '{PROGRAM}' of the Montreal Forced Aligner is not on the PATH; get it "
            "with: conda create -n aligner -c conda-forge montreal-forced-aligner, and start "
            "lipsync-lang after: conda activate aligner"
        )
    folder = output.parent
    command = [
        program, "align", str(corpus), models.dictionary, models.acoustic, str(output),
        "--temporary_directory", str(folder / "temporary"), "--num_jobs", str(jobs),
        "--output_format", "long_textgrid", "--clean",
    ]  # fmt: skip
    log = folder / "log"
    patience = PATIENCE_SECONDS + PATIENCE_FACTOR * seconds
    code = _waited(command, folder, log, patience)
    if code:
        raise SpeechError(_told(log, code))


def _waited(command: list[str], folder: Path, log: Path, patience: float) -> int:
    """Run a command to its end, and return its exit code."""
    plain = {"MFA_PROFILE": PROFILE, "NO_COLOR": "1", "TERM": "dumb", "COLUMNS": "400"}
    with log.open("wb") as said:
        try:
            process = subprocess.Popen(  # noqa: S603 no shell reads it
                command, stdin=subprocess.DEVNULL, stdout=said, stderr=said, cwd=folder,
                env={**os.environ, **plain}, start_new_session=True,
            )  # fmt: skip
        except (OSError, ValueError) as error:
            told = getattr(error, "strerror", None) or error
            raise SpeechError(f"MFA cannot be started with '{command[0]}': {told}") from None
        try:
            code = process.wait(patience)
        except subprocess.TimeoutExpired:
            end_tree(process)
            raise SpeechError(
                f"MFA did not finish within {patience:.0f} s; align fewer or shorter recordings"
            ) from None
        except BaseException:
            end_tree(process)
            raise
    if code:
        end_tree(process)
    return code


def end_tree(process: "subprocess.Popen[bytes]") -> None:
    """End a process in a session of its own, and all that it started."""
    if sys.platform == "win32":
        tool = Path(os.environ.get("SYSTEMROOT", r"C:\Windows"), "System32", "taskkill.exe")
        with suppress(OSError):
            subprocess.run(  # noqa: S603 no shell reads it
                [str(tool), "/F", "/T", "/PID", str(process.pid)], capture_output=True, check=False
            )
        process.kill()
    else:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _told(log: Path, code: int) -> str:
    """Return a message for a failed run, with the last words of the program."""
    with log.open("rb") as file:
        file.seek(max(0, log.stat().st_size - MAX_LOG_BYTES))
        text = _COLOUR.sub("", file.read().decode("utf-8", "replace"))
    unknown = _UNKNOWN.search(" ".join(_FRAME.sub(" ", text).split()))
    if unknown:
        name, kind = unknown["name"], unknown["kind"] or "acoustic"
        return (
            f"MFA has no {kind} model '{name}'; {_downloaded(name)} "
            f"(mfa model download {kind} {name} gets it, if there is one)"
        )
    if "NoAlignmentsError" in text or "no successful alignments" in text:
        return "MFA could not align the text with the recording; check that the text is right"
    lines = [_FRAME.sub("", line).strip() for line in re.split(r"[\r\n]+", text)]
    lines = [line for line in lines if line and not _BAR.search(line)]
    last = [n for n, line in enumerate(lines) if "Error" in line or "ERROR" in line][-1:]
    shown = " ".join(lines[last[0] :] if last else lines[-MAX_SHOWN_LINES:])
    words = f": {shown[-MAX_SHOWN_CHARS:]}" if shown else " without a message"
    how = f"ended with code {code}" if code > 0 else f"was ended by signal {-code}"
    return f"MFA {how}{words}"
