"""Figures of a report, from counted lines and a character."""

from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from lipsync_lang.base.arrays import Ints
from lipsync_lang.base.presentation.wording import percent
from lipsync_lang.performing.performer import Performer
from lipsync_lang.reports.coverage import plan
from lipsync_lang.reports.coverage.corpus import Count, Pages
from lipsync_lang.reports.coverage.report import (
    FITTED_STATUS,
    UNSTATED,
    AuthoredShare,
    BigramNeed,
    CoverageReport,
    NextHour,
    Sentence,
    TrigramNeed,
    WorkLeft,
    authored,
)
from lipsync_lang.resolver.compiled import Origin


class CountFigures:
    """A count, with the figures that do not depend on the character."""

    def __init__(self, counted: Count, pages: Pages) -> None:
        self.count = counted
        self.pages = pages
        self.examples = counted.examples()
        sounding = counted.sounding(np.arange(counted.size**2))
        self.spoken = np.where(sounding, counted.bigrams, 0)
        self.silent = np.where(sounding, 0, counted.bigrams)
        kinds = np.unique(counted.units)
        self.unused = kinds[sounding[kinds] & (counted.bigrams[kinds] == 0)].tolist()

    def trigrams(self, performer: Performer) -> tuple[TrigramNeed, ...]:
        """Return the trigrams that a character plays, most frequent first."""
        compiled, counted = performer.compiled, self.count
        found = [
            TrigramNeed(
                trigram=name,
                # a trigram plays in place of both of its bigrams
                count=counted.trigrams.get(name, Counter()).total() // 2,
                layer=origin.layer,
                status=origin.status,
                places=tuple(self.pages[n][0] for n in counted.first_trigrams.get(name, ())),
            )
            for name, origin in {one.name: one for one in compiled.origins if one.triple}.items()
        ]
        return tuple(sorted(found, key=lambda need: (-need.count, need.trigram)))

    def bigrams(
        self,
        counts: Ints,
        origins: dict[int, Origin],
        names: Sequence[str],
        trigrams: Iterable[TrigramNeed],
    ) -> tuple[BigramNeed, ...]:
        """Return the ranked bigrams; authored trigrams replace some of their occurrences."""
        within: Counter[int] = Counter()
        for one in trigrams:
            if authored(one.layer, one.status):
                within.update(self.count.trigrams.get(one.trigram, ()))
        total, running = int(counts.sum()), 0
        found = []
        for code in plan.ranked(counts):
            number = int(counts[code])
            running += number
            origin = origins[code]
            found.append(
                BigramNeed(
                    bigram=names[code],
                    count=number,
                    percent=percent(number, total),
                    running=percent(running, total),
                    layer=origin.layer,
                    status=origin.status,
                    example=self.examples.get(code, ""),
                    places=tuple(self.pages[line][0] for line in self.count.first[code]),
                    in_trigrams=within[code],
                    stated="" if origin.layer in UNSTATED else origin.places[0],
                )
            )
        return tuple(found)

    def sentences(self, missing: Sequence[int], names: Sequence[str]) -> tuple[Sentence, ...]:
        """Return a short list of lines that together have all missing bigrams."""
        sets, starts = self.count.sets()
        found = []
        for line, new in plan.cover(sets, starts, np.array(missing, np.int64)):
            place, text = self.pages[line]
            bigrams = tuple(names[code] for code in new)
            found.append(Sentence(place=place, text=text, bigrams=bigrams))
        return tuple(found)


def report_of(
    performer: Performer,
    counted_lines: CountFigures,
    minutes: float,
    title: str,
    *,
    sentences: bool = True,
) -> CoverageReport:
    """Return the report of counted lines for a character.

    Parameters
    ----------
    minutes : minutes of work for a bigram
    sentences : False for no short list of lines, which takes most of the time
    """
    counted, compiled = counted_lines.count, performer.compiled
    phonemes = compiled.phonemes
    names = [f"{a}-{b}" for a in phonemes for b in phonemes]
    codes = {name: code for code, name in enumerate(names)}
    bigrams = (origin for origin in compiled.origins[1:] if origin.triple is None)
    origins = {codes[one.name]: one for one in bigrams}
    trigrams = counted_lines.trigrams(performer)
    rows = counted_lines.bigrams(counted_lines.spoken, origins, names, trigrams)
    total = sum(row.count for row in rows)
    missing = [row for row in rows if not row.authored]
    # what was fitted to captures waits for a check alone
    soon = sorted(missing, key=lambda row: row.status == FITTED_STATUS)[: plan.affordable(minutes)]
    drawn = sum(row.covered for row in rows)
    gain = sum(row.count - row.covered for row in soon)
    return CoverageReport(
        language=performer.language,
        language_title=title or performer.language,
        character=performer.character,
        poseset=compiled.poseset,
        lines=counted.lines,
        words=counted.words,
        phonemes={name: int(counted.phonemes[n]) for n, name in enumerate(compiled.counted) if n},
        occurrences=total,
        bigrams=rows,
        silence=counted_lines.bigrams(counted_lines.silent, origins, names, trigrams),
        unused=tuple(names[code] for code in counted_lines.unused),
        needed=plan.needed([row.count for row in rows]),
        authored=AuthoredShare(bigrams=len(rows) - len(missing), percent=percent(drawn, total)),
        left=WorkLeft(bigrams=len(missing), hours=round(len(missing) * minutes / 60, 2)),
        next_hour=NextHour(bigrams=tuple(r.bigram for r in soon), percent=percent(gain, total)),
        sentences=counted_lines.sentences([codes[row.bigram] for row in missing], names)
        if sentences
        else (),
        unread=counted.unread.tallies(),
        unmapped=counted.unmapped.tallies(),
        other_scripts=counted.others.tallies(),
        entries=counted.entries.tallies(),
        trigrams=trigrams,
    )
