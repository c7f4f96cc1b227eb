"""Checks of `doctor`, in the order of its report."""

import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Literal, NamedTuple

from lipsync_lang.base.errors import LipsyncError, SpeechError, count, shortlist
from lipsync_lang.base.extensions import PACKS, EntryPoint, Extensions, plug_ins, removed_rooms
from lipsync_lang.base.extras import Extra, extras, install_line, package_line
from lipsync_lang.base.version import __version__

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Language
    from lipsync_lang.packs.pack import Pack

PartState = Literal["ok", "missing", "broken"]
"""States. A missing part is optional; a broken one fails the check."""

OK: PartState = "ok"
MISSING: PartState = "missing"
BROKEN: PartState = "broken"

ALWAYS, PROJECT, OPTIONAL = "always needed", "this project needs", "optional"
"""Sections of the report, in order."""

IMPORT_SECONDS = 60.0
"""Time limit for the process of a check."""

IMPORT_PLUG_IN = """
import sys
from lipsync_lang.base.extensions import faults_of_plug_in
sys.exit("; ".join(faults_of_plug_in(sys.argv[1])) or 0)
"""

LEAST_FREE_BYTES = 200 * 2**20
"""Free space that the cache of compiled pairs should have."""

SAMPLES = "aəʃ漢あ한نकกע"
"""A letter of each of several scripts that texts are written in."""

NO_COMMERCE = re.compile(
    r"non[- ]?commercial|BY-NC|no commercial|not .{0,40}commercial|(research|academic) .{0,20}only",
    re.IGNORECASE,
)
"""Words of terms that forbid commerce."""

VERSION_SECONDS = 20
"""Time in which ffmpeg tells its version."""


class CheckedPart(NamedTuple):
    """The state of a part."""

    part: str
    state: PartState
    told: str
    """Details of the part, or the way to mend it."""
    section: str = OPTIONAL
    """Use of the part: by every command, this project, or only some commands."""


Check = Callable[[], Iterator[CheckedPart]]

CHECKS: list[Check] = []
"""Checks of the program."""

MORE_CHECKS: Extensions[Check] = Extensions("doctor_checks", "check")
"""Checks of distributions and of rooms that can be closed, run after those of the program."""


def check(one: Check) -> Check:
    """Add a check of the program to the report."""
    CHECKS.append(one)
    return one


def fault_of(code: str, *arguments: str) -> str:
    """Run Python code in a separate process, and return its error; empty if it succeeds.

    Modules of the current folder are not found, so nothing of a stranger's project runs.
    """
    # A library that crashes or hangs must not take the report along.
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


@check
def _python() -> Iterator[CheckedPart]:
    from lipsync_lang.pipeline import kernel

    yield CheckedPart("Python", OK, f"{sys.version.split()[0]} at {sys.executable}", ALWAYS)
    yield CheckedPart("lipsync-lang", OK, f"{__version__} ({kernel.summary()})", ALWAYS)


@check
def _yaml() -> Iterator[CheckedPart]:
    from lipsync_lang.packs.yaml.events import parser_in_c

    if parser_in_c():
        yield CheckedPart("YAML", OK, "libyaml", ALWAYS)
    else:
        told = f"packs are read 13 times slower without {package_line('ruamel.yaml.clib')}"
        yield CheckedPart("YAML", MISSING, told, OPTIONAL)


@check
def _packs() -> Iterator[CheckedPart]:
    """Count the packs, and their faults by code."""
    from lipsync_lang.packs.checking.validate import validate
    from lipsync_lang.packs.library import Library

    library = Library()
    languages = count(len(library.names("language")), "language")
    told = f"{languages}, {count(len(library.names('poseset')), 'pose set')}"
    faults = validate(library)
    real = Counter(fault.code for fault in faults if fault.severity == "fault")
    if faults:
        codes = ", ".join(f"{number} {code}" for code, number in sorted(real.items()))
        warned = count(len(faults) - real.total(), "warning")
        told = f"{count(real.total(), 'fault')}{codes and f' ({codes})'}, {warned}"
        told = f"{told}; list them: lipsync-lang validate --no-tests"
    yield CheckedPart("packs", BROKEN if real else OK, told, ALWAYS)


