"""Routes of the bigrams: the matrix, and single bigrams with their curves and their layers."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.base.json_object import Json
from lipsync_lang.packs.splicing import get
from lipsync_lang.reports.coverage.report import authored
from lipsync_lang.resolver.bigram_sources import beneath, stated, target_curves
from lipsync_lang.resolver.compiled import Pair
from lipsync_lang.resolver.layers import BigramRow, PairPacks
from lipsync_lang.studio.bigram_home import bigram_home, known_style, styled_row
from lipsync_lang.studio.routes.requests import StudioRequest
from lipsync_lang.studio.script_count import script_needs
from lipsync_lang.studio.workshop import Workshop

if TYPE_CHECKING:
    from lipsync_lang.packs.pack import Pack

CURVE_DIGITS = 4
"""Decimal places of times and values."""

MAX_WANTED = 200
"""Maximum number of bigrams in the list of the next ones to draw."""

MAX_BIGRAM_CHARS = 40
"""Maximum length of an unknown bigram's name in a message."""


def matrix(workshop: Workshop, _: StudioRequest) -> Json:
    """Return the status and the need of every bigram, and the next ones to draw.

    The `source` of the need is the script with the last count, or else the line.
    """
    compiled = workshop.performer.compiled
    counted = script_needs(workshop)
    needs = counted or _needs(workshop)
    pairs: dict[str, Json] = {}
    for i, first in enumerate(compiled.phonemes):
        for j, second in enumerate(compiled.phonemes):
            # Silence followed by silence is no bigram.
            if i == j == compiled.tables.silence:
                continue
            origin = compiled.origins[int(compiled.tables.pairs[i, j])]
            state = {"status": origin.status or "gap", "layer": origin.layer}
            count, word = needs.get(f"{first}-{second}", (0, ""))
            found = {"need": count, "word": origin.word or word}
            pairs[f"{first}-{second}"] = state | {key: one for key, one in found.items() if one}
    wanted = [
        {"pair": pair, "count": count, "word": pairs[pair].get("word", "")}
        for pair, (count, _) in sorted(needs.items(), key=lambda need: -need[1][0])
        if pair in pairs and not authored(pairs[pair]["layer"], pairs[pair]["status"])
    ]
    return {
        "phonemes": list(compiled.phonemes),
        "pairs": pairs,
        "wanted": wanted[:MAX_WANTED],
        "source": "script" if counted else "line",
    }


def _needs(workshop: Workshop) -> dict[str, tuple[int, str]]:
    """Count each bigram in the line, with an example word."""
    schedule, performer = workshop.schedule, workshop.performer
    if schedule is None:
        return {}
    ids, _, source = performer.common_phonemes(schedule)
    names = [performer.compiled.phonemes[number] for number in ids.tolist()]
    said = list(zip(names, source.tolist(), strict=True))
    counts: Counter[str] = Counter()
    words: dict[str, str] = {}
    for (first, at), (second, then) in pairwise(said):
        pair = f"{first}-{second}"
        counts[pair] += 1
        for word in schedule.words:
            if min(at, then) >= word.first and max(at, then) < word.stop:
                # a bigram across two words has no word as its example
                words.setdefault(pair, word.text)
    return {pair: (count, words.get(pair, "")) for pair, count in counts.items()}


def bigram(workshop: Workshop, request: StudioRequest) -> Json:
    """Return a bigram: its curves and fields, its file, and curves for comparison.

    The query may name the `style`, and the bigrams `before` and `after` it in the line.
    """
    packs = workshop.pair().shelf
    pair = _pair(packs, request.name)
    style = known_style(workshop.performer.compiled, request.query.get("style", ""))
    row = styled_row(packs, pair, style)
    draft = workshop.performer.compiled.style_drafts.get(style)
    if draft is not None and row.style != style:
        row = replace(row, curves=_drafted(row.curves, draft))
    key = stated(packs, row)
    own: Any = None  # fields as in the file; a bigram that copies another has none
    if key == request.name and row.place is not None:
        files: tuple[Pack[Any], ...] = (packs.character, *packs.own_banks, *packs.banks)
        data = {pack.path: pack.source.data for pack in files}
        text = workshop.desk.text(row.place.file)  # with the unsaved edits
        stated_in = data.get(row.place.file) if text is None else text.data
        own = get(stated_in, ("bigrams", "-".join(row.origin.pair)))
    own = own if isinstance(own, dict) else {}
    answer = _drawn(packs, row) | _home(workshop, packs, pair, style)
    answer |= {
        "status": row.origin.status or "drafted",
        "word": row.origin.word or "",
        "why": own.get("why") or "",
        "contact": "free" if row.free else "hold",
        "interpolation": own.get("interpolation") or "",
        "kind": "linear" if row.linear else "bspline",
        "pair": request.name,
        "layer": row.origin.layer,
        "place": row.place and f"{workshop.shown(row.place.file)}:{row.place.line}",
        "drawn_as": key if key and key != request.name else "",
        "ghosts": list(_ghosts(packs, row, pair)),
    }
    for side in ("before", "after"):
        name = request.query.get(side, "")
        beside = _parted(packs, name)
        if beside:
            answer[side] = {"pair": name} | _drawn(packs, packs.row(beside))
    return answer


