"""Models of characters: their rigs as plain data, and models in place of a character.

The cache keeps the rig beside the tables.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from lipsync_lang.base.errors import ModelError, shortlist
from lipsync_lang.faces.rigs.face_on_model import FaceOnModel
from lipsync_lang.faces.rigs.recognise import Match
from lipsync_lang.packs import models
from lipsync_lang.packs.checking.rig_checks import check_rig
from lipsync_lang.packs.finding import beside, model_state
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models.rig_models import plain_channels
from lipsync_lang.packs.pack import Pack
from lipsync_lang.resolver.compiled import CompiledPair


class OtherModel(NamedTuple):
    """A model in place of a character's, and the rig of its pose set that drives it, if any."""

    path: Path
    rig: str | None


def plain_rig(library: Library, rig: str, poseset: Pack[models.PoseSet]) -> dict[str, Any]:
    """Return a rig of a pose set as plain data; raise `PackFaults` as `load_rig` does."""
    model = load_rig(library, rig, poseset.model).model
    to = library.poseset(model.to).model if model.to is not None else None
    return {
        "name": model.name,
        "channels": plain_channels(model, to),
        "lost": dict(model.lost),
        "measures": {name: dict(gains) for name, gains in to.measures.items()} if to else {},
    }


def load_rig(library: Library, name: str, poseset: models.PoseSet) -> Pack[models.RigPack]:
    """Load a rig; raise `PackFaults` if it is unsound, or does not fit its pose set."""
    path = next(path for path in library.rigs_of(poseset.name) if path.stem == name)
    rig: Pack[Any] = library.load(path, "rig", name)
    known = {found.name for found in library.names("poseset")}
    to = library.poseset(rig.model.to).model if rig.model.to in known else None
    faults = [f for f in check_rig(rig, poseset, known, to) if f.severity == "fault"]
    if faults:
        raise library.failing(*sorted(set(faults)))
    return rig


def model_file(*packs: Pack[Any]) -> str | None:
    """Return the model file that the first of some packs names: of a character, or its pose set."""
    named = (beside(pack.path, pack.model.model) for pack in packs if pack.model.model is not None)
    return next((str(path.resolve()) for path in named if path is not None), None)


def face_on_model(
    library: Library, character: Pack[Any], poseset: Pack[Any], on: OtherModel | None = None
) -> FaceOnModel | None:
    """Put a pose set on the model of a character; None without a readable one.

    Raises `ModelError` if the model in its place is unreadable.
    """
    # only a model needs the room of rigs
    from lipsync_lang.faces.rigs.face_on_model import FaceOnModel
    from lipsync_lang.faces.rigs.model import known_model

    named = on.path if on else model_file(character, poseset)
    if named is None:
        return None
    path, rig = Path(named), on.rig if on else character.model.rig
    library.model_states[str(path)] = model_state(path)
    plain = plain_rig(library, rig, poseset) if rig is not None else None
    try:
        return FaceOnModel.of(poseset.model, known_model(path), plain)
    except ModelError:
        if on:
            raise
        return None


def best_match(library: Library, path: Path) -> "tuple[Match, OtherModel]":
    """Return the pose set, with a rig or alone, that shows most of its poses on a model.

    Raise `ModelError` for a model that is unreadable, or whose shapes no pose set knows.
    """
    # only a model needs the room of rigs
    from lipsync_lang.faces.rigs.model import known_model
    from lipsync_lang.faces.rigs.read_outs import still_shapes
    from lipsync_lang.faces.rigs.recognise import recognise

    model = known_model(path)
    found = next((match for match in recognise(library, model) if match.enough), None)
    if found is None:
        still = still_shapes(model)
        moving = [name for name in model.shape_names if name not in still]
        dead = f"; no point of the mesh moves with {shortlist(sorted(still))}" if still else ""
        raise ModelError(
            f"{path}: no pose set knows its shapes ({shortlist(moving)}){dead}. Make them poses of "
            "their own with `lipsync-lang posesets new`"
        )
    return found, OtherModel(path.absolute(), found.rig)


def on_model(library: Library, compiled: CompiledPair, match: Match, path: Path) -> CompiledPair:
    """Put the compiled pair of a pose set on a model, through the rig of the match."""
    rig = None
    if match.rig is not None:
        rig = plain_rig(library, match.rig, library.poseset(match.poseset))
    told = (*compiled.report.idle, *(f"{path.absolute()}: {why}" for why in match.ahead))
    report = replace(compiled.report, idle=told)
    model = str(path.resolve())
    return replace(compiled, character=path.stem, rig=rig, model=model, report=report)
