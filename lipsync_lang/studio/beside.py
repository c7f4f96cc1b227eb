"""The open line on another character, to be seen beside its own."""

from collections.abc import Collection, Mapping
from copy import copy
from typing import Any

from lipsync_lang.animations.animation import Animation
from lipsync_lang.performing.performer import Performer
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.studio.line_settings import LineSettings
from lipsync_lang.studio.workshop import Workshop, without_lines


def other_performer(workshop: Workshop, character: str) -> Performer:
    """Return the performer of the open language on another character, with the unsaved edits."""
    now = workshop.language, workshop.desk.revision
    known = workshop.others.get(character)
    if known is None or known[:2] != now:
        compiled = compile_pair(workshop.library(), workshop.language, character)
        known = (*now, without_lines(workshop.performer_for(compiled)))
        workshop.others = {character: known}
    return known[2]


def performed_beside(workshop: Workshop, character: str) -> Animation | None:
    """Perform the line on another character, with those styles, regions and gestures it has.

    None if there is no line.
    """
    performer, stated = other_performer(workshop, character), workshop.settings
    if workshop.line is None:
        return None
    # A copy: the settings of the open line must not lose what the other face lacks.
    compiled, aside = performer.compiled, copy(workshop)
    moves = {shape.name for shape in performer.gesture_set.shapes}
    aside.settings = LineSettings(
        stated.fps,
        styles=_among(stated.styles, compiled.style_names),
        dials=_among(stated.dials, compiled.regions),
        intensity=stated.intensity,
        bends=_among(stated.bends, compiled.poses),
        placed=[one for one in stated.placed if one["gesture"] in moves],
    )
    return aside.perform_shown(performer)


def _among(levels: Mapping[str, Any], known: Collection[str]) -> dict[str, Any]:
    return {name: level for name, level in levels.items() if name in known}
