"""Draft of a rig for one model: its matching shapes and bones, under the names of the model.

Gains are in channel units per pose weight: shape weight, or degrees for the rotation of a bone.
"""

from collections.abc import Iterator, Mapping
from textwrap import wrap

from lipsync_lang.authoring.new_pack import WRAP_CHARS, head
from lipsync_lang.faces.rigs.model import Model
from lipsync_lang.faces.rigs.recognise import Match
from lipsync_lang.faces.rigs.shape_matching import folded
from lipsync_lang.packs.models import PoseSet, RigChannel, RigPack
from lipsync_lang.packs.models.rig_channels import channels_of, expanded
from lipsync_lang.packs.yaml.value_text import as_scalar, on_one_line

ABSENT_SHAPE = "the model has no shape for it"
"""Reason for a lost pose without a shape in the model."""

TURN = 15
"""Rotation of a bone in degrees, for the commented example."""

_SIDES = (("Left", "Right"), ("left", "right"), ("LEFT", "RIGHT"), ("L", "R"), ("l", "r"))


def drafted(name: str, title: str, match: Match, poseset: PoseSet, rig: RigPack | None) -> RigPack:
    """Draft a rig of the channels that match a model; without a rig, of the poses themselves."""
    own = {pose: RigChannel(gains={pose: 1}) for pose in match.poses}
    channels = own if rig is None else channels_of(rig)
    found = dict(_channels(match, channels))
    shown = {pose for one in found.values() for pose, gain in one.gains.items() if gain}
    known = rig.lost if rig is not None else {}
    lost = {pose: known.get(pose, ABSENT_SHAPE) for pose in poseset.poses if pose not in shown}
    return RigPack(
        kind="rig",
        format=1,
        name=name,
        title=title,
        poseset=poseset.name,
        channels=_paired(found),
        lost={**{pose: why for pose, why in known.items() if pose in poseset.poses}, **lost},
    )


def _channels(match: Match, channels: Mapping[str, RigChannel]) -> Iterator[tuple[str, RigChannel]]:
    """Yield a channel for every driven shape, and for each bone under the name of its channel."""
    found = match.found.places
    places = {n: (n,) if channels[n].node is not None else own for n, own in found.items()}
    for name, channel in channels.items():
        # A rig would expand a name with braces to several channels.
        plain = [shape for shape in places.get(name, ()) if expanded(shape) == (shape,)]
        limits = places.get(channel.at_most, ()) if channel.at_most is not None else ()
        for number, shape in enumerate(plain):
            sharing = [channels[other].gains for other in match.found.shared.get(shape, (name,))]
            # The mean over the sharing channels, because their sum would overdrive the shape.
            poses = dict.fromkeys(pose for gains in sharing for pose in gains)
            gains = {p: sum(g.get(p, 0) for g in sharing) / len(sharing) for p in poses}
            limit = limits[min(number, len(limits) - 1)] if limits else None
            yield shape, channel.model_copy(update={"gains": gains, "at_most": limit})


def _paired(channels: Mapping[str, RigChannel]) -> dict[str, RigChannel]:
    """Merge left and right channels with equal settings into one braced name."""
    made: dict[str, RigChannel] = {}
    done: set[str] = set()
    for name, channel in channels.items():
        if name in done:
            continue
        key = name
        for side, pair in ((one, sides) for sides in _SIDES for one in sides):
            start, found, end = name.rpartition(side)
            braced, both = f"{start}{{{','.join(pair)}}}{end}", [start + one + end for one in pair]
            left, right = map(channels.get, both)
            # Other braces in a name would expand as well.
            if found and left is not None and left == right and [*expanded(braced)] == both:
                key = braced
                break
        made[key] = channel
        done.update(expanded(key))
    return made


def rig_lines(rig: RigPack, model: Model, match: Match, poseset: PoseSet) -> Iterator[str]:
    """Format a drafted rig as YAML, with the manual tasks in comments."""
    yield f"# The poses of {rig.poseset} on {model.path.name}: a draft. It runs as it is."
    yield "# A gain is shape weight per pose weight; a shape may have several, also negative ones."
    title, poses_of = as_scalar(rig.title), as_scalar(rig.poseset)
    yield from head("rig", as_scalar(rig.name), title=title, poseset=poses_of)
    yield "channels:"
    yield from (f"  {as_scalar(name)}: {_channel(one)}" for name, one in rig.channels.items())
    if rig.lost:
        yield "# Add each of these poses to a shape above that looks similar, or leave it lost"
        yield "lost:"
        yield from (f"  {as_scalar(pose)}: {as_scalar(why)}" for pose, why in rig.lost.items())
    nodes = model.document.get("nodes", ())
    free = [str(node["name"]) for node in nodes if "name" in node and "mesh" not in node]
    for pose in rig.lost:
        region = folded(poseset.poses[pose].region)
        node = next((node for node in free if region and region in folded(node)), None)
        if node is not None:
            turned = RigChannel(gains={pose: TURN}, node=node, rotation=(1, 0, 0))
            yield f"# A bone may show '{pose}'. Degrees, about x; try other axes and signs:"
            yield f"#   {as_scalar(node)}: {_channel(turned)}"
            break
    if match.left:
        yield "# Unused shapes:"
        yield from (f"#   {line}" for line in wrap(", ".join(match.left), WRAP_CHARS - 4))


def _channel(channel: RigChannel) -> str:
    """Format a channel as one line of flow-style YAML."""
    stated = ("gains", "range", "rotation", "translation", "node", "mesh", "at_most")
    values = {name: getattr(channel, name) for name in stated}
    return on_one_line({name: value for name, value in values.items() if value is not None})
