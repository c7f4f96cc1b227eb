"""The command that checks an installation, and says how to mend each part."""

import os
import shutil
import subprocess
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from lipsync_lang.commands.output import FAULTS, SOUND, as_json, working
from lipsync_lang.errors import LipsyncError
from lipsync_lang.extras import Extra, extras, install_line

OK, MISSING, BROKEN = "ok", "missing", "broken"
"""States. A missing part is optional; a broken one fails the check."""

IMPORT_SECONDS = 60.0
"""Time in which the modules of an extra are imported."""

LEAST_FREE_BYTES = 200 * 2**20
"""Free space that the cache of compiled pairs should have."""

SAMPLES = "aəʃ漢あ한نकกע"
"""A letter of each of several scripts that texts are written in."""

PROGRAMS = {
    "mfa": "Montreal Forced Aligner, for --aligner mfa; see montreal-forced-aligner.readthedocs.io",
    "festival": "Festival, for --tts festival; your system's packages have it",
}
"""Programs of others that commands can start."""


class CheckedPart(NamedTuple):
    """The state of a part."""

    part: str
    state: str
    told: str
    """Details of the part, or the way to mend it."""


def doctor(options: Namespace) -> int:
    """Print the state of every part; broken parts are faults."""
    with working("checking"):
        found = [finding for check in CHECKS for finding in _checked(check)]
    if options.json:
        print(as_json([one._asdict() for one in found]))
    else:
        from lipsync_lang.text_table import columns

        print("\n".join(columns([(one.state, one.part, one.told) for one in found])))
    return FAULTS if any(one.state == BROKEN for one in found) else SOUND


def _checked(check: Callable[[], Iterator[CheckedPart]]) -> list[CheckedPart]:
    """Return the findings of a check; a check that fails is a broken part."""
    try:
        return list(check())
    except Exception as error:  # noqa: BLE001 a check may meet anything, and has to tell it
        part = check.__name__.strip("_").replace("_", " ")
        return [CheckedPart(part, BROKEN, f"{type(error).__name__}: {error}")]


def _python() -> Iterator[CheckedPart]:
    from lipsync_lang.pipeline import kernel
    from lipsync_lang.version import __version__

    yield CheckedPart("Python", OK, f"{sys.version.split()[0]} at {sys.executable}")
    yield CheckedPart("lipsync-lang", OK, f"{__version__} ({kernel.summary()})")


def _packs() -> Iterator[CheckedPart]:
    from lipsync_lang.packs.library import Library

    library = Library()
    counts = (
        (len(library.names("language")), "languages"),
        (len(library.names("poseset")), "pose sets"),
    )
    faults = [str(fault) for fault in library.faults]
    told = "; ".join(faults) or ", ".join(f"{number} {kind}" for number, kind in counts)
    yield CheckedPart("packs", BROKEN if faults else OK, told)


def _project() -> Iterator[CheckedPart]:
    from lipsync_lang.packs.project import find_project, load_project

    path = find_project()
    if path is None:
        yield CheckedPart(
            "project", MISSING, "none in this folder; make one: lipsync-lang new NAME"
        )
        return
    try:
        load_project(path)
    except LipsyncError as error:
        yield CheckedPart("project", BROKEN, f"{error}; then run: lipsync-lang validate")
        return
    yield CheckedPart("project", OK, os.path.relpath(path))


def _voices() -> Iterator[CheckedPart]:
    """Check the voice of each of the project's languages, or of the default language."""
    from lipsync_lang.build.project_folder import starter
    from lipsync_lang.packs.checking.voices import check_voices
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
    if {"espeakng_loader", "phonemizer"} & {m for e in extras() for m in e.missing()}:
        return  # the extra is told as missing
    library = Library()
    for name in sorted(names or {starter().language}):
        try:
            pack = library.language(name)
        except LipsyncError as error:
            yield CheckedPart(f"voice of {name}", BROKEN, str(error))
            continue
        faults = "; ".join(map(str, check_voices([pack])))
        yield CheckedPart(f"voice of {name}", BROKEN if faults else OK, faults or "found")


def _extras() -> Iterator[CheckedPart]:
    """Import the modules of each extra in a process of its own."""
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        yield from pool.map(_extra, extras())


def _extra(extra: Extra) -> CheckedPart:
    part, line = f"extra {extra.name}", install_line(extra.name)
    missing = extra.missing()
    if missing:
        told = f"{extra.purpose} (for {extra.used_by}): {line}"
        return CheckedPart(part, MISSING, told)
    command = [sys.executable, "-c", f"import {', '.join(extra.modules)}"]
    try:
        done = subprocess.run(  # noqa: S603 our own list of modules
            command, capture_output=True, timeout=IMPORT_SECONDS, check=False,
            stdin=subprocess.DEVNULL,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return CheckedPart(part, BROKEN, f"its import takes over {IMPORT_SECONDS:.0f} s; {line}")
    if done.returncode:
        words = done.stderr.decode("utf-8", "replace").strip().splitlines()
        why = words[-1] if words else f"its import ended with code {done.returncode}"
        return CheckedPart(part, BROKEN, f"{why}; install it again: {line}")
    return CheckedPart(part, OK, extra.purpose)


def _programs() -> Iterator[CheckedPart]:
    for name, purpose in PROGRAMS.items():
        path = shutil.which(name)
        yield CheckedPart(name, OK if path else MISSING, path or purpose)
    import webbrowser

    try:
        webbrowser.get()
    except webbrowser.Error:
        yield CheckedPart("browser", MISSING, "open pages and the studio's address in one yourself")
    else:
        yield CheckedPart("browser", OK, "opens the studio")


def _fonts() -> Iterator[CheckedPart]:
    """Check the fonts of plots."""
    from lipsync_lang.render.fonts import fonts_to_install, letters_of

    if any(one.name == "plot" and one.missing() for one in extras()):
        return  # the extra is told as missing
    from lipsync_lang.render.plot_fonts import fonts_for

    missing = fonts_for(letters_of([SAMPLES])).missing
    for name, how in fonts_to_install(missing).items():
        yield CheckedPart("font of plots", MISSING, f"{name}: {how}")
    if not missing:
        yield CheckedPart("fonts of plots", OK, f"for {' '.join(SAMPLES)}")


def _cache() -> Iterator[CheckedPart]:
    from lipsync_lang.resolver.cache import CACHE_VARIABLE, folder

    path = folder()
    if path is None:
        yield CheckedPart("cache", MISSING, f"is off by {CACHE_VARIABLE}, so each start is slower")
        return
    there = next(one for one in (path, *path.absolute().parents) if one.exists())
    free = shutil.disk_usage(there).free
    mend = f"name another folder in {CACHE_VARIABLE}"
    if not there.is_dir() or not os.access(there, os.W_OK):
        yield CheckedPart("cache", BROKEN, f"{path} cannot be written; {mend}")
    elif free < LEAST_FREE_BYTES:
        yield CheckedPart("cache", BROKEN, f"{path} has {free / 2**20:.0f} MB left; {mend}")
    else:
        yield CheckedPart("cache", OK, f"{path}, {free / 2**30:.0f} GB free")


def _terminal() -> Iterator[CheckedPart]:
    encoding = getattr(sys.stdout, "encoding", None) or "none"
    plain = not encoding.lower().startswith("utf")
    told = f"{encoding} shows no IPA; set PYTHONUTF8=1" if plain else encoding
    yield CheckedPart("terminal", MISSING if plain else OK, told)


CHECKS = (
    _python, _packs, _project, _voices, _extras, _programs, _fonts, _cache, _terminal,
)  # fmt: skip
"""Checks in the order of the report."""
