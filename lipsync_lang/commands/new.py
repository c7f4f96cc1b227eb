"""The command that makes a project: a new folder, or a project file for recordings."""

import sys
from argparse import Namespace
from pathlib import Path

from lipsync_lang.base.errors import LipsyncError, count
from lipsync_lang.base.files import write_all
from lipsync_lang.commands.output import FAULTS, SOUND, tell_all, tell_written
from lipsync_lang.commands.parser import lacking
from lipsync_lang.commands.registry import handler
from lipsync_lang.packs.project import FILE


@handler(
    "new",
    "make a project: a new folder, or the project file of your script and recordings",
    "new my-game -l finnish",
)
def new(options: Namespace) -> int:
    """Make a project folder, copy an example, or write the project file of a script."""
    if options.example is not None:
        return _of_example(options)
    if options.table is None and options.recordings is not None:
        raise LipsyncError("--recordings FOLDER needs their script too: --from SCRIPT")
    if options.table is not None and options.name is not None:
        raise LipsyncError(
            f"NAME '{options.name}' makes a new folder, and --from a project in the current one; "
            "leave one of the two out"
        )
    if options.table is not None:
        return _of_table(options)
    if options.name is None:
        raise LipsyncError(
            "give the NAME of the new folder, --example EXAMPLE to copy an example, or --from "
            "TABLE, with --recordings FOLDER if there are any, to make a project in this folder"
        )
    if len(options.characters) > 1:
        raise LipsyncError(f"a new folder has one character; add others to `cast` in its {FILE}")
    from lipsync_lang.packs.library import Library
    from lipsync_lang.production.builds.project_folder import make_project

    library = Library(options.path, project=None)
    character = next(iter(options.characters), None)
    tell_written(*make_project(options.name, library, options.new_language, character))
    folder = f'"{options.name}"' if " " in options.name else options.name
    print(f"next: cd {folder}, then: lipsync-lang build", file=sys.stderr)
    tell_all(lacking(("speech",)))
    return SOUND


def _of_example(options: Namespace) -> int:
    """Copy an example, and name the command that uses it."""
    from lipsync_lang.authoring.copies import copy_example

    others = (options.recordings, options.table, options.new_language, *options.characters)
    if any(other is not None for other in others):
        raise LipsyncError("--example copies an example as it is; leave out the other options")
    copied = copy_example(options.example, options.name and Path(options.name))
    tell_written(*copied)
    folder = next((path.parent for path in copied if path.name == FILE), None)
    quoted = f'"{folder}"' if " " in str(folder) else folder
    after = f"cd {quoted}, then: lipsync-lang build" if folder else "lipsync-lang validate"
    print(f"next: {after}", file=sys.stderr)
    return SOUND


def _of_table(options: Namespace) -> int:
    """Write `lipsync.yaml`, and print the numbers of its lines and the faults of the script."""
    from lipsync_lang.packs.finding import Finder
    from lipsync_lang.production.builds.new_project import new_project
    from lipsync_lang.production.builds.project_folder import starter
    from lipsync_lang.production.builds.script import read_script
    from lipsync_lang.production.builds.timing_formats import open_project
    from lipsync_lang.text.lines.line_readers import TableLayout

    path, here = Path(FILE), Path.cwd()
    if path.exists():
        raise LipsyncError(f"{path}: already exists; edit it, or remove it first")
    finder = Finder(options.path, here)
    drafted = new_project(
        options.recordings, options.table, folder=here, finder=finder,
        language=options.new_language, characters=options.characters or [starter().character],
        column=options.column, encoding=options.encoding,
        layout=TableLayout(options.sheet, options.header_row),
    )  # fmt: skip
    write_all({path: lambda stream: stream.write(drafted.text.encode())}, durable=True)
    tell_written(path)
    tell_all(drafted.matches)
    try:
        # The draft is read like any project: its faults are told while the table is at hand.
        planned = read_script(open_project(path), paths=options.path)
    except LipsyncError as error:
        print(f"{error}\ncorrect the script, then run: lipsync-lang build", file=sys.stderr)
        return FAULTS
    kinds = ("language", "character")
    made = " on ".join(count(len({getattr(one, of) for one in planned}), of) for of in kinds)
    told = f"{count(len(planned), 'line')} to make, in {made}; next, run: lipsync-lang build"
    print(told, file=sys.stderr)
    return SOUND
