"""The command that makes a project: a new folder, or a project file for recordings."""

import sys
from argparse import Namespace
from pathlib import Path

from lipsync_lang.commands.output import FAULTS, SOUND, count, tell_written
from lipsync_lang.commands.registry import Add, command
from lipsync_lang.commands.shared_options import add_path
from lipsync_lang.commands.starting import lacking
from lipsync_lang.errors import LipsyncError
from lipsync_lang.packs.project import FILE


@command("new")
def add_new(add: Add) -> None:
    """Add `new`."""
    made = add(
        "new",
        new,
        "make a project: a new folder, or the project file of your recordings and table",
        "new my-game -l finnish",
    )
    made.add_argument("name", metavar="NAME", nargs="?", help="the name of the new folder")
    made.add_argument(
        "--recordings", metavar="FOLDER", type=Path,
        help="make a project of this folder of recordings in the current folder, with --from",
    )  # fmt: skip
    made.add_argument(
        "--from", metavar="TABLE", type=Path, dest="table",
        help="the script of the recordings, one row for each line",
    )  # fmt: skip
    made.add_argument(
        "-l", "--language", metavar="LANGUAGE", dest="new_language",
        help="the language of the lines, by name or tag [english; of recordings, from their "
        "folders or a column]",
    )  # fmt: skip
    made.add_argument(
        "-c", "--character", metavar="CHARACTER", action="append", default=[], dest="characters",
        help="the pose set of the new character, or an installed character; for recordings, may "
        "be repeated [facefx]",
    )  # fmt: skip
    add_path(made)
    made.set_defaults(in_project=False)


def new(options: Namespace) -> int:
    """Make a project folder, or write the project file of recordings and their table."""
    given = [option is not None for option in (options.recordings, options.table)]
    if any(given) != all(given):
        raise LipsyncError("--recordings FOLDER and --from TABLE belong together; give both")
    if all(given) and options.name is not None:
        raise LipsyncError(
            f"NAME '{options.name}' makes a new folder, and --recordings and --from a project in "
            "the folder that holds both; leave one of the two out"
        )
    if all(given):
        return _of_recordings(options)
    if options.name is None:
        raise LipsyncError(
            "give the NAME of the new folder, or --recordings FOLDER and --from TABLE to make a "
            "project of both in this folder"
        )
    if len(options.characters) > 1:
        raise LipsyncError(f"a new folder has one character; add others to `cast` in its {FILE}")
    from lipsync_lang.build.project_folder import make_project
    from lipsync_lang.packs.library import Library

    library = Library(options.path, project=None)
    character = next(iter(options.characters), None)
    for path in make_project(options.name, library, options.new_language, character):
        tell_written(path)
    folder = f'"{options.name}"' if " " in options.name else options.name
    print(f"next: cd {folder}, then: lipsync-lang build", file=sys.stderr)
    for line in lacking(("speech",)):
        print(line, file=sys.stderr)
    return SOUND


def _of_recordings(options: Namespace) -> int:
    """Write `lipsync.yaml`, and print the numbers of its lines and the faults of the script."""
    from lipsync_lang.build.new_project import new_project
    from lipsync_lang.build.project_folder import starter
    from lipsync_lang.build.script import read_script
    from lipsync_lang.files import write_all
    from lipsync_lang.packs.finding import Finder
    from lipsync_lang.packs.project import load_project

    path, here = Path(FILE), Path.cwd()
    if path.exists():
        raise LipsyncError(f"{path}: already exists; edit it, or remove it first")
    finder = Finder(options.path, here)
    drafted = new_project(
        options.recordings, options.table, folder=here, finder=finder,
        language=options.new_language, characters=options.characters or [starter().character],
    )  # fmt: skip
    write_all({path: lambda stream: stream.write(drafted.text.encode())}, durable=True)
    tell_written(path)
    for told in drafted.matches:
        print(told, file=sys.stderr)
    try:
        planned = read_script(load_project(path), paths=options.path)
    except LipsyncError as error:
        print(f"{error}\ncorrect the script, then run: lipsync-lang build", file=sys.stderr)
        return FAULTS
    languages, characters = (
        {getattr(one, of) for one in planned} for of in ("language", "character")
    )
    print(
        f"{count(len(planned), 'line')} to make, in {count(len(languages), 'language')} on "
        f"{count(len(characters), 'character')}; next, run: lipsync-lang build",
        file=sys.stderr,
    )
    return SOUND
