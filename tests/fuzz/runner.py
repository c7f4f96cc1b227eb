"""Runner of mutated inputs for every target, also as a program for long runs.

`python -m fuzz.runner --inputs 20000 --seed 7 --keep` in the folder `tests` prints each kind of
failure once, and keeps its smallest input in the corpus.
"""

import argparse
import atexit
import os
import sys
from collections.abc import Collection, Iterator
from contextlib import suppress
from functools import cache
from hashlib import sha256
from math import ceil
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import NamedTuple

from fuzz.mutators import mutated
from fuzz.oracle import judge
from fuzz.targets import Target, targets
from lipsync_lang import LipsyncError


class Finding(NamedTuple):
    """An input that fails, and its fault."""

    target: str
    number: int
    what: str
    suffix: str
    content: bytes

    def keep(self) -> Path:
        """Write the input into the corpus."""
        name = sha256(self.content).hexdigest()[:10] + self.suffix
        path = targets()[self.target].home / "corpus" / self.target / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(self.content)
        return path


@cache
def folder_of(name: str) -> Path:
    """Return the temporary folder of a target's files."""
    # The cache of a run goes when it ends; a worker of pytest-xdist ends before it can clean up.
    cache = os.environ.get("LIPSYNC_LANG_CACHE")
    folder = TemporaryDirectory(prefix="lipsync-lang-fuzz-", dir=cache)
    atexit.register(folder.cleanup)
    return Path(folder.name, name.replace("/", "-"))


def put(target: Target, content: bytes, suffix: str) -> Path:
    """Write an input to the place for its target."""
    folder = folder_of(target.name)
    folder.mkdir(exist_ok=True)
    path = target.place(folder, suffix)
    path.write_bytes(content)
    return path


def judged(target: Target, content: bytes, suffix: str) -> str | None:
    """Let a target read a content, and return the fault, or None."""
    return judge(target.read, put(target, content, suffix))


@cache
def warm(name: str) -> int:
    """Read the valid files once, so that imports and caches do not count for an input.

    Returns
    -------
    how many of them are read without an error
    """
    target, sound = targets()[name], 0
    for seed in target.seeds:
        with suppress(LipsyncError):
            target.read(put(target, seed.read_bytes(), seed.suffix))
            sound += 1
    return sound


def count_for(target: Target, total: int, among: Collection[Target]) -> int:
    """Return the number of inputs for a target."""
    return ceil(total * target.share / sum(one.share for one in among))


def inputs(target: Target, seed: int, count: int) -> Iterator[tuple[int, bytes, str]]:
    """Yield damaged files, with their numbers and suffixes."""
    known = [*target.seeds, *target.corpus]
    contents = [path.read_bytes() for path in known]
    alike = [contents[n] for n, path in enumerate(known) if path in target.seeds]
    for number in range(count):
        rng = Random(f"{seed} {target.name} {number}")  # noqa: S311 repeatable, not secret
        at = rng.randrange(len(known))
        yield number, mutated(rng, contents[at], alike), known[at].suffix


def findings(target: Target, seed: int, count: int) -> Iterator[Finding]:
    """Yield the inputs that fail."""
    warm(target.name)
    for number, content, suffix in inputs(target, seed, count):
        what = judged(target, content, suffix)
        if what is not None:
            yield Finding(target.name, number, what, suffix, content)


def main() -> int:
    """Run as a program; return 1 if an input failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=20_000, help="over all targets")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--target", default="", help="only targets whose name has this in it")
    parser.add_argument("--keep", action="store_true", help="put failing inputs into the corpus")
    wanted = parser.parse_args()
    chosen = [one for name, one in targets().items() if wanted.target in name]
    total, kinds = 0, {}
    for target in chosen:
        for found in findings(target, wanted.seed, count_for(target, wanted.inputs, chosen)):
            total += 1
            kind = (target.name, found.what.split(": ")[0])
            best = kinds.get(kind)
            if best is None:
                print(f"{target.name} {found.number}: {found.what}", flush=True)  # noqa: T201 a command
            if best is None or len(found.content) < len(best.content):
                kinds[kind] = found
    if wanted.keep:
        for found in kinds.values():
            found.keep()
    print(f"{total} failures of {len(kinds)} kinds, seed {wanted.seed}")  # noqa: T201
    return bool(total)


if __name__ == "__main__":
    sys.exit(main())
