"""Conversion of another program's bigrams to common phonemes and poses, with remarks on losses.

Times and weights are clipped to [0, 1], times sorted, both rounded to `DECIMALS`.
"""

from collections.abc import Mapping
from itertools import pairwise

from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.packs.yaml.faults import visible
from lipsync_lang.plugins.smartbody.bank_files import ALONE, Diphone, DiphonePair, ImportRemarks

DECIMALS = 4
"""Decimals of a time or weight; the step is smaller than a pixel of any curve editor."""

MOST_KEYS = 200
"""Maximum number of keys of a curve. Longer curves are sampled by programs, not drawn."""

FEWEST_KEYS = 2

LONGEST, HINTS = 40, 100
"""Maximum length of a name in a remark, and maximum number of unknown names with a hint."""

CurvePoints = list[list[float]]
ImportedCurves = dict[str, CurvePoints]


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
    return round(min(max(number, 0.0), 1.0), DECIMALS) + 0.0


def _shown(pair: DiphonePair) -> str:
    return visible("-".join(pair))
