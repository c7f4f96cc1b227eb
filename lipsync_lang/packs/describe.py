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
    lines = [
        f"{row['name']:<16}{row['origin']:<12}{row['path']}"
        + (f"  (shadowed by {row['shadowed_by']})" if row["shadowed_by"] else "")
        for row in rows
    ]
    if kind == "character":
        sets = ", ".join(sorted({found.name for found in library.names("poseset")}))
        lines.append(f"pose sets that are characters by themselves: {sets}")
    return Told("\n".join(lines), rows)


def show(library: "Library", kind: "Kind", name: str) -> Told:
    """Show one pack."""
    if kind == "language":
        return _language(library, library.language(name))
    if kind == "poseset":
        return _poseset(library.poseset(name))
    pack = library.character(name)
    model = pack.model
    text = (
        f"{model.name}: pose set {model.poseset}, {len(model.bigrams)} bigrams of its own, "
        f"{len(model.banks)} banks, {len(model.words)} words ({shown(pack.path)})"
    )
    return Told(text, model.model_dump(mode="json", by_alias=True))


def _language(library: "Library", pack: "Pack[models.Language]") -> Told:
    """Print a language as the paper's Table 1: its phonemes by the common phoneme they become."""
    model = pack.model
    common = library.common().model
    names = [*common.base, *(label for label in model.adds if label not in common.base)]
    lines = [f"{model.title or model.name} ({model.tag}), {shown(pack.path)}"]
    if model.tts:
        lines.append(f"spoken by {model.tts.engine}, voice {model.tts.voice or 'as it comes'}")
    for notation, table in model.notations.items():
        lines.append(f"\n{notation}: {len(table)} labels")
        sequences = {s.to for s in table.values()}
        singles = [(name,) for name in names if (name,) in sequences]
        for sounds in [*singles, *sorted(s for s in sequences if len(s) != 1)]:
            labels = [label for label, s in table.items() if s.to == sounds]
            words = [model.examples[label] for label in labels if label in model.examples]
            becomes = " ".join(sounds) or "(mute)"
            lines.append(f"  {becomes:<10}{'  '.join(labels)}" + _example(words, sounds, common))
    heard = {sound for test in model.tests for sound in test.phonemes}
    untested = [name for name in names if name not in heard]
    lines.append(
        f"\n{len(model.tests)} tests" + (f"; untested: {' '.join(untested)}" * bool(untested))
    )
    return Told("\n".join(lines), model.model_dump(mode="json", by_alias=True))


def _example(words: list[str], sounds: tuple[str, ...], common: "models.Phonemes") -> str:
    if not words and len(sounds) == 1 and sounds[0] in common.phonemes:
        words = [w for w in (common.phonemes[sounds[0]].example,) if w]
    return f"  ({', '.join(words)})" if words else ""


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
