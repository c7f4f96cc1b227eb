"""Readers of phoneme inventories: the PHOIBLE table and plain segment lists.

An inventory is an ordered tuple of IPA segments without repeats, with its source. File sizes are in
bytes after decompression.
"""

import csv
import gzip
import zlib
from collections.abc import Iterator, Mapping
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.base.files.reading import MIB_BYTES, read_input, utf8_text

ID_COLUMNS = ("InventoryID", "inventory_id")
SEGMENT = ("Phoneme", "phoneme_raw", "phoneme", "segment")
NAME_COLUMNS = ("LanguageName", "language")
CODE_COLUMNS = ("ISO6393", "iso6393")
SOURCE = ("Source", "source")
"""Column names: first of the PHOIBLE file itself, then of tables derived from it."""

SHOWN_INVENTORIES = 12

MAX_INVENTORY_BYTES = 128 * MIB_BYTES
"""Upper limit of the decompressed size in bytes; the PHOIBLE table has 24 million."""


class Inventory(NamedTuple):
    """The segments of a language and their source."""

    source: str
    segments: tuple[str, ...]
    language: str = ""
    code: str = ""


def read_inventory(path: Path, which: str | None = None) -> Inventory:
    """Read one inventory.

    `path` is the PHOIBLE table (.csv or .tsv, optionally gzipped), or plain text of segments
    separated by white space; `which` is an inventory number, ISO 639-3 code or language name in the
    table. Raises LipsyncError if the file is unreadable, or the number of matching inventories is
    not one.
    """
    text = _text(path)
    first = text.partition("\n")[0]
    if not any(name in first for name in SEGMENT) or not any(name in first for name in ID_COLUMNS):
        segments = tuple(dict.fromkeys(text.split()))
        if not segments:
            raise LipsyncError(f"{path}: has no segments; write them with spaces between them")
        return Inventory(path.name, segments)
    found = dict(_inventories(text))
    if which is None:
        mend = "name one by number, ISO 639-3 code or language: --inventory-id 2269"
        raise LipsyncError(f"{path}: holds {len(found)} inventories; {mend}")
    if which in found:
        return found[which]
    key = which.casefold()
    fits = {n: i for n, i in found.items() if key in (i.code.casefold(), i.language.casefold())}
    if len(fits) == 1:
        return next(iter(fits.values()))
    if fits:
        listed = ", ".join(
            f"{n} ({len(i.segments)} segments)" for n, i in [*fits.items()][:SHOWN_INVENTORIES]
        )
        raise LipsyncError(f"{path}: several inventories match '{which}'; name one: {listed}")
    names = {n for i in found.values() for n in (i.language, i.code) if n}
    raise LipsyncError(f"{path}: has no inventory '{which}'; {did_you_mean(which, names)}")


def _text(path: Path) -> str:
    mend = "check that it is a table of phonemes"
    raw = read_input(path, MAX_INVENTORY_BYTES, mend=mend)
    try:
        if raw[:2] == b"\x1f\x8b":
            with gzip.open(BytesIO(raw)) as stream:
                # A guard against decompression bombs; one read would allocate the whole limit.
                blocks = iter(lambda: stream.read(MIB_BYTES), b"")
                raw = b"".join(islice(blocks, MAX_INVENTORY_BYTES // MIB_BYTES + 1))
            if len(raw) > MAX_INVENTORY_BYTES:
                size = f"{MAX_INVENTORY_BYTES // MIB_BYTES} MB"
                raise LipsyncError(f"{path}: unpacks to more than {size}; {mend}")
    except (EOFError, OSError, zlib.error):
        raise LipsyncError(f"{path}: is a broken gzip file; download it again") from None
    return utf8_text(path, raw)


def _inventories(text: str) -> Iterator[tuple[str, Inventory]]:
    """Yield (number, inventory) for every inventory with segments in a table."""
    comma = "\t" not in text.partition("\n")[0]
    rows = csv.DictReader(
        text.splitlines(), delimiter="," if comma else "\t",
        quoting=csv.QUOTE_MINIMAL if comma else csv.QUOTE_NONE,
    )  # fmt: skip
    found: dict[str, list[Mapping[str, str]]] = {}
    for row in rows:
        found.setdefault(_of(row, ID_COLUMNS), []).append(row)
    for number, members in found.items():
        name, code = _of(members[0], NAME_COLUMNS), _of(members[0], CODE_COLUMNS)
        segments = tuple(dict.fromkeys(filter(None, (_of(row, SEGMENT) for row in members))))
        source = ", ".join(filter(None, (_of(members[0], SOURCE), name)))
        if segments:
            yield number, Inventory(f"PHOIBLE {number} ({source})", segments, name, code)


def _of(row: Mapping[str, str], names: tuple[str, ...]) -> str:
    return next((row[name] or "" for name in names if name in row), "").strip()
