"""Draft of a character from its model, with the best-matching pose set and rig.

The match counts shown poses; output paths are relative to the project folder.

Gains are in channel units per pose weight: shape weight, or degrees for the rotation of a bone.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import Any

from lipsync_lang.authoring.new_pack import (
    WRAP_CHARS,
    PackDraft,
    PackWish,
    check_name,
    from_template,
    place_model,
)
from lipsync_lang.base.errors import LipsyncError, ModelError, PackError, did_you_mean, shortlist
from lipsync_lang.faces.rigs.model import Model, read_model
from lipsync_lang.faces.rigs.read_outs import measured
from lipsync_lang.faces.rigs.recognise import Match, recognise
from lipsync_lang.faces.rigs.shape_matching import folded
from lipsync_lang.packs.finding import FOLDERS, POSESET
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import PoseSet, RigChannel, RigPack
from lipsync_lang.packs.models.rig_models import channels_of, expanded
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.packs.yaml.value_text import on_one_line

MAX_ALTERNATIVES = 3

MIN_LIKE_SHARE = 0.5
"""Smallest share of shown poses for a pose set without doubt."""

UNSEEN_SCALE = 0.05
"""Largest difference from 1 of a dial that nobody sees."""

LEAST_SCALE, MOST_SCALE = 0.6, 1.6
"""Range of dials for a face's own shapes: farther from 1, the shape is another one."""

ABSENT_SHAPE = "the model has no shape for it"
"""Reason for a lost pose without a shape in the model."""

TURN = 15
"""Rotation of a bone in degrees, for the commented example."""

_SIDES = (("Left", "Right"), ("left", "right"), ("LEFT", "RIGHT"), ("L", "R"), ("l", "r"))


@dataclass(frozen=True)
class CharacterWish(PackWish):
    """Request for a new character: its model, with an optional pose set and rig."""

    model: Path
    poseset: str | None = None
    """Name of the pose set; None for the best match."""
    rig: str | None = None
    """Name of a rig of the pose set; None for the best match."""


