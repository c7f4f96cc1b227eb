"""Text for a terminal: the total, and each report from its next bigrams on.

`text.jinja` has the words, and this module the tables.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import TextIO

from lipsync_lang.base.errors import count, shortlist
from lipsync_lang.base.grouping import grouped
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.base.presentation.text_templates import filled
from lipsync_lang.base.presentation.wording import percentage_text, ranked_text
from lipsync_lang.reports.coverage.forms import FORMS, FormOptions
from lipsync_lang.reports.coverage.plan import affordable
from lipsync_lang.reports.coverage.report import (
    FITTED_STATUS,
    BigramNeed,
    Coverage,
    CoverageReport,
    GestureNeed,
    Tally,
    Total,
    TotalFigures,
    WorkItem,
    authored,
)

MAX_RANKING_ROWS = 20
"""Number of rows of the ranking by default."""

MAX_TEXT_SENTENCES = 3
"""Maximum number of lines to draw first, by default."""


_WHY = {"letters": "foreign letters", "name": "a name", "engines": "two readings"}
"""Reasons for an entry of a word."""

MAX_ROW_LANGUAGES = 3
"""Maximum number of languages in a row."""


@FORMS.register("text")
def write(coverage: Coverage, out: TextIO, options: FormOptions) -> None:
    """Write all reports; several reports are preceded by their total and a table."""
    facts = {name: getattr(coverage, name) for name in type(coverage).model_fields}
    facts |= {
        "soon": affordable(coverage.minutes),
        "rows": None if options.everything else MAX_RANKING_ROWS,
        "sentences": None if options.everything else MAX_TEXT_SENTENCES,
        "fitted_status": FITTED_STATUS,
    }
    out.write(filled(__package__, "text", {**facts, **TEXT_TOOLS}))


def _summary(reports: Sequence[CoverageReport]) -> Iterator[str]:
    """Yield a table with a row for each report."""
    rows = [("language", "character", "authored", "left", "hours")]
    for one in reports:
        share, left = f"{percentage_text(one.authored.percent):>7}", f"{one.left.bigrams:4}"
        rows.append((one.label, one.character, share, left, f"{one.left.hours:5.1f}"))
    yield from columns(rows)


def _faces(total: Total) -> Iterator[str]:
    """Yield a table with a row for each character."""
    rows = [("character", "pose set", "authored", "left", "hours", "first hour")]
    for face in total.faces:
        share, left = f"{percentage_text(face.authored.percent):>7}", face.left
        hour = f"{percentage_text(face.next_hour.percent):>10}"
        work = f"{left.bigrams:4}", f"{left.hours:5.1f}"
        rows.append((face.character, face.poseset, share, *work, hour))
    yield from columns(rows)


def _ranking(total: Total, items: Sequence[WorkItem]) -> Iterator[str]:
    """Yield a table of the bigrams to draw for all reports."""
    several = len({face.poseset for face in total.faces}) > 1
    own = ["pose set"] if several else []
    rows = [("rank", "bigram", *own, "gain %", "then %", "count", "serves")]
    for rank, item in enumerate(items, 1):
        own = [item.poseset] if several else []
        gain, then = f"{ranked_text(item.percent):>6}", f"{ranked_text(item.reaches):>6}"
        count = f"{item.count:5}"
        rows.append((f"{rank:4}", item.bigram, *own, gain, then, count, serves(item, total)))
    yield from columns(rows)


def _bigrams(shown: Sequence[BigramNeed]) -> Iterator[str]:
    """Yield a table of the bigrams of a report, the most frequent first."""
    rows = [("rank", "bigram", "count", "%", "running", "from", "status", "in", "first at")]
    for rank, one in enumerate(shown, 1):
        share, running = f"{ranked_text(one.percent):>5}", f"{ranked_text(one.running):>7}"
        source = one.layer, one.status or "unanswered"
        met = one.example, one.places[0] if one.places else ""
        rows.append((f"{rank:4}", one.bigram, f"{one.count:5}", share, running, *source, *met))
    yield from columns(rows)


def _gestures(needs: Sequence[GestureNeed]) -> Iterator[str]:
    """Yield a table of gestures."""
    rows = [("gesture", "count", "a minute", "at")]
    for one in needs:
        facts = ", ".join(f"{fact.replace('_', ' ')} {n:,}" for fact, n in one.facts.items())
        rows.append((one.gesture, f"{one.count:5,}", f"{one.a_minute:8.1f}", facts))
    yield from columns(rows)


def _stated_places(report: CoverageReport) -> dict[str, str]:
    """Return the places of the next bigrams that a bank or a character states already."""
    soon = report.next_hour.bigrams
    return {one.bigram: one.stated for one in report.bigrams if one.bigram in soon and one.stated}


def _played_trigrams(report: CoverageReport) -> list[str]:
    return [f"{one.trigram} ({one.count}, {one.places[0]})" for one in report.trigrams if one.count]


def _entries(report: CoverageReport) -> str:
    return shortlist([f"{one.what} ({one.count}, {_WHY[one.why]})" for one in report.entries])


def _drawn(bigrams: Sequence[BigramNeed]) -> int:
    return sum(authored(one.layer, one.status) for one in bigrams)


def _tallies(found: Sequence[Tally]) -> str:
    return shortlist([f"{one.what} ({one.count}, {one.place})" for one in found])


def draft_calls(items: Sequence[WorkItem]) -> Iterator[str]:
    """Yield few commands that draft all items; items in a bank of their own need none.

    A command drafts for one language and one pose set. Each command has the language that serves
    most of the remaining items, or the first of several.
    """
    left = grouped((item.poseset, item) for item in items if not item.bank)
    for poseset, missing in left.items():
        while missing:
            counts = Counter(name for item in missing for name in item.languages)
            best = max(counts, key=counts.__getitem__)
            now = [item.bigram for item in missing if best in item.languages]
            yield f"lipsync-lang bank draft -l {best} -c {poseset} --write {' '.join(now)}"
            missing[:] = [item for item in missing if best not in item.languages]


def headline(total: TotalFigures) -> str:
    """Return the total in a sentence."""
    number = len(total.languages)
    whom = f"all {number} languages" if number > 1 else total.languages[0]
    if not total.needed:
        return f"no bigrams in {whom}"
    if not total.left.bigrams:
        return f"nothing is left to draw for {whom}"
    hour = len(total.next_hour.bigrams)
    gain = f"; the first hour gives {percentage_text(total.next_hour.percent)}" if hour else ""
    drawn = "bigram" if total.left.bigrams == 1 else "bigrams"
    return f"{total.left.bigrams:,} {drawn}, {total.left.hours:g} hours for {whom}{gain}"


def serves(item: WorkItem, total: TotalFigures) -> str:
    """Return the languages that an item serves."""
    names = item.languages
    if len(names) == len(total.languages) > 1:
        return f"all {len(names)}"
    return shortlist(names, MAX_ROW_LANGUAGES)


TEXT_TOOLS: dict[str, Callable[..., object]] = {
    "count": count,
    "percent": percentage_text,
    "few": shortlist,
    "tallies": _tallies,
    "entries": _entries,
    "headline": headline,
    "draft_calls": draft_calls,
    "summary": _summary,
    "faces": _faces,
    "ranking": _ranking,
    "bigrams": _bigrams,
    "gestures": _gestures,
    "stated_places": _stated_places,
    "played_trigrams": _played_trigrams,
    "drawn": _drawn,
}
"""Functions for the template: words, and tables as lines."""
