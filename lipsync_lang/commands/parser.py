"""Argument parser: every command with its arguments and an example."""

import argparse

from lipsync_lang.base.version import __version__
from lipsync_lang.commands.registry import COMMANDS, add_command, leaves
from lipsync_lang.commands.shared_options import add_words
from lipsync_lang.commands.starting import welcome
from lipsync_lang.pipeline import kernel


def parser(first: str | None = None) -> argparse.ArgumentParser:
    """Build the parser; `docs/reference/commands.md` is generated from it.

    Parameters
    ----------
    first : first argument of the command line; if it is a built-in command, that one is enough,
        and neither the other commands nor the entry points of plug-ins are read
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
    top.set_defaults(command=welcome, quiet=False, verbose=False)
    known = top.add_subparsers(title="commands", metavar="COMMAND", required=False)
    # The order of registration depends on the imports before, and the help must not.
    names = [first] if first in COMMANDS.modules else [*COMMANDS.modules, *sorted(COMMANDS)]
    for name in dict.fromkeys(names):
        if " " not in name:
            add_command(known, name)
    for _, made in leaves(top):
        add_words(made)
    return top