@dataclass(frozen=True, eq=False)
class CharacterDraft(PackDraft):
    """A drafted character with its match; as text, a message with the next steps."""

    match: Match
    others: tuple[Match, ...]
    rig: str | None
    """Name of the drafted or known rig."""
    dials: Mapping[str, float]
    """Levels of regions by which the mouth opens as far as the pose set expects."""
    model: Model
    summaries: Mapping[Path, str]
    """Summary of each output file."""

    def __str__(self) -> str:
        match = self.match
        values = {
            **vars(self),
            "meshes": len(self.model.meshes),
            "doubts": [*match.found.doubts, *_unlike(match)],
            "absent": [loss.pose for loss in match.losses if not (loss.shown or loss.why)],
            "running": _running(self.path.stem, self.model.path),
            "shown": shown,
            "some": shortlist,
            "asking": _asking,
        }
        return from_template("character_told", **values).removesuffix("\n")

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON output."""
        return {
            "character": self.path.stem,
            "rig": self.rig,
            "dials": dict(self.dials),
            "wrote": [str(path) for path in self.outputs],
            "match": self.match.to_dict(),
            "others": [one.to_dict() for one in self.others],
        }


def draft(library: Library, wanted: CharacterWish, folder: Path = Path()) -> CharacterDraft:
    """Draft a character, under `characters` of the project folder, or raise a LipsyncError."""
    path = folder / FOLDERS["character"] / f"{wanted.name}.yaml"
    check_name(wanted.name)
    there = [path] if path.exists() else library.lookup("character", wanted.name)
    for one in there:
        raise PackError(f"{shown(Path(one))}: already exists; choose another name")
    model = read_model(wanted.model)
    matches = recognise(library, model)
    match = _chosen(library, wanted, model, matches)
    stated, copies = place_model(wanted.model, path)
    # A known rig serves only a model with all of its shapes.
    rig = match.rig if match.complete else wanted.name
    face = library.poseset(match.poseset).model
    # solved targets open each mouth as far as they should
    solved = face.mouth == "solved"
    dials = {} if match.rig or solved else _fitted(model, match, face)
    text = from_template(
        "character", wanted=wanted, match=match, rig=rig, model=stated, dials=dials, solved=solved,
        running=_running(wanted.name, wanted.model),
    )  # fmt: skip
    outputs: dict[Path, bytes | Path] = {path: text.encode()}
    summaries = {path: f"the poses of {match.poseset}" + (f", rig {rig}" if rig else "")}
    if not match.complete:
        rig_path = _new_rig_path(library, match, wanted.name, folder)
        own = [one for one in library.rigs_of(match.poseset) if one.stem == match.rig]
        base: Any = library.load(own[-1], "rig", own[-1].stem).model if own else None
        made = drafted(wanted.name, wanted.heading, match, face, base)
        outputs[rig_path] = rig_text(made, model, match, face).encode()
        count = sum(len(places) for places in match.found.places.values())
        summaries[rig_path] = f"{count} channel{'s' * (count != 1)} for the model"
    summaries |= dict.fromkeys(copies, f"a copy of {wanted.model}")
    best: dict[str, Match] = {}
    for other in matches:
        best.setdefault(other.poseset, other)
    others = tuple(m for m in best.values() if m.poseset != match.poseset and m.enough)
    files, others = {**outputs, **copies}, others[:MAX_ALTERNATIVES]
    return CharacterDraft(path, files, match, others, rig, dials, model, summaries)


def _fitted(model: Model, match: Match, poseset: PoseSet) -> dict[str, float]:
    """Return the level of each region at which the model's mouth opens as far as the pose set's."""
    moved, found = measured(model), {}
    for name, pose in poseset.poses.items():
        # All shapes of a pose open the mouth together.
        shapes = match.found.places.get(name, ())
        own = sum(moved[shape].aperture for shape in shapes if shape in moved)
        if pose.aperture and pose.region and own > 0:
            level = round(min(max(pose.aperture / own, LEAST_SCALE), MOST_SCALE), 2)
            if abs(level - 1) > UNSEEN_SCALE:
                found[pose.region] = level
    return found


def _chosen(
    library: Library, wanted: CharacterWish, model: Model, matches: Sequence[Match]
) -> Match:
    """Return the requested match; by default the best one."""
    if wanted.poseset is not None:
        library.find("poseset", wanted.poseset)
    fitting = [m for m in matches if wanted.poseset in {None, m.poseset}]
    if wanted.rig is not None:
        known = [wanted.poseset] if wanted.poseset else [p.name for p in library.names("poseset")]
        rigs = [path.stem for name in dict.fromkeys(known) for path in library.rigs_of(name)]
        if wanted.rig not in rigs:
            raise PackError(f"unknown rig '{wanted.rig}': {did_you_mean(wanted.rig, rigs)}")
        fitting = [m for m in fitting if m.rig == wanted.rig]
    asked = wanted.poseset is not None or wanted.rig is not None
    found = next((m for m in fitting if asked or m.enough), None)
    if found is not None:
        return found
    who = "no pose set knows"
    if asked:
        named = f"rig '{wanted.rig}'" if wanted.rig else f"pose set '{wanted.poseset}'"
        who = f"{named} knows none of"
    near = f"; the nearest is {fitting[0]} ({_asking(fitting[0])})" if fitting else ""
    raise ModelError(
        f"{wanted.model}: {who} its shapes{near}. It has "
        f"{shortlist(model.shape_names)}. Draft a pose set from them: lipsync-lang posesets new "
        f"{wanted.name} --model {wanted.model}"
    )


def _unlike(match: Match) -> Iterator[str]:
    """Yield a doubt if most of the poses are absent: the set may be that of another creature."""
    if match.shown < MIN_LIKE_SHARE * len(match.poses):
        yield f"the head has {match}, which may be made for another kind of face"


def _asking(match: Match) -> str:
    """Return the command-line options for the selection of a match."""
    return f"--poseset {match.poseset}" + (f" --rig {match.rig}" if match.rig else "")


def _running(name: str, model: Path) -> str:
    """Return an example command; its output file never overwrites the model."""
    same = Path(f"{name}.glb").resolve() == model.resolve()
    return f'lipsync-lang run "Hello" -l LANGUAGE -c {name} -o {name}{"-line" * same}.glb'


def _new_rig_path(library: Library, match: Match, name: str, folder: Path) -> Path:
    """Return the path of a new rig, in a folder that is searched for rigs of the pose set."""
    path = folder / FOLDERS["poseset"] / match.poseset / "rigs" / f"{name}.yaml"
    known = {one.stem: one for one in library.rigs_of(match.poseset)}
    if path.exists() or name in known:
        raise PackError(f"{shown(known.get(name, path))}: already exists; choose another name")
    home = library.find("poseset", match.poseset).parent.parent.parent
    roots = [root.path.resolve() for root in library.roots]
    here = folder.resolve()
    # Rigs are searched beside the pose set that wins, and one found earlier hides this folder.
    if here not in roots or roots.index(home.resolve()) < roots.index(here):
        source = shown(home / FOLDERS["poseset"] / match.poseset / POSESET)
        raise LipsyncError(
            f"the rig of a new character must be beside pose set '{match.poseset}', which is in "
            f"{source}; change to {shown(home)} first"
        )
    return path


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


def rig_text(rig: RigPack, model: Model, match: Match, poseset: PoseSet) -> str:
    """Format a drafted rig as YAML, with the manual tasks in comments."""
    nodes = model.document.get("nodes", ())
    free = [str(node["name"]) for node in nodes if "name" in node and "mesh" not in node]
    regions = {pose: folded(poseset.poses[pose].region) for pose in rig.lost}
    bones = [
        (pose, node, RigChannel(gains={pose: TURN}, node=node, rotation=(1, 0, 0)))
        for pose, region in regions.items()
        for node in free
        if region and region in folded(node)
    ]
    left = wrap(", ".join(match.left), WRAP_CHARS - 4)
    known = {"rig": rig, "model": model.path.name, "left": left, "shown": _channel}
    return from_template("rig", **known, bones=bones[:1])


def _channel(channel: RigChannel) -> str:
    """Format a channel as one line of flow-style YAML."""
    stated = ("gains", "range", "rotation", "translation", "node", "mesh", "at_most")
    values = {name: getattr(channel, name) for name in stated}
    return on_one_line({name: value for name, value in values.items() if value is not None})
