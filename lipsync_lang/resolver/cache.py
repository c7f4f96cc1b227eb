"""Compiled pairs on disk, so that a warm start reads no YAML.

A cache file is used only if it passes three checks. It is whole: its checksum fits its bytes. It is
ours: its mark, its pair and the digest of the compiling code fit. It is fresh: all lookups made
while compiling find the same files, with the same content. Any other file is compiled again.
Loading executes nothing from a file.
"""

import json
import logging
import os
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import cache, reduce
from hashlib import sha256
from itertools import accumulate
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zlib import crc32

from lipsync_lang.base.version import __version__
from lipsync_lang.packs.finding import FOLDERS, Finder, Paths, located, model_state
from lipsync_lang.packs.project import stated_mouth
from lipsync_lang.packs.yaml.pack_files import read_bytes
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.resolver.compiled import CompiledPair, Origin, Report

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library
    from lipsync_lang.pipeline.tables import Tables

_log = logging.getLogger(__name__)

MARK = b"lipsync-lang compiled pair, v1.\n"
CHECKSUM = 32
"""Size of the checksum in bytes; with the mark a multiple of 64, so that arrays are aligned."""

ALIGNMENT = 64
"""Alignment of arrays in the file, in bytes."""

COMPILERS = ("faces/rigs", "packs", "pipeline", "resolver", "text/phonology")
"""Folders of the compiling code. A change below them invalidates every file."""

BANK_ARRAYS = {
    "curves": ("f4", "rows times poses"), "boundary": ("f8", "rows"),
    "free": ("?", "rows"),
}  # fmt: skip
"""Arrays of a style by name, with their types and dimensions."""

CONTACT_ARRAYS = {
    "phonemes": ("?", "phonemes"), "floor": ("f8", "poses"),
    "ceiling": ("f8", "poses"),
}  # fmt: skip
"""Arrays of a contact."""

ARRAYS = {
    **BANK_ARRAYS, "pairs": ("p", "phonemes phonemes"), "opposed": ("?", "phonemes poses"),
    "thresholds": ("f8", "poses poses"), "paper": ("f8", "poses poses"),
    "priority": ("f8", "poses"), "softness": ("f8", "poses"),
    "anticipate": ("f8", "poses"), "highest": ("f8", "poses"),
    "trigrams": ("p", "trigrams"), "trigram_rows": ("p", "trigrams halves"),
}  # fmt: skip
"""Arrays of the tables."""

MAX_CACHE_BYTES = 2 * 2**30
"""Maximum bytes of all pairs; the oldest are deleted first. A built-in pair has 1 to 9 MB."""

CACHE_VARIABLE = "LIPSYNC_LANG_CACHE"
"""Environment variable with another folder for the cache, or `off`."""


def folder() -> Path | None:
    """Return the folder of compiled pairs; None if the user turned the cache off."""
    named = os.environ.get(CACHE_VARIABLE)
    if named is not None:
        return None if named in ("", "off") else Path(named)
    from platformdirs import user_cache_path

    return user_cache_path("lipsync-lang")


@cache
def compiler(folders: tuple[str, ...] = COMPILERS) -> str:
    """Return a digest of the code in folders of the package: the compiling code."""
    package = Path(__file__).parents[1]
    whole = sha256(__version__.encode())
    for folder in folders:
        # sorted, since the order of `rglob` is that of the file system
        for path in sorted((package / folder).rglob("*.py")):
            whole.update(path.read_bytes())
    return whole.hexdigest()


def _key(names: Sequence[str], paths: Sequence[Path]) -> str:
    """Return the file key of a pair, as JSON: its names, search paths, project and its mouths.

    Folders without packs are left out, so that all projects without packs share a file.
    """
    here = Path.cwd()
    searched = [str(path.absolute()) for path in paths if path.is_file() or _has_packs(path)]
    own = str(here) if _has_packs(here) else ""
    return json.dumps([*names, searched, own, stated_mouth(here)])


def _has_packs(folder: Path) -> bool:
    return any((folder / kind).exists() for kind in FOLDERS.values())


def _path(key: str) -> Path | None:
    where = folder()
    return where / f"{sha256(key.encode()).hexdigest()[:32]}.pair" if where else None


def load(language: str, character: str, paths: Sequence[Path]) -> CompiledPair | None:
    """Return a compiled pair from the cache; None if its file is damaged, foreign or stale."""
    with suppress(Exception):  # a forged file can fail anywhere
        return _compiled(*_read((language, character), paths))
    _log.info("%s on %s: to be compiled", language, character)
    return None


