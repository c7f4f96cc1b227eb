"""Check a rig against its pose set, and its channels against each other."""

from collections import Counter
from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.base.grouping import grouped
from lipsync_lang.packs.checking.conflicts import path_between
from lipsync_lang.packs.checking.pack_checks import check_home, check_poses
from lipsync_lang.packs.models import PoseSet, RigPack
from lipsync_lang.packs.models.rig_models import channels_of, expanded, paired, stated
from lipsync_lang.packs.yaml.faults import Fault

if TYPE_CHECKING:
    from lipsync_lang.packs.pack import Pack
    from lipsync_lang.packs.yaml.source import Loc


def check_rig(
    rig: "Pack[RigPack]", poseset: PoseSet, posesets: Collection[str], to: PoseSet | None = None
) -> Iterator[Fault]:
    """Check that a rig names poses of its pose set and its own channels only.

    `posesets` are the names of all; the rig drives the pose set `to`, None if that is faulty.
    """
    model = rig.model
    yield from check_home(rig, model.poseset, poseset)
    if model.to is not None and model.to not in posesets:
        yield rig.unknown(("to",), "P203", "pose set", model.to, posesets)
    # a rig is for all models of the set, and some of them have the optional poses
    every = poseset.having(poseset.optional_poses)
    for key, channel in model.channels.items():
        yield from check_poses(rig, ("channels", key, "gains"), channel.gains, every)
    yield from check_poses(rig, ("lost",), model.lost, every)
    yield from _twice(rig)
    yield from _limits(rig)
    yield from _names(rig)
    if to is not None:
        # a bone has a name of the model, not of a pose
        shapes = ((one.key, one.name) for one in stated(model) if one.channel.node is None)
        for key, name in dict.fromkeys(shapes):
            if name not in to.poses:
                yield rig.unknown(("channels", key), "P201", "pose", name, to.poses, key=True)
    yield from _unseen(rig, poseset)


def _twice(rig: "Pack[RigPack]") -> Iterator[Fault]:
    """Check that every channel is stated once, with braces expanded."""
    for field, keys in (("channels", rig.model.channels), ("names", rig.model.names)):
        first: dict[str, str] = {}
        for key in keys:
            for name, count in Counter(expanded(key)).items():
                if name in first or count > 1:
                    what = f"'{name}' appears twice in `{field}`"
                    hint = f"'{first.get(name, key)}' stands for it already"
                    yield rig.fault((field, key), "P205", what, hint, key=True)
                first.setdefault(name, key)


def _limits(rig: "Pack[RigPack]") -> Iterator[Fault]:
    """Check that `at_most` names another channel, and that the limits form no circle."""
    channels = channels_of(rig.model)
    waits = {name: {c.at_most} if c.at_most else set() for name, c in channels.items()}
    for key, ones in grouped((one.key, one) for one in stated(rig.model)).items():
        loc: Loc = ("channels", key, "at_most")
        unknown = {
            one.channel.at_most: one.name
            for one in ones
            if one.channel.at_most not in {None, *channels} - {one.name}
        }
        for limit, name in unknown.items():
            what = f"unknown channel '{limit}'"
            known = [other for other in channels if other != name]
            yield rig.fault(loc, "P214", what, did_you_mean(str(limit), known))
        for one in ones:
            limit = one.channel.at_most
            path = path_between(waits, limit, one.name) if limit and limit != one.name else ()
            if path:
                what = f"channels form a circle: {' -> '.join((one.name, *path))}"
                yield rig.fault(loc, "P206", what, "a channel cannot depend on itself; remove one")
                break


def _names(rig: "Pack[RigPack]") -> Iterator[Fault]:
    channels = channels_of(rig.model)
    for key, spellings in rig.model.names.items():
        meant = expanded(key)
        for name in dict.fromkeys(meant):
            if name not in channels:
                yield rig.unknown(("names", key), "P214", "channel", name, channels, key=True)
        for index, spelling in enumerate(spellings):
            if paired(spelling, len(meant)) is None:
                what = f"'{spelling}' stands for {len(expanded(spelling))} names, but '{key}' for"
                hint = "give both the same choices in braces"
                loc = ("names", key, index)
                yield rig.fault(loc, "P115", f"{what} {len(meant)} channels", hint)


def _unseen(rig: "Pack[RigPack]", poseset: PoseSet) -> Iterator[Fault]:
    """Check that every pose drives a channel or is listed as lost.

    After a misspelt pose name this check would only mislead, and is skipped.
    """
    gains = [channel.gains for channel in rig.model.channels.values()]
    named = {pose for some in gains for pose in some} | {*rig.model.lost}
    if not named <= {*poseset.poses, *poseset.optional_poses}:
        return
    shown = {pose for some in gains for pose, gain in some.items() if gain}
    for pose in poseset.poses:
        if pose not in shown and pose not in rig.model.lost:
            what = f"the rig never shows '{pose}'"
            hint = "drive a channel with it, or give the reason under `lost`"
            yield rig.warning(("channels",), "W311", what, hint, key=True)
