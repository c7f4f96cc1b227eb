"""Check of `doctor`: the program of the Montreal Forced Aligner, and its models."""

import shutil
from collections.abc import Iterator

from lipsync_lang.base.errors import shortlist
from lipsync_lang.commands.doctor_checks import MORE_CHECKS, CheckedPart
from lipsync_lang.plugins.mfa.mfa_command import GET_MODEL, PROGRAM, downloaded_models

INSTALL_LINE = "conda create -n aligner -c conda-forge montreal-forced-aligner"

MAX_SHOWN_MODELS = 5


@MORE_CHECKS.register("mfa")
def mfa() -> Iterator[CheckedPart]:
    """Check the program and the models that it has downloaded."""
    path = shutil.which(PROGRAM)
    purpose = f"Montreal Forced Aligner, for --aligner {PROGRAM}: {INSTALL_LINE}"
    yield CheckedPart(PROGRAM, "ok" if path else "missing", path or purpose)
    if path:
        names = downloaded_models()
        told = shortlist(names, MAX_SHOWN_MODELS) or f"none; {GET_MODEL}"
        yield CheckedPart(f"models of {PROGRAM}", "ok" if names else "missing", told)
