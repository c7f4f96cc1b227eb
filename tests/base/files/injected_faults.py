"""Run a command in which one act on files fails, with a limit of its memory.

Acts are opening a file to write, writing, syncing and closing it, making a folder, renaming, and
deleting, in the folder. The act of that number raises the error; all later ones succeed. The last
line of the output is the number of acts. The command `save` edits two banks in the studio and saves
them.
"""

import io
import os
import resource
import sys
from pathlib import Path

MEMORY_BYTES = 4 * 2**30

JOURNAL = ".lipsync/journal"


class Acts:
    """Count the acts on files in a folder, and let one fail."""

    def __init__(self, number, code, folder):
        self.number, self.code, self.folder = number, code, folder
        self.done = 0

    def act(self, path):
        """Count an act on a file of the folder."""
        if not isinstance(path, (str, os.PathLike)) or not self.inside(path):
            return
        self.done += 1
        if self.done == self.number:
            raise OSError(self.code, os.strerror(self.code), str(path))

    def inside(self, path):
        return os.path.abspath(path).startswith(self.folder)  # noqa: PTH100 quick

    def heed(self, event, values):
        """Count what Python tells of before it happens."""
        if event == "open":
            path, mode, flags = values
            if (mode and set(mode) & set("wax+")) or (flags or 0) & (os.O_CREAT | os.O_WRONLY):
                self.act(path)
        elif event in {"os.mkdir", "os.rename", "os.remove"}:
            self.act(values[0])

    def watch(self, opening):
        """Return a function that opens files whose writing and closing count."""

        def opened(file, mode="r", *values, **options):
            stream = opening(file, mode, *values, **options)
            path = str(Path(f"/proc/self/fd/{file}").readlink()) if isinstance(file, int) else file
            return Watched(stream, path, self) if set(mode) & set("wax+") else stream

        return opened


class Watched:
    """A file whose writing and closing count."""

    def __init__(self, stream, path, acts):
        self.stream, self.path, self.acts = stream, path, acts

    def __getattr__(self, name):
        return getattr(self.stream, name)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()

    def write(self, content):
        self.acts.act(self.path)
        return self.stream.write(content)

    def close(self):
        """Close the file, and fail afterwards, as file systems of a network do."""
        if not self.stream.closed:
            self.stream.close()
            self.acts.act(self.path)


def save(command):
    """Edit two banks in the studio, unless the journal has the edits, and save them."""
    from lipsync_lang.base.errors import LipsyncError
    from lipsync_lang.studio.desk import Desk

    _, *banks = map(Path, command)
    try:
        desk = Desk(Path(JOURNAL).absolute())
        status = ("bigrams", "l-ow", "status")
        desk.change("Edit", [(bank.absolute(), status, "edited") for bank in banks])
        desk.save()
    except (LipsyncError, OSError) as error:  # the command line and the server print both
        print(error, file=sys.stderr)  # noqa: T201 a command
        return 1
    return 0


def main(number: int, code: int, folder: str, *command: str) -> int:
    """Run the command, and return its exit code."""
    from lipsync_lang.cli import main as run

    acts = Acts(number, code, folder)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    fsync = os.fsync

    def synced(file):
        acts.act(str(Path(f"/proc/self/fd/{file}").readlink()))
        fsync(file)

    os.fsync, os.fdopen, io.open = synced, acts.watch(os.fdopen), acts.watch(io.open)
    sys.addaudithook(acts.heed)
    try:
        return save(command) if command[0] == "save" else run([*command])
    finally:
        print(f"\n{acts.done} acts")  # noqa: T201 a command
