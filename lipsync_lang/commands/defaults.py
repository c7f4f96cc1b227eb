"""Default option values from the project's `lipsync.yaml`."""

import logging
import os
import re
import sys
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.animations.rates import USUAL_FPS
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.reach import name_folders, refuse_outside
from lipsync_lang.packs.project import FILE, NARRATOR, find_project
from lipsync_lang.packs.speaker_faces import OTHERS, stated_faces

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Project
    from lipsync_lang.packs.pack import Pack

PAIR = ("language", "character")

MAX_SLUG_CHARS = 40

_log = logging.getLogger(__name__)


def fill(options: Namespace) -> None:
    """Fill unset options from the project file.

    Raises LipsyncError if the project is unsound, or the language or face is undefined.
    """
    if named := getattr(options, "path", []):
        name_folders((find_project() or Path(FILE).absolute()).parent, named)
    path = find_project() if getattr(options, "in_project", False) else None
    if path is None and wants_script_line(options):
        what = f"--line alone names a line of a script, but this folder has no {FILE}"
        raise LipsyncError(f"{what}; give a TEXT, or go to the folder of the project")
    if path is not None:
        from lipsync_lang.production.builds.timing_formats import open_project

        _log.info("project %s", path)
        project = open_project(path)
        if wants_script_line(options):
            _take_line(options, project, path.parent)
        _take(options, project, path.parent)
    options.stated_fps = getattr(options, "fps", None)
    for name, usual in (("fps", USUAL_FPS), ("offset", "0")):
        if getattr(options, name, "") is None:
            setattr(options, name, usual)
    # Defaults of `getattr` tell a command without an option (True) from one that is not given.
    if not getattr(options, "language", True) and _only_sound(options):
        from lipsync_lang.packs.automatic import UNDETERMINED

        options.language = UNDETERMINED
    for name, option in (("language", "-l"), ("character", "-c")):
        cast = name == "character" and getattr(options, "cast", None)
        if not (getattr(options, name, True) or cast or getattr(options, "choosing", False)):
            raise LipsyncError(
                f"a {name} is missing: give {option} {name.upper()}, or state `{name}: ...` in "
                f"{FILE}"
            )


def wants_script_line(options: Namespace) -> bool:
    """Return True if a line is given by its id alone, and the command finds it in the script."""
    given = [getattr(options, name, None) for name in ("text", "schedule", "audio")]
    return getattr(options, "in_script", False) and bool(options.line) and given == [None] * 3


def _take_line(options: Namespace, pack: "Pack[Project]", folder: Path) -> None:
    """Take text, recording, timings, language and character of a line of the script."""
    from lipsync_lang.base.errors import did_you_mean
    from lipsync_lang.production.builds.script import read_script

    lines = read_script(pack, paths=tuple(options.path))
    own = [line for line in lines if line.name == options.line]
    if not own:
        names = dict.fromkeys(line.name for line in lines)
        what = f"the script has no line '{options.line}'; {did_you_mean(options.line, names)}"
        raise LipsyncError(what)
    chosen = [
        line for line in own if all(getattr(options, n) in {None, getattr(line, n)} for n in PAIR)
    ]
    if not chosen:
        pairs = ", ".join(f"-l {line.language} -c {line.character}" for line in own)
        raise LipsyncError(f"the script has '{options.line}' on other pairs: {pairs}")
    line = chosen[0]
    options.language, options.character = line.language, line.character
    files = (path and folder / path for path in (line.timings, line.audio))
    options.schedule, options.audio = files
    options.text = None if line.timings else line.text or None
    options.from_script = True
    print(f"{line.place}: {line.language} on {line.character}", file=sys.stderr)


def _only_sound(options: Namespace) -> bool:
    """Return True if the speech is a sound alone, whose language need not be known."""
    given = [getattr(options, name, None) is not None for name in ("text", "schedule", "audio")]
    return given == [False, False, True] or getattr(options, "page", False)


