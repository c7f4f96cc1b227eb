"""Lists and descriptions of packs, as text and as data, and the JSON Schemas of their kinds."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any, NamedTuple

from lipsync_lang.base.errors import PackError, did_you_mean
from lipsync_lang.packs import models
from lipsync_lang.packs.finding import Kind, beside
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import MODELS, AtMost
from lipsync_lang.packs.models.pose_models import NO_THRESHOLD
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.pack_files import shown


class Description(NamedTuple):
    """A description as text for people and as data for programs."""

    text: str
    data: Any


def listing(library: Library, kind: Kind) -> Description:
    """List every pack of a kind with its path; shadowed packs are marked."""
    rows = [
        {
            "name": found.name,
            "path": shown(found.path),
            "origin": found.root.origin,
            "shadowed_by": shown(found.shadowed_by) if found.shadowed_by else None,
        }
        for found in library.names(kind)
    ]
    names, origins = (max((len(str(r[k])) for r in rows), default=0) for k in ("name", "origin"))
    lines = [
        f"{row['name']:<{max(names, 14)}}  {row['origin']:<{max(origins, 10)}}  {row['path']}"
        + (f"  (shadowed by {row['shadowed_by']})" if row["shadowed_by"] else "")
        for row in rows
    ]
    if kind == "character":
        sets = ", ".join(sorted({found.name for found in library.names("poseset")}))
        lines.append(f"pose sets that are characters by themselves: {sets}")
    return Description("\n".join(lines), rows)


def show(library: Library, kind: Kind, name: str) -> Description:
    """Describe one pose set or character; `authoring.language` describes languages."""
    if kind == "poseset":
        return _poseset(library, library.poseset(name))
    return _character(library, library.character(name))


def _poseset(library: Library, pack: Pack[models.PoseSet]) -> Description:
    model = pack.model
    lines = [f"{model.title or model.name}, {shown(pack.path)}", *_poses(model)]
    if model.neutral is not None:
        lines.append(f"at rest: {model.neutral}")
    lines.append(f"priority, lowest first: {' < '.join(model.priority) or 'none yields'}")
    for pair in model.constraints.pairs:
        if isinstance(pair, AtMost):
            lines.append(f"{pair.pose} at most {pair.at_most}")
        else:
            lines.append(f"{' + '.join(pair.between)} at most {pair.threshold:g}")
    if model.constraints.default < NO_THRESHOLD:
        lines.append(f"any other two at most {model.constraints.default:g}")
    for name, contact in model.contacts.items():
        holds = ", ".join(f"{pose} at {floor:g} or more" for pose, floor in contact.floor.items())
        keeps = ", ".join(f"{pose} at {top:g} or less" for pose, top in contact.ceiling.items())
        both = "; ".join(part for part in (holds, keeps) if part)
        lines.append(f"contact {name} for {' '.join(contact.phonemes)}: {both}")
    lines.append(f"targets for {len(model.targets)} phonemes: {' '.join(model.targets) or 'none'}")
    missing = [label for label in library.common().model.base if label not in model.targets]
    if missing:
        lines.append(f"  without: {' '.join(missing)}")
    for name, gains in model.measures.items():
        lines.append(f"measure {name}: {_sum(gains)}")
    lines += _checks(model.checks)
    lines += [f"bank {path.stem}: {shown(path)}" for path in library.banks_of(model.name)]
    lines += [f"rig {path.stem}: {shown(path)}" for path in library.rigs_of(model.name)]
    lines += _model(pack, model.model)
    return Description("\n".join(lines), model.model_dump(mode="json", by_alias=True))


def _poses(model: models.PoseSet) -> Iterator[str]:
    """List the poses of speech and of gestures, a line each."""
    groups: dict[str, Mapping[str, models.Pose | models.GesturePose]] = {
        "poses": model.poses,
        "poses that few models have": model.optional_poses,
        "poses of gestures": model.gesture_poses,
    }
    every = [(pose, one.region) for own in groups.values() for pose, one in own.items()]
    width = max(12, *(len(pose) + 2 for pose, _ in every))
    wide = max(8, *(len(region) + 2 for _, region in every))
    for heading, own in groups.items():
        if own:
            yield heading
        for name, pose in own.items():
            yield f"  {name:<{width}}{pose.region:<{wide}}{pose.title}".rstrip()


def _checks(checks: models.Checks) -> Iterator[str]:
    """Describe the checks of finished animations, a line each."""
    for name, rule in checks.rules.items():
        bounds = {"at least": rule.at_least, "at most": rule.at_most}
        told = " and ".join(f"{word} {n:g}" for word, n in bounds.items() if n is not None)
        missed = f", missed by {rule.missed:g} of them at most" if rule.missed else ""
        yield f"rule {name} for {' '.join(rule.phonemes)}: {rule.measure} {told}{missed}"
    limits = checks.model_dump(exclude_none=True, exclude={"rules"})
    yield from (f"limit {name}: {value:g}" for name, value in limits.items())


def _model(pack: Pack[Any], file: str | None) -> Iterator[str]:
    if file is not None:
        path = beside(pack.path, file)
        yield f"model: {file} (missing)" if path is None else f"model: {shown(path)}"


def _sum(gains: Mapping[str, float]) -> str:
    """Write a sum of gain times pose: ``jaw - 0.5 lips``."""
    terms = []
    for pose, gain in gains.items():
        times = "" if abs(gain) == 1 else f"{abs(gain):g} "
        terms.append(f"{'-' if gain < 0 else '+'} {times}{pose}")
    return " ".join(terms).removeprefix("+ ")


def _character(library: Library, pack: Pack[models.Character]) -> Description:
    model = pack.model
    lines = [f"{model.title or model.name}, {shown(pack.path)}", f"pose set: {model.poseset}"]
    counts: Mapping[str, Collection[str]] = {
        "bigrams of its own": model.bigrams,
        "trigrams of its own": model.trigrams,
        "targets of its own": model.targets,
        "mouths of its own": model.mouths,
        "banks": model.banks,
        "words": model.words,
        "lines": model.lines,
        "pronunciations in languages": model.pronunciations,
    }
    lines += [f"{what}: {' '.join(some)}" for what, some in counts.items() if some]
    motion = model.motion.model_dump(exclude_none=True)
    seconds = {"softness": model.softness, "anticipate": model.anticipate}
    levels = {"motion": motion, **seconds, "styles": model.styles, "dials": model.dials}
    for what, values in levels.items():
        told = ", ".join(f"{name} {_level(value)}" for name, value in values.items())
        lines += [f"{what}: {told}"] if told else []
    lines += _checks(model.checks)
    rigs = [path.stem for path in library.rigs_of(model.poseset)]
    if model.rig or rigs:
        chosen = f"rig: {model.rig}"
        lines.append(chosen if model.rig else f"rigs to choose from: {' '.join(rigs)}")
    lines += _model(pack, model.model)
    return Description("\n".join(lines), model.model_dump(mode="json", by_alias=True))


def _level(value: object) -> str:
    """Write a setting, or a level that changes from word to word."""
    if not isinstance(value, tuple):
        return f"{value:g}" if isinstance(value, float) else str(value)
    if len(value) == 1:
        return f"{value[0][1]:g}"
    return ", ".join(f"{level:g} at word {word:g}" for word, level in value)


DIALECT = "https://json-schema.org/draft/2020-12/schema"
"""The dialect of the schemas."""


def kinds() -> list[str]:
    """List the kinds of packs."""
    return sorted(MODELS)


def schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema of a kind of pack; raise `PackError` for an unknown kind."""
    if kind not in MODELS:
        raise PackError(f"unknown kind of pack '{kind}': {did_you_mean(kind, MODELS)}")
    made = MODELS[kind].model_json_schema(by_alias=True, mode="validation")
    return {"$schema": DIALECT, **made}
