"""Compilation of a pair: all its packs, checked, layered and sampled into tables."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, product
from pathlib import Path
from typing import Any, Self

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints, Singles
from lipsync_lang.base.grouping import grouped
from lipsync_lang.packs import models
from lipsync_lang.packs.banks.draft import shape
from lipsync_lang.packs.checking.pack_checks import idle_mouths
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models.rig_models import pose_names
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.project import stated_mouth
from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.pipeline.constrain import FREE
from lipsync_lang.pipeline.curve import bspline, polyline
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.tables import RESOLUTION, Bank, Tables
from lipsync_lang.resolver import pose_arrays
from lipsync_lang.resolver.compiled import LAYERS, CompiledPair, Origin, Pair, Report, Triple
from lipsync_lang.resolver.language_tables import manner_of, tables_of, visemes_of
from lipsync_lang.resolver.layers import NEUTRAL, BigramRow, Halves, PairPacks
from lipsync_lang.resolver.nearest_phonemes import plain_among, spelling
from lipsync_lang.resolver.rigging import OtherModel, model_file, plain_rig
from lipsync_lang.resolver.settings import motion_with
from lipsync_lang.resolver.solving import own_reach


def compile_pair(
    library: Library,
    language: str,
    character: str,
    has: Iterable[str] = (),
    on: OtherModel | None = None,
) -> CompiledPair:
    """Read the packs of a pair and compile them; the package's docstring lists the layers."""
    packs = PairPacks.open(library, language, character, has, on)
    return compile_packs(packs, PairRows.of(packs))


@dataclass(frozen=True, eq=False)
class PairRows:
    """The bigrams of a pair for its tables."""

    counted: list[BigramRow]
    """A row for each pair without shades."""
    finer: dict[Pair, BigramRow]
    """The row of each pair with a shade; several may share the row of a coarser pair."""
    styles: dict[str, list[BigramRow]]
    """Rows of `every` by style; rows that the style does not change are the neutral ones."""
    halves: dict[Triple, Halves]
    """Drawn trigrams that some phonemes play."""
    played: dict[Triple, Triple]
    """The drawn trigram of each sequence of three phonemes that plays one."""

    @classmethod
    def of(cls, shelf: PairPacks) -> Self:
        """Look up every pair."""
        drawn = drawn_trigrams(shelf)
        played = played_trigrams(shelf, drawn)
        halves = {triple: drawn[triple] for triple in sorted(set(played.values()))}
        made = cls(shelf.rows(), shelf.shade_rows(), {}, halves, played)
        styles = {}
        for style in shelf.styles:
            own = ((row, shelf.authored(row.origin.pair, style)) for row in made.bigrams)
            # the very row of neutral where no bank changes it: `_bank` looks for others
            rows = [one if one is not None and one.style == style else row for row, one in own]
            styles[style] = made.with_halves(rows)
        return replace(made, styles=styles)

    @cached_property
    def bigrams(self) -> list[BigramRow]:
        """The rows of bigrams: those without shades, then those with shades."""
        # a shade that plays the row of its parent needs no row of its own
        own = (row for pair, row in self.finer.items() if row.origin.pair == pair)
        return [*self.counted, *own]

    @cached_property
    def every(self) -> list[BigramRow]:
        """The rows of the tables, from row 1: bigrams, then the halves of trigrams."""
        return [*self.bigrams, *chain.from_iterable(self.halves.values())]

    @cached_property
    def numbers(self) -> dict[Pair, int]:
        """The number of the row that each pair plays; several may share that of a coarser pair."""
        every = enumerate(self.bigrams, 1)
        own = {row.origin.pair: n for n, row in every if row.origin.layer != "gap"}
        return own | {pair: own[row.origin.pair] for pair, row in self.finer.items()}

    def with_halves(self, bigrams: list[BigramRow]) -> list[BigramRow]:
        """Return rows of a style for bigrams, with those for the halves of trigrams.

        No style draws trigrams. Where it draws a bigram of one, its bigrams play instead.
        """
        rows = [*bigrams]
        for (one, two, three), halves in self.halves.items():
            numbers = [self.numbers.get(pair, 0) for pair in ((one, two), (two, three))]
            # row 0 is rest, so numbers of rows begin at 1
            found = [bigrams[number - 1] for number in numbers if number]
            drawn = any(row.style != NEUTRAL for row in found) and all(numbers)
            rows += found if drawn else halves
        return rows


