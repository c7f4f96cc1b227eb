"""The pose set of a character: its own targets, softness and anticipation in place of the set's."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Character, PoseSet


def own_face(poseset: "PoseSet", character: "Character") -> "PoseSet":
    """Return a pose set with the values that a character states in place of the set's."""
    if not (character.targets or character.softness or character.anticipate):
        return poseset
    poses = dict(poseset.poses)
    for name, seconds in character.anticipate.items():
        if name in poses:
            poses[name] = poses[name].model_copy(update={"anticipate": seconds})
    changed = {
        "poses": poses,
        "targets": {**poseset.targets, **character.targets},
        "softness": {**poseset.softness, **character.softness},
    }
    return poseset.model_copy(update=changed)
