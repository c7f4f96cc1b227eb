"""Acoustic models that are adapted to the recordings of a project, one for each language.

A model is found by the digest of all that it depends on, so that a build adapts once, and again
when a recording or a text changes. It is a folder of the cache (decision 0002).
"""

import shutil
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import mkdtemp

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.renaming import replace_file
from lipsync_lang.production.builds.digests import digest, file_digest
from lipsync_lang.production.builds.needs import PairNeeds
from lipsync_lang.production.builds.planned_line import PlannedLine
from lipsync_lang.production.builds.timing_cache import TIMERS
from lipsync_lang.resolver.cache import compiler, folder
from lipsync_lang.sound.speech.hearing.adaptation import SpokenFile, adapt, write_adapted
from lipsync_lang.sound.speech.hearing.align.pocketsphinx_aligner import models_of
from lipsync_lang.sound.speech.hearing.sphinx.folder import Models

MAX_KEPT_MODELS = 16
"""Maximum number of models in the cache; the oldest are deleted first. Each has some 10 MB."""

POCKETSPHINX = "pocketsphinx"
"""Name of the aligner with acoustic models."""

UNCHANGED = "gains-nothing"
"""Ending of a file in place of a model that would gain nothing."""

AdaptationRemark = Callable[[str], None]
"""A function that takes the result of an adaptation, in words."""


def adapted_pair(
    pair: PairNeeds, home: Path, lines: Sequence[PlannedLine], remark: AdaptationRemark
) -> PairNeeds:
    """Return a pair whose aligner has a model that knows the voices of some lines.

    Without enough recordings, or if the model gains nothing, it is the same pair.
    """
    manner = pair.performer.compiled.manner
    aligners = manner["audio"]["align"]
    if not any(name.partition(":")[0] == POCKETSPHINX for name in aligners):
        return pair
    try:
        path = _adapted_folder(pair, home, lines, remark)
    except (LipsyncError, OSError) as error:
        remark(f"{manner['language']}: the acoustic model was not adapted: {error}")
        return pair
    if path is None:
        return pair
    named = [
        f"{POCKETSPHINX}:{path}" if name.partition(":")[0] == POCKETSPHINX else name
        for name in aligners
    ]
    changed = manner | {"audio": manner["audio"] | {"align": named}}
    compiled = replace(pair.performer.compiled, manner=changed)
    return PairNeeds(replace(pair.performer, compiled=compiled), pair.settings)


def _adapted_folder(
    pair: PairNeeds, home: Path, lines: Sequence[PlannedLine], remark: AdaptationRemark
) -> Path | None:
    """Return the folder of the adapted model, made first if the cache lacks it."""
    where = folder()
    if where is None:
        raise LipsyncError("the cache is off, and adapted models are kept there")
    audio = pair.performer.speaker.manner.audio
    named = next(one for one in audio.align if one.partition(":")[0] == POCKETSPHINX)
    model = named.partition(":")[2] or (audio.model if named == audio.align[0] else None)
    models = models_of(model)
    spoken = [
        SpokenFile(home / one.audio, one.text)
        for one in {line.audio: line for line in lines}.values()
        if one.audio is not None and one.text and one.timings is None
    ]
    told = [(file_digest(one.path), one.text) for one in spoken if one.path.is_file()]
    base = [file_digest(path) for path in sorted(models.acoustic.iterdir()) if path.is_file()]
    name = digest(pair.speech.hex(), sorted(told), base, compiler(TIMERS)).hex()
    path = where / "models" / name
    if not path.is_dir() and not path.with_suffix(f".{UNCHANGED}").exists():
        _make(pair, spoken, models, path, remark)
    return path if path.is_dir() else None


def _make(
    pair: PairNeeds,
    spoken: Sequence[SpokenFile],
    models: Models,
    path: Path,
    remark: AdaptationRemark,
) -> None:
    """Adapt a model into a folder of the cache, or mark there that it gains nothing."""
    speaker = pair.performer.speaker
    found = adapt(speaker, spoken, models)
    rise = f"log likelihood of held-out frames {found.before:.2f} to {found.after:.2f}"
    told = f"{speaker.manner.language}: acoustic model adapted to {found.lines} lines, {rise}"
    remark(told if found.gains else f"{told}: it gains nothing, and stays as it was")
    for line in found.left_out:
        remark(f"{speaker.manner.language}: not adapted to {line}")
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    if not found.gains:
        path.with_suffix(f".{UNCHANGED}").touch()
        return
    # made beside its place and moved there whole
    made = Path(mkdtemp(dir=path.parent)) / path.name
    write_adapted(models, found.model, made)
    if not path.exists():
        replace_file(made, path)
    shutil.rmtree(made.parent)
    folders = (one for one in path.parent.iterdir() if one.is_dir())
    kept = sorted(folders, key=lambda one: one.stat().st_mtime)
    for old in kept[:-MAX_KEPT_MODELS]:
        shutil.rmtree(old, ignore_errors=True)
