"""Routes of the character: its stated rules, its face in a mix of poses, and its model."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError, ModelError
from lipsync_lang.base.files import write_all
from lipsync_lang.base.files.writing import replace_file
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.face_on_model import find
from lipsync_lang.faces.rigs.model import Model, read_model
from lipsync_lang.faces.rigs.recognise import Match, recognise
from lipsync_lang.packs.finding import FOLDERS, WHOLE_MODELS
from lipsync_lang.performing.performer import Performer
from lipsync_lang.performing.trace import VISIBLE
from lipsync_lang.pipeline.constrain import constrain
from lipsync_lang.pipeline.tables import Tables
from lipsync_lang.resolver.pose_arrays import SOFTNESS_SECONDS
from lipsync_lang.resolver.settings import RANGES
from lipsync_lang.schedules.schedule import AT_REST, Schedule
from lipsync_lang.studio.array_pack import ArrayPack
from lipsync_lang.studio.face_data import face_data
from lipsync_lang.studio.routes.requests import StudioRequest, listed, sent_file
from lipsync_lang.studio.workshop import Workshop

MAX_MIXES = 400
"""Maximum number of mixes of poses in a request, such as one for each pose."""

EDITED_FIELDS = ("constraints", "priority", "contacts", "softness", "motion", "targets", "poses")
"""Fields of a pose set that the character view edits."""

_NOT_IN_A_NAME = re.compile(r"[^A-Za-z0-9_-]+")


def character(workshop: Workshop, _: StudioRequest) -> Json:
    """Return the pose set as in its file, and the values in effect."""
    performer, library = workshop.performer, workshop.library()
    compiled = performer.compiled
    poseset = library.poseset(compiled.poseset)
    rule = {p: n for n, c in poseset.model.contacts.items() for p in c.phonemes}
    common = library.common().model
    who = library.character(compiled.character).model
    phonemes = dict.fromkeys((*compiled.counted, *compiled.shades, *poseset.model.targets))
    motion = asdict(performer.motion)
    # the file as it is, unless it states only what differs from its parents
    alone, model = not poseset.sources[1:], poseset.model
    whole = poseset.source.data if alone else model.model_dump(mode="json", exclude_unset=True)
    return {
        "poseset": compiled.poseset,
        "title": poseset.model.title,
        "file": workshop.shown(poseset.path),
        "own": workshop.own(poseset.path),
        "stated": {key: whole.get(key) for key in EDITED_FIELDS},
        "phonemes": [
            {
                "name": name,
                "title": getattr(common.phonemes.get(name), "title", ""),
                "example": getattr(common.phonemes.get(name), "example", None) or "",
                "like": compiled.shades.get(name, ""),
                "contact": rule.get(name, ""),
                "replaced": name in who.targets,
            }
            for name in phonemes
        ],
        "mouths": [
            {
                "name": name,
                "own": name in who.mouths,
                "steps": [one.model_dump(exclude_none=True) for one in mouth],
            }
            for name, mouth in (common.mouths() | who.mouths).items()
            if name in phonemes
        ],
        "motion": {name: None if value == np.inf else value for name, value in motion.items()},
        "ranges": {name: list(span) for name, span in RANGES.items()},
        "softness": SOFTNESS_SECONDS,
        "rig": None if compiled.rig is None else compiled.rig["name"],
        "model": None if compiled.model is None else Path(compiled.model).name,
    }


def pose(workshop: Workshop, request: StudioRequest) -> Json:
    """Convert mixes of poses to channels of the model, and list the rules that apply to them.

    Each of `mixes` is an object of poses and weights; `within` keeps them within the constraints.
    """
    performer, within = workshop.performer, request.body.get("within") is True
    mixes = listed(request.body.get("mixes"), "mixes")
    if len(mixes) > MAX_MIXES:
        raise LipsyncError(f"give at most {MAX_MIXES} mixes at once")
    for mix in mixes:
        if not isinstance(mix, dict):
            raise LipsyncError("a mix must be an object of poses and weights")
        for name, one in mix.items():
            if name not in performer.poses or type(one) not in {int, float} or not 0 <= one <= 1:
                raise LipsyncError(
                    f"'{name}' must be a pose of this face with a weight from 0 to 1"
                )
    rows = [[float(mix.get(name, 0.0)) for name in performer.poses] for mix in mixes]
    weights = np.array(rows).reshape(-1, len(performer.poses)).T
    tables = performer.compiled.tables
    tables = tables.papers if performer.motion.thresholds == "paper" else tables
    kept = constrain(weights, tables.binding, tables.at_most) if within else weights
    channels = performer.held_channels(kept.T)
    return {
        "rows": [
            {
                "channels": channels[number].tolist(),
                "weights": kept[:, number].tolist(),
                "acts": list(_acting(performer, tables, weights[:, number], kept[:, number])),
            }
            for number in range(weights.shape[1])
        ]
    }


def _acting(performer: Performer, tables: Tables, wanted: Floats, kept: Floats) -> Iterator[Json]:
    """Yield the rule that lowers each pose."""
    names = performer.poses
    for number in np.flatnonzero(wanted - kept > VISIBLE).tolist():
        rules = [
            (threshold - kept[high], high, f"together at most {threshold:g}")
            for low, high, threshold in tables.caps
            if low == number
        ]
        bounds = [
            (kept[other], other, "never above it") for low, other in tables.at_most if low == number
        ]
        _, other, told = min(rules + bounds)
        yield {"pose": names[number], "other": names[other], "why": told}


def own(workshop: Workshop, _: StudioRequest) -> Json:
    """Copy the pose set into the project for edits, and open the pair again."""
    from lipsync_lang.authoring.copies import copy_poseset

    name = workshop.performer.compiled.poseset
    home = workshop.project / FOLDERS["poseset"] / name
    if any(path.is_relative_to(home) for path in workshop.desk.contents):
        raise LipsyncError("save the unsaved edits first, so that the copy contains them")
    written = copy_poseset(workshop.library(), name, workshop.project)
    workshop.open(workshop.language, workshop.character)
    return {"wrote": [workshop.shown(path) for path in written], "state": workshop.state()}


def model(workshop: Workshop, request: StudioRequest) -> Json:
    """Put a model beside the character's pack in the project, and measure its fit.

    The answer has `name`, the value of the character's `model`. If another rig of the pose set
    shows more poses, the answer is its `offer`, and nothing is written; the query `rig` accepts it
    by its name, or declines it with an empty one.
    """
    chosen = request.query.get("rig")
    with _sent_model(request) as path:
        better = None if chosen == "" else _better_rig(workshop, read_model(path))
        if better is not None and better.rig != chosen:
            shown = {"rig": better.rig, "shown": better.shown, "poses": len(better.poses)}
            return {"offer": shown}
        if better is None:
            names, missing = _channels(workshop.performer, path)
        else:
            _draw_match(better, path)
            missing = list(better.missing)
            names = [*better.found.places, *missing]
        content = path.read_bytes()
    pack, _ = workshop.editable("character")
    target = pack.with_name(path.name)
    workshop.refuse_link(target)
    if not target.exists():
        target.parent.mkdir(parents=True, exist_ok=True)
        write_all({target: lambda stream: stream.write(content)}, durable=True)
    elif target.read_bytes() != content:
        raise LipsyncError(
            f"{target.name}: the project has another model with this name; rename your file"
        )
    return {
        "name": target.name,
        "shown": len(names) - len(missing),
        "channels": len(names),
        "missing": missing,
    }


def _better_rig(workshop: Workshop, sent: Model) -> Match | None:
    """Return the rig of the pose set that shows more poses on a model than the character's own."""
    compiled = workshop.performer.compiled
    now = None if compiled.rig is None else compiled.rig["name"]
    fits = [one for one in recognise(workshop.library(), sent) if one.poseset == compiled.poseset]
    own = max((one.shown for one in fits if one.rig == now), default=0)
    found = next((one for one in fits if one.rig is not None and one.enough), None)
    return found if found is not None and found.rig != now and found.shown > own else None


