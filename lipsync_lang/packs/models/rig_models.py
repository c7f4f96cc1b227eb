"""Models of rigs: packs that drive the shapes and bones of a model."""

import re
from collections.abc import Iterator, Mapping
from itertools import product
from math import prod
from typing import Any, Literal, NamedTuple, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lipsync_lang.packs.models.fields import Axis, Name, PackModel, PoseName, Strict, Text, Vector
from lipsync_lang.packs.models.pose_models import PoseSet


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


# `mouthSmile{Left,Right}` stands for two names, two braces for four. Malformed braces are ordinary
# characters, because models name their shapes as they like.
MAX_EXPANDED_NAMES = 256
"""Most names one pattern may expand to; beyond, its braces are ordinary characters."""

_BRACE = re.compile(r"\{([^{},]+(?:,[^{},]+)+)\}")


def expanded(name: str) -> tuple[str, ...]:
    """Return the names that a pattern expands to; a name without braces gives itself.

    The last brace varies fastest: `a{1,2}{x,y}` gives a1x, a1y, a2x, a2y.
    """
    parts = _BRACE.split(name)
    # a split by a pattern with a group gives the text between and the groups in turn
    fixed, choices = parts[::2], [inner.split(",") for inner in parts[1::2]]
    stray = any(mark in part for part in fixed for mark in "{}")
    if not choices or stray or prod(map(len, choices)) > MAX_EXPANDED_NAMES:
        return (name,)
    return tuple(
        fixed[0] + "".join(a + b for a, b in zip(chosen, fixed[1:], strict=True))
        for chosen in product(*choices)
    )


def paired(name: str, count: int) -> tuple[tuple[str, ...], ...] | None:
    """Distribute the names of a pattern over others, a tuple for each; None if they do not fit.

    Equal numbers pair one to one. A single name goes to each of the others. If `count` is 1, all
    names go to the one.
    """
    names = expanded(name)
    if len(names) == count:
        return tuple((one,) for one in names)
    return (names,) * count if 1 in {len(names), count} else None


class NamedChannel(NamedTuple):
    """A channel with the key that states it in the rig."""

    key: str
    name: str
    channel: RigChannel
    """The channel; the braces of its `at_most` are expanded too."""


def stated(rig: RigPack) -> Iterator[NamedChannel]:
    """Yield every channel in the rig's order; a channel stated twice is yielded twice."""
    for key, channel in rig.channels.items():
        names = expanded(key)
        limits = paired(channel.at_most, len(names)) if channel.at_most is not None else None
        # a limit that does not fit stays as it is stated, for the check that reports it
        for name, limit in zip(names, limits or [()] * len(names), strict=True):
            fits = len(limit) == 1
            one = channel.model_copy(update={"at_most": limit[0]}) if fits else channel
            yield NamedChannel(key, name, one)


def channels_of(rig: RigPack) -> dict[str, RigChannel]:
    """Return channels by name; of two with one name, the first."""
    found: dict[str, RigChannel] = {}
    for one in stated(rig):
        found.setdefault(one.name, one.channel)
    return found


def names_of(rig: RigPack) -> dict[str, tuple[str, ...]]:
    """Map channels to their other names in models; channels without any are left out."""
    found: dict[str, dict[str, None]] = {}
    for key, spellings in rig.names.items():
        channels = expanded(key)
        for spelling in spellings:
            pairs = paired(spelling, len(channels)) or [(spelling,)] * len(channels)
            for channel, own in zip(channels, pairs, strict=True):
                found.setdefault(channel, {}).update(dict.fromkeys(own))
    return {channel: tuple(own) for channel, own in found.items()}


def plain_channels(rig: RigPack, to: PoseSet | None) -> list[dict[str, Any]]:
    """Return every channel as plain data; its names include those of the pose in `to`."""
    known = pose_names(to.poses) if to is not None else {}
    own = names_of(rig)
    return [
        {
            "name": channel,
            "names": list(dict.fromkeys((*own.get(channel, ()), *known.get(channel, ())))),
            **stated.model_dump(mode="json"),
        }
        for channel, stated in channels_of(rig).items()
    ]


def pose_names(poses: Mapping[str, Any]) -> dict[str, list[str]]:
    """Map each pose, also of postures and gestures, to its other names in models."""
    return {
        pose: list(dict.fromkeys(name for spelt in stated.names for name in expanded(spelt)))
        for pose, stated in poses.items()
    }
