"""Commands that list voices and formats."""

import sys
from argparse import Namespace
from typing import TYPE_CHECKING, Any

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.commands.output import SOUND, as_json
from lipsync_lang.commands.registry import handler

if TYPE_CHECKING:
    from lipsync_lang.base.extensions import Formats

SHOWN = 4
"""Maximum number of suffixes per printed line."""


@handler("voices", "list the voices that speak text", "voices")
def voices(options: Namespace) -> int:
    """Print the voices of a speech engine."""
    from lipsync_lang.base.presentation.text_table import columns
    from lipsync_lang.sound.speech import ENGINES

    found = ENGINES.find(options.engine).voices()
    print(as_json(found) if options.json else "\n".join(columns(sorted(found.items()))))
    return SOUND


@handler("formats", "list the formats that can be read and written", "formats")
def formats(options: Namespace) -> int:
    """Print every registered reader and writer, and the formats of the project."""
    from lipsync_lang.animations.animation_readers import ANIMATION_READERS
    from lipsync_lang.animations.animation_writers import WRITERS
    from lipsync_lang.base.presentation.text_table import columns
    from lipsync_lang.packs.project import find_project
    from lipsync_lang.production.builds.timing_formats import open_project
    from lipsync_lang.schedules.timing_readers import TIMING_READERS
    from lipsync_lang.text.lines.line_readers import LINE_READERS

    if (project := find_project()) is not None:
        try:
            open_project(project)
        except LipsyncError as error:  # the other formats are there all the same
            print(f"{error}\nrun: lipsync-lang validate", file=sys.stderr)
    kinds: tuple[Formats[Any], ...] = TIMING_READERS, LINE_READERS, ANIMATION_READERS, WRITERS
    rows = [
        (kind, name, one.suffixes, one.title)
        for kind, known in zip(("read", "lines", "judge", "write"), kinds, strict=True)
        for name, one in sorted(known.items())
    ]
    if options.json:
        keys = ("direction", "name", "suffix", "title")
        told = [(kind, name, " ".join(suffixes), title) for kind, name, suffixes, title in rows]
        print(as_json([dict(zip(keys, row, strict=True)) for row in told]))
    else:
        shown = [
            (kind, name, " ".join(of[:SHOWN]) + (" ..." if len(of) > SHOWN else ""), title)
            for kind, name, of, title in rows
        ]
        print("\n".join(columns(shown)))
    return SOUND