def load_report(language: str, character: str, paths: Paths) -> Report | None:
    """Return the report of a pair from the cache, or None as `load`, without its arrays."""
    with suppress(Exception):  # also for a name that is not found
        names, folders = located(paths, language=language, character=character)
        return Report(**_tuples(_read(names, folders)[0]["report"]))
    return None


def _read(names: Sequence[str], paths: Sequence[Path]) -> tuple[dict[str, Any], memoryview]:
    """Return the head and the body of the file of a pair; raise an error for one that is stale."""
    key = _key(names, paths)
    rest = unsealed(MARK, _path(key))
    stop = 8 + int.from_bytes(rest[:8], "little")
    head = json.loads(bytes(rest[8:stop]))
    if (head["key"], head["compiler"]) != (key, compiler()) or not _fresh(head, paths):
        raise ValueError("the file is stale")
    _log.info("%s on %s: cached", *names)
    # the arrays begin at the next aligned place, as `_encode` lays them
    return head, rest[stop + (-stop % ALIGNMENT) :]


def save(compiled: CompiledPair, language: str, character: str, library: "Library") -> None:
    """Write a compiled pair to the cache; a cache that cannot be written is not an error."""
    key = _key((language, character), library.paths)
    path = _path(key)
    if path is not None:
        keep(path, MARK, _encode(compiled, key, library))
        delete_oldest(path.parent, "*.pair", MAX_CACHE_BYTES)


def keep(path: Path | None, mark: bytes, parts: Iterable[bytes | memoryview]) -> None:
    """Write a sealed file of the cache; a cache that cannot be written is not an error."""
    if path is None:
        return
    with suppress(OSError):
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        if CACHE_VARIABLE not in os.environ:  # a folder named by the user keeps its own permissions
            path.parent.chmod(0o700)
        # without a rename, which takes longer than the writing: a torn file fails its checksum
        with path.open("wb") as stream:
            stream.writelines(sealed(mark, parts))


def delete_oldest(where: Path, pattern: str, most: int) -> None:
    """Delete the oldest files of a cache beyond its size limit in bytes, but not the newest."""
    with suppress(OSError):
        found = ((one.stat(), one) for one in where.glob(pattern))
        newest = sorted(((s.st_mtime, s.st_size, one) for s, one in found), reverse=True)
        total = accumulate(size for _, size, _ in newest)
        for (_, _, one), taken in zip(newest, total, strict=True):
            # the newest is in use, even if it alone is beyond the limit
            if taken > most and one != newest[0][2]:
                one.unlink(missing_ok=True)


def sealed(mark: bytes, parts: Iterable[bytes | memoryview]) -> list[bytes | memoryview]:
    """Return the parts of a cache file with a mark, and with a checksum of them, before them.

    It finds damage, as fast as a start needs; whoever can write the folder is trusted anyway.
    """
    body = [*parts]
    whole = reduce(lambda found, part: crc32(part, found), body, 0)
    return [mark, whole.to_bytes(CHECKSUM, "little"), *body]


def unsealed(mark: bytes, path: Path | None) -> memoryview:
    """Return the content of a cache file after its mark and checksum; an error for another."""
    content = path.read_bytes() if path else b""
    rest = memoryview(content)[len(mark) + CHECKSUM :]
    if content[: -len(rest)] != b"".join(sealed(mark, [rest])[:2]):
        raise ValueError("the file is damaged, or of another program")
    return rest


def _encode(compiled: CompiledPair, key: str, library: "Library") -> list[bytes | memoryview]:
    """Return the parts of a cache file in order, without a copy of the arrays."""
    body: list[bytes | memoryview] = []
    places, size = {}, 0
    for name, array in compiled.tables.arrays.items():
        places[name] = [array.dtype.str, list(array.shape), size]
        # aligned, so that a load can use the file's own memory
        body += [array.ravel().data, b"\0" * (-array.nbytes % ALIGNMENT)]
        size += array.nbytes + len(body[-1])
    plain = {
        name: getattr(compiled, name)
        for name in compiled.__dataclass_fields__
        if name not in ("tables", "motion", "report")
    }
    head = {
        "key": key,
        "compiler": compiler(),
        "lookups": [[*asked, list(found)] for asked, found in library.lookups.items()],
        "files": library.files,
        "models": library.model_states,
        "plain": plain,
        "motion": asdict(compiled.motion),
        "report": asdict(compiled.report),
        "silence": compiled.tables.silence,
        "at_most": compiled.tables.at_most,
        "arrays": places,
    }
    text = json.dumps(head, ensure_ascii=False).encode()
    start = len(text).to_bytes(8, "little") + text
    start += b"\0" * (-len(start) % ALIGNMENT)
    return [start, *body]


