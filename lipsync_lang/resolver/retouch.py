"""Fast changes of the bigrams in a compiled pair.

Compiling looks up every pair in every layer and samples every curve. A changed bigram concerns few
pairs: its own, those with shades of its phonemes, and those that it stands in for (`like`).
Their rows are looked up again; all other samples are taken over.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from lipsync_lang.packs.checking.pack_checks import check_bigrams
from lipsync_lang.packs.library import FilePlace, Pack
from lipsync_lang.packs.models.validation import validated
from lipsync_lang.packs.splicing import INDEPENDENT, SplicedText, pack_name
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.packs.yaml.source import Data, YamlSource, scan
from lipsync_lang.pipeline.arrays import Singles
from lipsync_lang.pipeline.tables import Bank, Tables
from lipsync_lang.resolver.compile import (
    PairRows,
    compiled,
    differing,
    frozen,
    marks,
    row_numbers,
    styled,
    tabulated,
    told,
)
from lipsync_lang.resolver.compiled import Compiled, Pair
from lipsync_lang.resolver.layers import BigramRow, DrawnBigrams, PairPacks

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library


@dataclass(frozen=True, eq=False)
class OpenPair:
    """A compiled pair with its packs.

    Parameters
    ----------
    compiled : for a `Performer`
    shelf : its packs
    rows : its bigrams
    data : the data of each file with bigrams, by path
    """

    compiled: Compiled
    shelf: PairPacks
    rows: PairRows
    data: Mapping[Path, Data]

    @classmethod
    def open(cls, library: "Library", language: str, character: str) -> Self:
        """Compile a pair as `compile_pair` does, and keep its packs.

        Raises
        ------
        PackError
            A pack is missing or unsound, or two of them do not fit.
        """
        shelf = PairPacks.open(library, language, character)
        packs: tuple[Pack[Any], ...] = (shelf.character, *shelf.own_banks, *shelf.banks)
        rows = PairRows.of(shelf)
        return cls(compiled(shelf, rows), shelf, rows, {p.path: p.source.data for p in packs})

    def retouched(self, texts: Iterable[SplicedText]) -> Self | None:
        """Return the pair with bigrams from texts instead of their files.

        The result equals the pair compiled again, except that bigrams below an inserted or deleted
        line keep the line number that they had.

        Parameters
        ----------
        texts : files that changed

        Returns
        -------
        None if more changed than bigrams of the pair's files: it must be compiled again

        Raises
        ------
        PackFaults
            A bigram names an unknown phoneme or pose.
        """
        data, drawn, touched = dict(self.data), self.shelf.drawn, set[Pair]()
        for text in texts:
            if text.path not in data:
                return None
            old, new = data[text.path], text.data
            if not isinstance(new, dict) or _without_bigrams(old) != _without_bigrams(new):
                return None
            before, after = old.get(INDEPENDENT) or {}, new.get(INDEPENDENT) or {}
            keys = [key for key in {**before, **after} if before.get(key) != after.get(key)]
            data[text.path] = new
            if keys:
                drawn = tuple(self._redrawn(file, text, keys) for file in drawn)
                touched |= {_pair(key) for key in keys}
        if not touched:
            return replace(self, data=data)
        return self._with(self.shelf.redrawn(drawn), touched, data)

    def _redrawn(
        self, file: DrawnBigrams, text: SplicedText, keys: Collection[str]
    ) -> DrawnBigrams:
        """Return the bigrams of a file with some of them read from a text."""
        if file.path != text.path:
            return file
        made = self.shelf.drawn_rows(file.layer, _sound(self.shelf, text, keys))
        made = {pair: _placed(row, text) for pair, row in made.items()}
        rows = dict(file.rows)
        for pair in map(_pair, keys):
            rows.pop(pair, None)
        return file._replace(rows=rows | made)

    def _with(self, shelf: PairPacks, touched: Collection[Pair], data: Mapping[Path, Data]) -> Self:
        """Return the pair with other bigrams in its packs, which differ in some pairs."""
        if shelf.styles != self.shelf.styles or shelf.numbered != self.shelf.numbered:
            rows = PairRows.of(shelf)
            return replace(self, compiled=compiled(shelf, rows), shelf=shelf, rows=rows, data=data)
        rows = _looked_up(shelf, self.rows, _concerned(shelf, touched))
        tables = _retabulated(shelf, self.rows, rows, self.compiled.tables)
        made = replace(self.compiled, tables=tables, **told(shelf, rows, tables))
        return replace(self, compiled=made, shelf=shelf, rows=rows, data=data)


def _without_bigrams(data: Data) -> Data:
    return {key: value for key, value in data.items() if key != INDEPENDENT}


def _pair(key: str) -> Pair:
    first, _, second = key.partition("-")
    return first, second


def _sound(shelf: PairPacks, text: SplicedText, keys: Collection[str]) -> Pack[Any]:
    """Return the pack of a text with some of its bigrams alone; raise `PackFaults` for theirs."""
    some = text.data.get(INDEPENDENT) or {}
    data = {**text.data, INDEPENDENT: {key: some[key] for key in keys if key in some}}
    source = YamlSource(text.path, data)
    for whole in (False, True):  # the places of faults need the whole text
        model, faults = validated(source, name=pack_name(text.path))
        pack: Pack[Any] = Pack(model, (source,))
        if model is not None:
            bigrams = pack.model.bigrams
            faults = tuple(check_bigrams(pack, bigrams, shelf.poseset.model, shelf.known))
        if not faults:
            break
        if whole:
            raise PackFaults(sorted(faults))
        source = scan(text.path, text.content)
    return pack


def _placed(row: BigramRow, text: SplicedText) -> BigramRow:
    """Return a row with its place in a text."""
    key = "-".join(row.origin.pair)
    line, column = text.place((INDEPENDENT, key))
    place = FilePlace(text.path, line, column)
    return replace(row, place=place, origin=row.origin._replace(places=(str(place),)))


def _concerned(shelf: PairPacks, touched: Collection[Pair]) -> set[Pair]:
    """Return every pair whose look-up may depend on a changed pair."""
    meets: dict[str, list[str]] = {}
    for phoneme in shelf.numbered:
        parent = shelf.parents.get(phoneme, phoneme)
        for other in {phoneme, parent, shelf.likes.get(parent, parent)}:
            meets.setdefault(other, []).append(phoneme)
    return {
        (a, b) for one, other in touched for a in meets.get(one, ()) for b in meets.get(other, ())
    }


def _looked_up(shelf: PairPacks, old: PairRows, concerned: Collection[Pair]) -> PairRows:
    """Return rows with some pairs looked up again."""
    counted = [row.origin.pair for row in old.counted if row.origin.pair in concerned]
    fresh = dict(zip(counted, shelf.rows(counted), strict=True))
    finer = [pair for pair in shelf.shade_pairs() if pair in concerned]
    kept = {pair: row for pair, row in old.finer.items() if pair not in concerned}
    shades = kept | shelf.shade_rows(finer)
    order = [pair for pair in shelf.shade_pairs() if pair in shades]
    drawn = [pair for pair in order if not shades[pair].drafted]
    drafts = [pair for pair in order if shades[pair].drafted]
    rows = PairRows(
        [fresh.get(row.origin.pair, row) for row in old.counted],
        {pair: shades[pair] for pair in (*drawn, *drafts)},
        {},
        old.halves,
        old.played,
    )
    return replace(rows, styles=dict(_styles(shelf, old, rows, concerned)))


def _styles(
    shelf: PairPacks, old: PairRows, rows: PairRows, concerned: Collection[Pair]
) -> Iterable[tuple[str, list[BigramRow]]]:
    for style, before in old.styles.items():
        kept = {row.origin.pair: one for row, one in zip(old.bigrams, before, strict=False)}
        bigrams = [
            styled(shelf, row, style) if row.origin.pair in concerned else kept[row.origin.pair]
            for row in rows.bigrams
        ]
        yield style, rows.with_halves(bigrams)


def _retabulated(shelf: PairPacks, old: PairRows, new: PairRows, tables: Tables) -> Tables:
    """Return tables that reuse the unchanged rows."""
    curves = _taken(tables.curves, old.every, new.every)
    boundary, free = marks(new.every)
    styles = []
    for bank, style in zip(tables.styles, new.styles, strict=True):
        rows = new.styles[style]
        own = _taken(bank.curves, old.styles[style], rows)
        plain = np.ones(len(own), bool)
        plain[differing(rows, new.every)] = False
        own[plain] = curves[plain]
        styles.append(Bank(own, *marks(rows)))
    played = row_numbers(shelf, new)
    return frozen(tables.with_rows(Bank(curves, boundary, free), tuple(styles), played))


def _taken(curves: Singles, old: Sequence[BigramRow], new: Sequence[BigramRow]) -> Singles:
    """Return the samples of new rows, reused for unchanged rows."""
    numbers = {id(row): number for number, row in enumerate(old, 1)}
    places = [numbers.get(id(row), 0) for row in new]
    made: Singles = curves[[0, *places]]
    fresh = [number for number, place in enumerate(places, 1) if not place]
    made[fresh] = tabulated([new[number - 1] for number in fresh], curves.shape[2])[1:]
    return made