def compile_packs(shelf: PairPacks, rows: PairRows) -> CompiledPair:
    """Compile the packs of a pair to tables and plain data."""
    common, spoken, who, poseset = shelf.common, shelf.language, shelf.character, shelf.poseset
    model, library = spoken.model, shelf.library
    manner = manner_of(spoken, common.model, who.model)
    motion = Motion()
    for layer in (poseset.model, model, who.model):  # the character has the last word
        motion = motion_with(motion, layer.motion.model_dump(exclude_none=True))
    return CompiledPair(
        language=model.name,
        character=who.model.name,
        poseset=poseset.model.name,
        poses=shelf.poses,
        shades=dict(shelf.parents),
        notations=tables_of(model),
        visemes=visemes_of(common.model),
        spelling=spelling(library),
        silences=(*common.model.rests, *model.silence, common.model.silence),
        noises=common.model.noise_labels,
        words=dict(manner.words),
        word_edits=_plain({w.casefold(): e.curves for w, e in who.model.words.items()}),
        line_edits=_plain(
            {name: [e.model_dump() for e in line.edits] for name, line in who.model.lines.items()}
        ),
        contact_names=tuple(poseset.model.contacts),
        style_drafts=_style_drafts(poseset),
        posture=_posture(poseset.model),
        regions=_regions(poseset.model),
        intensity=_plain(poseset.model.intensity.model_dump()) if poseset.model.intensity else None,
        delivery=_delivery(who.model),
        line_deliveries={
            name: _line_delivery(one, model.name) for name, one in who.model.lines.items()
        },
        motion=motion,
        gestures=_gestures(poseset, model.gesture_words),
        mirrored=_mirrored(poseset.model),
        measures={name: dict(gains) for name, gains in poseset.model.measures.items()},
        checks=_checks(shelf) | _filmed(shelf),
        nearest=plain_among(library, spoken) if model.automatic else None,
        manner=_plain(manner.plain()),
        rig=plain_rig(library, who.model.rig, poseset) if who.model.rig is not None else None,
        pose_names=pose_names(poseset.model.poses),
        neutral=poseset.model.neutral,
        model=model_file(who, poseset),
        **bigram_fields(shelf, rows),
    )


Sampled = tuple[list[BigramRow], Singles]
"""Rows of tables, and their curves as `Tables` has them."""


def bigram_fields(
    shelf: PairPacks, rows: PairRows, earlier: Sampled | None = None
) -> dict[str, Any]:
    """Return the fields of a compiled pair that depend on its bigrams.

    Rows with the curves of an `earlier` row take over its samples.
    """
    tables = _tables(shelf, rows, earlier)
    return {
        "phonemes": shelf.numbered,
        "tables": tables,
        "origins": (Origin(("", ""), "gap", "", ()), *(row.origin for row in rows.every)),
        "style_origins": {
            style: {str(n): row.origin for n, row in enumerate(changed, 1) if row.style == style}
            for style, changed in rows.styles.items()
        },
        "report": _report(shelf, rows, list(_shorts(shelf, rows.every, tables))),
    }


