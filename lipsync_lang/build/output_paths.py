"""Paths of outputs and recordings, which a project states with placeholders."""

import os
import posixpath
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from lipsync_lang.animations.animation_writers import WRITERS, find_writer
from lipsync_lang.build.script_faults import ScriptFaults
from lipsync_lang.errors import OutputError
from lipsync_lang.packs.models import Project
from lipsync_lang.packs.project import FILE, NARRATOR


class OutputPattern(NamedTuple):
    """An output of every line: its writer, and its path from the project's folder."""

    writer: str
    path: str


def filled(pattern: str, language: str, character: str = "") -> str:
    """Fill in all but the line's own placeholders."""
    path = pattern.replace("{line}", "{id}")
    return path.replace("{language}", language).replace("{character}", character)


def for_line(pattern: str, name: str, speaker: str) -> str:
    """Fill in the line's own placeholders."""
    if "{speaker}" in pattern:
        pattern = pattern.replace("{speaker}", speaker or NARRATOR)
    return pattern.replace("{id}", name)


def outputs_of(project: Project, faults: ScriptFaults) -> list[OutputPattern]:
    """Return the outputs that a project states, each with its writer."""
    if not project.outputs:
        faults.add(FILE, "states no `outputs`, such as takes/{language}/{character}/{id}.csv")
    found: list[OutputPattern] = []
    for stated in project.outputs:
        name, colon, path = stated.partition(":")
        try:
            if not (colon and name in WRITERS):
                name, path = find_writer(Path(stated)).name, stated
        except OutputError as error:
            faults.add(FILE, f"outputs: {error}")
            continue
        found.append(OutputPattern(name, posixpath.normpath(path.replace("\\", "/"))))
    return found


def check_outputs(
    outputs: Sequence[OutputPattern], needed: Mapping[str, str], faults: ScriptFaults
) -> None:
    """Check that no two lines share an output.

    `needed` has the placeholders that must stand in a path, with what there are several of.
    """
    paths = [output.path for output in outputs]
    for path in paths:
        for placeholder, several in needed.items():
            if placeholder not in path.replace("{line}", "{id}"):
                what = f"'{path}' would be the same file for {several}; add {placeholder} to it"
                faults.add(FILE, f"outputs: {what}")
    for path in {path for path in paths if paths.count(path) > 1}:
        faults.add(FILE, f"outputs: '{path}' is stated twice; state it once")


def check_links(paths: set[str], folder: Path, faults: ScriptFaults) -> None:
    """Check that the folders of paths do not lead outside the project by a link."""
    home = os.path.realpath(folder)
    heads = {
        posixpath.dirname(path.partition("{id}")[0].partition("{speaker}")[0]) for path in paths
    }
    for head in sorted(heads):
        real = os.path.realpath(os.path.join(home, head))  # noqa: PTH118 links are followed here
        if not Path(real).is_relative_to(home):
            faults.add(FILE, f"outputs: {head} leads outside {folder} by a link; remove the link")


def recorded_path(folder: Path, path: Path) -> str:
    """Return a file as records name it: from the project's folder, or in full outside of it.

    >>> recorded_path(Path("/game"), Path("/game/vo/l1.wav"))
    'vo/l1.wav'
    """
    return str(path).removeprefix(f"{folder}{os.sep}")