def _channels(performer: Performer, path: Path) -> tuple[list[str], list[str]]:
    """Return the channels of a character, and those that a drawable model lacks."""
    sent = read_model(path, bones=performer.compiled.rig is not None)
    animation = replace(performer.rigged(performer.perform(AT_REST)), model=path)
    _draw(animation)
    found = find(animation.columns, sent)
    names = [channel.name for channel in animation.columns]
    return names, [name for name in names if name not in found.places]


def drafted(workshop: Workshop, request: StudioRequest) -> Json:
    """Draft a character from a model, with the pose set and the rig that fit it best."""
    from lipsync_lang.authoring.character_draft import CharacterWish, draft

    with _sent_model(request) as path:
        name = request.query.get("as", "") or _NOT_IN_A_NAME.sub("-", path.stem).strip("-")
        made = draft(workshop.library(), CharacterWish(name, path), workshop.project)
        _draw_match(made.match, path)
        made.write()
    workshop.open(workshop.language, workshop.character)  # to find the new packs
    return {
        "name": name,
        "match": str(made.match),
        "wrote": [workshop.shown(path) for path in made.outputs],
        "doubts": list(made.match.found.doubts),
    }


@contextmanager
def _sent_model(request: StudioRequest) -> Iterator[Path]:
    """Write a sent model into a temporary folder, which messages about the model leave out."""
    with TemporaryDirectory() as folder:
        path = sent_file(request, Path(folder))
        if not path.name.lower().endswith(WHOLE_MODELS):
            raise LipsyncError(
                f"{path.name}: export the model as GLB, which contains all parts in one file"
            )
        stem = _NOT_IN_A_NAME.sub("-", path.stem).strip("-") or "model"
        model = path.with_name(f"{stem}.glb")
        # The name becomes a value in the character's pack, and a word of commands.
        replace_file(path, model)
        try:
            yield model
        except LipsyncError as error:
            # the folder is the studio's own, and says nothing to the user
            raise LipsyncError(str(error).replace(f"{folder}/", "")) from None


def _draw_match(match: Match, path: Path) -> None:
    """Draw a model with the shapes of a match once; raise ModelError if it cannot be drawn."""
    shapes = [shape for own in match.found.places.values() for shape in own]
    times, still = np.array([0, 0.1]), np.zeros((2, len(shapes)))
    _draw(Animation(times, tuple(shapes), still, 10.0, Schedule(("_",), times), model=path))


def _draw(animation: Animation) -> None:
    """Draw a model once; raise ModelError if it cannot be drawn."""
    face = face_data(animation, ArrayPack())
    if "parts" not in face:
        raise ModelError("; ".join(face["unshown"]))
