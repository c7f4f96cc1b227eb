"""Argument parser of every command, and the screen of `lipsync-lang` without a command."""

import argparse
import os
from argparse import Namespace
from pathlib import Path

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.extras import extras, install_line
from lipsync_lang.base.version import __version__
from lipsync_lang.commands.output import SOUND
from lipsync_lang.commands.registry import COMMANDS, add_command, leaves
from lipsync_lang.commands.shared_options import add_options, option_sets
from lipsync_lang.packs.project import find_project, load_project
from lipsync_lang.pipeline import kernel

TITLE = f"lipsync-lang {__version__} turns speech into mouth animation, for any language and face."

MORE = "All commands: lipsync-lang --help. One of them: lipsync-lang run --help."

SHOWN_IN_NEXT_STEPS = ("speech", "audio", "studio")
"""Extras of the first steps, most important first."""


def parser(first: str | None = None) -> argparse.ArgumentParser:
    """Build the parser; `docs/reference/commands.md` is generated from it.

    Parameters
    ----------
    first : first argument of the command line; if it is a built-in command, that one is enough,
        and neither the other commands nor the entry points of plug-ins are read; `--version` needs
        no command, and `--help` only their titles
    """
    top = argparse.ArgumentParser(
        prog="lipsync-lang",
        description="Lip sync for any language and any character, from data you can edit.",
        epilog='Try: lipsync-lang run "Hello, world" -l english -c facefx -o hello.csv',
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.color = False  # type: ignore[attr-defined] # Python 3.14 would colour what is spelled out
    version = f"lipsync-lang {__version__} ({kernel.summary()})"
    top.add_argument("--version", action="version", version=version)
    # Without a command, no parser below has set these.
    top.set_defaults(command=welcome, quiet=False, verbose=False)
    known = top.add_subparsers(title="commands", metavar="COMMAND", required=False)
    # The order of registration depends on the imports before, and the help must not.
    alone, titles = first in (*COMMANDS.modules, "--version"), first in ("-h", "--help")
    names = [str(first)] if alone else [*COMMANDS.modules, *sorted(COMMANDS)]
    for name in dict.fromkeys(names):
        if " " not in name and name[0] != "-":
            add_command(known, name, whole=not titles)
    for _, made in leaves(top) if not titles else ():
        add_options(made.add_mutually_exclusive_group(), option_sets()["words"])
    return top


def welcome(options: Namespace) -> int:  # noqa: ARG001 every command takes options
    """Print the purpose of the program, and commands for the next steps."""
    from lipsync_lang.base.presentation.text_table import columns
    from lipsync_lang.production.builds.project_folder import starter

    path, first = find_project(), starter()
    if path is None:
        head, pair = "Next steps:", f"-l {first.language} -c {first.character}"
        alone, heard = f'"{first.text}" {pair}', f'"ITS TEXT" --audio FILE {pair}'
        steps = [
            ("a sentence, to hear and see", f"lipsync-lang run {alone} -o line.html"),
            ("with your recording", f"lipsync-lang run {heard} -o line.html"),
            ("make a project", "lipsync-lang new my-game"),
            ("shape a character in your browser", f"lipsync-lang studio {pair}"),
            ("check this installation", "lipsync-lang doctor"),
        ]
    else:
        head = f"Next steps in the project {os.path.relpath(path)}:"
        steps = _project_steps(path, first.text)
    shown, missing = columns([(f"  {what}", how) for what, how in steps]), lacking()
    print("\n".join([TITLE, "", head, *shown, *([""] if missing else []), *missing, "", MORE]))
    return SOUND


def _project_steps(path: Path, text: str) -> list[tuple[str, str]]:
    try:
        project = load_project(path).model
    except (LipsyncError, OSError):
        return [("find the faults of the project", "lipsync-lang validate")]
    steps = [("check all packs", "lipsync-lang validate")]
    if project.lines:
        steps += [("make the lines that changed", "lipsync-lang build")]
    paired = project.language and project.character
    if paired:
        steps += [("make one line", f'lipsync-lang run "{text}"')]
    if paired or project.lines:
        steps += [("hear and change lines in your browser", "lipsync-lang studio")]
    return [*steps, ("check this installation", "lipsync-lang doctor")]


def lacking(names: tuple[str, ...] = SHOWN_IN_NEXT_STEPS) -> list[str]:
    """Return a line for each missing extra, with its installation command."""
    known = {one.name: one for one in extras()}
    missing = [known[name] for name in names if known[name].missing()]
    return [f"not installed: {one.purpose}: {install_line(one.name)}" for one in missing]
