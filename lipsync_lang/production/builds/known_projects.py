"""Validated projects in the cache, so that a command in a folder loads no models of packs.

A file is named by the content of the project and by the validating code, and is trusted as a
compiled pair is (decision 0002). Folders and formats that a project names are checked each time.
"""

import json
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.project import check_paths, load_project
from lipsync_lang.packs.yaml.pack_files import read_bytes
from lipsync_lang.resolver.cache import compiler, delete_oldest, folder, keep, unsealed

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Project

MARK = b"lipsync-lang project, v1.\n"

PROJECT_SUFFIX = ".project"

STATED = ""
"""Key of the fields that a model states, beside its fields: no field has this name."""

MAX_BYTES = 2**20
"""Maximum bytes of all projects in the cache; the oldest are deleted first."""


class KnownFields:
    """Fields of a model that was validated before; it serves as the model does."""

    def __init__(self, fields: dict[str, Any]) -> None:
        self.model_fields_set = frozenset(fields.pop(STATED))
        self._fields = fields
        self.__dict__.update(fields)

    def model_dump(self, *, exclude_none: bool) -> dict[str, Any]:
        """Return the fields as plain data."""
        return {
            name: one.model_dump(exclude_none=exclude_none) if isinstance(one, KnownFields) else one
            for name, one in self._fields.items()
            if not (exclude_none and one is None)
        }


def known_project(path: Path) -> "Pack[Project]":
    """Return a project from the cache; any other is read and validated, and kept there.

    Raises an error for one that is unsound, or a link out of its folder.
    """
    refuse_outside(path, path.parent)
    content = read_bytes(path)
    key = sha256(compiler().encode() + content).hexdigest()
    where = folder()
    file = where / f"{key[:32]}{PROJECT_SUFFIX}" if where else None
    with suppress(Exception):  # a forged file can fail anywhere
        model = json.loads(bytes(unsealed(MARK, file)), object_hook=_restored)
        from lipsync_lang.packs.yaml.building import scan

        known = Pack(cast("Project", model), (scan(path, content),))
        if not [*check_paths(known)]:
            return known
    pack = load_project(path, content)
    keep(file, MARK, [json.dumps(pack.model, default=_fields).encode()])
    if where:
        delete_oldest(where, f"*{PROJECT_SUFFIX}", MAX_BYTES)
    return pack


def _fields(model: Any) -> dict[str, Any]:
    return {STATED: sorted(model.model_fields_set), **vars(model)}


def _restored(fields: dict[str, Any]) -> Any:
    tuples = {n: tuple(one) if isinstance(one, list) else one for n, one in fields.items()}
    return KnownFields(tuples) if STATED in tuples else tuples