def _tables(shelf: PairPacks, rows: PairRows, earlier: Sampled | None) -> Tables:
    """Return rows, rows of styles, and the rules of the pose set as read-only arrays."""
    poseset = shelf.face
    index = shelf.numbers
    # a pair that no row plays has row 0, which is rest
    pairs = np.zeros((len(index), len(index)), np.intp)
    for (a, b), number in rows.numbers.items():
        pairs[index[a], index[b]] = number
    first = len(rows.bigrams) + 1
    firsts = {triple: first + 2 * n for n, triple in enumerate(rows.halves)}
    trigrams, trigram_rows = trigram_arrays(index, rows.played, firsts)
    curves = tabulated(rows.every, len(shelf.poses), earlier)
    boundary, free = _marks(rows.every)
    tables = Tables(
        curves=curves,
        boundary=boundary,
        free=free,
        pairs=pairs,
        trigrams=trigrams,
        trigram_rows=trigram_rows,
        silence=0,
        contacts=tuple(shelf.contacts()),
        thresholds=pose_arrays.thresholds(poseset),
        paper=pose_arrays.thresholds(poseset, paper=True),
        priority=pose_arrays.priority(poseset),
        softness=pose_arrays.softness(poseset),
        anticipate=np.array([pose.anticipate for pose in poseset.poses.values()], float),
        highest=shelf.highest(),
        opposed=shelf.opposed(),
        at_most=tuple(pose_arrays.at_most(poseset)),
        styles=tuple(_bank(changed, rows.every, curves) for changed in rows.styles.values()),
    )
    # read-only, like arrays from the cache
    for array in tables.arrays.values():
        array.setflags(write=False)
    return tables


def _plain(data: Any) -> Any:
    """Return nested data with lists for tuples, as JSON returns it."""
    if isinstance(data, (str, float)):  # most of it; to test for a mapping takes longer
        return data
    if isinstance(data, Mapping):
        return {key: _plain(value) for key, value in data.items()}
    return [_plain(value) for value in data] if isinstance(data, (list, tuple)) else data


def _checks(shelf: PairPacks) -> dict[str, Any]:
    """Return limits and rules as plain data; those of the character override the pose set's."""
    limits: dict[str, Any] = {}
    rules: dict[str, Any] = {}
    own, who = shelf.poseset.model.checks, shelf.character.model.checks
    if shelf.solved is not None:
        # A pose set allows its own look on the mesh more; solved targets have another.
        seen = [name for name in type(own).model_fields if name.startswith("seen_")]
        own = own.model_copy(update=dict.fromkeys(seen))
    for layer in (own, who):
        stated = layer.model_dump(exclude_none=True)
        rules |= _plain(stated.pop("rules"))
        limits |= stated
    return {"limits": limits, "rules": rules}


def _filmed(shelf: PairPacks) -> dict[str, Any]:
    """Return the reach, and the widest aperture and the narrowest rounding of each phoneme.

    A cartoon rounds as people do, and a set that is not drawn after people need not round at all.
    """
    who, own = shelf.character.model, shelf.poseset.model
    reach, asked = who.reach or own.reach, own.mouth == "solved"
    stated = {name: shelf.mouths[name] for name in shelf.numbered if name in shelf.mouths}
    rows = [(name, mouth) for name, several in stated.items() for mouth in several]
    widest, narrowest = dict.fromkeys(stated, 0.0), dict[str, float]()
    for name, mouth in rows:
        widest[name] = max(widest[name], round(own_reach(mouth, reach) * mouth.aperture, 4))
        width = round(own_reach(mouth, min(reach, 1.0)) * mouth.width, 4)
        if asked and (mouth.protrusion or 0) > 0 > width:
            narrowest[name] = min(narrowest.get(name, 0.0), width)
    return {"reach": reach, "apertures": widest, "rounded": narrowest}


def tabulated(
    rows: list[BigramRow], poses: int, earlier: Sampled | None = None, kind: type = np.float32
) -> Any:
    """Return (B, RESOLUTION + 1, P) samples of every bigram's curves; row 0 is rest."""
    at = np.linspace(0, 1, RESOLUTION + 1)
    out: Any = np.zeros((len(rows) + 1, RESOLUTION + 1, poses), kind)
    known: dict[tuple[int, tuple[float, float]], int] = {}
    if earlier is not None:
        # the very curves, which `earlier` keeps alive; halves of a trigram share theirs
        known = {(id(row.curves), row.span): n for n, row in enumerate(earlier[0], 1)}
        same = [known.get((id(row.curves), row.span), 0) for row in rows]
        out[1:] = earlier[1][same]
    alike: dict[tuple[int, bool, tuple[float, float]], list[tuple[int, int, Floats]]] = {}
    drafted: list[tuple[int, int, Floats]] = []
    for number, row in enumerate(rows, start=1):
        if (id(row.curves), row.span) in known:
            continue
        for pose, points in row.curves.items():
            sort = len(points), row.linear, row.span
            kept = drafted if row.drafted else alike.setdefault(sort, [])
            kept.append((number, pose, points))
    if drafted:  # drafts share their control times, so one basis serves them all
        _put(out, drafted, _mixed(np.stack([points[:, 1] for _, _, points in drafted]), shape(at)))
    for (_, linear, (begin, end)), curves in alike.items():
        points = np.stack([control for _, _, control in curves])
        _put(out, curves, (polyline if linear else bspline)(points, begin + (end - begin) * at))
    return out


