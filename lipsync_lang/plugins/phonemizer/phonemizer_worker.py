"""The worker of phonemizer: it reads lines with one backend, in a process of its own.

It runs as a script, and imports nothing of the program. Its first line of input is the backend, the
language, and the lines of a profile; each further line is a list of texts in JSON, and is answered
by a line. The folder of its argument holds all temporary files, and goes when the input ends.
"""

import atexit
import importlib.resources  # noqa: F401 phonemizer 3.4.0 uses it, and does not import it
import json
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

NO_MARKS = re.compile("(?!)")
"""Pattern of no punctuation, because any character may be a grapheme."""

BACKEND_OPTIONS: dict[str, dict[str, Any]] = {
    "segments": {"punctuation_marks": NO_MARKS},
    "espeak": {"with_stress": True, "language_switch": "remove-flags"},
}


def reader(
    backend: str, language: str, profile: list[str], folder: Path
) -> Callable[[list[str]], object]:
    """Return a function from texts to their phones, with ``_`` after each and a space after words.

    For a language that the backend lacks, it returns those that it has.
    """
    from phonemizer.backend import BACKENDS
    from phonemizer.separator import Separator

    make: Any = BACKENDS[backend]
    if profile:
        file = folder / "profile.g2p"
        file.write_text("".join(f"{line}\n" for line in profile), "utf-8", newline="\n")
        language = str(file)
    elif not make.is_supported_language(language):
        known = {"known": sorted(make.supported_languages())}
        return lambda _: known
    phonemize = make(language, **BACKEND_OPTIONS.get(backend, {})).phonemize
    # Festival joins the phones of neighbouring syllables if separators are stripped at the end.
    form = {"separator": Separator(word=" ", phone="_"), "strip": False}

    def read(texts: list[str]) -> list[str]:
        said = phonemize(texts, **form)
        if len(said) == len(texts):
            return said
        # Festival leaves out the lines in which it finds nothing.
        return ["".join(phonemize([text], **form)) for text in texts]

    return read


def main() -> None:
    """Answer lists of texts until the input ends."""
    folder = Path(sys.argv[1])
    atexit.register(shutil.rmtree, folder, ignore_errors=True)  # after phonemizer's own, as first
    tempfile.tempdir = os.environ["TMPDIR"] = str(folder)
    replies = os.fdopen(os.dup(1), "w", encoding="ascii")
    os.dup2(2, 1)  # libraries may print
    backend, language, profile = json.loads(sys.stdin.readline())
    read = None
    for line in sys.stdin:
        reply: object
        try:
            read = read or reader(backend, language, profile, folder)
            reply = read(json.loads(line))
        except Exception as error:  # noqa: BLE001 the program tells it
            reply = {"error": str(error) or type(error).__name__}
        print(json.dumps(reply), file=replies, flush=True)


if __name__ == "__main__":
    main()
