"""A channel: one shape or bone of a model that a column of an animation drives."""

from typing import NamedTuple

Vector = tuple[float, float, float]


class Channel(NamedTuple):
    """What one column of an animation drives on a model."""

    name: str
    names: tuple[str, ...] = ()
    """How models spell it otherwise; `*` stands for anything."""
    mesh: str | None = None
    """The one mesh that has it; None for every mesh with such a shape."""
    node: str | None = None
    """The bone it turns or moves; None for a morph target."""
    rotation: Vector | None = None
    """The axis it turns about; its values are degrees."""
    translation: Vector | None = None
    """The way it moves, in the model's units for a value of 1."""
