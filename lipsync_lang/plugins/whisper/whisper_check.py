"""Check of `doctor`: the models of Whisper, those of the project and the one that is installed."""

import os
from collections.abc import Iterator
from importlib.util import find_spec

from lipsync_lang import SpeechError
from lipsync_lang.commands.doctor_checks import MORE_CHECKS, CheckedPart
from lipsync_lang.plugins.whisper.whisper_recogniser import (
    OTHER_MODEL,
    check_folder,
    shipped_model,
)
from lipsync_lang.sound.speech.hearing.sphinx.folder import is_whisper, project_models

MODEL_PART = "model of whisper"


@MORE_CHECKS.register("whisper")
def whisper() -> Iterator[CheckedPart]:
    """Check each model, if the library that reads them is installed."""
    if find_spec("faster_whisper") is None:
        return
    own = [folder for folder in project_models() if is_whisper(folder)]
    # a damaged model of the project is a fault, a missing one of a package is not
    for folder in own:
        try:
            check_folder(folder)
        except SpeechError as error:
            yield CheckedPart(MODEL_PART, "broken", str(error))
        else:
            yield CheckedPart(MODEL_PART, "ok", f"--recogniser whisper:{folder}")
    try:
        folder = shipped_model()
        check_folder(folder)
    except SpeechError as error:
        if not own:
            yield CheckedPart(MODEL_PART, "missing", str(error))
    else:
        yield CheckedPart(MODEL_PART, "ok", os.fspath(folder) + ("" if own else f"; {OTHER_MODEL}"))
