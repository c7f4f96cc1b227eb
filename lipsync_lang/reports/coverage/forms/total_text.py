"""The total of a coverage as text: figures, faces, and the ranking of bigrams."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import shortlist
from lipsync_lang.base.presentation.percentages import percentage_text, ranked_text
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.reports.coverage.plan import affordable

if TYPE_CHECKING:
    from lipsync_lang.reports.coverage.report import Coverage, Total, TotalFigures, WorkItem

MAX_ROW_LANGUAGES = 3
"""Maximum number of languages in a row."""


def total_lines(coverage: "Coverage", total: "Total", rows: int | None) -> Iterator[str]:
    """Yield the total of several reports, with some rows of the ranking or all."""
    yield (
        f"all reports together: {total.authored.bigrams} of {total.needed} bigrams, "
        f"{percentage_text(total.authored.percent)} of the speech; shared work counts once"
    )
    if not total.ranking:
        return
    if len(total.faces) > 1:
        yield ""
        rows_of_faces = [("character", "pose set", "authored", "left", "hours", "first hour")]
        for face in total.faces:
            share, left = f"{percentage_text(face.authored.percent):>7}", face.left
            hour = f"{percentage_text(face.next_hour.percent):>10}"
            work = f"{left.bigrams:4}", f"{left.hours:5.1f}"
            rows_of_faces.append((face.character, face.poseset, share, *work, hour))
        yield from (f"  {line}" for line in columns(rows_of_faces))
    soon = total.ranking[: affordable(coverage.minutes)]
    for number, call in enumerate(draft_calls(soon)):
        yield from () if number else ("", "  next, for all:")
        yield f"    {call}"
    yield ""
    shown = total.ranking if rows is None else total.ranking[:rows]
    yield from (f"  {line}" for line in columns(_ranking(total, shown)))
    if len(shown) < len(total.ranking):
        yield f"  ... and {len(total.ranking) - len(shown)} more; --all lists them"


def draft_calls(items: "Sequence[WorkItem]") -> Iterator[str]:
    """Yield few commands that draft all items; items in a bank of their own need none.

    A command drafts for one language and one pose set. Each command has the language that serves
    most of the remaining items, or the first of several.
    """
    left: dict[str, list[WorkItem]] = {}
    for item in items:
        if not item.bank:
            left.setdefault(item.poseset, []).append(item)
    for poseset, own in left.items():
        missing = own
        while missing:
            counts = Counter(name for item in missing for name in item.languages)
            best = max(counts, key=counts.__getitem__)
            now = [item.bigram for item in missing if best in item.languages]
            yield f"lipsync-lang bank draft -l {best} -c {poseset} --write {' '.join(now)}"
            missing = [item for item in missing if best not in item.languages]


def headline(total: "TotalFigures") -> str:
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


def _ranking(total: "Total", items: "Sequence[WorkItem]") -> list[tuple[str, ...]]:
    several = len({face.poseset for face in total.faces}) > 1
    own = ["pose set"] if several else []
    rows = [("rank", "bigram", *own, "gain %", "then %", "count", "serves")]
    for rank, item in enumerate(items, 1):
        own = [item.poseset] if several else []
        gain, then = f"{ranked_text(item.percent):>6}", f"{ranked_text(item.reaches):>6}"
        count = f"{item.count:5}"
        rows.append((f"{rank:4}", item.bigram, *own, gain, then, count, serves(item, total)))
    return rows


def serves(item: "WorkItem", total: "TotalFigures") -> str:
    """Return the languages that an item serves."""
    names = item.languages
    if len(names) == len(total.languages) > 1:
        return f"all {len(names)}"
    return shortlist(names, MAX_ROW_LANGUAGES)
