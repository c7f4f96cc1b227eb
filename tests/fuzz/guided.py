"""Coverage-guided fuzzing of every reader, with `atheris`, from the valid files and the corpus.

    python -m fuzz.guided SECONDS SEED     in the folder `tests`

An input begins with two bytes: the number of its target, and of its suffix. Memory is limited, a
warning is a failure, and the first failure ends the run with its input and its fault.
"""

import os
import resource
import sys
import tempfile
import warnings
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["lipsync_lang"], enable_loader_override=False):
    from fuzz.runner import put, warm
    from fuzz.targets import targets
    from lipsync_lang import LipsyncError

MEMORY_BYTES = 4 * 2**30
"""Limit of the address space; a reader that asks for more fails."""

MAX_INPUT_BYTES = 65_536

TARGETS = [targets()[name] for name in sorted(targets())]
SUFFIXES = [sorted({path.suffix for path in (*one.seeds, *one.corpus)}) for one in TARGETS]


def read(data: bytes) -> None:
    """Let a target read an input."""
    if len(data) < 3:
        return
    number = data[0] % len(TARGETS)
    target, suffixes = TARGETS[number], SUFFIXES[number]
    path = put(target, data[2:], suffixes[data[1] % len(suffixes)])
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            target.read(path)
    except LipsyncError:
        return
    except BaseException:
        print(f"{target.name}{path.suffix}: {data[2:200]!r}", flush=True)  # noqa: T201 a command
        raise


def corpus(folder: Path) -> None:
    """Write the valid files and the corpus as inputs."""
    for number, (target, suffixes) in enumerate(zip(TARGETS, SUFFIXES, strict=True)):
        for at, path in enumerate((*target.seeds, *target.corpus)):
            content = path.read_bytes()
            if len(content) <= MAX_INPUT_BYTES:
                head = bytes((number, suffixes.index(path.suffix)))
                (folder / f"{number}-{at}").write_bytes(head + content)


def main(seconds: str, seed: str) -> None:
    """Fuzz for a time."""
    for one in TARGETS:
        warm(one.name)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    with tempfile.TemporaryDirectory(prefix="lipsync-lang-guided-") as name:
        corpus(Path(name))
        os.chdir(name)  # failing inputs are written here
        options = [f"-max_total_time={seconds}", f"-seed={int(seed) + 1}", "-timeout=60"]
        limits = [f"-max_len={MAX_INPUT_BYTES}", "-rss_limit_mb=0", "-print_final_stats=1"]
        atheris.Setup([sys.argv[0], *options, *limits, name], read)
        atheris.Fuzz()


if __name__ == "__main__":
    main(*sys.argv[1:])
