"""Gestures of a line for the studio's lane: those that it may have, and those that it has."""

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.json_object import Json
from lipsync_lang.performing.gesturing import (
    BY_HAND,
    laid_gestures,
    placed_by_hand,
    scales_of,
    told_gesture,
)
from lipsync_lang.performing.performer import PerformedLine


def gesture_data(animation: Animation) -> Json | None:
    """Return the gestures of an animation as JSON data; None if it has no columns for them.

    `kinds` are those that are on. `hand` is the number of a gesture that a person placed, among the
    `placed` of the line, and -1 for one that came by rule. `first` is the number in the line of the
    first word shown.
    """
    said = PerformedLine.of(animation)
    if said is None:
        return None
    performer, settings = said.performer, said.settings
    scales = scales_of(performer.compiled, settings["gestures"], settings["line"])
    if scales is None:
        return None
    own, part = performer.gesture_set, animation.schedule
    whole = settings["whole"] or part
    hands = placed_by_hand(performer, whole, settings["line"], settings["placed"])
    places = {(one.number, one.fact): n for n, one in enumerate(hands)}
    rows = []
    for one in laid_gestures(said.performer, said.settings, animation)[1]:
        placed = one.gesture
        by_hand = placed.trigger == BY_HAND
        rows.append(
            {
                "name": own.shapes[placed.number].name,
                "at": round(placed.fact, 5),
                "begin": round(float(animation.times[one.first]), 5),
                "scale": round(placed.height / scales[placed.number], 3),
                "why": told_gesture(own, one, animation),
                "hand": places[placed.number, placed.fact] if by_hand else -1,
            }
        )
    kinds = [
        {"name": one.name, "lead": one.lead, "seconds": one.seconds, "room": one.room}
        for one, scale in zip(own.shapes, scales, strict=True)
        if scale
    ]
    # A long line is shown in parts, and gestures by hand name words of the whole line.
    first = sum(word.start < part.start for word in whole.words)
    return {"poses": list(own.poses), "kinds": kinds, "rows": rows, "first": first}
