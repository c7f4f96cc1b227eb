"""The rig of a character's model as plain data; the cache keeps it beside the tables."""

from typing import TYPE_CHECKING, Any

from lipsync_lang.packs.checking.rig_checks import check_rig
from lipsync_lang.packs.finding import beside
from lipsync_lang.packs.models.rig_channels import plain_channels

if TYPE_CHECKING:
    from lipsync_lang.packs import models
    from lipsync_lang.packs.library import Library, Pack


def plain_rig(
    library: "Library", character: "Pack[models.Character]", poseset: "Pack[models.PoseSet]"
) -> dict[str, Any] | None:
    """Return the rig of a character as plain data; None if the character names none.

    Raises
    ------
    PackFaults
        The rig is unsound, or does not fit the pose set.
    """
    name = character.model.rig
    return None if name is None else plain_channels_of(library, name, poseset)


def plain_channels_of(
    library: "Library", rig: str, poseset: "Pack[models.PoseSet]"
) -> dict[str, Any]:
    """Return a rig of a pose set as plain data.

    Raises
    ------
    PackFaults
        The rig is unsound, or does not fit the pose set.
    """
    model = load_rig(library, rig, poseset.model).model
    to = library.poseset(model.to).model if model.to is not None else None
    return {"name": model.name, "channels": plain_channels(model, to), "lost": dict(model.lost)}


def load_rig(library: "Library", name: str, poseset: "models.PoseSet") -> "Pack[models.RigPack]":
    """Load a rig and check it against its pose set.

    Raises
    ------
    PackFaults
        It is not.
    """
    path = next(path for path in library.rigs_of(poseset.name) if path.stem == name)
    rig: Pack[Any] = library.load(path, "rig", name)
    known = {found.name for found in library.names("poseset")}
    to = library.poseset(rig.model.to).model if rig.model.to in known else None
    faults = [f for f in check_rig(rig, poseset, known, to) if f.severity == "fault"]
    if faults:
        raise library.failing(*sorted(set(faults)))
    return rig


def model_file(character: "Pack[models.Character]", poseset: "Pack[models.PoseSet]") -> str | None:
    """Return the model file of a character, or else of its pose set."""
    for pack in (character, poseset):
        named = pack.model.model
        path = beside(pack.path, named) if named is not None else None
        if path is not None:
            return str(path.resolve())
    return None