BLOCK_ROWS = 256
"""Number of curves in a block; its intermediate values fit into the processor's cache."""


def _mixed(values: Floats, basis: Floats) -> Floats:
    """Return `values @ basis`, summed in order, so that no row depends on other rows.

    A matrix product would choose its order of summing by the number of rows, so that one drafted
    bigram more would change the last bits of all others.
    """
    out = np.empty((len(values), basis.shape[1]))
    for first in range(0, len(values), BLOCK_ROWS):
        some = values[first : first + BLOCK_ROWS, :, None]
        total = some[:, 0] * basis[0]
        for control in range(1, len(basis)):
            total += some[:, control] * basis[control]
        out[first : first + BLOCK_ROWS] = total
    return out


def _put(out: Singles, curves: list[tuple[int, int, Floats]], sampled: Floats) -> None:
    out[[n for n, _, _ in curves], :, [pose for _, pose, _ in curves]] = sampled.clip(0, 1)


def _bank(rows: list[BigramRow], plain: list[BigramRow], neutral: Singles) -> Bank:
    """Return a style's bank: the neutral samples, with the different rows replaced."""
    both = enumerate(zip(rows, plain, strict=True), 1)
    own = [number for number, (row, other) in both if row is not other]
    curves = neutral.copy()
    curves[own] = tabulated([rows[number - 1] for number in own], neutral.shape[2])[1:]
    return Bank(curves, *_marks(rows))


def _marks(rows: list[BigramRow]) -> tuple[Floats, Bools]:
    """Return boundaries and waivers of all rows; row 0 is rest."""
    boundary = np.array([0.5, *(row.boundary for row in rows)])
    return boundary, np.array([False, *(row.free for row in rows)])


def _regions(poseset: models.PoseSet) -> dict[str, list[int]]:
    """Return pose numbers by region."""
    regions = enumerate(pose.region for pose in poseset.poses.values())
    return grouped((region, number) for number, region in regions if region)


def _style_drafts(poseset: Pack[models.PoseSet]) -> dict[str, dict[str, Any]]:
    """Return the drafts of the pose set's styles, pose by pose."""
    poses = poseset.model.poses
    every = (*poses, *poseset.model.posture_poses)
    return {
        name: {
            "scale": [
                style.regions.get(pose.region, 1.0) * style.scale.get(one, 1.0)
                for one, pose in poses.items()
            ],
            "offset": [style.offset.get(one, 0.0) for one in poses],
            "posture": [style.posture.get(one, 0.0) for one in every],
            "speed": style.speed,
            "softness": style.softness,
            "place": str(poseset.where(("styles", name))),
        }
        for name, style in poseset.model.styles.items()
    }


def _mirrored(poseset: models.PoseSet) -> dict[str, list[str]]:
    """Return pairs of mirrored poses by what their names share, or by both names."""
    poses = {*poseset.poses, *poseset.posture_poses, *poseset.gesture_poses}
    pairs = {}
    for part in poseset.mirrored:
        for one, other in poseset.mirrors(part).items():
            shared = "".join(one.rsplit(part, 1))
            pairs[f"{one}/{other}" if shared in poses else shared] = [one, other]
    return pairs


def _posture(poseset: models.PoseSet) -> dict[str, Any]:
    """Return the poses of postures, and their limits beside the poses of speech."""
    stated = poseset.posture_poses
    return {
        "names": pose_names(stated),
        "softness": [pose.softness for pose in stated.values()],
        "together": [
            [pose.together.get(one, FREE) for one in poseset.poses] for pose in stated.values()
        ],
        "ceilings": [
            [pose.ceiling.get(name, 1.0) for pose in stated.values()] for name in poseset.contacts
        ],
    }


