"""Compile a pair: every pack of it, checked, layered and sampled into tables."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.banks.draft import shape
from lipsync_lang.packs.models.rig_channels import pose_names
from lipsync_lang.packs.yaml.faults import Fault, shown
from lipsync_lang.pipeline.arrays import Bools, Floats, Ints, Singles
from lipsync_lang.pipeline.curve import bspline, polyline
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.tables import RESOLUTION, Bank, Tables
from lipsync_lang.resolver import pose_arrays
from lipsync_lang.resolver.compiled import LAYERS, Compiled, Origin, Pair, Report
from lipsync_lang.resolver.language_tables import manner_of, tables_of, visemes_of
from lipsync_lang.resolver.layers import NEUTRAL, BigramRow, PairPacks
from lipsync_lang.resolver.nearest_phonemes import plain_among, spelling
from lipsync_lang.resolver.rigging import model_file, plain_rig
from lipsync_lang.resolver.settings import motion_with

if TYPE_CHECKING:
    from lipsync_lang.packs import models
    from lipsync_lang.packs.library import Library, Pack


def compile_pair(library: "Library", language: str, character: str) -> Compiled:
    """Read the packs of a pair and compile them; the package's docstring lists the layers."""
    shelf = PairPacks.open(library, language, character)
    common, spoken, who, poseset = shelf.common, shelf.language, shelf.character, shelf.poseset
    counted = list(shelf.rows())
    finer = shelf.shade_rows()
    rows = [*counted, *(row for pair, row in finer.items() if row.origin.pair == pair)]
    styles = {style: _styled(shelf, rows, style) for style in shelf.styles}
    tables = _tables(shelf, rows, finer, styles)
    model = spoken.model
    manner = manner_of(spoken, common.model, who.model)
    return Compiled(
        language=model.name,
        character=who.model.name,
        poseset=poseset.model.name,
        poses=shelf.poses,
        phonemes=shelf.numbered,
        shades=dict(shelf.parents),
        notations=tables_of(model),
        visemes=visemes_of(common.model),
        spelling=spelling(library),
        silences=(*common.model.silence_labels, *model.silence, common.model.silence),
        words=dict(manner.words),
        word_edits=_plain({w.casefold(): e.curves for w, e in who.model.words.items()}),
        line_edits=_plain(
            {name: [e.model_dump() for e in line.edits] for name, line in who.model.lines.items()}
        ),
        origins=(Origin(("", ""), "gap", "", ()), *(r.origin for r in rows)),
        contact_names=tuple(poseset.model.contacts),
        style_origins={
            style: {str(n): row.origin for n, row in enumerate(changed, 1) if row.style == style}
            for style, changed in styles.items()
        },
        style_drafts=_style_drafts(poseset, styles),
        regions=_regions(poseset.model),
        intensity=_plain(poseset.model.intensity.model_dump()) if poseset.model.intensity else None,
        delivery=_delivery(who.model),
        line_deliveries={name: _delivery(line) for name, line in who.model.lines.items()},
        tables=tables,
        motion=_motion(poseset.model.motion, who.model.motion),
        measures={name: dict(gains) for name, gains in poseset.model.measures.items()},
        checks=_checks(poseset.model.checks, who.model.checks),
        report=replace(
            _report(shelf, [r.origin for r in counted], _warnings(shelf, rows, tables)),
            styles={style: _statuses(rows[: len(counted)]) for style, rows in styles.items()},
        ),
        nearest=plain_among(library, spoken) if model.automatic else None,
        manner=_plain(manner.plain()),
        rig=plain_rig(library, who, poseset),
        pose_names=pose_names(poseset.model),
        neutral=poseset.model.neutral,
        model=model_file(who, poseset),
    )


def _tables(
    shelf: PairPacks,
    rows: list[BigramRow],
    finer: Mapping[Pair, BigramRow],
    styles: Mapping[str, list[BigramRow]],
) -> Tables:
    """Return rows, rows of styles, and the rules of the pose set as read-only arrays."""
    poseset = shelf.poseset.model
    curves = _tabulate(rows, len(shelf.poses))
    boundary, free = _marks(rows)
    tables = Tables(
        curves=curves,
        boundary=boundary,
        free=free,
        pairs=_pairs(shelf, rows, finer),
        silence=0,
        contacts=tuple(shelf.contacts()),
        thresholds=pose_arrays.thresholds(poseset),
        paper=pose_arrays.thresholds(poseset, paper=True),
        priority=pose_arrays.priority(poseset),
        softness=pose_arrays.softness(poseset),
        anticipate=pose_arrays.anticipate(poseset),
        highest=shelf.highest(),
        opposed=shelf.opposed(),
        at_most=tuple(pose_arrays.at_most(poseset)),
        styles=tuple(_bank(changed, curves) for changed in styles.values()),
    )
    _freeze(tables)
    return tables


