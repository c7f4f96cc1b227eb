"""The packs of one pair, and the bigrams of each of their layers."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.packs import models
from lipsync_lang.packs.banks.draft import PASSIVE, TIMES, Target, draft
from lipsync_lang.packs.checking import pack_checks as checks
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import KnownPhonemes, Library
from lipsync_lang.packs.models import PhonemeTarget
from lipsync_lang.packs.pack import FilePlace, Pack
from lipsync_lang.packs.project import stated_mouth
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.pipeline.constrain import FREE
from lipsync_lang.pipeline.tables import Contact
from lipsync_lang.resolver.compiled import Origin, Pair, Triple
from lipsync_lang.resolver.pose_arrays import thresholds
from lipsync_lang.resolver.rigging import OtherModel, face_on_model, model_file
from lipsync_lang.resolver.solving import SolvedFace, farther, solved_face

NEUTRAL = "neutral"
"""The style of a bank that names none."""

DRAFTED, FITTED = "drafted", "fitted"
"""The statuses of bigrams that no person drew."""


@dataclass(frozen=True, eq=False)
class BigramRow:
    """A bigram before it enters the tables."""

    origin: Origin
    curves: dict[int, Floats]
    """Control points (n, 2) by pose number."""
    linear: bool = False
    boundary: float = 0.5
    free: bool = False
    place: FilePlace | None = None
    """Location in a bank file; None for a draft."""
    style: str = NEUTRAL
    drafted: bool = False
    """True if its control times are those of every draft."""
    span: tuple[float, float] = (0.0, 1.0)
    """Normalised times of the curves at the start and end of the row; for a half of a trigram,
    a part of its time."""


THIRDS = 1 / 3, 2 / 3
"""Boundaries of a trigram that states none."""

Halves = tuple[BigramRow, BigramRow]
"""A trigram as rows: its first two phonemes and its last two; both have the one in the middle."""


class DrawnBigrams(NamedTuple):
    """The bigrams and trigrams of one file."""

    path: Path
    layer: str
    style: str
    rows: Mapping[Pair, BigramRow]
    halves: Mapping[Triple, Halves]


Layers = dict[str, dict[str, dict[Pair, BigramRow]]]
"""Bigrams by layer, then style."""

UNDRAWN = frozenset({"face", "known", "parents", "likes", "_mapped"})
"""Cached properties of `PairPacks` that do not depend on bigrams."""


@dataclass(frozen=True, eq=False)
class PairPacks:
    """All packs of one language-character pair."""

    common: Pack[models.Phonemes]
    language: Pack[models.Language]
    character: Pack[models.Character]
    poseset: Pack[models.PoseSet]
    banks: tuple[Pack[models.BankPack], ...]
    own_banks: tuple[Pack[models.BankPack], ...]
    """Banks that the character names."""
    library: Library
    solved: SolvedFace | None = None
    """Targets that were solved on the model; None for a face whose targets are declared."""
    doubts: tuple[str, ...] = ()
    """Descriptions of shapes of the model that do not do what their names say."""

    @classmethod
    def open(
        cls,
        library: Library,
        language: str,
        character: str,
        has: Iterable[str] = (),
        on: OtherModel | None = None,
    ) -> Self:
        """Load and check every pack of a pair; raise `PackError` for one that is unsound.

        Parameters
        ----------
        has : optional poses of the pose set that the model has, besides those of the character
        on : another model than that of the character; raise `ModelError` if it opens no mouth
        """
        try:
            who = library.character(character)
            shelf = cls(
                library.common(),
                library.language(language),
                who,
                library.poseset(who.model.poseset),
                tuple(library.banks(who.model.poseset)),
                tuple(library.character_banks(who)),
                library,
            )
        except PackFaults as error:
            # each file once: a file of a thousand faults would be checked a thousand times
            named = dict.fromkeys(Path(fault.file) for fault in error.faults)
            # a comparison with other files may find more
            more = validate(library, [file for file in named if file.is_file()])
            faults = {*error.faults, *more}
            raise PackFaults(sorted(f for f in faults if f.severity == "fault")) from None
        shelf.refuse_faults()
        poseset = shelf.poseset.model.having((*who.model.has, *has))
        shelf = replace(shelf, poseset=replace(shelf.poseset, model=poseset))
        return shelf.with_model(on)

    def with_model(self, on: OtherModel | None = None) -> Self:
        """Return these packs with targets solved on the character's model, or on another.

        The targets of a pose set were made for its own model. Raises `ModelError` if no pose opens
        the mouth of another one, unless declared targets are asked for.
        """
        who = self.character.model
        shown = face_on_model(self.library, self.character, self.poseset, on)
        if shown is None:
            return self
        told = [*shown.told]
        made = replace(self, doubts=shown.told)
        asked = who.mouth or stated_mouth(self.library.project)
        if asked == "declared" or (not on and str(shown.model.path) == model_file(self.poseset)):
            return made
        kept = shown.honest()
        kept.refuse_shut()
        if (asked or shown.poseset.mouth) == "declared":
            return made
        face = kept.poseset.model_copy(update={"reach": who.reach or shown.poseset.reach})
        solved = solved_face(replace(kept, poseset=face), self.mouths | who.mouths, self.likes)
        told += shown.unsolved
        if shown.resting:
            told.append(f"{shown.model.path}: solved without {', '.join(sorted(shown.resting))}")
        poseset = replace(self.poseset, model=kept.poseset)
        return replace(made, solved=solved, poseset=poseset, doubts=(*told,))

    def refuse_faults(self) -> None:
        """Raise an error with every fault that prevents a performance of these packs.

        Phonemes that this pair does not know may well be another language's, but must be some.
        """
        common, poseset, sound = self.common.model, self.poseset.model, self.library.sound
        rigs = {path.stem for path in self.library.rigs_of(poseset.name)}
        spoken = {found.name for found in self.library.names("language")}
        phonemes = self.known
        found = [
            *checks.check_phonemes(self.common),
            *([] if self.language in sound else checks.check_language(self.language, common)),
            *checks.check_poseset(self.poseset, phonemes),
        ]
        for bank in (*self.banks, *self.own_banks):
            found += checks.check_bank(bank, poseset, phonemes, spoken)
        # a bare pose set is its own character, and was checked as a pose set
        if self.character.path != self.poseset.path:
            styles = {bank.model.style for bank in (*self.banks, *self.own_banks)}
            found += checks.check_character(
                self.character,
                poseset,
                phonemes,
                rigs=rigs,
                languages=spoken,
                styles=styles,
                unsaved=self.library.unsaved,
            )
        faults = [f for f in found if f.severity == "fault"]
        if faults:
            raise PackFaults(sorted(set(faults)))
        sound.add(self.language)

    @cached_property
    def known(self) -> Collection[str]:
        """Phonemes that a pack may name: those of the pair, and of every other language."""
        common = self.common.model
        return KnownPhonemes(self.library, {*common.phonemes, *common.shades, *self.phonemes})

    @property
    def mouths(self) -> dict[str, tuple[models.SoundMouth, ...]]:
        """The mouth of each sound that states one; the character's own, if targets are solved."""
        stated = self.common.model.mouths(self.language.model.adds)
        return stated if self.solved is None else stated | self.character.model.mouths

    @cached_property
    def face(self) -> models.PoseSet:
        """The pose set, with solved targets, and the character's own, in place of its.

        Declared targets show the reach of the set; the reach of the character scales them.
        """
        poseset, who = self.poseset.model, self.character.model
        targets = dict(poseset.targets)
        if self.solved is not None:
            targets |= self.solved.targets
        elif who.reach is not None:
            targets = farther(poseset, who.reach / poseset.reach, self.mouths)
        return who.own_face(poseset.model_copy(update={"targets": targets}))

    @property
    def poses(self) -> tuple[str, ...]:
        """Pose names, in the order of the curves."""
        return tuple(self.poseset.model.poses)

    @property
    def phonemes(self) -> tuple[str, ...]:
        """Phonemes without shades: silence, the base, and the additions of the language."""
        model = self.common.model
        return (model.silence, *dict.fromkeys((*model.base, *self.language.model.adds)))

    @cached_property
    def parents(self) -> dict[str, str]:
        """The parent of each shade that the language can have."""
        shades = self.common.model.shades.items()
        return {name: shade.like for name, shade in shades if shade.like in self.phonemes}

    @cached_property
    def shades(self) -> tuple[str, ...]:
        """Shades of the language that a target or a bank distinguishes from their parents."""
        units = chain.from_iterable(chain(file.rows, file.halves) for file in self.drawn)
        shown = self.face.targets.keys() | set(chain.from_iterable(units))
        said = self.parents if self.language.model.automatic else self._mapped
        return tuple(name for name in self.parents if name in shown and name in said)

    @cached_property
    def _mapped(self) -> frozenset[str]:
        """Phonemes in labels and words of the language, and in words of the character."""
        model = self.language.model
        labels = (s.to for table in model.notations.values() for s in table.values())
        own = (words.values() for words in self.character.model.pronunciations.values())
        words = (reading.phonemes for reading in model.words.values())
        return frozenset(chain(*labels, *words, *chain(*own)))

    @property
    def numbered(self) -> tuple[str, ...]:
        """Every phoneme with rows of its own in the tables: `phonemes`, then `shades`."""
        return (*self.phonemes, *self.shades)

    @cached_property
    def numbers(self) -> dict[str, int]:
        """Number of each phoneme in the tables."""
        return {phoneme: number for number, phoneme in enumerate(self.numbered)}

    @cached_property
    def likes(self) -> dict[str, str]:
        """The substitute (`like`) of each added phoneme."""
        common = self.common.model.phonemes
        adds = {name: own or common.get(name) for name, own in self.language.model.adds.items()}
        return {name: one.like for name, one in adds.items() if one and one.like is not None}

    @cached_property
    def drawn(self) -> tuple[DrawnBigrams, ...]:
        """Bigrams of the first three layers by file; earlier files take precedence."""
        found = [self._file("character", self.character)]
        for bank in (*self.own_banks, *self.banks):
            layer = "character" if bank in self.own_banks else "shared"
            if layer == "shared" and bank.model.language is not None:
                if bank.model.language not in self.language.lineage:
                    continue
                layer = "language"
            found.append(self._file(layer, bank))
        return tuple(found)

    def _file(self, layer: str, pack: Pack[Any]) -> DrawnBigrams:
        style = getattr(pack.model, "style", NEUTRAL)
        halves = {}
        for key, trigram in pack.model.trigrams.items():
            one, two, three = key.split("-")
            row = self._drawn_row(layer, pack, ("trigrams", key), (one, two))
            first, second = trigram.boundaries or THIRDS
            origin = row.origin._replace(triple=(one, two, three))
            later = origin._replace(pair=(two, three))
            # each boundary as a share of its half: up to the second, and from the first on
            near, far = first / second, (second - first) / (1 - first)
            halves[one, two, three] = (
                replace(row, origin=origin, boundary=near, span=(0.0, second)),
                replace(row, origin=later, boundary=far, span=(first, 1.0)),
            )
        return DrawnBigrams(pack.path, layer, style, self.drawn_rows(layer, pack), halves)

    @cached_property
    def layers(self) -> Layers:
        """Bigrams of the first three layers, by style."""
        return _layered(self.drawn)

    @cached_property
    def _by_origin(self) -> tuple[Layers, Layers]:
        """The layers without fitted bigrams, and those of fitted ones, empty if there are none."""
        parts: list[list[DrawnBigrams]] = [[], []]
        for fitted, part in enumerate(parts):
            for file in self.drawn:
                rows = {p: r for p, r in file.rows.items() if (r.origin.status == FITTED) == fitted}
                part.append(file._replace(rows=rows))
        return _layered(parts[0]), _layered(parts[1]) if any(f.rows for f in parts[1]) else {}

    def redrawn(self, drawn: "tuple[DrawnBigrams, ...]") -> Self:
        """Return these packs with other bigrams in their files."""
        other = replace(self)
        kept = {name: value for name, value in vars(self).items() if name in UNDRAWN}
        vars(other).update(kept, drawn=drawn)
        if other.numbered == self.numbered:
            drafts = self.known_drafts
            vars(other).update(targets=self.targets, numbers=self.numbers, known_drafts=drafts)
        return other

    @property
    def styles(self) -> tuple[str, ...]:
        """Styles of the pair's banks, without neutral."""
        found = {style for layer in self.layers.values() for style in layer}
        return tuple(sorted(found - {NEUTRAL}))

    def drawn_rows(self, layer: str, pack: Pack[Any]) -> dict[Pair, BigramRow]:
        """Return the bigrams of a bank or a character as rows."""
        rows = {}
        for key, bigram in pack.model.bigrams.items():
            first, second = key.split("-")
            row = self._drawn_row(layer, pack, ("bigrams", key), (first, second))
            rows[first, second] = replace(row, boundary=bigram.boundary)
        return rows

    def _drawn_row(
        self, layer: str, pack: Pack[Any], loc: tuple[str, str], pair: Pair
    ) -> BigramRow:
        """Return the curves at a location of a pack as a row for two phonemes."""
        field, key = loc
        unit = getattr(pack.model, field)[key]
        linear = getattr(pack.model, "interpolation", "") == "linear"
        numbers = {pose: number for number, pose in enumerate(self.poses)}
        place = FilePlace(pack.path, *pack.source.where(loc, key=True))
        told = f"{shown(pack.path)}:{place.line}:{place.column}"
        return BigramRow(
            Origin(pair, layer, unit.status, (told,), unit.word),
            {numbers[p]: np.array(at, float) for p, at in unit.curves.items() if p in numbers},
            linear=unit.interpolation == "linear" or (linear and not unit.interpolation),
            free=unit.contact == "free",
            place=place,
            style=getattr(pack.model, "style", NEUTRAL),
        )

    def rows(self) -> list[BigramRow]:
        """Return the row of every ordered pair without shades."""
        asked = self.pairs()
        found = {pair: self.authored(pair) for pair in asked}
        drafts = self.drafts([pair for pair in asked if found[pair] is None])
        gaps = (BigramRow(Origin(pair, "gap", "", ()), {}) for pair in asked)
        return [found[pair] or drafts.get(pair, gap) for pair, gap in zip(asked, gaps, strict=True)]

    def shade_rows(self) -> dict[Pair, BigramRow]:
        """Return the row of every ordered pair with a shade, by pair.

        It is the row of a coarser pair (`origin.pair`) where a bank draws that one and not this.
        Rows of banks come before drafts.
        """
        pairs = self.shade_pairs()
        drawn = {pair for layer in self.layers.values() for rows in layer.values() for pair in rows}
        found = {}
        for pair in pairs:
            row = self.authored(pair)
            if row is not None:
                own = row.origin._replace(pair=pair) if pair in drawn else row.origin
                found[pair] = replace(row, origin=own)
        return found | self.drafts([pair for pair in pairs if pair not in found])

    def shade_pairs(self) -> list[Pair]:
        """Every ordered pair with at least one shade."""
        shades = {*self.shades}
        return [(a, b) for a in self.numbered for b in self.numbered if a in shades or b in shades]

    def drawn_shade_pairs(self) -> list[Pair]:
        """The pairs with a shade that a neutral bank draws, in their order."""
        drawn = {pair for layer in self.layers.values() for pair in layer.get(NEUTRAL, ())}
        return [pair for pair in self.shade_pairs() if pair in drawn]

    def row(self, pair: Pair) -> BigramRow:
        """Return the row of any pair, with or without shades, under the name of this pair."""
        authored = self.authored(pair)
        if authored is not None:
            return replace(authored, origin=authored.origin._replace(pair=pair))
        coarser = self._coarser(pair)
        drafts = self.drafts(coarser)
        found = next((drafts[one] for one in coarser if one in drafts), None)
        if found is None:
            return BigramRow(Origin(pair, "gap", "", ()), {})
        return replace(found, origin=found.origin._replace(pair=pair))

    def pairs(self) -> list[Pair]:
        """Every ordered pair of phonemes except silence with itself, without shades."""
        silence = self.common.model.silence
        return [(a, b) for a in self.phonemes for b in self.phonemes if {a, b} != {silence}]

    def authored(self, pair: Pair, style: str = NEUTRAL) -> BigramRow | None:
        """Return the bank row of a pair, or of its substitute (`like`) pair; None if there is none.

        Of a pair with shades it is the finest that a bank draws, down to that of their parents: a
        drawn parent comes before a drafted shade. Within a layer the style comes first, then
        neutral. A fitted row comes after all that a person drew, and before drafts.
        """
        unfitted, fitted = self._by_origin
        row = self._found(pair, style, unfitted)
        if fitted and (row is None or row.origin.status == DRAFTED):
            return self._found(pair, style, fitted) or row
        return row

    def drawn_by_hand(self, pair: Pair) -> BigramRow | None:
        """Return a neutral row that a person drew for a pair, or that is performed in its place."""
        files = (file.rows.get(pair) for file in self.drawn if file.style == NEUTRAL)
        rows = (row for row in (*files, self.authored(pair)) if row is not None)
        return next((row for row in rows if row.origin.status not in {DRAFTED, FITTED}), None)

    def _found(self, pair: Pair, style: str, layers: Layers) -> BigramRow | None:
        """Return the row of a pair, of a coarser one, or of its substitute, in some layers."""
        # from the finest: a drawn parent comes before a drafted shade
        for finer in self._coarser(pair):
            row = _stated(layers, finer, style)
            if row is not None:
                return row
        pair, likes = finer, self.likes
        alike = (likes.get(pair[0], pair[0]), likes.get(pair[1], pair[1]))
        row = _stated(layers, alike, style) if alike != pair else None
        return row and replace(row, origin=row.origin._replace(pair=pair, layer="like"))

    def _coarser(self, pair: Pair) -> list[Pair]:
        """Return a pair, then variants with parents in place of shades; the last has none."""
        first, second = pair
        parents = self.parents.get(first, first), self.parents.get(second, second)
        return [*dict.fromkeys((pair, (first, parents[1]), (parents[0], second), parents))]

    def drafts(self, pairs: list[Pair]) -> dict[Pair, BigramRow]:
        """Draft the pairs whose two phonemes have targets, each once."""
        targets, known = self.targets, self.known_drafts
        able = [pair for pair in pairs if pair[0] in targets and pair[1] in targets]
        new = [pair for pair in able if pair not in known]
        if new:
            values = draft([targets[a][0] for a, _ in new], [targets[b][0] for _, b in new])
            points = np.stack(np.broadcast_arrays(TIMES, values), axis=-1)
            moving: list[list[bool]] = (values != 0).any(axis=2).tolist()
            for pair, lines, moves in zip(new, points, moving, strict=True):
                places = tuple(targets[p][1] for p in pair if targets[p][1])
                curves = {pose: line for pose, line in enumerate(lines) if moves[pose]}
                row = BigramRow(Origin(pair, "draft", DRAFTED, places), curves, drafted=True)
                known[pair] = row
        return {pair: known[pair] for pair in able}

    @cached_property
    def known_drafts(self) -> dict[Pair, BigramRow]:
        """Drafts made so far, which changed bigrams leave alone."""
        return {}

    @cached_property
    def targets(self) -> dict[str, tuple[Target, str]]:
        """Target of each phoneme with its location; silence rests by default."""
        model = self.face
        bound = thresholds(model) < FREE
        found = {}
        for phoneme in self.numbered:
            name = self.target_phoneme(phoneme)
            if name in model.targets:
                found[phoneme] = (self._target(model.targets[name], bound), self._place(name))
        silence = self.common.model.silence
        if found and silence not in found:
            still = np.zeros((1, len(self.poses)))
            found[silence] = (Target(still, np.ones(len(self.poses))), "")
        return found

    def _place(self, phoneme: str) -> str:
        """Return the place of a phoneme's target, or of the mouth that it was solved for."""
        own = phoneme in self.character.model.targets
        if not own and self.solved is not None and phoneme in self.solved.targets:
            kind = "shades" if phoneme in self.common.model.shades else "phonemes"
            place = self.common.where((kind, phoneme, "mouth"))
            if phoneme in self.character.model.mouths:
                place = self.character.where(("mouths", phoneme))
            elif phoneme not in self.common.model.mouths():
                place = self.language.where(("adds", phoneme, "mouth"))
            return f"{place}, {self.solved.told(phoneme)}"
        return str((self.character if own else self.poseset).where(("targets", phoneme)))

    def target_phoneme(self, phoneme: str) -> str:
        """Return the phoneme whose target a phoneme uses: itself, its parent or its substitute."""
        targets = self.face.targets
        coarse = phoneme if phoneme in targets else self.parents.get(phoneme, phoneme)
        return coarse if coarse in targets else self.likes.get(coarse, coarse)

    def _target(self, steps: Iterable[models.PhonemeTarget], bound: Bools) -> Target:
        """Return a target as arrays; `bound` is (P, P), True for two poses with a constraint.

        A pose that is not named yields to the neighbours, unless a constraint sets it against one
        that is: a target that opens the jaw opposes pressed lips.
        """
        steps = tuple(steps)
        weights = [[step.weights.get(pose, 0.0) for pose in self.poses] for step in steps]
        stated = {pose: value for step in steps for pose, value in step.dominance.items()}
        overall = next((step.overall for step in steps if step.overall is not None), None)
        mentioned = {pose for step in steps for pose in step.weights}
        wanted = np.any(weights, axis=0)
        against = bound @ wanted
        dominance = []
        for pose, opposed in zip(self.poses, against, strict=True):
            usual = 1.0 if pose in mentioned or opposed else PASSIVE
            usual = usual if overall is None or opposed else overall
            dominance.append(stated.get(pose, usual))
        # above 0, since drafts divide by the sum of dominances
        return Target(np.array(weights), np.maximum(dominance, 1e-6))

    def usual_dominance(self, steps: "Iterable[Mapping[str, float]]") -> Floats:
        """Return the dominance (P,) of a target that states only the weights of each step."""
        plain = [PhonemeTarget(weights=dict(weights)) for weights in steps]
        return self._target(plain, thresholds(self.poseset.model) < FREE).dominance

    def contacts(self) -> Iterator[Contact]:
        """Contacts as arrays.

        An added phoneme has the contacts of its substitute, and a shade those of its parent unless
        its `contact` is `free`.
        """
        named = {p for c in self.poseset.model.contacts.values() for p in c.phonemes}
        meant = [self._touching(p, named) for p in self.numbered]
        for contact in self.poseset.model.contacts.values():
            demands = [p in contact.phonemes for p in meant]
            floor = [contact.floor.get(pose, 0.0) for pose in self.poses]
            ceiling = [contact.ceiling.get(pose, 1.0) for pose in self.poses]
            yield Contact(np.array(demands), np.array(floor), np.array(ceiling))

    def _touching(self, phoneme: str, named: Collection[str]) -> str:
        """Return the phoneme whose contacts a phoneme has; empty for a shade without any."""
        if phoneme in named:
            return phoneme
        if phoneme in self.parents:
            free = self.common.model.shades[phoneme].contact == "free"
            return "" if free else self._touching(self.parents[phoneme], named)
        return self.likes.get(phoneme, phoneme)

    def highest(self) -> Floats:
        """(P,) maximum weight of each pose in any target; 1 for a pose without a target.

        Shades are left out: their targets change no curve of other phonemes.
        """
        targets, shades = self.face.targets.items(), self.common.model.shades
        steps = [step for name, steps in targets if name not in shades for step in steps]
        tops = [max((s.weights.get(pose, 0.0) for s in steps), default=0.0) for pose in self.poses]
        return np.array([top or 1 for top in tops], float)

    def opposed(self) -> Bools:
        """(N, P) True if a phoneme's target names a pose and ends with it at 0; not for silence.

        A target with `W: 0` opposes early rounding.
        """
        targets = self.face.targets
        out = np.zeros((len(self.numbered), len(self.poses)), bool)
        for number, phoneme in enumerate(self.numbered[1:], start=1):
            steps = targets.get(self.target_phoneme(phoneme), ())
            # the last step is what the next sound follows; a diphthong may name a pose and leave it
            last = steps[-1].weights if steps else {}
            out[number] = [last.get(pose) == 0 for pose in self.poses]
        return out


def _layered(files: Iterable[DrawnBigrams]) -> Layers:
    """Return the bigrams of some files by layer and style; the earlier file wins."""
    layers: Layers = {layer: {} for layer in ("character", "language", "shared")}
    for file in files:
        layer = layers[file.layer]
        # later keys win in a merge, so what earlier files drew comes last
        layer[file.style] = {**file.rows, **layer.get(file.style, {})}
    return layers


def _stated(layers: Layers, pair: Pair, style: str) -> BigramRow | None:
    for layer in layers.values():
        for manner in dict.fromkeys((style, NEUTRAL)):
            if pair in layer.get(manner, ()):
                return layer[manner][pair]
    return None
