"""What there is, and what a pack says, in words and as data."""

from typing import TYPE_CHECKING, Any, NamedTuple

from lipsync_lang.packs.faults import shown

if TYPE_CHECKING:
    from lipsync_lang.packs import models
    from lipsync_lang.packs.finding import Kind
    from lipsync_lang.packs.library import Library, Pack


class Told(NamedTuple):
    """The same thing twice: to read, and to compute with."""

    text: str
    data: Any


def listing(library: "Library", kind: "Kind") -> Told:
    """List every pack of a kind and where it lies; what is shadowed is said to be."""
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
    return Told("\n".join(lines), rows)


def show(library: "Library", kind: "Kind", name: str) -> Told:
    """Show one pose set or character; a language is `authoring.language`'s to describe."""
    if kind == "poseset":
        return _poseset(library.poseset(name))
    pack = library.character(name)
    model = pack.model
    text = (
        f"{model.name}: pose set {model.poseset}, {len(model.bigrams)} bigrams of its own, "
        f"{len(model.banks)} banks, {len(model.words)} words ({shown(pack.path)})"
    )
    return Told(text, model.model_dump(mode="json", by_alias=True))


def _poseset(pack: "Pack[models.PoseSet]") -> Told:
    model = pack.model
    lines = [f"{model.title or model.name}, {shown(pack.path)}", "poses"]
    lines += [f"  {pose:<12}{p.region:<8}{p.title}" for pose, p in model.poses.items()]
    lines.append(f"priority, lowest first: {' < '.join(model.priority) or 'none yields'}")
    for name, contact in model.contacts.items():
        holds = ", ".join(f"{pose} at {floor:g} or more" for pose, floor in contact.floor.items())
        keeps = ", ".join(f"{pose} at {top:g} or less" for pose, top in contact.ceiling.items())
        both = "; ".join(part for part in (holds, keeps) if part)
        lines.append(f"contact {name} for {' '.join(contact.phonemes)}: {both}")
    lines.append(
        f"targets for {len(model.targets)} phonemes; measures: {', '.join(model.measures)}"
    )
    return Told("\n".join(lines), model.model_dump(mode="json", by_alias=True))
