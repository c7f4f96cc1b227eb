"""Rename files and folders, on Windows also while a virus scanner reads them."""

import sys
import time
from pathlib import Path

PAUSES_SECONDS = (0.02, 0.05, 0.1, 0.2, 0.4)
"""Pauses between attempts on Windows; scanners read a new file for less than their sum."""


def replace_file(source: Path, target: Path) -> None:
    """Rename a file, maybe over another, or a folder to a free name.

    Windows refuses that while any program has a file of them open. A virus scanner opens each new
    file for a moment, so the rename is attempted again there.
    """
    for seconds in PAUSES_SECONDS if sys.platform == "win32" else ():
        try:
            source.replace(target)
        except PermissionError:
            time.sleep(seconds)
        else:
            return
    try:
        source.replace(target)
    except OSError as error:
        error.filename = str(target)  # its user has never seen the temporary file
        raise
