"""Reports for every language on every character, from one reading of the lines."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.coverage import plan
from lipsync_lang.coverage.corpus import Count, Pages, count
from lipsync_lang.coverage.report import (
    Authored,
    BigramNeed,
    Corpus,
    Coverage,
    CoverageReport,
    Left,
    NextHour,
    Sentence,
    Shared,
    Tally,
    TrigramNeed,
    authored,
)
from lipsync_lang.coverage.scripts import scripts_of
from lipsync_lang.errors import LipsyncError
from lipsync_lang.packs.finding import Paths, folders_of

if TYPE_CHECKING:
    from lipsync_lang.lines import Line
    from lipsync_lang.packs.models.language_models import Language
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.resolver.compiled import Origin


def coverage(
    lines: "Iterable[Line]",
    language: str | Path | Iterable[str | Path],
    character: str | Path | Iterable[str | Path],
    *,
    paths: Paths = (),
    minutes: float = 5.0,
) -> Coverage:
    """Count the bigrams that lines need, and those that characters have.

    Parameters
    ----------
    lines : to be spoken, such as `read_lines` yields; iterated over once
    language, character : names or files, one or several: there is a report for each pair
    paths : a folder to search for packs before all others, or several
    minutes : to author a bigram

    Raises
    ------
    LipsyncError
        There are no lines, a pack is missing or unsound, or a language does not read text.
    """
    if not 0 < minutes < float("inf"):
        raise LipsyncError(f"{minutes:g} minutes a bigram: give a number above 0")
    pairs = _resolved(_names(language), _names(character), folders_of(paths))
    reading: list[Performer] = []
    reader_of = [_reader_index(performer, reading) for performer in pairs]
    packs = {performer.language: _pack(performer) for performer in pairs}
    scripts = [scripts_of(packs[performer.language]) for performer in reading]
    with Pages() as pages:
        corpus, counts = count(lines, reading, scripts, pages)
        if not corpus.lines:
            raise LipsyncError(
                "there are no lines to count; give files, or folders, that hold some text"
            )
        counted_lines = [CountFigures(one, pages) for one in counts]
        reports = tuple(
            report_of(performer, counted_lines[at], minutes, packs[performer.language].title)
            for performer, at in zip(pairs, reader_of, strict=True)
        )
    shared = {p.language: _shared(p, counts[at]) for p, at in zip(pairs, reader_of, strict=True)}
    return Coverage(corpus=corpus, minutes=minutes, reports=reports, shared=tuple(shared.values()))


def joined(documents: Mapping[str | None, Coverage]) -> Coverage:
    """Join the documents of a table's columns into one.

    Parameters
    ----------
    documents : by column; reports name their column if a language is in several
    """
    if len(documents) == 1:
        return next(iter(documents.values()))
    corpora = [document.corpus for document in documents.values()]
    dropped: dict[str, Tally] = {}
    for tally in (tally for corpus in corpora for tally in corpus.dropped):
        known = dropped.get(tally.what)
        total = tally.count + (known.count if known else 0)
        dropped[tally.what] = (known or tally).model_copy(update={"count": total})
    reports = tuple(_with_columns(documents))
    return Coverage(
        corpus=Corpus(
            files=tuple(dict.fromkeys(file for corpus in corpora for file in corpus.files)),
            lines=sum(corpus.lines for corpus in corpora),
            words=sum(corpus.words for corpus in corpora),
            dropped=tuple(sorted(dropped.values(), key=lambda tally: -tally.count)),
        ),
        minutes=next(iter(documents.values())).minutes,
        reports=reports,
        shared=tuple(_used_by_any(documents.values(), reports)),
    )


def _with_columns(documents: Mapping[str | None, Coverage]) -> Iterator[CoverageReport]:
    """Yield all reports, with their columns where a language has several."""
    languages = [{report.language for report in d.reports} for d in documents.values()]
    columns = Counter(language for found in languages for language in found)
    for column, document in documents.items():
        for report in document.reports:
            several = columns[report.language] > 1
            yield report.model_copy(update={"column": column or ""}) if several else report


def _used_by_any(
    documents: Iterable[Coverage], reports: Sequence[CoverageReport]
) -> Iterator[Shared]:
    """Yield the additions of each language, with the number that any of its columns needs."""
    found = {one.language: one for document in documents for one in document.shared}
    for one in found.values():
        needed = {
            bigram.bigram
            for report in reports
            if report.language == one.language
            for bigram in report.bigrams
            if not set(one.phonemes).isdisjoint(bigram.bigram.split("-"))
        }
        yield one.model_copy(update={"used": len(needed)})


def _names(given: str | Path | Iterable[str | Path]) -> list[str | Path]:
    return [given] if isinstance(given, (str, Path)) else list(dict.fromkeys(given))


def _resolved(
    languages: Sequence[str | Path], characters: Sequence[str | Path], paths: Paths
) -> "list[Performer]":
    from lipsync_lang.performing.resolving import resolve

    return [
        resolve(language, character, paths=paths, gaps="rest")
        for language in languages
        for character in characters
    ]


def _reader_index(performer: "Performer", reading: "list[Performer]") -> int:
    """Return the index of a performer that counts the same; append this one if there is none."""
    for number, other in enumerate(reading):
        mine, others = performer.compiled, other.compiled
        trigrams = mine.report.trigrams.keys() == others.report.trigrams.keys()
        if (mine.manner, mine.words) == (others.manner, others.words) and trigrams:
            return number
    reading.append(performer)
    return len(reading) - 1


def _pack(performer: "Performer") -> "Language":
    from lipsync_lang.packs.library import Library

    return Library(performer.paths).language(performer.language).model


class CountFigures:
    """A count, with the figures that are the same for every character."""

    def __init__(self, counted: Count, pages: Pages) -> None:
        self.count = counted
        self.pages = pages
        self.examples = counted.examples()
        codes = np.arange(counted.size**2)
        sounding = counted.sounding(codes)
        self.spoken = np.where(sounding, counted.bigrams, 0)
        self.silent = np.where(sounding, 0, counted.bigrams)
        self.unused = [int(c) for c in codes if sounding[c] and not counted.bigrams[c]]

    def trigrams(self, performer: "Performer") -> tuple[TrigramNeed, ...]:
        """Return the trigrams that a character plays, most frequent first.

        Those of shades are left out, as bigrams of shades are.
        """
        compiled, counted = performer.compiled, self.count
        numbers = {name: number for number, name in enumerate(compiled.counted)}
        found = []
        for name, origin in {one.name: one for one in compiled.origins if one.triple}.items():
            one, two, three = (numbers.get(phoneme, -1) for phoneme in origin.triple or ())
            if min(one, two, three) < 0:
                continue
            lines = counted.first_trigrams.get((one, two, three), ())
            need = TrigramNeed(
                trigram=name,
                count=counted.trigrams.get((one, two, three), 0),
                layer=origin.layer,
                status=origin.status,
                places=tuple(self.pages[line][0] for line in lines),
            )
            found.append(need)
        return tuple(sorted(found, key=lambda need: (-need.count, need.trigram)))

    def bigrams(
        self,
        counts: plan.Ints,
        origins: "dict[int, Origin]",
        names: Sequence[str],
        within: Mapping[str, int],
    ) -> tuple[BigramNeed, ...]:
        """Return the ranked bigrams with layer and status of each.

        Parameters
        ----------
        within : occurrences that authored trigrams play, by bigram
        """
        total, running = int(counts.sum()), 0
        found = []
        for code in plan.ranked(counts):
            number = int(counts[code])
            running += number
            found.append(
                BigramNeed(
                    bigram=names[code],
                    count=number,
                    percent=plan.percent(number, total),
                    running=plan.percent(running, total),
                    layer=origins[code].layer,
                    status=origins[code].status,
                    example=self.examples.get(code, ""),
                    places=tuple(self.pages[line][0] for line in self.count.first[code]),
                    in_trigrams=within.get(names[code], 0),
                )
            )
        return tuple(found)

    def sentences(self, missing: Sequence[int], names: Sequence[str]) -> tuple[Sentence, ...]:
        """Return a short list of lines that together hold all missing bigrams."""
        sets, starts = self.count.sets()
        return tuple(
            Sentence(
                place=self.pages[line][0],
                text=self.pages[line][1],
                bigrams=tuple(names[code] for code in new),
            )
            for line, new in plan.cover(sets, starts, np.array(missing, np.int64))
        )


def report_of(
    performer: "Performer",
    counted_lines: CountFigures,
    minutes: float,
    title: str,
    *,
    sentences: bool = True,
) -> CoverageReport:
    """Return what lines that were counted need of a character.

    Parameters
    ----------
    performer : of the language that the lines were counted in
    minutes : to author a bigram
    title : of the language
    sentences : False to leave out the short list of lines, which takes the longest
    """
    counted, phonemes = counted_lines.count, performer.compiled.counted
    names = [f"{a}-{b}" for a in phonemes for b in phonemes]
    codes = {name: code for code, name in enumerate(names)}
    bigrams = (origin for origin in performer.compiled.origins if origin.triple is None)
    origins = {codes[one.name]: one for one in bigrams if one.name in codes}
    trigrams = counted_lines.trigrams(performer)
    within = _within(trigrams)
    rows = counted_lines.bigrams(counted_lines.spoken, origins, names, within)
    total = sum(row.count for row in rows)
    missing = [row for row in rows if not row.authored]
    done = [row for row in rows if row.authored]
    soon = missing[: plan.affordable(minutes)]
    return CoverageReport(
        language=performer.language,
        language_title=title or performer.language,
        character=performer.character,
        poseset=performer.compiled.poseset,
        lines=counted.lines,
        words=counted.words,
        phonemes={name: int(counted.phonemes[n]) for n, name in enumerate(phonemes) if n},
        occurrences=total,
        bigrams=rows,
        silence=counted_lines.bigrams(counted_lines.silent, origins, names, within),
        unused=tuple(names[code] for code in counted_lines.unused),
        needed=plan.needed([row.count for row in rows]),
        authored=Authored(
            bigrams=len(done), percent=plan.percent(sum(row.covered for row in rows), total)
        ),
        left=Left(bigrams=len(missing), hours=round(len(missing) * minutes / 60, 2)),
        next_hour=NextHour(bigrams=tuple(r.bigram for r in soon), percent=_left(soon, total)),
        sentences=counted_lines.sentences([codes[row.bigram] for row in missing], names)
        if sentences
        else (),
        unread=counted.unread.tallies(),
        unmapped=counted.unmapped.tallies(),
        other_scripts=counted.others.tallies(),
        trigrams=trigrams,
    )


def _within(trigrams: Iterable[TrigramNeed]) -> Counter[str]:
    """Count the occurrences of bigrams that authored trigrams play in their place."""
    found: Counter[str] = Counter()
    for one in trigrams:
        if authored(one.layer, one.status):
            first, middle, last = one.trigram.split("-")
            found[f"{first}-{middle}"] += one.count
            found[f"{middle}-{last}"] += one.count
    return found


def _left(rows: Sequence[BigramNeed], total: int) -> float:
    """Return the percentage of all occurrences that rows cover once they are drawn."""
    return plan.percent(sum(row.count - row.covered for row in rows), total)


def _shared(performer: "Performer", counted: Count) -> Shared:
    report = performer.report
    own = {performer.compiled.phonemes.index(name) for name in report.added}
    used = [
        code
        for code in np.flatnonzero(counted.bigrams).tolist()
        if code >= counted.size and code % counted.size and own & set(divmod(code, counted.size))
    ]
    return Shared(
        language=performer.language,
        phonemes=report.added,
        bigrams=report.extra,
        used=len(used),
    )
