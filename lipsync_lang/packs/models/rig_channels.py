"""The channels of a rig one by one: braces written out, spellings gathered."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from lipsync_lang.packs.models import PoseSet, RigChannel, RigPack
from lipsync_lang.packs.models.braces import expanded, paired


class Stated(NamedTuple):
    """One channel, and the key under which a rig states it."""

    key: str
    name: str
    channel: RigChannel
    """Its `at_most` written out too."""


def stated(rig: RigPack) -> Iterator[Stated]:
    """Yield every channel in the rig's order; one that is stated twice comes twice."""
    for key, channel in rig.channels.items():
        names = expanded(key)
        limits = paired(channel.at_most, len(names)) if channel.at_most is not None else None
        for name, limit in zip(names, limits or [()] * len(names), strict=True):
            fits = len(limit) == 1
            one = channel.model_copy(update={"at_most": limit[0]}) if fits else channel
            yield Stated(key, name, one)


def channels_of(rig: RigPack) -> dict[str, RigChannel]:
    """Return each channel by name; the first of two alike."""
    found: dict[str, RigChannel] = {}
    for one in stated(rig):
        found.setdefault(one.name, one.channel)
    return found


def names_of(rig: RigPack) -> dict[str, tuple[str, ...]]:
    """Return how models spell each channel that the rig has spellings of."""
    found: dict[str, dict[str, None]] = {}
    for key, spellings in rig.names.items():
        channels = expanded(key)
        for spelling in spellings:
            pairs = paired(spelling, len(channels)) or [(spelling,)] * len(channels)
            for channel, own in zip(channels, pairs, strict=True):
                found.setdefault(channel, {}).update(dict.fromkeys(own))
    return {channel: tuple(own) for channel, own in found.items()}


def plain_channels(rig: RigPack, to: PoseSet | None) -> list[dict[str, Any]]:
    """Return every channel as plain data, spelled as the pose set it belongs to is too."""
    known = pose_names(to) if to is not None else {}
    own = names_of(rig)
    return [
        {
            "name": channel,
            "names": list(dict.fromkeys((*own.get(channel, ()), *known.get(channel, ())))),
            **stated.model_dump(mode="json"),
        }
        for channel, stated in channels_of(rig).items()
    ]


def pose_names(poseset: PoseSet) -> dict[str, list[str]]:
    """Return how models spell each pose otherwise, braces written out."""
    return {
        pose: list(dict.fromkeys(name for spelt in stated.names for name in expanded(spelt)))
        for pose, stated in poseset.poses.items()
    }
