"""The total of all reports: the work that is left, with shared work counted once, and its order.

A work item is a bigram of a pose set. Drawn once in the pose set's bank, it serves every language
that needs it and every face of that pose set. A draft in the bank of one language or one character
is an item of its own, because it takes precedence over the shared bank.

The gain of an item is its share of the missing occurrences of each language, averaged over the
languages. Languages have equal weights by default, because each player hears one language.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter

from lipsync_lang.base.grouping import grouped
from lipsync_lang.base.presentation.wording import WHOLE_PERCENT, rounded
from lipsync_lang.reports.coverage import plan
from lipsync_lang.reports.coverage.report import (
    AuthoredShare,
    BigramNeed,
    Corpus,
    Coverage,
    CoverageReport,
    FaceTotal,
    LanguageAddition,
    NextHour,
    Total,
    WorkItem,
    WorkKey,
    WorkLeft,
)
from lipsync_lang.resolver.compiled import Report


def total_of(
    reports: Sequence[CoverageReport], minutes: float, weights: Mapping[str, float] | None = None
) -> Total:
    """Return the total of reports, with minutes per bigram; a language without a weight has 1."""
    stated = weights or {}
    full = {report.language: float(stated.get(report.language, 1)) for report in reports}
    totals: list[FaceTotal] = []
    for character, own in grouped((report.character, report) for report in reports).items():
        figures, _ = _figures(own, minutes, full)
        totals.append(FaceTotal(**figures, character=character, poseset=own[0].poseset))
    figures, ranking = _figures(reports, minutes, full)
    return Total(**figures, weights=full, faces=tuple(totals), ranking=tuple(ranking))


def _figures(
    reports: Sequence[CoverageReport], minutes: float, weights: Mapping[str, float]
) -> tuple[dict[str, object], list[WorkItem]]:
    """Return the fields of `TotalFigures`, and the work that is left, the largest gain first."""
    worth = _worth(reports, weights)
    done = sum(need.covered * worth[one.language] for one in reports for need in one.bigrams)
    ranking = _ranking(reports, worth, done)
    needed = {piece_of(report, need) for report in reports for need in report.bigrams}
    soon = ranking[: plan.affordable(minutes)]
    left = len(ranking)
    gain = round(max(soon[-1].reaches - done, 0.0), 4) if soon else 0.0
    is_all = not any(item.percent for item in ranking)
    figures: dict[str, object] = {
        "languages": tuple(dict.fromkeys(report.language for report in reports)),
        "needed": len(needed),
        "authored": AuthoredShare(bigrams=len(needed) - left, percent=rounded(done, is_all=is_all)),
        "left": WorkLeft(bigrams=left, hours=round(left * minutes / 60, 2)),
        "next_hour": NextHour(bigrams=tuple(item.bigram for item in soon), percent=gain),
    }
    return figures, ranking


def _ranking(
    reports: Sequence[CoverageReport], worth: Mapping[str, float], reached: float
) -> list[WorkItem]:
    """Rank the work that is left from the percentage `reached` on, the largest gain first."""
    gains: defaultdict[WorkKey, float] = defaultdict(float)
    counts: Counter[WorkKey] = Counter()
    serves: dict[WorkKey, list[CoverageReport]] = {}
    for report in reports:
        for need in report.bigrams:
            if not need.authored:
                piece, missing = piece_of(report, need), need.count - need.covered
                gains[piece] += missing * worth[report.language]
                counts[piece] += missing
                serves.setdefault(piece, []).append(report)
    items: list[WorkItem] = []
    # Rounded: sums of equal gains in another order must not decide the ranking.
    for piece in sorted(serves, key=lambda one: (-round(gains[one], 9), one)):
        reached += gains[piece]
        items.append(
            WorkItem(
                **piece._asdict(),
                count=counts[piece],
                percent=rounded(gains[piece], is_all=False),
                reaches=round(min(reached, WHOLE_PERCENT), 4),
                languages=tuple(dict.fromkeys(report.language for report in serves[piece])),
                characters=tuple(dict.fromkeys(report.character for report in serves[piece])),
            )
        )
    return items


def piece_of(report: CoverageReport, need: BigramNeed) -> WorkKey:
    """Return the work item of a bigram of a report."""
    own = {"language": report.language, "character": report.character}
    return WorkKey(need.bigram, report.poseset, own.get(need.layer, ""))


def _worth(reports: Sequence[CoverageReport], weights: Mapping[str, float]) -> dict[str, float]:
    """Return the percentage of one occurrence in each language."""
    heard: Counter[str] = Counter()
    for report in reports:
        heard[report.language] += report.occurrences
    whole = sum(weights[language] for language, number in heard.items() if number)
    return {
        language: WHOLE_PERCENT * weights[language] / (whole * number) if number and whole else 0.0
        for language, number in heard.items()
    }


def joined(
    documents: Sequence[tuple[str | None, Coverage]], weights: Mapping[str, float] | None = None
) -> Coverage:
    """Join the documents of columns into one; reports name theirs if a language is in several."""
    if len(documents) == 1:
        return documents[0][1]
    corpora = [document.corpus for _, document in documents]
    asides = grouped((one.what, one) for corpus in corpora for one in corpus.dropped).values()
    counts = [{"count": sum(one.count for one in own)} for own in asides]
    dropped = [own[0].model_copy(update=one) for own, one in zip(asides, counts, strict=True)]
    speakers = grouped((one.what, one) for corpus in corpora for one in corpus.other_speakers)
    # not a sum, because all columns have the same rows
    others = (max(own, key=attrgetter("count")) for own in speakers.values())
    # A language in two columns is two readings of one script: their reports name the column.
    read_in = {(one.language, at) for at, (_, d) in enumerate(documents) for one in d.reports}
    columns = Counter(language for language, _ in read_in)
    reports = tuple(
        one.model_copy(update={"column": column or ""}) if columns[one.language] > 1 else one
        for column, document in documents
        for one in document.reports
    )
    minutes = documents[0][1].minutes
    added = {one.language: one for _, document in documents for one in document.shared}
    return Coverage(
        corpus=Corpus(
            files=tuple(dict.fromkeys(file for corpus in corpora for file in corpus.files)),
            lines=sum(corpus.lines for corpus in corpora),
            heard=sum(corpus.heard for corpus in corpora),
            words=sum(corpus.words for corpus in corpora),
            dropped=tuple(sorted(dropped, key=lambda tally: -tally.count)),
            other_speakers=tuple(others),
            script=tuple(
                digests.model_copy(update={"column": column or ""})
                for column, document in documents
                for digests in document.corpus.script
            ),
        ),
        minutes=minutes,
        reports=reports,
        shared=tuple(
            one.model_copy(update={"used": _used(language, one.phonemes, reports)})
            for language, one in added.items()
        ),
        total=total_of(reports, minutes, weights),
    )


def shared_of(
    resolved: Iterable[Report], reports: Sequence[CoverageReport]
) -> tuple[LanguageAddition, ...]:
    """Return the bigrams that each language adds, with the number that any report needs."""
    return tuple(
        LanguageAddition(
            language=language,
            phonemes=one.added,
            bigrams=one.extra,
            used=_used(language, one.added, reports),
        )
        for language, one in {one.language: one for one in resolved}.items()
    )


def _used(language: str, phonemes: Sequence[str], reports: Sequence[CoverageReport]) -> int:
    own = (report for report in reports if report.language == language)
    needed = {bigram.bigram for report in own for bigram in report.bigrams}
    return sum(not set(phonemes).isdisjoint(name.split("-")) for name in needed)
