"""Models of rigs: packs that drive the shapes and bones of a model."""

from typing import Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lipsync_lang.packs.models.fields import (
    Axis,
    Name,
    PackModel,
    PoseName,
    Strict,
    Text,
    Vector,
)


class RigChannel(Strict):
    """A shape or bone of a model, driven by a sum of gain times pose."""

    gains: dict[PoseName, float]
    """The channel's value for each pose at weight 1."""
    range: tuple[float, float] | None = None
    """The least and the largest value."""
    at_most: Text | None = None
    """Another channel, whose value is an upper limit."""
    mesh: Text | None = None
    """The mesh with the shape; every mesh with such a shape unless stated."""
    node: Text | None = None
    """The bone to turn or move; without it, the channel is a shape."""
    rotation: Axis | None = None
    """The axis of a bone's rotation; gains are in degrees."""
    translation: Vector | None = None
    """A bone's movement for a value of 1, in the model's units."""

    @model_validator(mode="after")
    def _bone_fits(self) -> Self:
        if self.range is not None and self.range[0] > self.range[1]:
            what = "`range` must begin with its smaller number; swap the two"
            raise PydanticCustomError("P115", what, {"field": "range"})
        moves = [f for f in ("rotation", "translation") if getattr(self, f) is not None]
        if moves and self.node is None:
            what = "`{field}` moves a bone, but `node` names none"
            raise PydanticCustomError("P115", what, {"field": moves[0]})
        if self.node is not None and len(moves) != 1:
            what = "`node` needs either `rotation` or `translation`"
            raise PydanticCustomError("P115", what, {"field": "node"})
        return self


class RigPack(PackModel):
    """A rig: poses of a pose set drive the shapes and bones of a model."""

    kind: Literal["rig"]
    """The kind of pack."""
    poseset: Name
    """The pose set whose poses drive the channels."""
    to: Name | None = None
    """The pose set whose poses are the channels, for a rig from one pose set to another."""
    channels: dict[Text, RigChannel] = Field(min_length=1)
    """Channels by name; `{Left,Right}` in a name stands for two equal channels."""
    names: dict[Text, tuple[Text, ...]] = Field(default={})
    """Other names of a channel in models; `{Left,Right}` as in the channel, `*` for any text."""
    lost: dict[PoseName, Text] = Field(default={})
    """Poses that these channels cannot show, or cannot tell from another pose, and why."""
