"""The command that writes the project of a folder of recordings."""

import sys
from argparse import Namespace
from pathlib import Path

from lipsync_lang.commands.output import FAULTS, SOUND, count, tell_written
from lipsync_lang.errors import LipsyncError
from lipsync_lang.packs.project import FILE


def new(options: Namespace) -> int:
    """Write `lipsync.yaml`, and print the numbers of its lines and the faults of the script."""
    from lipsync_lang.build.new_project import new_project
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
        language=options.new_language, characters=options.characters,
    )  # fmt: skip
    write_all({path: lambda stream: stream.write(drafted.text.encode())}, durable=True)
    tell_written(path)
    for told in drafted.matches:
        print(told, file=sys.stderr)
    try:
        planned = read_script(load_project(path).model, here, paths=options.path)
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
