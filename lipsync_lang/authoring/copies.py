"""Copies to change in a project: examples, each under its own name, and pose sets.

An example is a built-in pack, or a folder such as a whole game. A copied pose set, with its model,
banks and rigs, takes precedence over its original, and its animations are identical, bit for bit.
"""

from collections.abc import Iterator
from os.path import normpath, relpath
from pathlib import Path
from typing import NamedTuple

from lipsync_lang.authoring.new_pack import write_new
from lipsync_lang.base.errors import LipsyncError, OutputError, PackError, did_you_mean
from lipsync_lang.packs.finding import FOLDERS, POSESET, SHARED, beside, built_in, yaml_files
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.splicing import spliced
from lipsync_lang.packs.yaml.building import read_yaml
from lipsync_lang.packs.yaml.pack_files import shown

MAX_COPY_BYTES = 256 * 2**20
"""Maximum size of a copy in bytes; a larger folder has other files than a pose set."""

EXAMPLE_FOLDERS = ("examples", "docs/examples")
"""Folders of examples beside the built-in packs: of an installation, and of a clone."""


def copy_poseset(library: Library, name: str, folder: Path) -> list[Path]:
    """Copy a pose set into a project, completely or not at all; no file is overwritten.

    Banks and rigs of the project for this pose set are kept, and keep their precedence. Raises
    PackError if the project has the pose set, would not use its copy, or has other files of its
    names, and OutputError if a file is not writable; nothing is copied. Returns the files written.
    """
    source = library.find("poseset", name)
    home = folder.absolute() / FOLDERS["poseset"] / source.parent.name
    if (home / POSESET).exists() or source == home / POSESET:
        raise PackError(f"{shown(home / POSESET)}: already exists; the project has this pose set")
    searched = [root.path.resolve() for root in library.roots]
    origin = next(f.root.path for f in library.names("poseset") if f.path == source)
    project = folder.resolve()
    if project not in searched or searched.index(origin.resolve()) < searched.index(project):
        why = "takes precedence over the project, so a copy would have no effect; edit this file"
        raise PackError(f"{shown(source)}: {why}")
    outputs: dict[Path, bytes] = {}
    last = max((path.name for path in yaml_files(home / "banks").values()), default="")
    # A bank sorts after the banks of the project, which keep their precedence.
    marks = ("", *(f"{'z' * number}-" for number in range(1, len(last) + 2)))
    for path in _whole(library, source):
        target, content = Path(normpath(home / relpath(path, source.parent))), path.read_bytes()
        bank = target.parent == home / "banks" and target.suffix == ".yaml"
        stem = next(m + path.stem for m in marks if not bank or f"{m}{path.stem}.yaml" > last)
        if stem != path.stem:
            target = target.with_name(f"{stem}.yaml")
            content = spliced(read_yaml(target, content), content, [(("name",), stem)])
        # A rig of the project hides the original's of its name already; it is no clash.
        if target.parent != home / "rigs" or not target.exists():
            outputs[target] = content
    for target, content in outputs.items():
        if target.exists() and not (target.is_file() and target.read_bytes() == content):
            raise PackError(f"{shown(target)}: already exists and differs; move or delete it")
    write_new(outputs)
    return list(outputs)


def _whole(library: Library, source: Path) -> Iterator[Path]:
    """Yield the files of a pose set: all in its folder, and a model beside the folder."""
    home = source.parent
    files = [path for path in sorted(home.rglob("*")) if path.is_file()]
    if sum(path.stat().st_size for path in files) > MAX_COPY_BYTES:
        raise PackError(
            f"{shown(home)}: is larger than {MAX_COPY_BYTES >> 20} MB; move other files out of it"
        )
    yield from files
    stated = library.load(source, "poseset", home.name).source.data.get("model")
    model = beside(source, stated) if isinstance(stated, str) else None
    if model is not None and home not in model.parents:
        yield model


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