def _home(workshop: Workshop, packs: PairPacks, pair: Pair, style: str) -> Json:
    """Return the target file for edits; `locked` is the reason if there is none.

    `character` is the user's file of the character, for edits of this face only, and `bank_kind`
    is the default kind of curve in the target file.
    """
    who = workshop.files().get("character")
    own = {"character": workshop.shown(who) if who and workshop.own(who) else ""}
    try:
        path, here = bigram_home(packs, pair, workshop.project, workshop.own, style)
    # the browser shows the reason beside the locked curve
    except LipsyncError as error:
        return own | {"stated": False, "file": "", "bank_kind": "bspline", "locked": str(error)}
    kinds = {pack.path: pack.model.interpolation for pack in (*packs.own_banks, *packs.banks)}
    return own | {
        "stated": here,
        "file": workshop.shown(path),
        "bank_kind": kinds.get(path, "bspline"),
        "locked": "",
    }


def _parted(packs: PairPacks, name: str) -> Pair | None:
    """Return the two phonemes of a bigram; None if there is no such bigram."""
    first, _, second = name.partition("-")
    known = packs.numbered
    # silence alone makes no bigram
    there = first in known and second in known and {first, second} != {known[0]}
    return (first, second) if there else None


def _pair(packs: PairPacks, name: str) -> Pair:
    """Return the two phonemes of a bigram, or refuse it."""
    found = _parted(packs, name)
    if found:
        return found
    short, known = name[:MAX_BIGRAM_CHARS], packs.numbered
    every = [f"{a}-{b}" for a in known for b in known if a != b or a != known[0]]
    language = packs.language.model.name
    raise LipsyncError(f"unknown bigram '{short}' in {language}; {did_you_mean(short, every)}")


def _drawn(packs: PairPacks, row: BigramRow) -> Json:
    return {"boundary": row.boundary, "curves": _curves(packs, row.curves)}


def _curves(packs: PairPacks, curves: Mapping[int, Floats]) -> Json:
    """Return control points by pose."""
    return {
        packs.poses[pose]: [
            [round(t, CURVE_DIGITS), round(v, CURVE_DIGITS)] for t, v in points.tolist()
        ]
        for pose, points in sorted(curves.items())
    }


def _drafted(curves: Mapping[int, Floats], draft: Mapping[str, Any]) -> dict[int, Floats]:
    """Return neutral curves as the draft of a style plays them, without its posture."""
    # A style may move poses that the neutral bigram leaves at rest.
    flat = np.array([[0.0, 0.0], [1.0, 0.0]])
    shifted = {pose: curves.get(pose, flat) for pose in np.flatnonzero(draft["offset"]).tolist()}
    found = {}
    for pose, points in {**curves, **shifted}.items():
        values = points[:, 1] * draft["scale"][pose] + draft["offset"][pose]
        found[pose] = np.column_stack((points[:, 0], np.clip(values, 0, 1)))
    return found


def _ghosts(packs: PairPacks, row: BigramRow, pair: Pair) -> Iterator[Json]:
    """Yield the draft, the layer below, and the targets, if they differ from the row."""
    draft = packs.drafts([pair]).get(pair)
    if draft is not None:
        yield {"name": "draft", "kind": "draft"} | _drawn(packs, draft)
    under = beneath(packs, row)
    if under is not None and under.place is not None:
        yield {"name": "beneath", "kind": "beneath"} | _drawn(packs, under)
    targets = target_curves(packs, pair, row.boundary)
    if targets:
        curves = _curves(packs, targets)
        yield {"name": "targets", "kind": "targets", "boundary": row.boundary, "curves": curves}
