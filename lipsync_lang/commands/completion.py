"""The command that generates shell completion scripts."""

from argparse import Namespace
from pathlib import Path

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.extras import needing
from lipsync_lang.commands.output import SOUND
from lipsync_lang.commands.registry import handler, leaves

FILE_PLACEHOLDERS = {"FILE", "FOLDER", "PATH", "CORPUS", "GLB", "ANSWERS"}
"""Placeholders of file arguments."""


@handler(
    "completion",
    "print a script that completes commands, options and names in a shell",
    "completion bash > ~/.local/share/bash-completion/completions/lipsync-lang",
)
def completion(options: Namespace) -> int:
    """Print a script that completes commands, options, files, and names of packs found now."""
    with needing(LipsyncError, "completion needs shtab:", "completion"):
        import shtab
    from lipsync_lang.commands.parser import parser
    from lipsync_lang.packs.finding import Finder

    finder = Finder()
    languages, posesets, characters = (
        {found.name for found in finder.names(kind)}
        for kind in ("language", "poseset", "character")
    )
    faces = sorted(posesets | characters)
    names = {"LANGUAGE": sorted(languages), "POSESET": faces, "CHARACTER": faces}
    # The whole parser, plug-ins included, and not only the part of one command.
    top = parser()
    for _, leaf in leaves(top):
        for action in leaf._actions:  # noqa: SLF001 argparse has no other list of them
            if action.type is Path or str(action.metavar) in FILE_PLACEHOLDERS:
                action.complete = shtab.FILE  # type: ignore[attr-defined] # where shtab looks
            elif action.metavar in names and action.option_strings:
                action.choices = names[str(action.metavar)]
    print(shtab.complete(top, options.shell))
    return SOUND
