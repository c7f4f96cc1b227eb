"""Import of SmartBody banks: read the files, fit them to a pose set, and write a bank.

Imported bigrams keep their keys and have the status of manual edits. Existing bigrams of the target
bank are never replaced. Curves are lists of (time, weight) points, with weights from 0 to 1.

SmartBody curves interpolate their keys, linearly or as a cardinal spline (`isDiphoneSplineCurve` in
its `SbmCharacter`). B-splines only approximate their control points and remain below the peaks, so
the import reports the ratio of peak heights.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from lipsync_lang.base.errors import LipsyncError, did_you_mean, shortlist
from lipsync_lang.packs.banks.write import NEUTRAL, BankBigrams, done, write_bank
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.faults import visible
from lipsync_lang.pipeline.curve import bspline
from lipsync_lang.plugins.smartbody.bank_files import (
    Diphone,
    DiphonePair,
    ImportRemarks,
    Sets,
    read_smartbody,
)
from lipsync_lang.plugins.smartbody.conversion import Conversion, CurvePoints, ImportedCurves

STATUS = "edited"
"""Status of imported bigrams, because SmartBody banks are drawn manually."""

USUAL = frozenset({"", "default", NEUTRAL})
"""Set names for the neutral style; the name is empty for a text export."""

Interpolation = Literal["bspline", "linear"]

CURVE_SAMPLES = 129
"""Number of samples in the search for the peak of a curve."""

ENOUGH = 0.95
"""Minimum ratio of the curve peak to the highest key, without a warning."""

FEW = 24
"""Maximum number of names in a message."""


@dataclass(frozen=True)
class BankImport:
    """Result of an import."""

    path: Path
    poseset: str
    set: str
    """Name of the imported set in the files."""
    style: str
    """Name of the style in the bank."""
    new: tuple[str, ...]
    """Keys of bigrams added to the bank."""
    kept: tuple[str, ...]
    """Keys of bigrams kept from the existing bank."""
    reach: float
    """Median ratio of curve peak to highest key."""
    remarks: ImportRemarks

    def __str__(self) -> str:
        said = done(self.path, len(self.new), len(self.kept), "imported")
        if self.reach >= ENOUGH:
            return said
        return (
            f"{said}\n"
            f"half of these smooth curves reach at most {self.reach:.0%} of their highest key; to "
            "keep the peaks of SmartBody, import without --interpolation bspline"
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data for JSON output."""
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


def import_bank(  # noqa: PLR0913 the sources, the target and options
    library: Library,
    files: Sequence[Path],
    character: str,
    *,
    to: Path | None = None,
    style: str | None = None,
    interpolation: Interpolation = "linear",
    mapped: Mapping[str, str] | None = None,
) -> BankImport:
    """Import SmartBody banks into a bank of a pose set.

    By default, `to` is a path in the project, named after the first file. `style` is the name of
    the set among several; for a single set, it is the new style name. `mapped` gives the phoneme or
    pose of a SmartBody label or shape. Raises LipsyncError if no bigram in the files can be
    imported.
    """
    poseset = library.poseset(library.character(character).model.poseset).model
    silence, sounds, poses = _names(library, poseset.name, mapped or {})
    remarks = ImportRemarks()
    chosen, pairs = _chosen([read_smartbody(path, remarks) for path in files], style, remarks)
    shapes = dict.fromkeys(shape for diphone in pairs.values() for shape in diphone.shapes)
    if shapes and poses.keys().isdisjoint(shapes):
        raise LipsyncError(
            f"no shape of this bank is a pose of {poseset.name}; select its pose set, or map its "
            f"shapes with --map THEIRS=OURS. Its shapes: {shortlist(map(visible, shapes), FEW)}. "
            f"The poses of {poseset.name}: {', '.join(poseset.poses)}"
        )
    found = Conversion(sounds, poses, silence, remarks).fit(pairs)
    if not found:
        raise LipsyncError(_nothing(remarks))
    manner = style or (NEUTRAL if chosen in USUAL else chosen)
    stem = re.sub(r"[^A-Za-z0-9_-]+", "-", files[0].stem).strip("-_")[:80] or "imported"
    path = to or Path("posesets") / poseset.name / "banks" / f"{stem}.yaml"
    made = BankBigrams(poseset.name, found, STATUS, manner, interpolation)
    origin = ", ".join(visible(file.name) for file in files)
    origin += f", set '{visible(chosen)}'" if chosen else ""
    new = write_bank(library, path, made, f"Imported from SmartBody: {origin}.")
    kept = tuple(key for key in found if key not in new)
    reach = _reach(found, interpolation)
    return BankImport(path, poseset.name, chosen, manner, tuple(new), kept, reach, remarks)


def _reach(found: Mapping[str, ImportedCurves], interpolation: Interpolation) -> float:
    """Return the median ratio of curve peak to highest key; 1 for linear curves."""
    alike: dict[int, list[CurvePoints]] = {}
    for curves in found.values():
        for points in curves.values():
            alike.setdefault(len(points), []).append(points)
    if interpolation == "linear" or not alike:
        return 1.0
    at = np.linspace(0, 1, CURVE_SAMPLES)
    shares = []
    # ImportedCurves are grouped by number of keys, so that each group is one array.
    for lines in alike.values():
        keys = np.array(lines, dtype=np.float64)
        shares.append(bspline(keys, at).max(axis=1) / keys[..., 1].max(axis=1))
    return float(np.median(np.concatenate(shares)))


def _names(
    library: Library, face: str, mapped: Mapping[str, str]
) -> tuple[str, dict[str, str], dict[str, str]]:
    """Return silence, and the maps of labels and shapes to phonemes and poses of a pose set.

    `mapped` has precedence.
    """
    common, poseset = library.common().model, library.poseset(face).model
    sounds = {label.casefold(): common.silence for label in common.rests}
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
    return common.silence, sounds, poses


def _chosen(
    files: Sequence[Sets], style: str | None, remarks: ImportRemarks
) -> tuple[str, dict[DiphonePair, Diphone]]:
    """Merge the sets of files, the first of equal pairs kept, and return the one to import."""
    merged: Sets = {}
    for name, pairs in (one for sets in files for one in sets.items()):
        there = merged.setdefault(name, {})
        for pair, diphone in pairs.items():
            if pair in there:
                what = f"{visible('-'.join(pair))} is already in {there[pair].file}, which is kept"
                remarks.add("twice", diphone.file, diphone.line, what)
            there.setdefault(pair, diphone)
    sets = {name: pairs for name, pairs in merged.items() if pairs}
    if not sets:
        raise LipsyncError(_nothing(remarks))
    fit = [*sets]
    if len(sets) > 1:
        fit = [name for name in sets if name == style or (style == NEUTRAL and name in USUAL)]
    if len(fit) != 1:
        listed = ", ".join(visible(name) or "a set without a name" for name in [*sets][:FEW])
        raise LipsyncError(f"the bank has {len(sets)} sets: {listed}; select one with --style")
    return fit[0], sets[fit[0]]


def _nothing(remarks: ImportRemarks) -> str:
    """Return the message for an empty import, with the first remarks."""
    why = [f"\n  {remark}" for remark in remarks.kept[:FEW]]
    return f"no bigram can be imported from these files{''.join(why)}"