def _pairs(shelf: PairPacks, rows: list[BigramRow], finer: Mapping[Pair, BigramRow]) -> Ints:
    """Return (N, N) row numbers; several pairs with shades may share the row of a coarser pair."""
    numbers = {row.origin.pair: n for n, row in enumerate(rows, 1) if row.origin.layer != "gap"}
    played = numbers | {pair: numbers[row.origin.pair] for pair, row in finer.items()}
    index = {phoneme: number for number, phoneme in enumerate(shelf.numbered)}
    pairs = np.zeros((len(index), len(index)), np.intp)
    for (a, b), number in played.items():
        pairs[index[a], index[b]] = number
    return pairs


def _freeze(tables: Tables) -> None:
    """Make every array read-only, as arrays from the cache are."""
    stored = (tables, *tables.contacts)
    arrays = [value for one in stored for value in vars(one).values()]
    arrays += [value for bank in tables.styles for value in bank]
    for array in arrays:
        if isinstance(array, np.ndarray):
            array.setflags(write=False)


def _plain(data: Any) -> Any:
    """Return nested data with lists for tuples, as JSON returns it."""
    if isinstance(data, Mapping):
        return {key: _plain(value) for key, value in data.items()}
    return [_plain(value) for value in data] if isinstance(data, (list, tuple)) else data


def _motion(*layers: "models.MotionFields") -> Motion:
    motion = Motion()
    for layer in layers:
        motion = motion_with(motion, layer.model_dump(exclude_none=True))
    return motion


def _checks(*layers: "models.Checks") -> dict[str, Any]:
    """Return limits and rules as plain data; later layers override earlier ones."""
    limits: dict[str, Any] = {}
    rules: dict[str, Any] = {}
    for layer in layers:
        stated = layer.model_dump(exclude_none=True)
        rules |= _plain(stated.pop("rules"))
        limits |= stated
    return {"limits": limits, "rules": rules}


def _tabulate(rows: list[BigramRow], poses: int) -> Singles:
    """Return (B, RESOLUTION + 1, P) samples of every bigram's curves; row 0 is rest."""
    at = np.linspace(0, 1, RESOLUTION + 1)
    out = np.zeros((len(rows) + 1, RESOLUTION + 1, poses), np.float32)
    alike: dict[tuple[int, bool], list[tuple[int, int, Floats]]] = {}
    drafted: list[tuple[int, int, Floats]] = []
    for number, row in enumerate(rows, start=1):
        for pose, points in row.curves.items():
            kept = drafted if row.drafted else alike.setdefault((len(points), row.linear), [])
            kept.append((number, pose, points))
    if drafted:  # drafts share their control times, so one basis serves them all
        values = np.stack([points[:, 1] for _, _, points in drafted])
        _put(out, drafted, values @ shape(at))
    for (_, linear), curves in alike.items():
        points = np.stack([control for _, _, control in curves])
        _put(out, curves, (polyline if linear else bspline)(points, at))
    return out


def _put(out: Singles, curves: list[tuple[int, int, Floats]], sampled: Floats) -> None:
    out[[n for n, _, _ in curves], :, [pose for _, pose, _ in curves]] = sampled.clip(0, 1)


def _styled(shelf: PairPacks, rows: list[BigramRow], style: str) -> list[BigramRow]:
    """Return the rows of a style; bigrams that no bank of it changes are neutral's own."""
    found = (shelf.authored(row.origin.pair, style) for row in rows)
    return [
        one if one is not None and one.style == style else row
        for one, row in zip(found, rows, strict=True)
    ]


def _bank(rows: list[BigramRow], neutral: Singles) -> Bank:
    """Return a style's bank: neutral's samples, with the style's own rows laid over them."""
    own = [number for number, row in enumerate(rows, 1) if row.style != NEUTRAL]
    curves = neutral.copy()
    curves[own] = _tabulate([rows[number - 1] for number in own], neutral.shape[2])[1:]
    return Bank(curves, *_marks(rows))


def _statuses(rows: list[BigramRow]) -> dict[str, int]:
    """Count the bigrams of a style's banks by status."""
    return dict(sorted(Counter(r.origin.status for r in rows if r.style != NEUTRAL).items()))


