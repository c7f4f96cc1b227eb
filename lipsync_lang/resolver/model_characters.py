"""A model file in place of a character: its pose set and rig are recognised by its shapes."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.errors import ModelError
from lipsync_lang.resolver.rigging import plain_channels_of
from lipsync_lang.rigs.model import known_model, some
from lipsync_lang.rigs.recognise import recognise

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library
    from lipsync_lang.resolver.compiled import Compiled
    from lipsync_lang.rigs.recognise import Match


def best_match(library: "Library", path: Path) -> "Match":
    """Return the pose set, with a rig or alone, that shows most of its poses on a model.

    Raises
    ------
    ModelError
        The model is unreadable, or no pose set knows its shapes.
    """
    model = known_model(path)
    found = next((match for match in recognise(library, model) if match.enough), None)
    if found is None:
        shapes = dict.fromkeys(name for mesh in model.meshes for name in mesh.shapes)
        raise ModelError(
            f"{path}: no pose set knows its shapes ({some(shapes)}). Make them poses of their own "
            "with `lipsync-lang posesets new`"
        )
    return found


def on_model(library: "Library", compiled: "Compiled", match: "Match", path: Path) -> "Compiled":
    """Put the compiled pair of a pose set on a model, through the rig of the match."""
    rig = None
    if match.rig is not None:
        rig = plain_channels_of(library, match.rig, library.poseset(match.poseset))
    return replace(compiled, character=path.stem, rig=rig, model=str(path.resolve()))
