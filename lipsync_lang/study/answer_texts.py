"""Files of answers: finds them, and reads the texts of their submissions."""

import json
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from lipsync_lang.errors import LipsyncError
from lipsync_lang.files import read_input
from lipsync_lang.study.study_file import MAX_ANSWERS_BYTES, MAX_SUBMISSION_BYTES, STUDY_NAME

REPORT_FORMAT = "lipsync-lang study report 1"
"""Format of reports, which may be in the same folder as answers."""

REPORT_HEAD_BYTES = 80
"""Number of bytes at the start of a report that contain its format."""


def answer_files(places: Iterable[Path]) -> list[Path]:
    """Return the files of answers in files and folders, in order, each once.

    Folders give their `.json` and `.jsonl` files, without the study itself and reports of it.

    Raises
    ------
    LipsyncError
        A folder cannot be read, or contains no such file.
    """
    found: dict[Path, None] = {}
    for place in places:
        if not place.is_dir():
            found[place] = None
            continue
        inside = []
        for path in sorted(place.iterdir()):
            if path.suffix in {".json", ".jsonl"} and path.name != STUDY_NAME and path.is_file():
                start = b""
                with suppress(OSError), path.open("rb") as stream:
                    start = stream.read(REPORT_HEAD_BYTES)
                if not (start.startswith(b"{") and f'"{REPORT_FORMAT}"'.encode() in start):
                    inside.append(path)
        if not inside:
            raise LipsyncError(
                f"{place}: contains no .json or .jsonl file of answers; name another folder"
            )
        found |= dict.fromkeys(inside)
    return list(found)


def texts_of(paths: Iterable[Path]) -> Iterator[tuple[str, bytes | LipsyncError]]:
    """Yield the place and text of each submission, or the error of an unreadable file."""
    for path in paths:
        try:
            content = read_input(path, MAX_ANSWERS_BYTES, mend="split the file")
        except LipsyncError as error:
            yield str(path), error
            continue
        content = content.strip()
        lines = content.split(b"\n")
        documents = (parse_document(line)[2] for line in lines)
        # JSON lines have a whole document in some line; an indented document has none.
        if len(lines) == 1 or not any(isinstance(one, dict) and "kind" in one for one in documents):
            yield str(path), content
            continue
        for number, line in enumerate(lines, 1):
            if line.strip():
                yield f"{path}:{number}", line


def parse_document(text: bytes | LipsyncError) -> tuple[str, str, Any]:
    """Return the document after a reason and its words, which are empty if the text is JSON."""
    if isinstance(text, LipsyncError):
        return "unreadable", str(text), None
    if len(text) > MAX_SUBMISSION_BYTES:
        return "unreadable", "is larger than the answers of a rater can be", None
    try:
        return "", "", json.loads(text)
    except (ValueError, RecursionError) as error:
        words = "is empty" if not text else f"is not JSON or is cut off: {error}"
        return "unreadable", words, None
