"""A compiled pair that takes changed bigrams without reading its packs again.

Reading a bank in which all 483 bigrams are drawn takes 0.1 to 0.4 s, and the studio has 0.1 s
for an edit. So only the changed entries are read, checked, drafted and sampled. All pairs are then
looked up again, which takes 0.01 s.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from lipsync_lang.packs.checking.pack_checks import check_bigrams
from lipsync_lang.packs.finding import pack_name
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models.validation import validated
from lipsync_lang.packs.pack import FilePlace, Pack
from lipsync_lang.packs.splicing import INDEPENDENT, SplicedText
from lipsync_lang.packs.yaml.building import scan
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.packs.yaml.source import Data
from lipsync_lang.resolver.compile import PairRows, bigram_fields, compile_packs
from lipsync_lang.resolver.compiled import CompiledPair
from lipsync_lang.resolver.layers import DrawnBigrams, PairPacks


@dataclass(frozen=True, eq=False)
class OpenPair:
    """A compiled pair with its packs and bigrams, and the data of their files by path."""

    compiled: CompiledPair
    shelf: PairPacks
    rows: PairRows
    data: Mapping[Path, Data]

    @classmethod
    def open(cls, library: Library, language: str, character: str) -> Self:
        """Compile a pair as `compile_pair` does, and keep its packs; errors are as there."""
        shelf = PairPacks.open(library, language, character)
        packs: tuple[Pack[Any], ...] = (shelf.character, *shelf.own_banks, *shelf.banks)
        rows = PairRows.of(shelf)
        return cls(compile_packs(shelf, rows), shelf, rows, {p.path: p.source.data for p in packs})

    def retouched(self, texts: Iterable[SplicedText]) -> Self | None:
        """Return the pair with bigrams from texts instead of their files.

        The result equals the pair compiled again, except that bigrams below an inserted or deleted
        line keep the line number that they had. None means that more changed in the texts than
        bigrams of the pair's files: it must be compiled again. Raise `PackFaults` for a bigram that
        names an unknown phoneme or pose.
        """
        data, drawn = dict(self.data), self.shelf.drawn
        for text in texts:
            if text.path not in data:
                return None
            old, new = data[text.path], text.data
            # trigrams too: their rows change the numbers of all rows behind them
            if not isinstance(new, dict) or {**old, INDEPENDENT: 0} != {**new, INDEPENDENT: 0}:
                return None
            before, after = old.get(INDEPENDENT) or {}, new.get(INDEPENDENT) or {}
            keys = [key for key in {**before, **after} if before.get(key) != after.get(key)]
            data[text.path] = new
            if keys:
                drawn = tuple(self._redrawn(file, text, keys) for file in drawn)
        if drawn is self.shelf.drawn:
            return replace(self, data=data)
        shelf = self.shelf.redrawn(drawn)
        rows, compiled = PairRows.of(shelf), self.compiled
        earlier = self.rows.every, compiled.tables.curves
        made = replace(compiled, **bigram_fields(shelf, rows, earlier))
        return type(self)(made, shelf, rows, data)

    def _redrawn(
        self, file: DrawnBigrams, text: SplicedText, keys: Collection[str]
    ) -> DrawnBigrams:
        """Return the bigrams of a file with some of them read from a text."""
        if file.path != text.path:
            return file
        made = self.shelf.drawn_rows(file.layer, _sound(self.shelf, text, keys))
        gone = {tuple(key.split("-")) for key in keys}
        rows = {pair: row for pair, row in file.rows.items() if pair not in gone}
        for pair, row in made.items():
            # the place in the whole text: the one of `made` is in a part of it
            place = FilePlace(text.path, *text.place((INDEPENDENT, "-".join(pair))))
            origin = row.origin._replace(places=(str(place),))
            rows[pair] = replace(row, place=place, origin=origin)
        return file._replace(rows=rows)


def _sound(shelf: PairPacks, text: SplicedText, keys: Collection[str]) -> Pack[Any]:
    """Return the pack of a text with some of its bigrams alone; raise `PackFaults` for theirs."""
    source = text.only(keys)
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