def _delivery(manner: models.Delivery) -> dict[str, Any]:
    """Return a delivery as plain data."""
    return _plain({"styles": manner.styles, "dials": manner.dials, "gestures": manner.gestures})


def _line_delivery(line: models.LineEdits, language: str) -> dict[str, Any]:
    """Return what a line states in one language, except its curve edits.

    An entry of `languages` takes the place of the line's own words; `further` marks it.
    """
    stated = line.model_dump(exclude={"edits", "languages"}, exclude_defaults=True)
    if language in line.languages:
        words = line.languages[language].model_dump(exclude_defaults=True)
        shared = {
            key: one for key, one in stated.items() if key not in models.SpokenEdits.model_fields
        }
        stated = {**shared, **words, "language": language, "further": True}
    return _delivery(line) | _plain(stated)


def _gestures(poseset: Pack[models.PoseSet], words: models.GestureWords) -> dict[str, Any]:
    """Return the gestures, their poses, and the words of the language that have them."""
    model = poseset.model
    spelt = pose_names(model.gesture_poses)
    poses = [
        {
            "name": name,
            "region": pose.region,
            "most": pose.most,
            "speed_limit": pose.speed_limit,
            "channel": {
                "name": name,
                "names": spelt[name],
                "node": pose.node,
                "rotation": pose.rotation,
                "head_axis": pose.head_axis(model.front),
            },
        }
        for name, pose in model.gesture_poses.items()
    ]
    gestures = [
        {
            "name": name,
            "rates": one.per_minute and (one.per_minute.speech, one.per_minute.silence),
            "by_pitch": one.height == "pitch",
            "place": str(poseset.where(("gestures", name))),
            **one.model_dump(
                include={"curve", "poses", "on", "share", "lead", "at", "apart", "spread"}
            ),
        }
        for name, one in model.gestures.items()
    ]
    stated = {trigger: [*map(str.casefold, own)] for trigger, own in words}
    return _plain({"poses": poses, "gestures": gestures, "words": stated, "front": model.front})


ENOUGH = 0.9
"""Minimum share of a contact's floor for a bigram's own curve."""


def _shorts(shelf: PairPacks, rows: list[BigramRow], tables: Tables) -> Iterator[Fault]:
    """Yield warnings about contacts that the curves of bank rows miss by far."""
    asked = [n for n, row in enumerate(rows, 1) if row.place is not None and not row.free]
    spoken = np.array([[shelf.numbers[p] for p in rows[n - 1].origin.pair] for n in asked], int)
    tops = _tops(tables, asked)
    found = [
        (int(row), side, number, pose)
        for side in range(2 if asked else 0)
        for number, contact in enumerate(tables.contacts)
        for pose in contact.raised
        for row in np.flatnonzero(
            contact.phonemes[spoken[:, side]]
            & (tops[side, :, pose] < ENOUGH * float(contact.floor[pose]))
        )
    ]
    names = list(shelf.poseset.model.contacts)
    for row, side, number, pose in sorted(found):
        # otherwise the phoneme in the middle of a trigram would have two warnings
        if side == 0 and rows[asked[row] - 1].span[0] > 0:
            continue  # the first half of a trigram has told of its middle
        floor, one = float(tables.contacts[number].floor[pose]), rows[asked[row] - 1]
        what = (
            f"{one.origin.name} brings {shelf.poses[pose]} to {tops[side, row, pose]:.2f} at "
            f"{one.origin.pair[side]}, but contact '{names[number]}' requires {floor:g}"
        )
        hint = "the contact holds it up anyway; raise the curve, or write `contact: free`"
        file, line, column = one.place or ("", 0, 0)
        yield Fault(shown(Path(file)), line, column, "W306", what, hint, "warning")


