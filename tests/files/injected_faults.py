"""Run a command in which one act on files fails, with a limit of its memory.

    python injected_faults.py NUMBER ERRNO FOLDER COMMAND...

Acts are opening a file to write, making a folder, renaming, and deleting, in the folder. The act of
that number raises the error; all later ones succeed. The last line of the output is the number of
acts.
"""

import os
import resource
import sys

MEMORY_BYTES = 4 * 2**30


def main(number: int, code: int, folder: str, *command: str) -> int:
    """Run the command, and return its exit code."""
    from lipsync_lang.cli import main as run

    acts = 0

    def heed(event: str, values: tuple) -> None:
        nonlocal acts
        if event == "open":
            path, mode, flags = values
            writes = (mode and set(mode) & set("wax+")) or (flags or 0) & (os.O_CREAT | os.O_WRONLY)
            if not writes:
                return
        elif event in {"os.mkdir", "os.rename", "os.remove"}:
            path = values[0]
        else:
            return
        if not isinstance(path, (str, os.PathLike)) or not os.path.abspath(path).startswith(folder):  # noqa: PTH100 quick
            return
        acts += 1
        if acts == number:
            raise OSError(code, os.strerror(code), str(path))

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    sys.addaudithook(heed)
    try:
        return run([*command])
    finally:
        print(f"\n{acts} acts")  # noqa: T201 a command


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2]), *sys.argv[3:]))
