"""Joining of the documents of several columns into one."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from lipsync_lang.reports.coverage.report import (
    Corpus,
    Coverage,
    CoverageReport,
    LanguageAddition,
    Tally,
)
from lipsync_lang.reports.coverage.total import total_of
from lipsync_lang.resolver.compiled import Report


def joined(
    documents: Sequence[tuple[str | None, Coverage]], weights: Mapping[str, float] | None = None
) -> Coverage:
    """Join the documents of columns into one; reports name theirs if a language is in several."""
    if len(documents) == 1:
        return documents[0][1]
    corpora = [document.corpus for _, document in documents]
    dropped: dict[str, Tally] = {}
    others: dict[str, Tally] = {}
    for corpus in corpora:
        for tally in corpus.dropped:
            known = dropped.get(tally.what)
            total = tally.count + (known.count if known else 0)
            dropped[tally.what] = (known or tally).model_copy(update={"count": total})
        for tally in corpus.other_speakers:  # not a sum, because all columns have the same rows
            found = others.setdefault(tally.what, tally)
            if found.count < tally.count:
                others[tally.what] = tally
    # A language in two columns is two readings of one script, so their reports need the column's
    # name.
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
            dropped=tuple(sorted(dropped.values(), key=lambda tally: -tally.count)),
            other_speakers=tuple(others.values()),
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