def _marks(rows: list[BigramRow]) -> tuple[Floats, Bools]:
    """Return boundaries and waivers of all rows; row 0 is rest."""
    boundary = np.array([0.5, *(row.boundary for row in rows)])
    return boundary, np.array([False, *(row.free for row in rows)])


def _regions(poseset: "models.PoseSet") -> dict[str, list[int]]:
    """Return pose numbers by region."""
    regions: dict[str, list[int]] = {}
    for number, pose in enumerate(poseset.poses.values()):
        if pose.region:
            regions.setdefault(pose.region, []).append(number)
    return regions


def _style_drafts(
    poseset: "Pack[models.PoseSet]", drawn: Mapping[str, object]
) -> dict[str, dict[str, Any]]:
    """Return scale and offset of every pose for the pose set's styles that no bank draws."""
    poses = poseset.model.poses
    return {
        name: {
            "scale": [
                style.regions.get(pose.region, 1.0) * style.scale.get(one, 1.0)
                for one, pose in poses.items()
            ],
            "offset": [style.offset.get(one, 0.0) for one in poses],
            "place": str(poseset.where(("styles", name))),
        }
        for name, style in poseset.model.styles.items()
        if name not in drawn
    }


def _delivery(manner: "models.Delivery") -> dict[str, Any]:
    """Return a delivery as plain data."""
    plain: dict[str, Any] = _plain({"styles": manner.styles, "dials": manner.dials})
    return plain


ENOUGH = 0.9
"""Share of a contact's floor that a bigram's own curve should reach."""


def _warnings(shelf: PairPacks, rows: list[BigramRow], tables: Tables) -> list[Fault]:
    """Return warnings about sound packs: weak contacts, and words that are never performed."""
    found = [f for f in shelf.library.faults if f.severity == "warning"]
    names = list(shelf.poseset.model.contacts)
    for number, row in enumerate(rows, start=1):
        if row.place is None or row.free:
            continue
        edge = round(row.boundary * RESOLUTION)
        halves = tables.curves[number, : edge + 1], tables.curves[number, edge:]
        for phoneme, half in zip(row.origin.pair, halves, strict=True):
            for name, contact in zip(names, tables.contacts, strict=True):
                if not contact.phonemes[shelf.numbered.index(phoneme)]:
                    continue
                for pose in contact.raised:
                    top, floor = float(half[:, pose].max()), float(contact.floor[pose])
                    if top < ENOUGH * floor:
                        found.append(_short(row, phoneme, name, shelf.poses[pose], top, floor))
    return found


def _short(  # noqa: PLR0913, PLR0917 the parts of one message
    row: BigramRow, phoneme: str, contact: str, pose: str, top: float, floor: float
) -> Fault:
    file, line, column = row.place or ("", 0, 0)
    what = (
        f"{'-'.join(row.origin.pair)} brings {pose} to {top:.2f} at {phoneme}, where contact "
        f"'{contact}' wants {floor:g}"
    )
    hint = "it is held up all the same; raise the curve, or say `contact: free` if it may be missed"
    return Fault(shown(Path(file)), line, column, "W306", what, hint, "warning")


def _report(shelf: PairPacks, origins: list[Origin], warnings: list[Fault]) -> Report:
    silence = shelf.common.model.silence
    base = set(shelf.common.model.base)
    spoken = [o for o in origins if silence not in o.pair]

    def by_layer(some: list[Origin]) -> dict[str, dict[str, int]]:
        counts = Counter((o.layer, o.status) for o in some)
        return {
            layer: {status: n for (one, status), n in sorted(counts.items()) if one == layer}
            for layer in LAYERS
            if any(one == layer for one, _ in counts)
        }

    return Report(
        language=shelf.language.model.name,
        character=shelf.character.model.name,
        poseset=shelf.poseset.model.name,
        phonemes=shelf.phonemes[1:],
        added=tuple(p for p in shelf.phonemes[1:] if p not in base),
        shades=shelf.shades,
        layers=by_layer(spoken),
        silence_layers=by_layer([o for o in origins if silence in o.pair]),
        shared=sum(base.issuperset(o.pair) for o in spoken),
        extra=sum(not base.issuperset(o.pair) for o in spoken),
        gaps=tuple("-".join(o.pair) for o in spoken if o.layer == "gap"),
        automatic=shelf.language.model.automatic,
        warnings=tuple(str(fault) for fault in warnings),
    )