def _fresh(head: dict[str, Any], paths: Sequence[Path]) -> bool:
    """Return True if all lookups and files are unchanged since the compilation."""
    finder = Finder(paths)
    return (
        all(
            # a pack that appeared earlier on the search path would win now
            finder.lookup(kind, name) == tuple(found)
            for kind, name, found in head["lookups"]
        )
        and all(
            # `is_file` first: reading an endless device or a pipe would never return
            Path(path).is_file() and sha256(read_bytes(Path(path))).hexdigest() == digest
            for path, digest in head["files"].items()
        )
        and all(model_state(Path(path)) == state for path, state in head["models"].items())
    )


def _compiled(head: dict[str, Any], body: memoryview) -> CompiledPair:
    plain = head["plain"]
    tables = _tables(head, body)
    origins = tuple(map(_origin, plain.pop("origins")))
    styles = {
        style: {row: _origin(origin) for row, origin in rows.items()}
        for style, rows in plain.pop("style_origins").items()
    }
    notations, visemes = (
        {
            name: {label: tuple((p, s) for p, s in value) for label, value in table.items()}
            for name, table in plain.pop(field).items()
        }
        for field in ("notations", "visemes")
    )
    words = {text: tuple(sounds) for text, sounds in plain.pop("words").items()}
    return CompiledPair(
        **_tuples(plain),
        origins=origins,
        style_origins=styles,
        notations=notations,
        visemes=visemes,
        words=words,
        tables=tables,
        motion=Motion(**head["motion"]),
        report=Report(**_tuples(head["report"])),
    )


def _tuples(plain: dict[str, Any]) -> dict[str, Any]:
    """Return fields with tuples in place of lists, which JSON does not distinguish."""
    return {
        name: tuple(value) if isinstance(value, list) else value for name, value in plain.items()
    }


def _tables(head: dict[str, Any], body: memoryview) -> "Tables":
    """Return the tables of a file; raise an error for arrays or indices that do not fit."""
    import numpy as np

    from lipsync_lang.pipeline.tables import RESOLUTION, Tables

    plain, places = head["plain"], head["arrays"]
    sizes = {name: len(plain[name]) for name in ("poses", "phonemes")}
    sizes |= {"rows": len(plain["origins"]), "times": RESOLUTION + 1}
    sizes |= {"trigrams": places["trigrams"][1][0], "halves": 2}
    expected = dict(ARRAYS)
    for name, parts in (("contact_names", CONTACT_ARRAYS), ("style_origins", BANK_ARRAYS)):
        owner = name.partition("_")[0]
        for number in range(len(plain[name])):
            expected |= {f"{owner}.{number}.{part}": sort for part, sort in parts.items()}
    arrays: dict[str, Any] = {}
    for name, (kind, dimensions) in expected.items():
        (dtype, stated, offset), shape = places[name], [sizes[one] for one in dimensions.split()]
        if dtype != np.dtype(kind).str or stated != shape:
            raise ValueError(f"array {name} is {dtype} {stated}, not {kind} {shape}")
        arrays[name] = np.frombuffer(body, kind, prod(shape), offset).reshape(shape)
    at_most = tuple((pose, other) for pose, other in head["at_most"])
    tables = Tables.of(arrays, head["silence"], at_most)
    # numpy would read other rows for negative indices
    rows = np.concatenate((tables.pairs.ravel(), tables.trigram_rows.ravel()))
    poses = {pose for pair in tables.at_most for pose in pair}
    if (
        rows.min() < 0
        or rows.max() >= len(tables.boundary)
        or tables.silence not in range(len(tables.pairs))
        or not poses <= set(range(len(tables.priority)))
    ):
        raise ValueError("an index is out of range")
    return tables


def _origin(plain: Any) -> Origin:
    pair, layer, status, places, word, triple = plain
    # JSON has lists alone
    whole = None if triple is None else (triple[0], triple[1], triple[2])
    return Origin((pair[0], pair[1]), layer, status, tuple(places), word, whole)