@check
def _project() -> Iterator[CheckedPart]:
    from lipsync_lang.packs.project import find_project
    from lipsync_lang.production.builds.timing_formats import open_project

    path = find_project()
    if path is None:
        made = "none in this folder; make one: lipsync-lang new NAME"
        yield CheckedPart("project", MISSING, made)
        return
    try:
        open_project(path)
    except LipsyncError as error:
        yield CheckedPart("project", BROKEN, f"{error}; then run: lipsync-lang validate", PROJECT)
        return
    yield CheckedPart("project", OK, os.path.relpath(path), PROJECT)


@check
def voices() -> Iterator[CheckedPart]:
    """Check the voice of each of the project's languages, or of the default language."""
    from lipsync_lang.packs.library import Library
    from lipsync_lang.packs.project import find_project, load_project
    from lipsync_lang.production.builds.project_folder import starter

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
        section = ALWAYS if path is None else PROJECT
        yield from (part._replace(section=section) for part in _voice(name, pack))


def _voice(name: str, pack: "Pack[Language]") -> Iterator[CheckedPart]:
    from lipsync_lang.packs.checking.voices import ESPEAK, check_voices
    from lipsync_lang.sound.speech.speaking.speech_engines import ENGINES

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
    # If the library is missing, the check of its extra says so.
    elif "espeakng_loader" not in {m for e in extras() for m in e.missing()}:
        faults = "; ".join(map(str, check_voices([pack])))
        yield CheckedPart(f"voice of {name}", BROKEN if faults else OK, faults or "found")


@check
def _extras() -> Iterator[CheckedPart]:
    """Import the modules of each extra in a process of its own."""
    needed = _project_extras()
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        # Threads will do, because each waits for a process.
        for extra, part in zip(extras(), pool.map(_extra, extras()), strict=True):
            users = needed.get(extra.name)
            told = f"{part.told}, for {shortlist(users)}" if users else part.told
            yield part._replace(told=told, section=PROJECT) if users else part
    if missing := [extra.name for extra in extras() if extra.name in needed and extra.missing()]:
        yield CheckedPart("to install", MISSING, install_line(*missing), PROJECT)


def _project_extras() -> dict[str, list[str]]:
    """Return the extras that the project needs, each with its users; none without a project."""
    from lipsync_lang.packs.library import Library
    from lipsync_lang.packs.project import find_project, load_project
    from lipsync_lang.production.builds.project_build import extras_of_project
    from lipsync_lang.sound.speech.needed_extras import providers

    try:
        path = find_project()
        project = None if path is None else load_project(path).model
        if project is None or path is None:
            return {}
        library = Library([path.parent / one for one in project.paths], path.parent)
        return providers(extras_of_project(project, library))
    except LipsyncError:
        return {}  # the check of the project says why


def _extra(extra: Extra) -> CheckedPart:
    part, line = f"extra {extra.name}", install_line(extra.name)
    if extra.missing():
        return CheckedPart(part, MISSING, f"{extra.purpose} (for {extra.used_by}): {line}")
    fault = fault_of(f"import {', '.join(extra.modules)}")
    if fault and extra.system:
        return CheckedPart(part, MISSING, f"{extra.purpose}; your system lacks {extra.system}")
    if fault:
        return CheckedPart(part, BROKEN, f"{fault}; install it again: {line}")
    return CheckedPart(part, OK, extra.purpose)


@check
def _plug_ins() -> Iterator[CheckedPart]:
    """Import each plug-in in a process of its own; find the folders of its packs."""
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        yield from pool.map(lambda found: _plug_in(*found), sorted(plug_ins().items()))


@check
def _removed_rooms() -> Iterator[CheckedPart]:
    """Name the plug-ins of the program whose folders were removed, and what the user loses."""
    for package, entry_points in removed_rooms().items():
        lost = [
            f"{one.group.rpartition('.')[2].replace('_', ' ').removesuffix('s')} "
            f"'{one.name.replace('-', ' ')}'"
            for one in entry_points
        ]
        told = f"its folder was removed: no {', no '.join(lost)}; install lipsync-lang again"
        yield CheckedPart(f"plug-in {package.rpartition('.')[2]}", MISSING, told)


def _plug_in(name: str, entry_points: list[EntryPoint]) -> CheckedPart:
    from lipsync_lang.packs.finding import location

    lost = [one.value for one in entry_points if one.group == PACKS and location(one) is None]
    fault = f"no folder {lost[0]}" if lost else fault_of(IMPORT_PLUG_IN, name)
    if fault:
        return CheckedPart(f"plug-in {name}", BROKEN, f"{fault}; update it, or uninstall it")
    kinds = sorted({one.group.rpartition(".")[2].replace("_", " ") for one in entry_points})
    told = f"{entry_points[0].version} with {', '.join(kinds)}"
    return CheckedPart(f"plug-in {name}", OK, told)


