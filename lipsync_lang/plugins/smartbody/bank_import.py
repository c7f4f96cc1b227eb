"""Import of SmartBody banks: read the files, fit them to a pose set, and write a bank.

Imported bigrams keep their keys and have the status of manual edits. Existing bigrams of the target
bank are never replaced. Curves are lists of (time, weight) points, with weights from 0 to 1.

SmartBody curves interpolate their keys, linearly or as a cardinal spline (`isDiphoneSplineCurve` in
its `SbmCharacter`). B-splines only approximate their control points and remain below the peaks, so
the import reports the ratio of peak heights.

Times and weights are clipped to [0, 1], times sorted, both rounded to `DECIMALS`.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np

from lipsync_lang import LipsyncError, OutputError
from lipsync_lang.base.errors import did_you_mean, shortlist
from lipsync_lang.base.files import atomic
from lipsync_lang.packs.banks.write import (
    NEUTRAL,
    BankBigrams,
    add_bigrams,
    bank_yaml,
    done,
    make_room,
)
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.faults import visible
from lipsync_lang.pipeline.curve import bspline
from lipsync_lang.plugins.smartbody.bank_files import (
    ALONE,
    Diphone,
    DiphonePair,
    ImportRemarks,
    Sets,
    read_smartbody,
)

DECIMALS = 4
"""Decimals of a time or weight; the step is smaller than a pixel of any curve editor."""

MOST_KEYS = 200
"""Maximum number of keys of a curve. Longer curves are sampled by programs, not drawn."""

FEWEST_KEYS = 2

BANK_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,79}")
"""Pattern of valid bank names."""

LONGEST, HINTS = 40, 100
"""Maximum length of a name in a remark, and maximum number of unknown names with a hint."""

CurvePoints = list[list[float]]
ImportedCurves = dict[str, CurvePoints]

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


class Conversion:
    """A foreign bank during its conversion to a bank pack.

    `sounds` are common phonemes by label in lower case, and `poses` those of shapes, in the order
    of the pose set.
    """

    def __init__(
        self,
        sounds: Mapping[str, str],
        poses: Mapping[str, str],
        silence: str,
        remarks: ImportRemarks,
    ) -> None:
        self.sounds, self.poses, self.silence, self.remarks = sounds, poses, silence, remarks
        self.bigrams: dict[str, ImportedCurves] = {}
        self.strays: list[tuple[float, str, Diphone]] = []
        """Bigrams with keys outside [0, 1]: the largest distance, a sentence, and the diphone."""
        self.unknown: dict[tuple[str, str], list[Diphone]] = {}
        """Unknown names as (kind, name), with the diphones that use them."""

    def fit(self, pairs: Mapping[DiphonePair, Diphone]) -> dict[str, ImportedCurves]:
        """Return curves by bigram; of duplicates, the pair with more of our own labels wins."""
        ours = {pair: self._pair(pair, diphone) for pair, diphone in pairs.items()}
        known = [(pair, key) for pair, key in ours.items() if key]
        # A stable sort: pairs with fewer foreign labels first, and then in the order of the file.
        known.sort(key=lambda one: sum(self.sounds[label] != label for label in one[0]))
        taken: dict[str, DiphonePair] = {}
        for pair, key in known:
            if key in taken:
                what = f"{_shown(pair)} is skipped: {_shown(taken[key])} already gives {key}"
                self._tell("twice", pairs[pair], what)
                continue
            curves = self._curves(key, pairs[pair])
            if curves is not None:
                taken[key] = pair
                self.bigrams[key] = curves
        for (kind, name), diphones in self.unknown.items():
            own = self.sounds if kind == "phoneme" else self.poses
            count = "1 bigram" if len(diphones) == 1 else f"{len(diphones)} bigrams"
            lost = "skipped" if kind == "phoneme" else "without it"
            label = visible(name[:LONGEST])
            near = self.remarks.counts[kind] < HINTS
            hint = f"; {did_you_mean(label, set(own.values()))}" if near else ""
            what = f"unknown {kind} '{label}', {count} {lost}{hint} (--map {label}=OURS)"
            self._tell(kind, diphones[0], what)
        for _, what, diphone in sorted(self.strays, key=lambda one: -one[0]):
            self._tell("stray", diphone, what)
        order = {key: number for number, key in enumerate(ours.values())}
        return dict(sorted(self.bigrams.items(), key=lambda one: order[one[0]]))

    def _tell(self, kind: str, diphone: Diphone, text: str) -> None:
        self.remarks.add(kind, diphone.file, diphone.line, text)

    def _pair(self, pair: DiphonePair, diphone: Diphone) -> str:
        """Map a pair to a bigram key; empty without a key."""
        if ALONE in pair and ALONE not in self.sounds:
            what = f"{_shown(pair)} is skipped: the curve of a single phoneme is not a bigram"
            self._tell("alone", diphone, what)
            return ""
        missing = [label for label in dict.fromkeys(pair) if label not in self.sounds]
        for label in missing:
            self.unknown.setdefault(("phoneme", label), []).append(diphone)
        if missing:
            return ""
        first, second = (self.sounds[label] for label in pair)
        if first == second == self.silence:
            what = f"{_shown(pair)} is skipped: silence has no curves"
            self._tell("alone", diphone, what)
            return ""
        return f"{first}-{second}"

    def _curves(self, key: str, diphone: Diphone) -> ImportedCurves | None:
        """Return a bigram's curves in the order of our poses; None if no curve is left."""
        shapes = {shape: points for shape, points in diphone.shapes.items() if points}
        if not shapes:
            self._tell("empty", diphone, f"{key} is skipped: it has no keys, so its draft is used")
            return None
        known = {shape: points for shape, points in shapes.items() if shape in self.poses}
        for shape in shapes.keys() - known.keys():
            self.unknown.setdefault(("pose", shape), []).append(diphone)
        if not known:
            what = f"{key} is skipped: none of its shapes is a pose of the pose set"
            self._tell("empty", diphone, what)
            return None
        if max(map(len, known.values())) > MOST_KEYS:
            what = f"{key} is skipped: it has a curve of more than {MOST_KEYS} keys"
            self._tell("keys", diphone, what)
            return None
        curves: ImportedCurves = {}
        for shape in sorted(known, key=list(self.poses).index):
            pose, points = self.poses[shape], self._points(key, diphone, shape)
            if len(points) < FEWEST_KEYS:
                what = f"{key}: '{visible(shape)}' is skipped: a curve needs more than one key"
                self._tell("empty", diphone, what)
            elif pose in curves:
                what = f"{key}: '{visible(shape)}' is skipped: another shape is already {pose}"
                self._tell("twice", diphone, what)
            else:
                curves[pose] = points
        if not curves:
            return None
        by = [max(0 - t, t - 1, 0 - v, v - 1) for points in known.values() for t, v in points]
        strays = sum(distance > 0 for distance in by)
        if strays:
            noun = "key" if strays == 1 else "keys"
            what = f"{key}: {strays} {noun} outside 0 to 1 clipped, by at most {max(by):.3g}"
            self.strays.append((max(by), what, diphone))
        return {pose: points for pose, points in curves.items() if any(v for _, v in points)}

    def _points(self, key: str, diphone: Diphone, shape: str) -> CurvePoints:
        """Sort keys by time, clip them to the unit square, and merge duplicates."""
        points = diphone.shapes[shape]
        if any(after < before for (before, _), (after, _) in pairwise(points)):
            what = f"{key}: the times of '{visible(shape)}' do not rise; the keys are sorted"
            self._tell("order", diphone, what)
            points = sorted(points, key=lambda point: point[0])
        unit = [[_unit(time), _unit(weight)] for time, weight in points]
        merged = [unit[0], *(here for before, here in pairwise(unit) if here != before)]
        if len(merged) < len(unit):
            what = f"{key}: '{visible(shape)}' has repeated keys; {len(merged)} are kept"
            self._tell("repeat", diphone, what)
        return merged


def _unit(number: float) -> float:
    # The sum turns -0.0 into 0.0, which YAML would show.
    return round(min(max(number, 0.0), 1.0), DECIMALS) + 0.0


def _shown(pair: DiphonePair) -> str:
    return visible("-".join(pair))


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
    new = _write_bank(library, path, made, f"Imported from SmartBody: {origin}.")
    kept = tuple(key for key in found if key not in new)
    reach = _reach(found, interpolation)
    return BankImport(path, poseset.name, chosen, manner, tuple(new), kept, reach, remarks)


def _write_bank(library: Library, path: Path, made: BankBigrams, comment: str) -> list[str]:
    """Write bigrams to a new bank with a comment, or add them to one; return the new ones."""
    make_room(path)
    if path.exists():
        return add_bigrams(library, path, made)
    if not BANK_NAME.fullmatch(path.stem):
        raise OutputError(f"{path}: the name of a bank may have only letters, digits, '-' and '_'")
    with atomic(path, durable=True) as stream:
        stream.write(f"# {comment}\n{bank_yaml(made, path.stem)}".encode())
    return list(made.bigrams)


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
    # Our own names last: a spelling of one phoneme may be the name of another.
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
    # A single set is taken whatever its name, which is often that of its file.
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
