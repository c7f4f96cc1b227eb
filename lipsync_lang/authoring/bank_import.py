"""Import banks of another program: read them, fit them to our packs, and write a bank.

A bigram is taken over as it was drawn, and counts as edited by a person. What is in the target
already stays as it is.

SmartBody's curves pass through their keys, straight or as a cardinal spline (`isDiphoneSplineCurve`
in its `SbmCharacter`). Ours are pulled by theirs and stay below; so it is told how far they reach.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.banks.fit import BankNames, Curves, Fitting
from lipsync_lang.banks.smartbody import Remarks, Sets, read_smartbody, visible
from lipsync_lang.banks.write import (
    NEUTRAL,
    Interpolation,
    Made,
    Points,
    add_bigrams,
    bank_yaml,
    done,
    make_room,
)
from lipsync_lang.errors import LipsyncError, OutputError, did_you_mean
from lipsync_lang.files import atomic
from lipsync_lang.pipeline.curve import bspline
from lipsync_lang.pipeline.tables import RESOLUTION

if TYPE_CHECKING:
    from lipsync_lang.packs import models
    from lipsync_lang.packs.library import Library
    from lipsync_lang.pipeline.arrays import Floats

STATUS = "edited"
"""Whoever drew it, a person has seen to it."""

USUAL = frozenset({"", "default", NEUTRAL})
"""Names of sets that hold the usual manner of speaking; a text export does not name its set."""

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,79}")
"""What a bank may be called."""

ENOUGH = 0.95
"""Share of the highest key that a curve should reach."""

FEW = 24
"""Names that a message lists."""


@dataclass(frozen=True)
class Imported:
    """What an import came to."""

    path: Path
    poseset: str
    set: str
    """The set that was taken, as the files call it."""
    style: str
    """The manner of speaking that it is here."""
    new: tuple[str, ...]
    """Bigrams that were put into the bank."""
    kept: tuple[str, ...]
    """Bigrams that were there already, and stay as they are."""
    reach: float
    """How high the curves come beside their highest keys, in the middle of all."""
    remarks: Remarks

    def __str__(self) -> str:
        said = done(self.path, len(self.new), len(self.kept), "imported")
        if self.reach >= ENOUGH:
            return said
        return (
            f"{said}\n"
            f"half of these smooth curves reach {self.reach:.0%} of their highest key or less, "
            "where SmartBody's reach it; without --interpolation bspline they do"
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the import as JSON holds it."""
        return {
            "bank": str(self.path),
            "poseset": self.poseset,
            "set": visible(self.set),
            "style": self.style,
            "reach": round(self.reach, 3),
            "imported": list(self.new),
            "kept": list(self.kept),
            "counts": dict(self.remarks.counts),
            "remarks": [remark._asdict() for remark in self.remarks.kept],
        }


def import_bank(  # noqa: PLR0913 what is read, what it is for, and where it goes
    library: "Library",
    files: Sequence[Path],
    character: str,
    *,
    to: Path | None = None,
    style: str | None = None,
    interpolation: Interpolation = "linear",
    mapped: Mapping[str, str] | None = None,
) -> Imported:
    """Import SmartBody's banks into a bank of ours.

    Parameters
    ----------
    files : scripts or text exports
    character : a pose set, or a character of it
    to : the bank to write to; None is one of the first file's name in the project's own folder
    style : the set to take where there are several, or what the only one is called here
    interpolation : the kind of curve
    mapped : our phoneme or pose for a label or shape of theirs

    Raises
    ------
    LipsyncError
        Nothing in the files can be taken over.
    """
    poseset = library.poseset(library.character(character).model.poseset).model
    names = _names(library.common().model, poseset, mapped or {})
    remarks = Remarks()
    sets = _merged([read_smartbody(path, remarks) for path in files], remarks)
    chosen = _chosen(sets, style, remarks)
    _refuse_foreign(sets[chosen], poseset, names)
    found = Fitting(names, remarks).fit(sets[chosen])
    if not found:
        raise LipsyncError(_nothing(remarks))
    manner = style or (NEUTRAL if chosen in USUAL else chosen)
    path = to or _usual_path(poseset.name, files[0])
    made = Made(poseset.name, found, STATUS, manner, interpolation)
    new = _write(path, made, _header(files, chosen))
    kept = tuple(key for key in found if key not in new)
    reach = _reach(found, interpolation)
    return Imported(path, poseset.name, chosen, manner, tuple(new), kept, reach, remarks)