def _take(options: Namespace, pack: "Pack[Project]", folder: Path) -> None:
    project, own = pack.model, [] if folder == Path.cwd() else [folder]
    options.path = [*options.path, *(folder / path for path in project.paths), *own]
    if hasattr(options, "cast"):
        _take_script(options, pack, folder)
    for name in ("language", "character"):
        stated, given = getattr(project, name), getattr(options, name, True)
        if stated is not None and not given:
            setattr(options, name, [stated] if given == [] else stated)
    if getattr(options, "fps", 0) is None and project.fps is not None:
        from lipsync_lang.animations.rates import parse_rate

        options.fps = parse_rate(project.fps)
    offset = None if project.offset is None else str(project.offset)
    plain = {"offset": offset, "shades": project.shades, "gestures": project.gestures,
             "idle": project.idle}  # fmt: skip
    for name, value in plain.items():
        if getattr(options, name, "") is None:
            setattr(options, name, value)
    if project.motion is not None and hasattr(options, "settings"):
        stated = project.motion.model_dump(exclude_none=True).items()
        # A preset on the command line replaces all of the project's motion; settings follow it.
        again = any(one.startswith("motion=") for one in options.settings)
        own_settings = (f"motion.{name}={value}" for name, value in stated if not again)
        # A preset is the setting of motion as a whole.
        whole = (one.replace("motion.preset=", "motion=") for one in own_settings)
        options.settings = [*whole, *options.settings]
    if hasattr(options, "values"):
        stated = [f"{name}={text}" for name, text in project.values.items()]
        options.values = [*stated, *options.values]
        options.unspoken = project.unspoken
    # `-o` of other commands names other files than the outputs of lines.
    if getattr(options, "output", None) == [] and hasattr(options, "schedule"):
        file = options.schedule or options.audio
        line = _slug(options.line or (file.stem if file else options.text) or "") or "line"
        named = {"id": line, "line": line, "speaker": NARRATOR}
        named |= {name: _slug(getattr(options, name, None) or "") for name in PAIR}
        options.output = [_output(one, folder, named) for one in project.outputs]


def _take_script(options: Namespace, pack: "Pack[Project]", folder: Path) -> None:
    """Take the script of a project: its files, languages, columns and cast."""
    project = pack.model
    if not options.language:
        from lipsync_lang.packs.checking.project_checks import check_languages
        from lipsync_lang.packs.finding import Finder
        from lipsync_lang.packs.yaml.faults import PackFaults

        if faults := [*check_languages(pack, Finder(options.path, folder))]:
            raise PackFaults(faults)
        options.language = list(project.languages)
    options.words = dict(project.languages)
    if not options.column:
        options.text_column = project.columns.text
    options.home = folder
    options.lines = [Path(os.path.relpath(folder / stated)) for stated in project.lines]
    options.speaker_column = project.columns.speaker
    options.encoding = options.encoding or project.encoding
    options.sheet = options.sheet or project.columns.sheet
    options.header_row = options.header_row or project.columns.header_row
    if project.cast and not options.character:
        stated = stated_faces(project)
        options.character = list(stated.pop(OTHERS, ()))
        options.cast = {name: list(own) for name, own in stated.items()}


def _output(stated: str, folder: Path, named: dict[str, str]) -> str:
    """Return an output path relative to the command line's working folder."""
    from lipsync_lang.animations.animation_writers import WRITERS

    name, colon, rest = stated.partition(":")
    if not (colon and name in WRITERS):
        name, colon, rest = "", "", stated
    path = folder / re.sub(r"\{(\w+)\}", lambda found: named.get(found[1], found[0]), rest)
    refuse_outside(path, folder)
    # Only the folders that a project states are made; a mistyped `-o` is an error.
    path.parent.mkdir(parents=True, exist_ok=True)
    return f"{name}{colon}{os.path.relpath(path)}"


def _slug(text: str) -> str:
    return re.sub(r"[^\w]+", "-", text).strip("-")[:MAX_SLUG_CHARS].strip("-")
