"""Examples to copy: built-in packs, and folders such as a whole game, each under its own name."""

from pathlib import Path
from typing import NamedTuple

from lipsync_lang.authoring.new_pack import write_new
from lipsync_lang.base.errors import LipsyncError, OutputError, did_you_mean
from lipsync_lang.packs.finding import FOLDERS, SHARED, built_in

EXAMPLE_FOLDERS = ("examples", "docs/examples")
"""Folders of examples beside the built-in packs: of an installation, and of a clone."""


class Example(NamedTuple):
    """A file or folder that comes with the program, to copy and change."""

    source: Path
    place: Path | None
    """Folder of packs of its kind in a project; None for a folder that stands alone."""


def examples() -> dict[str, Example]:
    """Return all examples by name; of equal names, a pose set comes before a language."""
    found: dict[str, Example] = {}
    for home in (*FOLDERS.values(), *EXAMPLE_FOLDERS):
        place = None if home in EXAMPLE_FOLDERS else Path(home)
        for source in sorted((built_in() / home).glob("[!_.]*")):
            if source.stem not in SHARED:
                found[source.stem] = Example(source, place)
    return found


def copy_example(name: str, folder: Path | None) -> list[Path]:
    """Copy an example, and return the new files. No file is overwritten.

    A pack goes to its place in a folder, or in the current one. Any other example becomes the
    folder, or a folder of its own name.
    """
    known = examples()
    if name not in known:
        alone = ", ".join(other for other, one in known.items() if one.place is None)
        choice = f"Examples are {alone}, and each built-in language and pose set"
        raise LipsyncError(f"unknown example '{name}': {did_you_mean(name, known)} {choice}")
    source, place = known[name]
    target = (folder or Path(name)) if place is None else (folder or Path()) / place / source.name
    inner = sorted(p for p in source.rglob("*") if p.is_file() and "__pycache__" not in p.parts)
    copies = {target / path.relative_to(source): path for path in inner or [source]}
    if target.exists() or target.is_symlink():
        raise OutputError(f"{target}: is there already; name another folder, or remove it first")
    write_new(dict(copies))
    return list(copies)
