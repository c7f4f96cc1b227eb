"""Copies of pose sets in a project, for local changes: poses, model, banks and rigs.

A copy takes precedence over its original, and its animations are identical, bit for bit.
"""

from collections.abc import Iterator
from os.path import normpath, relpath
from pathlib import Path

from lipsync_lang.authoring.new_pack import write_new
from lipsync_lang.base.errors import PackError
from lipsync_lang.packs.finding import FOLDERS, POSESET, beside, yaml_files
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.splicing import spliced
from lipsync_lang.packs.yaml.building import read_yaml
from lipsync_lang.packs.yaml.faults import shown

MAX_COPY_BYTES = 256 * 2**20
"""Maximum size of a copy in bytes; a larger folder has other files than a pose set."""


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
