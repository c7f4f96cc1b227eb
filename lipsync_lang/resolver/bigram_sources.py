"""Sources of a bigram's curves: its file, the layers beneath, and drafts from the targets."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.packs.banks.write import BankBigrams
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.value_text import block_lines
from lipsync_lang.resolver.compiled import Origin, Pair
from lipsync_lang.resolver.layers import DRAFTED, BigramRow, PairPacks


@dataclass(frozen=True, eq=False)
class ShownBigram:
    """A bigram with the curves that are performed, and their source."""

    origin: Origin
    curves: Mapping[str, Floats]
    """(n, 2) control points by pose."""
    linear: bool
    """True if the face follows the control polygon, False for its B-spline."""
    boundary: float
    """Normalised end of the first phoneme."""
    free: bool
    """True if the bigram waives its contacts."""

    def to_dict(self) -> dict[str, Any]:
        """Return the bigram as JSON data; `curves` are those of a bank."""
        return {
            "bigram": self.origin.name,
            "word": self.origin.word,
            "layer": self.origin.layer,
            "status": self.origin.status,
            "places": list(self.origin.places),
            "boundary": self.boundary,
            "contact": "free" if self.free else "hold",
            "interpolation": "linear" if self.linear else "bspline",
            "curves": {pose: points.tolist() for pose, points in self.curves.items()},
        }

    def told(self) -> str:
        """Return the source of the bigram, and its curves as a bank has them."""
        places = ", ".join(self.origin.places)
        head = f"{self.origin.name}: {self.origin.source}" + (f", {places}" if places else "")
        usual = {"word": None, "status": "", "boundary": 0.5, "contact": "hold"}
        own = {name: one for name, one in self.to_dict().items() if one != usual.get(name, one)}
        stated = own | {"curves": self.to_dict()["curves"]}
        return "\n".join((f"# {head}", *block_lines({self.origin.name: stated})))


def show_bigrams(
    library: Library, language: str, character: str, wanted: Sequence[str]
) -> list[ShownBigram]:
    """Return bigrams such as `l-ow`, drawn or drafted, as a character performs them."""
    shelf = PairPacks.open(library, language, character)
    pairs = {"-".join(pair): pair for pair in (*shelf.pairs(), *shelf.shade_pairs())}
    for key in wanted:
        if key not in pairs:
            raise LipsyncError(f"unknown bigram '{key}' in {language}; {did_you_mean(key, pairs)}")
    rows = (shelf.row(pairs[key]) for key in wanted)
    return [
        ShownBigram(
            row.origin,
            {shelf.poses[pose]: points for pose, points in row.curves.items()},
            row.linear, row.boundary, row.free,
        )
        for row in rows
    ]  # fmt: skip


def stated(shelf: PairPacks, row: BigramRow) -> str | None:
    """Return the key of a row in the file that states it; None for a draft.

    The key is another pair's where a coarser pair, or a substitute, is drawn in its place.
    """
    for file in shelf.drawn:
        if row.place is not None and file.path == row.place.file:
            stating = [pair for pair, one in file.rows.items() if one.place == row.place]
            own = [pair for pair in stating if pair == row.origin.pair]
            return next(map("-".join, own or stating), None)
    return None


def beneath(shelf: PairPacks, row: BigramRow) -> BigramRow | None:
    """Return the row of the same pair without the file that states it; None for a draft."""
    if row.place is None:
        return None
    rest = tuple(file for file in shelf.drawn if file.path != row.place.file)
    return shelf.redrawn(rest).row(row.origin.pair)


def target_curves(shelf: PairPacks, pair: Pair, boundary: float) -> dict[int, Floats]:
    """Return curves that reach the targets of both phonemes in the middle of each.

    `boundary` is the normalised time at which the first phoneme ends. The result has (n, 2) control
    points by pose number, for poses that move, with 0 at either end. It is empty if one of the
    phonemes has no target.
    """
    if pair[0] not in shelf.targets or pair[1] not in shelf.targets:
        return {}
    first, second = (shelf.targets[phoneme][0].weights for phoneme in pair)
    times = [*_middles(len(first), 0, boundary), *_middles(len(second), boundary, 1)]
    values = np.pad(np.concatenate((first, second)), ((1, 1), (0, 0)))
    at = np.array([0, *times, 1])
    return {
        int(pose): np.column_stack((at, values[:, pose]))
        for pose in np.flatnonzero(values.any(axis=0))
    }


def _middles(parts: int, start: float, end: float) -> list[float]:
    """Return the middles of equal parts of a span."""
    return [start + (end - start) * (part + 0.5) / parts for part in range(parts)]


def draft_bigrams(
    library: Library, language: str, character: str, wanted: Sequence[str] = ()
) -> BankBigrams:
    """Draft bigrams from the targets of a character's pose set, also bigrams in banks.

    `wanted` are bigrams such as `l-ow`; none means every one that no bank answers. Raise
    `LipsyncError` for one that is not of this language, or whose phonemes have no targets.
    """
    shelf = PairPacks.open(library, language, character)
    pairs = {"-".join(pair): pair for pair in shelf.pairs()}
    if wanted:
        pairs |= {"-".join(pair): pair for pair in shelf.shade_pairs()}
    for key in wanted:
        if key not in pairs:
            raise LipsyncError(f"unknown bigram '{key}' in {language}; {did_you_mean(key, pairs)}")
    chosen = list(wanted) or [key for key, pair in pairs.items() if shelf.authored(pair) is None]
    rows = shelf.drafts([pairs[key] for key in chosen])
    missing = [key for key in chosen if pairs[key] not in rows]
    if missing and wanted:
        raise LipsyncError(
            f"{shelf.poseset.model.name} has no targets to draft {', '.join(missing)} from; "
            f"add them in {shelf.poseset.path}"
        )
    bigrams = {
        "-".join(pair): {
            shelf.poses[pose]: [[float(t), float(v)] for t, v in points]
            for pose, points in row.curves.items()
        }
        for pair, row in rows.items()
    }
    who = shelf.character.model
    own = who.name if who.targets else ""
    owner = None if shelf.character.path == shelf.poseset.path else shelf.character.path
    return BankBigrams(shelf.poseset.model.name, bigrams, DRAFTED, character=own, owner=owner)