@check
def engines() -> Iterator[CheckedPart]:
    """Check the voices of the speech engines that are programs of others."""
    from lipsync_lang.packs.checking.voices import ESPEAK
    from lipsync_lang.sound.speech.speaking.speech_engines import ENGINES

    for name in ENGINES:
        if name == ESPEAK:
            continue  # its voices are those of the languages
        try:
            told, state = shortlist(ENGINES[name].voices()), OK
        except SpeechError as error:
            told, state = f"{error}, for --tts {name}", MISSING
        yield CheckedPart(f"voices of {name}", state, told)


@check
def acoustic_models() -> Iterator[CheckedPart]:
    """Read the acoustic models with a name: those of the project, and those of pocketsphinx."""
    from lipsync_lang.sound.speech.hearing.sphinx.folder import installed_models

    for models in installed_models():
        part = f"acoustic model {models.folder.name}"
        try:
            speech, known = len(models.numbers), models.phones
        except LipsyncError as error:
            yield CheckedPart(part, BROKEN, str(error))
            continue
        mapped = f"{speech} phones" if known else f"{speech} phones without IPA (phones.yaml)"
        terms = str(models.licence or "no file tells its terms")
        if models.licence and NO_COMMERCE.search(models.licence.read_text("utf-8", "replace")):
            terms += ", which speaks of NO COMMERCIAL USE: read it before you sell a game"
        yield CheckedPart(part, OK, f"{mapped}; terms: {terms}; {models.folder}")


@check
def ffmpeg() -> Iterator[CheckedPart]:
    """Check the program that makes films, and that decodes recordings such as .m4a."""
    from lipsync_lang.sound.speech.decoding import find_ffmpeg

    program, purpose = find_ffmpeg(), "makes films, and reads .m4a, .mp4 and .mov"
    if program is None:
        yield CheckedPart("ffmpeg", MISSING, f"{purpose}: {install_line('video')}")
        return
    try:
        done = subprocess.run(  # noqa: S603 the program that makes films
            # ffmpeg takes commands from its input.
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


@check
def _browser() -> Iterator[CheckedPart]:
    import webbrowser

    try:
        webbrowser.get()
    except webbrowser.Error:
        yield CheckedPart("browser", MISSING, "open pages and the studio's address in one yourself")
    else:
        yield CheckedPart("browser", OK, "opens the studio")


@check
def _fonts() -> Iterator[CheckedPart]:
    """Check the fonts of plots."""
    from lipsync_lang.render.fonts import fonts_for, fonts_to_install, letters_of

    if any(one.name == "plot" and one.missing() for one in extras()):
        return  # the extra is told as missing
    missing = fonts_for(letters_of([SAMPLES])).missing
    for name, how in fonts_to_install(missing).items():
        yield CheckedPart("font of plots", MISSING, f"{name}: {how}")
    if not missing:
        yield CheckedPart("fonts of plots", OK, f"for {' '.join(SAMPLES)}")


@check
def _cache() -> Iterator[CheckedPart]:
    from lipsync_lang.resolver.cache import CACHE_VARIABLE, folder

    path = folder()
    if path is None:
        yield CheckedPart("cache", MISSING, f"is off by {CACHE_VARIABLE}, so each start is slower")
        return
    # The cache may not be made yet: the folder that would hold it decides.
    there = next(one for one in (path, *path.absolute().parents) if one.exists())
    free = shutil.disk_usage(there).free
    mend = f"name another folder in {CACHE_VARIABLE}"
    if not there.is_dir() or not os.access(there, os.W_OK):
        yield CheckedPart("cache", BROKEN, f"{path} cannot be written; {mend}")
    elif free < LEAST_FREE_BYTES:
        yield CheckedPart("cache", BROKEN, f"{path} has {free / 2**20:.0f} MB left; {mend}")
    else:
        yield CheckedPart("cache", OK, f"{path}, {free / 2**30:.0f} GB free")


@check
def _terminal() -> Iterator[CheckedPart]:
    encoding = getattr(sys.stdout, "encoding", None) or "none"
    plain = not encoding.lower().startswith("utf")
    told = f"{encoding} shows no IPA; set PYTHONUTF8=1" if plain else encoding
    yield CheckedPart("terminal", MISSING if plain else OK, told, ALWAYS)
