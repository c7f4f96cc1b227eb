"""The form of a check of `doctor`, and checks of voices, speech engines, models and ffmpeg."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple

from lipsync_lang.errors import LipsyncError, SpeechError, shortlist
from lipsync_lang.extensions import Extensions
from lipsync_lang.extras import extras, install_line

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Pack
    from lipsync_lang.packs.models import Language

OK, MISSING, BROKEN = "ok", "missing", "broken"
"""States. A missing part is optional; a broken one fails the check."""

IMPORT_SECONDS = 60.0
"""Time limit for the process of a check."""

SHOWN_NAMES = 5
"""Maximum number of names of voices or models in a line."""

VERSION_SECONDS = 20
"""Time in which ffmpeg tells its version."""


class CheckedPart(NamedTuple):
    """The state of a part."""

    part: str
    state: str
    told: str
    """Details of the part, or the way to mend it."""


Check = Callable[[], Iterator[CheckedPart]]

MORE_CHECKS: Extensions[Check] = Extensions("doctor_checks", "check")
"""Checks of distributions and of rooms that can be closed, run after those of the program."""


def fault_of(code: str, *arguments: str) -> str:
    """Run Python code in a separate process, and return its error; empty if it succeeds.

    Modules of the current folder are not found, so nothing of a stranger's project runs.
    """
    command = [sys.executable, "-P", "-c", code, *arguments]
    try:
        done = subprocess.run(  # noqa: S603 our own code
            command, capture_output=True, timeout=IMPORT_SECONDS, check=False,
            stdin=subprocess.DEVNULL,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return f"its import takes over {IMPORT_SECONDS:g} s"
    if not done.returncode:
        return ""
    words = done.stderr.decode("utf-8", "replace").strip().splitlines()
    return words[-1] if words else f"its import ended with code {done.returncode}"


def voices() -> Iterator[CheckedPart]:
    """Check the voice of each of the project's languages, or of the default language."""
    from lipsync_lang.build.project_folder import starter
    from lipsync_lang.packs.library import Library
    from lipsync_lang.packs.project import find_project, load_project

    path = find_project()
    stated = None
    if path is not None:
        try:
            stated = load_project(path).model
        except LipsyncError:
            return  # the project is broken already
    names = {*stated.languages, *filter(None, [stated.language])} if stated else set()
    library = Library()
    for name in sorted(names or {starter().language}):
        try:
            pack = library.language(name)
        except LipsyncError as error:
            yield CheckedPart(f"voice of {name}", BROKEN, str(error))
            continue
        yield from _voice(name, pack)


def _voice(name: str, pack: "Pack[Language]") -> Iterator[CheckedPart]:
    from lipsync_lang.packs.checking.voices import ESPEAK, check_voices
    from lipsync_lang.speech.speaking.speech_engines import ENGINES

    tts = pack.model.tts
    if tts is not None and tts.engine not in {None, ESPEAK}:
        try:
            known = ENGINES.find(tts.engine or "", SpeechError).voices()
        except SpeechError as error:
            yield CheckedPart(f"voice of {name}", BROKEN, str(error))
            return
        there = tts.voice in known
        told = f"{tts.engine} {tts.voice}" if there else f"{tts.engine} has no voice '{tts.voice}'"
        yield CheckedPart(f"voice of {name}", OK if there else BROKEN, told)
    elif "espeakng_loader" not in {m for e in extras() for m in e.missing()}:
        faults = "; ".join(map(str, check_voices([pack])))
        yield CheckedPart(f"voice of {name}", BROKEN if faults else OK, faults or "found")


def engines() -> Iterator[CheckedPart]:
    """Check the voices of the speech engines that are programs of others."""
    from lipsync_lang.packs.checking.voices import ESPEAK
    from lipsync_lang.speech.speaking.speech_engines import ENGINES

    for name in ENGINES.modules:
        if name == ESPEAK:
            continue  # its voices are those of the languages
        try:
            told, state = shortlist(ENGINES[name].voices(), SHOWN_NAMES), OK
        except SpeechError as error:
            told, state = f"{error}, for --tts {name}", MISSING
        yield CheckedPart(f"voices of {name}", state, told)


def models() -> Iterator[CheckedPart]:
    """Check the models of recognisers that are installed."""
    if find_spec("faster_whisper") is not None:
        from lipsync_lang.speech.hearing.recognise.whisper_models import check_folder, shipped_model

        try:
            folder = shipped_model()
            check_folder(folder)
        except SpeechError as error:
            yield CheckedPart("model of whisper", MISSING, str(error))
        else:
            yield CheckedPart("model of whisper", OK, os.fspath(folder))


def ffmpeg() -> Iterator[CheckedPart]:
    """Check the program that encodes films, and that converts recordings by hand."""
    program, purpose = shutil.which("ffmpeg"), "converts recordings such as .m4a"
    if not any(one.name == "video" and one.missing() for one in extras()):
        from lipsync_lang.render.video import find_ffmpeg

        try:
            program, purpose = find_ffmpeg(), "makes films"
        except LipsyncError as error:
            yield CheckedPart("ffmpeg", MISSING, str(error))
            return
    if program is None:
        yield CheckedPart("ffmpeg", MISSING, f"makes films: {install_line('video')}")
        return
    try:
        done = subprocess.run(  # noqa: S603 the program that makes films
            [program, "-version"], capture_output=True, check=False, timeout=VERSION_SECONDS,
            stdin=subprocess.DEVNULL,
        )  # fmt: skip
        words = done.stdout.decode("utf-8", "replace").split()
        sound, version = done.returncode == 0, " ".join(words[1:3])
    except (OSError, subprocess.TimeoutExpired) as error:
        sound, version = False, str(error)
    mend = "install it again, or name another in IMAGEIO_FFMPEG_EXE"
    told = f"{version}, {purpose}, {program}" if sound else f"{program} does not run; {mend}"
    yield CheckedPart("ffmpeg", OK if sound else BROKEN, told)
