"""A channel: a shape or bone of a model, driven by one column of an animation."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

Vector = tuple[float, float, float]


class Channel(NamedTuple):
    """Target of one animation column on a model."""

    name: str
    names: tuple[str, ...] = ()
    """Alternative spellings in models; `*` is a wildcard."""
    mesh: str | None = None
    """Mesh of the shape; None for every mesh with such a shape."""
    node: str | None = None
    """Bone to rotate or translate; None for a morph target."""
    rotation: Vector | None = None
    """Rotation axis; the channel's values are degrees."""
    translation: Vector | None = None
    """Translation for a value of 1, in the model's units."""
    head_axis: Vector | None = None
    """Axis of a turn of the head, in axes of the face: x to its left, y up, z to the front."""
    gesture: bool = False
    """True for what gestures move, not speech."""


def bare(poses: Sequence[str], names: Mapping[str, Sequence[str]]) -> tuple[Channel, ...]:
    """Build channels for a face without a rig: its poses, under the names in models."""
    return tuple(Channel(pose, tuple(names.get(pose, ()))) for pose in poses)
