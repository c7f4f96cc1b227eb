"""A new project folder: a commented `lipsync.yaml`, a script, a character and a README.

The files come from `project_templates`. The folder is made under a temporary name and then renamed,
so that it is whole or not there.
"""

import csv
import io
import json
import os
import re
import shutil
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.names import fault_of_name
from lipsync_lang.base.files.reach import name_folders
from lipsync_lang.base.files.temporary import temporary_name
from lipsync_lang.base.files.writing import cannot_write, replace_file
from lipsync_lang.base.presentation.text_templates import filled
from lipsync_lang.packs.finding import FOLDERS
from lipsync_lang.packs.project import FILE
from lipsync_lang.packs.yaml.value_text import on_one_line

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library

TEMPLATES = "project_templates"

SHOWN_SAMPLE_LINES = 3
"""Lines of a new script."""

LINE_ID = "line_{:02}"
"""Form of their ids."""

UNQUOTED = re.compile(r'["$`\\]')
"""Characters that mean something to a shell within double quotes."""


class Starter(NamedTuple):
    """Defaults of a new project, from `starter.json`."""

    language: str
    character: str
    """A pose set, or a character."""
    name: str
    """Name of the new character."""
    text: str
    """A sentence for examples of commands."""
    lines: tuple[str, ...]
    """Lines of the script in the default language."""


@cache
def starter() -> Starter:
    """Return the defaults of new projects."""
    told = json.loads((files(__package__ or "") / TEMPLATES / "starter.json").read_text("utf-8"))
    return Starter(**told | {"lines": tuple(told["lines"])})


def make_project(
    name: str, library: "Library", language: str | None, character: str | None
) -> list[Path]:
    """Make a project folder in the current one, and return its files.

    The project states the paths of the library, and defaults for a missing language or character.
    """
    if fault := fault_of_name(name):
        where = "the new folder is made in the current one"
        raise LipsyncError(f"cannot make a project '{name}': the name {fault} ({where})")
    target = Path(name)
    if target.exists() or target.is_symlink():
        raise LipsyncError(f"{name}: is there already; choose another name, or remove it first")
    texts = project_files(name, library, language, character)
    waiting = Path(temporary_name(name))
    try:
        for path, text in texts.items():
            (waiting / path).parent.mkdir(parents=True, exist_ok=True)
            (waiting / path).write_text(text, encoding="utf-8", newline="\n")
        replace_file(waiting, target)
    except OSError as error:
        raise cannot_write(target, error, "change to another folder") from None
    finally:
        shutil.rmtree(waiting, ignore_errors=True)
    name_folders(target, library.paths)
    return [Path(name, path) for path in texts]


def project_files(
    name: str, library: "Library", language: str | None, character: str | None
) -> dict[str, str]:
    """Return the texts of a new project's files by path, in order."""
    defaults = starter()
    spoken = library.language(language or defaults.language).model
    face = character or defaults.character
    own = not library.lookup("character", face)
    poseset = library.poseset(face).model.name if own else face
    usual = spoken.name == library.language(defaults.language).model.name
    lines = defaults.lines
    if not usual:
        texts = list(dict.fromkeys(test.text for test in spoken.tests))
        longest = sorted(texts, key=len, reverse=True)[:SHOWN_SAMPLE_LINES]
        lines = tuple(text for text in texts if text in longest)
    script = io.StringIO()
    rows = csv.writer(script, lineterminator="\n")
    rows.writerow(("id", "speaker", "text"))
    rows.writerows((LINE_ID.format(n), defaults.name, text) for n, text in enumerate(lines, 1))
    paths = []
    for path in library.paths:
        try:
            paths.append(on_one_line(Path(os.path.relpath(path, name)).as_posix()))
        except ValueError:  # another drive of Windows
            paths.append(on_one_line(path.absolute().as_posix()))
    known = {
        "name": name,
        "title": on_one_line(name),
        "language": on_one_line(spoken.name),
        "character": on_one_line(defaults.name if own else face),
        "poseset": on_one_line(poseset),
        "own": own,
        "paths": paths,
        "first": LINE_ID.format(1),
        "text": next((line for line in lines if not UNQUOTED.search(line)), defaults.text),
    }
    character_file = f"{FOLDERS['character']}/{defaults.name}.yaml"
    made = {
        "README.md": from_template("README.md", known),
        FILE: from_template(FILE, known),
        "lines.csv": script.getvalue(),
        character_file: from_template("character.yaml", known),
        ".gitignore": from_template("gitignore", known),
    }
    return {path: text for path, text in made.items() if own or path != character_file}


def from_template(name: str, known: Mapping[str, object]) -> str:
    """Return a file of a new project."""
    return filled(__package__ or "", f"{TEMPLATES}/{name}", known, yaml=on_one_line)