def _reach(found: Mapping[str, Curves], interpolation: Interpolation) -> float:
    """Return how high curves come beside their highest keys, in the middle of all."""
    alike: dict[int, list[Points]] = {}
    for curves in found.values():
        for points in curves.values():
            alike.setdefault(len(points), []).append(points)
    if interpolation == "linear" or not alike:
        return 1.0
    at = np.linspace(0, 1, RESOLUTION + 1)
    shares = []
    for lines in alike.values():
        keys: Floats = np.array(lines)
        shares.append(bspline(keys, at).max(axis=1) / keys[..., 1].max(axis=1))
    return float(np.median(np.concatenate(shares)))


def _names(
    common: "models.Phonemes", poseset: "models.PoseSet", mapped: Mapping[str, str]
) -> BankNames:
    """Return what labels and shapes are called here; what the caller says comes first."""
    sounds = {label.casefold(): common.silence for label in common.silence_labels}
    for name, phoneme in common.phonemes.items():
        sounds.update(dict.fromkeys((label.casefold() for label in phoneme.spelled), name))
    ours = dict.fromkeys((*common.phonemes, common.silence))
    sounds.update(dict(zip(ours, ours, strict=True)))
    poses = {pose: pose for pose in poseset.poses}
    for theirs, our in mapped.items():
        if our not in ours and our not in poseset.poses:
            raise LipsyncError(
                f"--map {theirs}={our}: '{our}' is neither a phoneme nor a pose of "
                f"{poseset.name}; {did_you_mean(our, [*ours, *poseset.poses])}"
            )
        if our in ours:
            sounds[theirs.casefold()] = our
        if our in poseset.poses:
            poses[theirs] = our
    return BankNames(sounds, poses, common.silence)


def _merged(files: Sequence[Sets], remarks: Remarks) -> Sets:
    """Put the sets of several files together; of a pair in two of them the first stays."""
    merged: Sets = {}
    for sets in files:
        for name, pairs in sets.items():
            there = merged.setdefault(name, {})
            for pair, diphone in pairs.items():
                if pair in there:
                    what = f"{visible('-'.join(pair))} is in {there[pair].file} too, which stays"
                    remarks.add("twice", diphone.file, diphone.line, what)
                there.setdefault(pair, diphone)
    return {name: pairs for name, pairs in merged.items() if pairs}


def _chosen(sets: Sets, style: str | None, remarks: Remarks) -> str:
    """Return the set to take."""
    if not sets:
        raise LipsyncError(_nothing(remarks))
    if len(sets) == 1:
        return next(iter(sets))
    fit = [name for name in sets if name == style or (style == NEUTRAL and name in USUAL)]
    if len(fit) != 1:
        listed = ", ".join(visible(name) or "one without a name" for name in [*sets][:FEW])
        raise LipsyncError(f"{len(sets)} sets are there: {listed}; take one of them with --style")
    return fit[0]


def _refuse_foreign(pairs: Mapping[Any, Any], poseset: "models.PoseSet", names: BankNames) -> None:
    """Raise where the bank moves nothing that the pose set has."""
    shapes = dict.fromkeys(shape for diphone in pairs.values() for shape in diphone.shapes)
    if shapes and not any(shape in names.poses for shape in shapes):
        listed = ", ".join(visible(shape) for shape in [*shapes][:FEW])
        more = ", ..." if len(shapes) > FEW else ""
        raise LipsyncError(
            f"no shape of this bank is a pose of {poseset.name}: is it of another pose set? "
            f"Its shapes are {listed}{more}; those of {poseset.name} are "
            f"{', '.join(poseset.poses)}. Say which is which with --map THEIRS=OURS"
        )


def _nothing(remarks: Remarks) -> str:
    """Say that nothing was taken over, and why."""
    why = [f"\n  {remark}" for remark in remarks.kept[:FEW]]
    return f"nothing can be imported: no bigram of ours is in there{''.join(why)}"


def _usual_path(poseset: str, file: Path) -> Path:
    """Return the bank's place in the project's own folder."""
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", file.stem).strip("-_")[:80] or "imported"
    return Path("posesets") / poseset / "banks" / f"{name}.yaml"


def _header(files: Sequence[Path], chosen: str) -> str:
    """Say in a comment where the curves are from."""
    listed = ", ".join(visible(file.name) for file in files)
    of = f", set '{visible(chosen)}'" if chosen else ""
    return f"# Imported from SmartBody: {listed}{of}.\n"


def _write(path: Path, made: Made, header: str) -> list[str]:
    """Write a new bank, or add to one that is there; return the bigrams that are new."""
    make_room(path)
    if path.exists():
        return add_bigrams(path, made)
    if not NAME.fullmatch(path.stem):
        raise OutputError(f"{path}: a bank is called by letters, digits, '-' and '_' only")
    with atomic(path, durable=True) as stream:
        stream.write(f"{header}{bank_yaml(made, path.stem)}".encode())
    return list(made.bigrams)
