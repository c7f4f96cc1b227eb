"""Text for a terminal: the total, and each report from its next bigrams on."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TextIO

from lipsync_lang.base.errors import count, shortlist
from lipsync_lang.base.grouping import grouped
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.base.presentation.wording import percentage_text, ranked_text
from lipsync_lang.reports.coverage.forms import FORMS, FormOptions
from lipsync_lang.reports.coverage.plan import affordable
from lipsync_lang.reports.coverage.report import (
    FITTED_STATUS,
    Corpus,
    Coverage,
    CoverageChanges,
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

MAX_TEXT_NAMES = 8
"""Maximum number of names of a list."""

MAX_TEXT_SENTENCES = 3
"""Maximum number of lines to draw first, by default."""


_WHY = {"letters": "foreign letters", "name": "a name", "engines": "two readings"}
"""Reasons for an entry of a word."""

MAX_ROW_LANGUAGES = 3
"""Maximum number of languages in a row."""


@FORMS.register("text")
def write(coverage: Coverage, out: TextIO, options: FormOptions) -> None:
    """Write all reports; several reports are preceded by their total and a table."""
    blocks = [list(_corpus(coverage.corpus))]
    if len(coverage.reports) > 1:
        if coverage.total is not None:
            blocks[0].insert(0, headline(coverage.total))
            rows = None if options.everything else MAX_RANKING_ROWS
            blocks += [list(total_lines(coverage, coverage.total, rows))]
        table = [("language", "character", "authored", "left", "hours")]
        for one in coverage.reports:
            share, left = f"{percentage_text(one.authored.percent):>7}", f"{one.left.bigrams:4}"
            table.append((one.label, one.character, share, left, f"{one.left.hours:5.1f}"))
        blocks += [list(columns(table))]
    for report in coverage.reports:
        met = f"{count(report.occurrences, 'bigram')} of {count(len(report.bigrams), 'kind')}"
        block = [f"{report.label} on {report.character}: {met}"]
        block += [f"  {line}" for line in _next(report, coverage.minutes)]
        block += ["", *(f"  {line}" for line in _table(report, everything=options.everything))]
        block += ["", *(f"  {line}" for line in _facts(report, everything=options.everything))]
        blocks.append(block)
    if len(coverage.shared) > 1 or any(one.bigrams for one in coverage.shared):
        blocks.append([])
        for own in coverage.shared:
            added = "nothing: all its bigrams are shared"
            if own.bigrams:
                added = f"{count(own.bigrams, 'bigram')} with {', '.join(own.phonemes)}, "
                added += f"{own.used} of them needed here"
            blocks[-1].append(f"{own.language} adds {added}")
    blocks += [_since(coverage.since)] if coverage.since else []
    out.write("\n\n".join("\n".join(lines) for lines in blocks) + "\n")


def _corpus(corpus: Corpus) -> Iterator[str]:
    """Yield what was read, what was heard, and what was left out."""
    read = (len(corpus.files), "file"), (corpus.lines, "line"), (corpus.words, "word")
    yield ", ".join(count(number, thing) for number, thing in read)
    if corpus.heard:
        lines = count(corpus.heard, "line")
        yield f"heard in recordings, and not read: {lines}; some sounds are wrong"
    if corpus.dropped:
        yield f"not spoken: {_tallies(corpus.dropped)}"
    if corpus.other_speakers:
        yield f"no character of their own: {_tallies(corpus.other_speakers)}"


def _next(report: CoverageReport, minutes: float) -> Iterator[str]:
    if not report.bigrams:
        yield f"{'no bigram is' if report.words else 'the language reads nothing'} in these lines"
        return
    if not report.left.bigrams:
        yield "next: nothing; every bigram of these lines is authored"
        return
    soon = report.next_hour.bigrams
    if soon:
        spent = len(soon) * minutes
        # What is left may take less than the hour.
        within = "an hour" if len(soon) < report.left.bigrams else f"{spent:g} minutes"
        yield (
            f"next: draw {count(len(soon), 'bigram')} in {within}, {minutes:g} minutes each, for "
            f"{percentage_text(report.next_hour.percent)} of the speech:"
        )
        # a draft of a bank is drawn there: the command writes to another, or leaves it alone
        places = {one.bigram: one.stated for one in report.bigrams if one.bigram in soon}
        new = [name for name in soon if not places[name]]
        if new:
            whose = f"-l {report.language} -c {report.character}"
            yield f"  lipsync-lang bank draft {whose} --write {' '.join(new)}"
        yield from (f"  {name} in {place}" for name, place in places.items() if place)
    else:
        yield f"next: draw {report.left.bigrams} bigrams; an hour is not enough for one"
    fitted = sum(not one.authored and one.status == FITTED_STATUS for one in report.bigrams)
    yield (
        f"authored: {report.authored.bigrams} of {count(len(report.bigrams), 'bigram')}, "
        f"{percentage_text(report.authored.percent)} of the speech; "
        f"{count(report.left.bigrams, 'bigram')} left, {report.left.hours:g} hours"
        f"{f'; {fitted} of them fitted, to be checked' if fitted else ''}"
    )


def _table(report: CoverageReport, *, everything: bool) -> Iterator[str]:
    shown = report.bigrams if everything else report.bigrams[:MAX_RANKING_ROWS]
    rows = [("rank", "bigram", "count", "%", "running", "from", "status", "in", "first at")]
    for rank, one in enumerate(shown, 1):
        share, running = f"{ranked_text(one.percent):>5}", f"{ranked_text(one.running):>7}"
        source = one.layer, one.status or "unanswered"
        met = one.example, one.places[0] if one.places else ""
        rows.append((f"{rank:4}", one.bigram, f"{one.count:5}", share, running, *source, *met))
    yield from columns(rows)
    if len(shown) < len(report.bigrams):
        yield f"... and {len(report.bigrams) - len(shown)} more; --all lists them"


def _facts(report: CoverageReport, *, everything: bool) -> Iterator[str]:
    shares = ", ".join(f"{share} % in {number}" for share, number in report.needed.items())
    yield f"most frequent bigrams: {shares}"
    kinds = len(report.bigrams) + len(report.unused)
    yield f"never used: {len(report.unused)} of {kinds} bigrams"
    drawn = sum(authored(one.layer, one.status) for one in report.silence)
    yield f"with silence: {len(report.silence)} bigrams, {drawn} of them authored"
    if report.trigrams:
        met = (one for one in report.trigrams if one.count)
        played = [f"{one.trigram} ({one.count}, {one.places[0]})" for one in met]
        told = f": {_few(played)}" if played else ""
        yield f"{count(len(report.trigrams), 'trigram')} drawn, {len(played)} of them played{told}"
    if report.unread:
        yield f"not read: {_tallies(report.unread)}"
    if report.unmapped:
        yield f"no map for: {_tallies(report.unmapped)}"
    read = [one for one in report.other_scripts if one.counted]
    spelled = [one for one in report.other_scripts if not one.counted]
    if read:
        yield f"in another script, read by the voice: {_tallies(read)}"
    if spelled:
        yield f"in another script, not counted: {_tallies(spelled)}"
    if report.entries:
        words = [f"{one.what} ({one.count}, {_WHY[one.why]})" for one in report.entries]
        yield f"words that deserve an entry in `words` of the language: {_few(words)}"
    yield from _gestures(report.gestures)
    shown = report.sentences if everything else report.sentences[:MAX_TEXT_SENTENCES]
    if shown:
        yield f"{count(len(report.sentences), 'line')} that use every unauthored bigram:"
    for one in shown:
        yield f"  {one.place}: {one.text or '(timed phonemes)'} ({len(one.bigrams)} new)"
    if len(shown) < len(report.sentences):
        yield f"  ... and {len(report.sentences) - len(shown)} more; --all lists them"


def _gestures(needs: Sequence[GestureNeed]) -> Iterator[str]:
    if needs:
        yield "gestures, at estimated times unless lines have their own:"
    rows = [("gesture", "count", "a minute", "at")] if needs else []
    for one in needs:
        facts = ", ".join(f"{fact.replace('_', ' ')} {n:,}" for fact, n in one.facts.items())
        rows.append((one.gesture, f"{one.count:5,}", f"{one.a_minute:8.1f}", facts))
    yield from (f"  {row}" for row in columns(rows))


def _since(since: CoverageChanges) -> list[str]:
    lines = [f"since {since.file}:"]
    if since.left is not None and len(since.reports) > 1:
        before, now = since.left
        hours = f"{before.hours:g} to {now.hours:g} hours"
        lines.append(f"  in all: {before.bigrams} to {now.bigrams} left, {hours}")
    for script in since.script:
        was, has = script.lines
        whose = f"script in {_few(script.languages)}" if len(since.script) > 1 else "script"
        parts = (("added", script.added), ("removed", script.removed), ("changed", script.changed))
        told = ", ".join(f"{len(names)} {what}" for what, names in parts if names) or "no change"
        lines.append(f"  {whose}: {count(has, 'line')}, {was:,} before; {told}")
        lines += [f"    {what}: {_few(names)}" for what, names in parts if names]
    for change in since.reports:
        share = " to ".join(map(percentage_text, change.percent))
        left = " to ".join(map(str, change.left))
        lines.append(f"  {change.label} on {change.character}: {share} authored, {left} left")
        lists = (
            ("authored", change.authored),
            ("no longer authored", change.lost),
            ("newly needed", change.new),
            ("no longer needed", change.gone),
        )
        lines += [f"    {what}: {_few(names)}" for what, names in lists if names]
    lines += [f"  {name}: in only one of the documents" for name in since.unmatched]
    return lines


def _tallies(found: Sequence[Tally]) -> str:
    return _few([f"{one.what} ({one.count}, {one.place})" for one in found])


def _few(names: Sequence[str]) -> str:
    return shortlist(names, MAX_TEXT_NAMES)


def total_lines(coverage: Coverage, total: Total, rows: int | None) -> Iterator[str]:
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


def _ranking(total: Total, items: Sequence[WorkItem]) -> list[tuple[str, ...]]:
    several = len({face.poseset for face in total.faces}) > 1
    own = ["pose set"] if several else []
    rows = [("rank", "bigram", *own, "gain %", "then %", "count", "serves")]
    for rank, item in enumerate(items, 1):
        own = [item.poseset] if several else []
        gain, then = f"{ranked_text(item.percent):>6}", f"{ranked_text(item.reaches):>6}"
        count = f"{item.count:5}"
        rows.append((f"{rank:4}", item.bigram, *own, gain, then, count, serves(item, total)))
    return rows


def serves(item: WorkItem, total: TotalFigures) -> str:
    """Return the languages that an item serves."""
    names = item.languages
    if len(names) == len(total.languages) > 1:
        return f"all {len(names)}"
    return shortlist(names, MAX_ROW_LANGUAGES)