def _tops(tables: Tables, rows: list[int]) -> Floats:
    """Return (2, R, P) maximum weights of rows in each of their phonemes.

    Poses that no contact raises stay at 0.
    """
    raised = sorted({pose for contact in tables.contacts for pose in contact.raised})
    numbers = np.array(rows, int)
    # few distinct boundaries: one pass for each is faster than one for each row
    edges = np.array([round(float(edge) * RESOLUTION) for edge in tables.boundary[numbers]])
    tops = np.zeros((2, len(rows), len(tables.priority)))
    for edge in set(edges.tolist()):
        some = np.flatnonzero(edges == edge)
        for side, half in enumerate((slice(None, edge + 1), slice(edge, None))):
            for pose in raised:
                tops[side, some, pose] = tables.curves[numbers[some], half, pose].max(axis=1)
    return tops


def _report(shelf: PairPacks, rows: PairRows, shorts: Sequence[Fault]) -> Report:
    warnings = [*(f for f in shelf.library.faults if f.severity == "warning"), *shorts]
    project, solved = stated_mouth(shelf.library.project), shelf.solved is not None
    idle = idle_mouths(shelf.character, shelf.poseset.model, project, solved=solved)
    origins = [row.origin for row in rows.counted]
    silence = shelf.common.model.silence
    base = set(shelf.common.model.base)
    spoken = [o for o in origins if silence not in o.pair]
    drawn = {
        style: Counter(r.origin.status for r in some[: len(origins)] if r.style != NEUTRAL)
        for style, some in rows.styles.items()
    }

    def by_layer(some: list[Origin]) -> dict[str, dict[str, int]]:
        own = grouped((o.layer, o.status) for o in some)
        return {one: dict(sorted(Counter(own[one]).items())) for one in LAYERS if one in own}

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
        warnings=tuple(map(str, warnings)),
        idle=(*map(str, idle), *shelf.doubts),
        styles={style: dict(sorted(count.items())) for style, count in drawn.items()},
        trigrams={"-".join(triple): row.origin.layer for triple, (row, _) in rows.halves.items()},
    )


# Trigrams are never drafted, and no phoneme plays that of its substitute (`like`): where nobody
# drew three phonemes, two bigrams show them.
def drawn_trigrams(shelf: PairPacks) -> dict[Triple, Halves]:
    """Return the trigrams of all files; earlier layers take precedence, then earlier files."""
    found: dict[Triple, Halves] = {}
    # stable: within a layer the order of the files stays
    for file in sorted(shelf.drawn, key=lambda file: LAYERS.index(file.layer)):
        found = {**file.halves, **found}
    return found


def played_trigrams(shelf: PairPacks, drawn: Mapping[Triple, Halves]) -> dict[Triple, Triple]:
    """Return the drawn trigram that each three phonemes of the pair play.

    Of phonemes with shades it is the finest that is drawn, down to that of their parents.
    """
    names = {name: (name, shelf.parents.get(name, name)) for name in shelf.numbered}
    kin = grouped((one, name) for name, both in names.items() for one in {*both})
    # by the number of parents; `sorted` is stable, so ties prefer the finer first phoneme
    coarser = sorted(product((0, 1), repeat=3), key=sum)
    played = {}
    for triple in drawn:
        for one, two, three in product(*(kin.get(phoneme, ()) for phoneme in triple)):
            found = ((names[one][a], names[two][b], names[three][c]) for a, b, c in coarser)
            played[one, two, three] = next(finest for finest in found if finest in drawn)
    return dict(sorted(played.items()))


def trigram_arrays(
    numbers: Mapping[str, int], played: Mapping[Triple, Triple], rows: Mapping[Triple, int]
) -> tuple[Ints, Ints]:
    """Return ascending codes of three phonemes, and the two rows of each: (K,) and (K, 2).

    `rows` has the number of the first row of each drawn trigram; the second follows it.
    """
    size = len(numbers)
    found = sorted(
        ((numbers[a] * size + numbers[b]) * size + numbers[c], rows[drawn])
        for (a, b, c), drawn in played.items()
    )
    codes = np.array([code for code, _ in found], np.intp)
    firsts = np.array([row for _, row in found], np.intp)
    return codes, firsts[:, None] + np.arange(2)
