"""Draft of a pose set from names of poses, shapes of a model, or poses of another pose set.

A draft is valid without manual edits. A pose that matches a known pose set inherits its targets.
Without any match, the targets are at rest, or on request a heuristic assignment of one class of
sounds per pose. Weights are from 0 to 1; the speed limit is in weight per second.

Lengths are in lines and in characters per line.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from textwrap import wrap
from typing import Any

from lipsync_lang.authoring.new_pack import (
    WRAP_CHARS,
    NewFiles,
    PackDraft,
    PackWish,
    check_name,
    from_template,
    place_model,
)
from lipsync_lang.base.errors import LipsyncError, PackError
from lipsync_lang.base.grouping import grouped
from lipsync_lang.faces.rigs.channel import bare
from lipsync_lang.faces.rigs.face_on_model import FaceOnModel
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.faces.rigs.shape_matching import placed
from lipsync_lang.packs import models
from lipsync_lang.packs.finding import FOLDERS, POSESET
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import Phonemes, PoseSet
from lipsync_lang.packs.models.pose_models import NO_THRESHOLD
from lipsync_lang.packs.models.rig_models import pose_names
from lipsync_lang.packs.yaml.value_text import as_scalar, on_one_line
from lipsync_lang.pipeline.motion import PRESETS
from lipsync_lang.resolver.solving import solved_face

STRONG = 0.8
"""Weight of a guessed pose at the sounds assigned to it."""

WEAK_WEIGHT = 0.3
"""Weight of the first guessed pose at unassigned sounds."""

SHUT = 0.1
"""Ceiling of the first guessed pose at closure sounds."""

RESERVED_TARGET_KEYS = frozenset({"dominance", "status", "weights"})
"""Reserved keys of a target, excluded as pose names."""

WEIGHT_PLACES = 3
"""Places of the weights of a drafted target."""

MAX_POSE_NAME_CHARS = 120

MAX_SCREEN_LINES = 90
"""Maximum number of lines before a denser layout is used."""


@dataclass(frozen=True)
class PoseSetWish(PackWish):
    """Request for a new pose set: pose names, a model or a known set, at least one of them."""

    poses: Sequence[str] = ()
    model: Path | None = None
    """Path of a model; its shapes are the poses if no names are given."""
    like: str | None = None
    """Pose set for the targets; its poses are used if neither names nor shapes are given."""
    guess: bool = False
    """Assign sounds to unknown poses instead of targets at rest."""
    solve: bool = False
    """Solve the targets on the model, so that they give the mouth of each sound there."""


@dataclass(frozen=True, eq=False)
class PoseSetDraft(PackDraft):
    """A drafted pose set with its summary; as text, a message with the next steps."""

    summary: str

    def __str__(self) -> str:
        name = self.path.parent.name
        copied = "".join(f"wrote {path}, a copy\n" for path in [*self.outputs][1:])
        return (
            f"wrote {self.path}: {self.summary}\n{copied}"
            f"next: look at its targets, then\n"
            f'  lipsync-lang run "Hello" -l LANGUAGE -c {name} -o {name}.html\n'
            f"  lipsync-lang validate {self.path}"
        )


def draft(library: Library, wanted: PoseSetWish, folder: Path = Path()) -> PoseSetDraft:
    """Draft a pose set, under `posesets` of the project folder, or raise a LipsyncError."""
    path = folder / FOLDERS["poseset"] / wanted.name / POSESET
    check_name(wanted.name, path)
    if wanted.name in {found.name for found in library.names("poseset")}:
        raise PackError(f"there is a pose set '{wanted.name}' already; choose another name")
    if not wanted.poses and wanted.model is None and wanted.like is None:
        what = "a new pose set needs a source: the names of its poses, --model or --like"
        raise LipsyncError(what)
    sets = _sets(library, wanted.like)
    shapes = read_model(wanted.model).shape_names if wanted.model is not None else ()
    names = list(dict.fromkeys(wanted.poses or shapes or sets[0].poses))
    for name in names:
        fits = name == name.strip() and name.isprintable() and 0 < len(name) <= MAX_POSE_NAME_CHARS
        if not fits or name in RESERVED_TARGET_KEYS:
            raise LipsyncError(f"{name!r} cannot be the name of a pose; choose another name")
    common, sets = library.common().model, [one.having(one.optional_poses) for one in sets]
    made, why, origin = _made(names, sets, common, guess=wanted.guess)
    if wanted.solve:
        made, origin = _solved(made, wanted.model, common), f"{origin}, solved on the model"
    left = [name for name in names if name not in made.poses]
    stated, copies = place_model(wanted.model, path) if wanted.model is not None else (None, {})
    own = {"name": wanted.name, "title": wanted.heading, "model": stated}
    made = made.model_copy(update=own)
    absent = [name for name in made.poses if shapes and name not in shapes]
    said = [
        f"{len(made.poses)} pose{'s' * (len(made.poses) != 1)}, {origin}",
        *([f"{len(left)} unused, in a comment"] if left else ()),
        *([f"the model has no shape called {', '.join(absent)}"] if absent else ()),
    ]
    lines = poseset_lines(made, common, why, left)
    outputs: NewFiles = {path: "\n".join([*lines, ""]).encode(), **copies}
    return PoseSetDraft(path, outputs, "; ".join(said))


def solve_looks(library: Library, name: str, model: Path | None) -> PackDraft:
    """Solve the looks of a pose set on a model: the file `targets.yaml`, which the set extends.

    The looks stay as they are, so a second run gives the same weights.

    Raises
    ------
    LipsyncError
        The set states no looks, is no part of this folder, or somebody wrote the file by hand.
    """
    pack, common = library.poseset(name), library.common().model
    made, path = pack.model, pack.path.resolve().with_name("targets.yaml")
    optional = (*made.optional_poses,)
    if not made.looks:
        what = "states no looks; call the targets that are to be solved `looks`"
        raise PackError(f"{pack.path}: {what}")
    if not path.is_relative_to(Path.cwd()):
        raise PackError(f"{pack.path}: lies outside this folder; copy the pose set to posesets/")
    path = path.relative_to(Path.cwd())
    head = f"# Targets of {name}, solved on "
    if path.exists() and not path.read_bytes().startswith(head.encode()):
        raise PackError(f"{path}: was written by hand, so it stays; move it away first")
    lines = [
        f"{head}{model and model.name}: the face at each sound without a model.",
        "# Change the looks, and write this file again:",
        f"# lipsync-lang posesets solve {name} --model {model and model.name}",
        "kind: poseset", "format: 1", "name: targets", *_poses(made, {}, packed=True),
        f"optional_poses: {on_one_line({pose: {} for pose in optional})}", "targets:",
        *_targets(_solved(made.having(optional), model, common), common, packed=True), "",
    ]  # fmt: skip
    count = f"{len(made.looks)} targets, solved on the model"
    return PoseSetDraft(path, {path: "\n".join(lines).encode()}, count)


def _solved(made: models.PoseSet, path: Path | None, common: models.Phonemes) -> models.PoseSet:
    """Return a pose set whose targets are solved on a model."""
    if path is None:
        raise LipsyncError("targets are solved on a model; name it with --model")
    shown = FaceOnModel.of(made, read_model(path))
    shown.refuse_shut()
    face = solved_face(shown, common.mouths())
    if face is None:
        what = "its mouth cannot be measured, so no target is solved on it; leave out --solve"
        raise LipsyncError(f"{path}: {what}")
    targets = {**made.targets, **made.looks, **face.targets}
    return made.model_copy(update={"targets": targets})


def _sets(library: Library, like: str | None) -> list[models.PoseSet]:
    """Return the candidate pose sets for known targets."""
    if like is not None:
        return [library.poseset(like).model]
    found = []
    for name in dict.fromkeys(one.name for one in library.names("poseset")):
        try:
            found.append(library.poseset(name).model)
        except PackError:  # An invalid pack is the concern of `validate`, not of a draft.
            continue
    return found or [_bare({})]


def _made(
    names: Sequence[str], sets: Sequence[models.PoseSet], common: models.Phonemes, *, guess: bool
) -> tuple[models.PoseSet, dict[str, str], str]:
    """Return a pose set with targets, its comments by pose, and the origin of the targets."""
    # Of equally good sets, `max` keeps the first.
    known, called = max(((s, _called(names, s)) for s in sets), key=lambda pair: len(pair[1]))
    if called:
        why = {name: f"as {as_scalar(pose)}" for name, pose in called.items() if name != pose}
        why[""] = f"Poses move as in pose set '{known.name}' until you change them."
        return with_poses_of(known, called, common), why, f"with the targets of {known.name}"
    if not guess:
        what = (
            "No pose set knows these poses, so every target is at rest. Give each sound its poses, "
            "such as {NAME: 0.8}, or draft again with --guess to distribute the sounds."
        )
        origin = "all at rest until you give them targets, or use --guess"
        targets = {label: (models.PhonemeTarget(weights={}),) for label in common.base}
        return _bare(dict.fromkeys(names, models.Pose()), targets=targets), {"": what}, origin
    made = guessed(names[: len(common.base)], common)
    kinds: dict[str, dict[str, None]] = {}
    for label, (target,) in made.targets.items():
        kind = common.phonemes[label].sound if label in common.phonemes else None
        strong = (pose for pose, weight in target.weights.items() if weight == STRONG)
        kinds.setdefault(kind or "other", {}).update(dict.fromkeys(strong))
    told = ", ".join(f"{kind} {' '.join(poses)}" for kind, poses in kinds.items() if poses)
    why = {"": f"No pose set knows these poses: a first guess by sounds ({told})."}
    return made, why, "with guessed targets"


def _called(names: Sequence[str], known: models.PoseSet) -> dict[str, str]:
    """Map names to matching poses of a known set; poses without positive weights are excluded."""
    steps = [target for targets in known.targets.values() for target in targets]
    moved = {pose for step in steps for pose, weight in step.weights.items() if weight > 0}
    poses = tuple(pose for pose in known.poses if pose in moved)
    called: dict[str, str] = {}
    found = placed(bare(poses, pose_names(known.poses)), names).shapes
    for number, shapes in sorted(found.items()):
        for name in shapes:
            called.setdefault(name, poses[number])
    return {name: called[name] for name in names if name in called}


def _bare(poses: Mapping[str, models.Pose], **fields: Any) -> models.PoseSet:
    """Return a pose set without a name, by default with the speed limit of the default preset."""
    fields.setdefault("motion", models.MotionFields(speed_limit=PRESETS["default"].speed_limit))
    return models.PoseSet.model_construct(
        kind="poseset", format=1, name="", poses=dict(poses), **fields
    )


def with_poses_of(
    known: models.PoseSet, called: Mapping[str, str], common: models.Phonemes
) -> models.PoseSet:
    """Return a pose set with some poses of another; `called` maps new names to old ones."""
    new = grouped((pose, name) for name, pose in called.items())

    def renamed(values: Mapping[str, float]) -> dict[str, float]:
        return {name: value for pose, value in values.items() for name in new.get(pose, ())}

    contacts = {
        name: models.ContactRule(
            phonemes=rule.phonemes, floor=renamed(rule.floor), ceiling=renamed(rule.ceiling)
        )
        for name, rule in known.contacts.items()
    }
    rest = (models.PhonemeTarget(),)
    targets: dict[str, Sequence[models.PhonemeTarget]] = dict.fromkeys(common.base, rest)
    for label, steps in known.targets.items():
        moved = []
        for step in steps:
            own = {"weights": renamed(step.weights), "dominance": renamed(step.dominance)}
            moved.append(step.model_copy(update=own))
        targets[label] = tuple(moved if any(step.weights for step in moved) else moved[:1])
    measures = {name: renamed(gains) for name, gains in known.measures.items()}
    # The motion states what differs from the default preset, and always the speed limit.
    usual = {**asdict(PRESETS["default"]), "speed_limit": None}
    motion: dict[str, Any] = {"speed_limit": PRESETS["default"].speed_limit}
    motion |= known.motion.model_dump(exclude_none=True)
    unusual = {name: value for name, value in motion.items() if value != usual.get(name)}
    # The spellings of a pose in models go, because they are specific to its old name.
    old = {name: known.poses[pose] for name, pose in called.items()}
    poses = {name: models.Pose(title=pose.title, region=pose.region) for name, pose in old.items()}
    return _bare(
        poses,
        constraints=_constraints(known.constraints, new),
        priority=tuple(name for pose in known.priority for name in new.get(pose, ())),
        contacts={name: c for name, c in contacts.items() if c.floor or c.ceiling},
        motion=models.MotionFields(**unusual),
        targets=targets,
        measures={name: gains for name, gains in measures.items() if gains},
    )


def _constraints(known: models.Constraints, new: Mapping[str, Sequence[str]]) -> models.Constraints:
    pairs: list[models.Threshold | models.AtMost] = []
    for pair in known.pairs:
        if isinstance(pair, models.Threshold):
            one, other = (new.get(pose, ()) for pose in pair.between)
            between = product(one, other)
            pairs += [models.Threshold(between=both, threshold=pair.threshold) for both in between]
        else:
            one, other = new.get(pair.pose, ()), new.get(pair.at_most, ())
            pairs += [models.AtMost(pose=a, at_most=b) for a, b in product(one, other)]
    return models.Constraints(default=known.default, pairs=tuple(pairs))


def guessed(poses: Sequence[str], common: models.Phonemes) -> models.PoseSet:
    """Return a heuristic pose set for unknown poses, with one class of sounds per pose.

    The first pose gets the largest class of sounds. Sounds whose mouth is shut have weight 0 and a
    ceiling for the first pose.
    """
    first = poses[0]
    mouths = {label: one.mouth for label, one in common.phonemes.items() if one.mouth}
    shutting = [n for n in common.base if n in mouths and not any(m.aperture for m in mouths[n])]
    sounds = {label: one.sound for label, one in common.phonemes.items()}
    kinds = grouped((sounds.get(label), label) for label in common.base)
    groups = sorted(kinds.values(), key=len, reverse=True)
    shares = [[pose] for pose in poses[: len(groups)]]
    for pose in poses[len(groups) :]:  # surplus poses split the largest shares
        most = max(range(len(shares)), key=lambda n: len(groups[n]) / len(shares[n]))
        shares[most].append(pose)
    dealt = {
        label: share[number * len(share) // len(group)]
        for group, share in zip(groups, shares, strict=False)
        for number, label in enumerate(group)
    }
    targets = {}
    for label in common.base:
        weights = {dealt[label]: STRONG} if label in dealt else {first: WEAK_WEIGHT}
        shut = {first: 0.0} if label in shutting else {}
        targets[label] = (models.PhonemeTarget(weights={**weights, **shut}),)
    contacts = {"closure": models.ContactRule(phonemes=tuple(shutting), ceiling={first: SHUT})}
    still = dict.fromkeys(poses, models.Pose())
    return _bare(still, contacts=contacts if shutting else {}, targets=targets)


def poseset_lines(
    model: PoseSet, common: Phonemes, why: Mapping[str, str], left: Sequence[str] = ()
) -> list[str]:
    """Format a pose set as YAML in the most spacious layout within the line limit.

    `common` are common phonemes, for the titles of sounds; `why` are comments by pose, with the
    general one under ""; `left` are unused names, listed in a comment.
    """
    lines: list[str] = []
    for packed, dense in ((False, False), (True, False), (True, True)):
        lines = _text(model, common, why, left, packed=packed).removesuffix("\n").split("\n")
        lines = [line for line in lines if line or not dense]
        if len(lines) <= MAX_SCREEN_LINES:
            break
    return lines


def _text(
    model: PoseSet, common: Phonemes, why: Mapping[str, str], left: Sequence[str], *, packed: bool
) -> str:
    constraints = model.constraints
    contacts = {}
    for title, one in model.contacts.items():
        parts = {"phonemes": one.phonemes, "floor": one.floor, "ceiling": one.ceiling}
        contacts[title] = {part: own for part, own in parts.items() if own or part == "phonemes"}
    return from_template(
        "poseset",
        model=model,
        why=wrap(why[""], WRAP_CHARS - 2),
        names=[*model.poses],
        poses="\n".join(_poses(model, why, packed=packed)),
        left=[*map(as_scalar, left)],
        pairs=[on_one_line(pair.model_dump(exclude_none=True)) for pair in constraints.pairs],
        default=constraints.default if constraints.default < NO_THRESHOLD else None,
        contacts=contacts,
        targets=_targets(model, common, packed=packed),
        packed=packed,
        wrapped=lambda *parts: "\n".join(_wrapped(*parts)),
    )


def _targets(model: PoseSet, common: Phonemes, *, packed: bool) -> Iterator[str]:
    entries = {}
    for label, steps in model.targets.items():
        told = []
        for step in steps:
            insisting = step.dominance or step.overall
            dominance = {} if insisting in ({}, None) else {"dominance": insisting}
            # a solver may leave -0
            weights = {n: round(one, WEIGHT_PLACES) + 0.0 for n, one in step.weights.items()}
            told.append(on_one_line({**weights, **dominance}))
        listed = told[0] if len(told) == 1 else f"[{', '.join(told)}]"
        entries[label] = f"  {label + ':':<4} {listed}"
    width = min(40, max(map(len, entries.values()), default=0))
    for label, entry in entries.items():
        title = common.phonemes[label].title if label in common.phonemes and not packed else ""
        yield f"{entry:<{width}}   # {title}" if title else entry


def _poses(model: PoseSet, why: Mapping[str, str], *, packed: bool) -> Iterator[str]:
    if packed:
        told = (f"{as_scalar(n)}: {_pose('', p.region)}" for n, p in model.poses.items())
        yield from _wrapped("poses: {", told, "}")
        return
    yield "poses:"
    width = max(len(as_scalar(name)) for name in model.poses) + 1
    for name, pose in model.poses.items():
        entry = f"  {as_scalar(name) + ':':<{width}} {_pose(pose.title, pose.region)}"
        yield f"{entry}   # {why[name]}" if name in why else entry


def _pose(title: str, region: str) -> str:
    fields = {"title": title, "region": region}
    return on_one_line({field: text for field, text in fields.items() if text})


def _wrapped(head: str, items: Iterable[str], end: str) -> Iterator[str]:
    """Yield the head and its items, wrapped at the line width and indented below the head."""
    line, indent = head, "#   " if head.startswith("#") else " " * len(head)
    told = list(items)
    for number, item in enumerate(told):
        more = item + (end if number == len(told) - 1 else ", ")
        if len(line) + len(more) > WRAP_CHARS and line.strip(" #"):
            yield line.rstrip()
            line = indent
        line += more
    yield line
