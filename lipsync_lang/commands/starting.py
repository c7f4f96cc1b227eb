"""The screen of `lipsync-lang` without a command."""

import os
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.commands.output import SOUND
from lipsync_lang.errors import LipsyncError
from lipsync_lang.extras import Extra, extras, install_line
from lipsync_lang.packs.project import find_project
from lipsync_lang.version import __version__

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Project

TITLE = f"lipsync-lang {__version__} turns speech into mouth animation, for any language and face."

MORE = "All commands: lipsync-lang --help. One of them: lipsync-lang run --help."

SHOWN_IN_NEXT_STEPS = ("speech", "audio", "studio")
"""Extras of the first steps, most important first."""


def welcome(options: Namespace) -> int:  # noqa: ARG001 every command takes options
    """Print the purpose of the program, and commands for the next steps."""
    missing = lacking()
    lines = [TITLE, "", *_next_steps(), *([""] if missing else []), *missing, "", MORE]
    print("\n".join(lines))
    return SOUND


def _next_steps() -> list[str]:
    """Return commands with their purposes, for the project or for a start without one."""
    from lipsync_lang.reports.text_table import columns

    path = find_project()
    steps = _first_steps() if path is None else _project_steps(path)
    shown = columns([(f"  {purpose}", command) for purpose, command in steps])
    head = "Next steps:" if path is None else f"Next steps in the project {os.path.relpath(path)}:"
    return [head, *shown]


def _first_steps() -> list[tuple[str, str]]:
    from lipsync_lang.build.project_folder import starter

    told = starter()
    pair = f"-l {told.language} -c {told.character}"
    return [
        ("a sentence, to hear and see", f'lipsync-lang run "{told.text}" {pair} -o line.html'),
        ("with your recording", f'lipsync-lang run "ITS TEXT" --audio FILE {pair} -o line.html'),
        ("make a project", "lipsync-lang new my-game"),
        ("shape a character in your browser", f"lipsync-lang studio {pair}"),
        ("check this installation", "lipsync-lang doctor"),
    ]


def _project_steps(path: Path) -> list[tuple[str, str]]:
    from lipsync_lang.build.project_folder import starter

    project = _stated(path)
    if project is None:
        return [("find the faults of the project", "lipsync-lang validate")]
    steps = [("check all packs", "lipsync-lang validate")]
    if project.lines:
        steps += [("make the lines that changed", "lipsync-lang build")]
    paired = project.language and project.character
    if paired:
        steps += [("make one line", f'lipsync-lang run "{starter().text}"')]
    if paired or project.lines:
        steps += [("hear and change lines in your browser", "lipsync-lang studio")]
    return [*steps, ("check this installation", "lipsync-lang doctor")]


def _stated(path: Path) -> "Project | None":
    """Return the project, or None if it has faults."""
    from lipsync_lang.packs.project import load_project

    try:
        return load_project(path).model
    except (LipsyncError, OSError):
        return None


def lacking(names: tuple[str, ...] = SHOWN_IN_NEXT_STEPS) -> list[str]:
    """Return a line for each missing extra, with its installation command."""
    known = {one.name: one for one in extras()}
    missing: list[Extra] = [known[name] for name in names if known[name].missing()]
    return [f"not installed: {one.purpose}: {install_line(one.name)}" for one in missing]
