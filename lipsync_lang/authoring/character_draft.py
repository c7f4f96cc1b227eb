"""Draft of a character from its model, with the best-matching pose set and rig.

The match counts shown poses; output paths are relative to the project folder.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, cast

from lipsync_lang.authoring.placing import place_model
from lipsync_lang.authoring.poseset_text import scalar
from lipsync_lang.authoring.rig import drafted, laid_out
from lipsync_lang.errors import LipsyncError, ModelError, PackError, did_you_mean
from lipsync_lang.files import write_all
from lipsync_lang.packs.finding import FOLDERS, POSESET
from lipsync_lang.packs.yaml.faults import shown
from lipsync_lang.rigs.model import Model, read_model, some
from lipsync_lang.rigs.recognise import Match, recognise

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library
    from lipsync_lang.packs.models import RigPack

OTHERS = 3
"""Maximum number of alternatives in a message."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,79}")


@dataclass(frozen=True)
class CharacterWish:
    """Request for a new character: its model, with an optional pose set and rig."""

    name: str
    model: Path
    poseset: str | None = None
    """Name of the pose set; None for the best match."""
    rig: str | None = None
    """Name of a rig of the pose set; None for the best match."""
    title: str | None = None


@dataclass(frozen=True, eq=False)
class CharacterDraft:
    """A drafted character: output files and their summary."""

    path: Path
    match: Match
    others: tuple[Match, ...]
    rig: str | None
    """Name of the drafted or known rig."""
    model: Model
    outputs: dict[Path, Callable[[BinaryIO], object]] = field(default_factory=dict)
    said: dict[Path, str] = field(default_factory=dict)

    def write(self) -> None:
        """Write the character and its dependent files.

        Raises
        ------
        OutputError
            A file is not writable; no file is changed.
        """
        for path in self.outputs:
            path.parent.mkdir(parents=True, exist_ok=True)
        write_all(self.outputs, durable=True)

    def __str__(self) -> str:
        return "\n".join(self._told())

    def _told(self) -> Iterator[str]:
        """Return a message on the match, the output files, the lost poses and the next steps."""
        shapes = dict.fromkeys(name for mesh in self.model.meshes for name in mesh.shapes)
        meshes = len(self.model.meshes)
        within = f"{meshes} meshes" if meshes > 1 else "one mesh"
        yield f"{shown(self.model.path)}: {len(shapes)} shapes in {within}; {self.match}"
        yield from (f"  or {other}: {_asking(other)}" for other in self.others)
        yield from (f"wrote {path}: {self.said[path]}" for path in self.outputs)
        yield from (f"doubtful: {doubt}" for doubt in self.match.found.doubts)
        for shape, channels in self.match.found.shared.items():
            yield f"approximate: {' and '.join(channels)} share one shape, {shape}"
        yield from _lost(self.match)
        if self.match.left:
            yield f"not used: {some(self.match.left)}"
        yield "next:"
        yield f"  {_running(self.path.stem, self.model.path)}"
        yield "  lipsync-lang validate"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON output."""
        return {
            "character": self.path.stem,
            "rig": self.rig,
            "wrote": [str(path) for path in self.outputs],
            "match": self.match.to_dict(),
            "others": [one.to_dict() for one in self.others],
        }


def _lost(match: Match) -> Iterator[str]:
    """Return the lost and approximated poses with the missing features of the model."""
    absent = [loss.pose for loss in match.losses if not (loss.shown or loss.why)]
    if absent:
        yield f"not shown: {', '.join(absent)}"
    yield from (f"lost: {loss}" for loss in match.losses if loss.pose not in absent)
    if match.missing and match.rig:
        yield f"shapes of rig {match.rig} that the model lacks: {some(match.missing)}"


def draft(library: "Library", wanted: CharacterWish, folder: Path = Path()) -> CharacterDraft:
    """Draft a character.

    Parameters
    ----------
    library : source of pose sets and rigs
    wanted : request with the sources of the draft
    folder : project folder; the output is under `characters`

    Raises
    ------
    LipsyncError
        The model is unreadable or without a match, or the name is invalid or in use.
    """
    path = folder / FOLDERS["character"] / f"{wanted.name}.yaml"
    _refuse(library, wanted, path)
    model = read_model(wanted.model)
    matches = recognise(library, model)
    match = _chosen(library, wanted, model, matches)
    title = " ".join((wanted.title or "").split()) or re.sub("[-_]", " ", wanted.name).title()
    placed = place_model(wanted.model, path)
    fits = match.complete
    rig = match.rig if fits else wanted.name
    made = CharacterDraft(path, match, tuple(_others(match, matches)), rig, model)
    text = "\n".join(_lines(made, title, placed.stated)) + "\n"
    _add(made, path, text, f"the poses of {match.poseset}" + (f", rig {rig}" if rig else ""))
    if not fits:
        _add_rig(library, made, title, folder)
    if placed.copy is not None:
        copy = path.with_name(placed.stated)
        made.outputs[copy] = placed.write
        made.said[copy] = f"a copy of {placed.copy}"
    return made


def _refuse(library: "Library", wanted: CharacterWish, path: Path) -> None:
    if not _NAME.fullmatch(wanted.name):
        raise LipsyncError(
            f"'{wanted.name}' cannot be a pack's name; write letters, digits, - and _"
        )
    there = [path] if path.exists() else library.finder.lookup("character", wanted.name)
    for one in there:
        raise PackError(f"{shown(Path(one))}: already exists; choose another name")


def _chosen(
    library: "Library", wanted: CharacterWish, model: Model, matches: Sequence[Match]
) -> Match:
    """Return the requested match; by default the best one."""
    if wanted.poseset is not None:
        library.find("poseset", wanted.poseset)
    fitting = [m for m in matches if wanted.poseset in {None, m.poseset}]
    if wanted.rig is not None:
        rigs = _rigs(library, wanted.poseset)
        if wanted.rig not in rigs:
            raise PackError(f"unknown rig '{wanted.rig}': {did_you_mean(wanted.rig, rigs)}")
        fitting = [m for m in fitting if m.rig == wanted.rig]
    asked = wanted.poseset is not None or wanted.rig is not None
    found = next((m for m in fitting if asked or m.enough), None)
    if found is not None:
        return found
    shapes = dict.fromkeys(name for mesh in model.meshes for name in mesh.shapes)
    who = "no pose set knows"
    if asked:
        named = f"rig '{wanted.rig}'" if wanted.rig else f"pose set '{wanted.poseset}'"
        who = f"{named} knows none of"
    near = f"; the nearest is {fitting[0]} ({_asking(fitting[0])})" if fitting else ""
    raise ModelError(
        f"{wanted.model}: {who} its shapes{near}. It has "
        f"{some(shapes)}. Draft a pose set from them: lipsync-lang posesets new "
        f"{wanted.name} --model {wanted.model}"
    )


def _rigs(library: "Library", poseset: str | None) -> list[str]:
    sets = [poseset] if poseset else dict.fromkeys(f.name for f in library.names("poseset"))
    return [path.stem for name in sets for path in library.rigs_of(name)]


def _others(match: Match, matches: Sequence[Match]) -> list[Match]:
    """Return the alternatives: the best match of each other pose set."""
    best: dict[str, Match] = {}
    for other in matches:
        best.setdefault(other.poseset, other)
    return [m for m in best.values() if m.poseset != match.poseset and m.enough][:OTHERS]


def _asking(match: Match) -> str:
    """Return the command-line options for the selection of a match."""
    return f"--poseset {match.poseset}" + (f" --rig {match.rig}" if match.rig else "")


def _running(name: str, model: Path) -> str:
    """Return an example command; its output file never overwrites the model."""
    same = Path(f"{name}.glb").resolve() == model.resolve()
    return f'lipsync-lang run "Hello" -l LANGUAGE -c {name} -o {name}{"-line" * same}.glb'


def _add(made: CharacterDraft, path: Path, text: str, said: str) -> None:
    made.outputs[path] = lambda stream: stream.write(text.encode("utf-8"))
    made.said[path] = said


def _add_rig(library: "Library", made: CharacterDraft, title: str, folder: Path) -> None:
    """Add a rig under the names of the model."""
    match, name = made.match, made.path.stem
    path = folder / FOLDERS["poseset"] / match.poseset / "rigs" / f"{name}.yaml"
    known = {one.stem: one for one in library.rigs_of(match.poseset)}
    if path.exists() or name in known:
        raise PackError(f"{shown(known.get(name, path))}: already exists; choose another name")
    _refuse_hidden(library, match.poseset, folder)
    poseset = library.poseset(match.poseset).model
    base = None
    if match.rig is not None:
        base = cast("RigPack", library.load(known[match.rig], "rig", match.rig).model)
    rig = drafted(name, title, match, poseset, base)
    count = sum(len(places) for places in match.found.places.values())
    said = f"{count} channel{'s' * (count != 1)} for the model"
    _add(made, path, laid_out(rig, made.model, match, poseset), said)


def _refuse_hidden(library: "Library", poseset: str, folder: Path) -> None:
    """Reject a folder outside the search path for rigs of the pose set."""
    home = library.find("poseset", poseset).parent.parent.parent
    roots = [root.path.resolve() for root in library.roots]
    here = folder.resolve()
    if here not in roots or roots.index(home.resolve()) < roots.index(here):
        raise LipsyncError(
            f"the rig of a new character must be beside pose set '{poseset}', which is in "
            f"{shown(home / FOLDERS['poseset'] / poseset / POSESET)}; change to {shown(home)} first"
        )


def _lines(made: CharacterDraft, title: str, model: str) -> Iterator[str]:
    name, poseset = made.path.stem, made.match.poseset
    yield f"# {title}: the poses of {poseset} on {made.model.path.name}. See it speak:"
    yield f"#   {_running(name, made.model.path)}"
    yield "kind: character"
    yield "format: 1"
    yield f"name: {name}"
    yield f"title: {scalar(title)}"
    yield f"poseset: {poseset}"
    if made.rig is not None:
        yield f"rig: {made.rig}"
    yield f"model: {scalar(model)}"
    yield ""
    yield "# Optional settings of this character; it can also have bigrams, words and lines"
    yield "# motion: {speed_limit: 8}      # weight per second"
    yield "# dials: {REGION: 0.8}          # scale of a region's movement"
