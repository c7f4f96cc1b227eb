"""The command that checks an installation, and says how to mend each part."""

import os
import shutil
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter
from typing import TYPE_CHECKING

from lipsync_lang.commands.doctor_checks import (
    BROKEN,
    MISSING,
    MORE_CHECKS,
    OK,
    CheckedPart,
    engines,
    fault_of,
    ffmpeg,
    models,
    voices,
)
from lipsync_lang.commands.output import FAULTS, SOUND, as_json, count, working
from lipsync_lang.commands.registry import Add, command
from lipsync_lang.commands.shared_options import add_json
from lipsync_lang.errors import LipsyncError
from lipsync_lang.extras import Extra, extras, install_line

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

IMPORT_PLUG_IN = """
import sys
from lipsync_lang.extensions import faults_of_plug_in
sys.exit("; ".join(faults_of_plug_in(sys.argv[1])) or 0)
"""

LEAST_FREE_BYTES = 200 * 2**20
"""Free space that the cache of compiled pairs should have."""

SAMPLES = "aəʃ漢あ한نकกע"
"""A letter of each of several scripts that texts are written in."""


@command("doctor")
def add_doctor(add: Add) -> None:
    """Add `doctor`."""
    made = add("doctor", doctor, "check the installation, and say how to mend it", "doctor")
    add_json(made)


def doctor(options: Namespace) -> int:
    """Print the state of every part; broken parts are faults."""
    start = perf_counter()
    with working("checking"):
        found = [
            finding for check in (*CHECKS, *MORE_CHECKS.values()) for finding in _checked(check)
        ]
    if options.json:
        print(as_json([one._asdict() for one in found]))
    else:
        from lipsync_lang.reports.text_table import columns

        print("\n".join(columns([(one.state, one.part, one.told) for one in found])))
    print(f"checked in {perf_counter() - start:.1f} s", file=sys.stderr)
    return FAULTS if any(one.state == BROKEN for one in found) else SOUND


def _checked(check: Callable[[], Iterator[CheckedPart]]) -> list[CheckedPart]:
    """Return the findings of a check; a check that fails is a broken part."""
    try:
        return list(check())
    except Exception as error:  # noqa: BLE001 any error in a check is its finding
        part = check.__name__.strip("_").replace("_", " ")
        return [CheckedPart(part, BROKEN, f"{type(error).__name__}: {error}")]


def _python() -> Iterator[CheckedPart]:
    from lipsync_lang.pipeline import kernel
    from lipsync_lang.version import __version__

    yield CheckedPart("Python", OK, f"{sys.version.split()[0]} at {sys.executable}")
    yield CheckedPart("lipsync-lang", OK, f"{__version__} ({kernel.summary()})")


def _packs() -> Iterator[CheckedPart]:
    """Count the packs, and their faults by code."""
    from collections import Counter

    from lipsync_lang.packs.checking.validate import validate
    from lipsync_lang.packs.library import Library

    library = Library()
    counts = (
        count(len(library.names("language")), "language"),
        count(len(library.names("poseset")), "pose set"),
    )
    faults = validate(library)
    real = Counter(fault.code for fault in faults if fault.severity == "fault")
    if faults:
        codes = ", ".join(f"{number} {code}" for code, number in sorted(real.items()))
        warned = count(len(faults) - real.total(), "warning")
        told = f"{count(real.total(), 'fault')}{codes and f' ({codes})'}, {warned}"
        told = f"{told}; list them: lipsync-lang validate --no-tests"
    else:
        told = ", ".join(counts)
    yield CheckedPart("packs", BROKEN if real else OK, told)


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
    fault = fault_of(f"import {', '.join(extra.modules)}")
    if fault:
        return CheckedPart(part, BROKEN, f"{fault}; install it again: {line}")
    return CheckedPart(part, OK, extra.purpose)


def _plug_ins() -> Iterator[CheckedPart]:
    """Import each plug-in in a process of its own; find the folders of its packs."""
    from lipsync_lang.extensions import plug_ins

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        yield from pool.map(lambda found: _plug_in(*found), sorted(plug_ins().items()))


def _plug_in(name: str, entry_points: "list[EntryPoint]") -> CheckedPart:
    from lipsync_lang.extensions import PACKS
    from lipsync_lang.packs.finding import location

    lost = [one.value for one in entry_points if one.group == PACKS and location(one) is None]
    fault = f"no folder {lost[0]}" if lost else fault_of(IMPORT_PLUG_IN, name)
    if fault:
        return CheckedPart(f"plug-in {name}", BROKEN, f"{fault}; update it, or uninstall it")
    dist = entry_points[0].dist
    kinds = sorted({one.group.rpartition(".")[2].replace("_", " ") for one in entry_points})
    return CheckedPart(
        f"plug-in {name}", OK, f"{dist.version if dist else ''} with {', '.join(kinds)}"
    )


def _browser() -> Iterator[CheckedPart]:
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
    _python, _packs, _project, voices, _extras, _plug_ins, engines, models, ffmpeg, _browser,
    _fonts, _cache, _terminal,
)  # fmt: skip
"""Checks in the order of the report."""
