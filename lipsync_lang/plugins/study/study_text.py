"""Texts of a study's report and plan for a terminal."""

from collections.abc import Iterable, Iterator, Sequence

from lipsync_lang.base.errors import count
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.plugins.study.answer_sorting import reasons
from lipsync_lang.plugins.study.bradley_terry import Ranking
from lipsync_lang.plugins.study.comparisons import Comparison, Interval, MeanStrength
from lipsync_lang.plugins.study.power import PowerPlan
from lipsync_lang.plugins.study.study_report import StudyReport

MAX_LISTED_ASIDE = 20
"""Maximum number of listed submissions and answers that are set aside."""

EVERYBODY = "all"

SMALLEST_P = 1e-4
"""Probability below which digits have no meaning."""


def report_text(report: StudyReport) -> str:
    """Return the report as text."""
    answers, study = report.answers, report.study
    counted = (
        f"{count(answers.raters, 'rater')} and {count(len(answers.choices), 'choice')} counted, "
        f"of {count(answers.submissions, 'submission')} with {count(answers.answers, 'answer')}; "
        f"{count(answers.checks, 'answer')} to attention checks"
    )
    title = f"{study.title or 'study'} ({study.study})"
    heading = [title, f"methods: {', '.join(study.methods)}", counted]
    blocks: list[Iterable[str]] = [heading, _set_aside(report)]
    cells = sorted(report.by_pair().items(), key=lambda cell: study.questions.index(cell[0][0]))
    for (question, first, second), rows in cells:
        preferences = (f"  {line}" for line in columns(_preferences(rows)))
        blocks.append((f"{question}: {first} against {second}", *preferences))
        blocks.append(f"  {line}" for line in columns(_strengths(rows)))
    blocks += map(_ranking, report.rankings)
    blocks.append(("notes", *(f"  {note}" for note in report.notes)))
    return "\n\n".join(map("\n".join, blocks)) + "\n"


def _set_aside(report: StudyReport) -> Iterator[str]:
    found = report.answers.set_aside
    if not found:
        yield "set aside: nothing"
    else:
        rules = report.rules.words
        rows = [("set aside", "submissions", "answers", "rule")]
        rows += [
            (f"  {reason}", f"{whole:11}", f"{single:7}", rules[reason])
            for reason, (whole, single) in reasons(found).items()
        ]
        yield from columns(rows)
        for one in found[:MAX_LISTED_ASIDE]:
            rater = f" rater {one.rater}" if one.rater else ""
            yield f"  {one.place}:{rater} {one.reason}: {one.words}"
        if len(found) > MAX_LISTED_ASIDE:
            yield f"  ... and {len(found) - MAX_LISTED_ASIDE} more; the JSON report lists all"
    yield from (f"  suspicious, but counted: {one}" for one in report.answers.suspicious)


def _preferences(found: Sequence[Comparison]) -> Iterator[Sequence[str]]:
    yield (
        "character", "first", "second", "share", "95 % independent", "95 % raters", "chi2 (1)", "p",
        "p binomial", "p (raters)", "p (lines)",
    )  # fmt: skip
    for one in found:
        yield (
            one.character or EVERYBODY,
            f"{one.for_first:5}",
            f"{one.choices - one.for_first:6}",
            percent(one.share),
            percents(one.interval),
            percents(one.clustering.interval),
            f"{one.chi_square:8.2f}",
            probability(one.p_chi_square),
            probability(one.p_binomial),
            probability(one.p_raters),
            probability(one.p_lines),
        )


def _strengths(found: Sequence[Comparison]) -> Iterator[Sequence[str]]:
    yield (
        "character", "difference", "strength of first", "of second", "raters", "lines",
        "design effect", "correlation", "agreement", "alpha",
    )  # fmt: skip
    for one in found:
        agreed = one.agreement
        effect, correlation = one.clustering.design_effect, one.clustering.correlation
        yield (
            one.character or EVERYBODY,
            f"{100 * one.difference:+8.1f} %",
            strength(one.strength_of_first),
            strength(one.strength_of_second),
            f"{one.raters:6}",
            f"{one.lines:5}",
            "-" if effect is None else f"{effect:.2f}",
            "-" if correlation is None else f"{correlation:.2f}",
            "-" if agreed is None else f"{agreed.percent:.0f} %",
            "-" if agreed is None or agreed.alpha is None else f"{agreed.alpha:.2f}",
        )


def _ranking(found: Ranking) -> Iterator[str]:
    who = f" by {found.character}" if found.character else ""
    yield f"{found.question}{who}: strengths (Bradley-Terry)"
    if found.problem:
        yield f"  none: {found.problem}"
        return
    rows = [("method", "choices for", "of", "strength", "95 % raters", "beats others")]
    for one in found.methods:
        around = one.interval
        ends = "-" if around is None else f"{around.low:+.2f} to {around.high:+.2f}"
        figures = f"{one.wins:11}", f"{one.choices}", f"{one.strength:+.2f}", ends
        rows.append((one.method, *figures, percent(one.beats_others)))
    yield from (f"  {line}" for line in columns(rows))
    yield f"  {equal_strengths(found)}"


def equal_strengths(found: Ranking) -> str:
    """Write the tests of a ranking against equal strengths; empty if there are none."""
    if None in (found.likelihood_ratio, found.p_likelihood_ratio, found.p_raters):
        return ""
    return (
        f"against equal strengths: p (raters) {probability(found.p_raters or 0)}; likelihood ratio "
        f"{found.likelihood_ratio:.2f} ({found.freedom}), p "
        f"{probability(found.p_likelihood_ratio or 0)}"
    )


def plan_text(plan: PowerPlan) -> str:
    """Return a plan as text."""
    asked = plan.question
    lines = [
        f"{percent(asked.share)} for one method against an even split, level {asked.alpha:g}:",
        f"  {plan.choices:,} independent choices give a power of {percent(asked.power)}",
        f"designs, if choices of the same rater have a correlation of {asked.correlation:g}:",
    ]
    rows = [("pairs each", "raters", "choices", "worth", "power")]
    for one in plan.rows:
        sizes = f"{one.pairs:10,}", f"{one.raters:6,}", f"{one.choices:7,}"
        rows.append((*sizes, f"{one.effective:5,}", percent(one.power)))
    return "\n".join([*lines, *(f"  {line}" for line in columns(rows))]) + "\n"


def percent(share: float) -> str:
    """Write a share as a percentage with one decimal."""
    return f"{100 * share:.1f} %"


def percents(interval: Interval | None) -> str:
    """Write an interval of a share in percent."""
    return "-" if interval is None else f"{100 * interval.low:.1f} to {100 * interval.high:.1f} %"


def probability(value: float) -> str:
    """Write a probability with three decimals, or more if it is small."""
    if value < SMALLEST_P:
        return f"< {SMALLEST_P:.4f}"
    return f"{value:.4f}" if value < 0.01 else f"{value:.3f}"  # noqa: PLR2004 a second zero


def strength(mean: MeanStrength | None) -> str:
    """Write a mean strength with its interval."""
    if mean is None:
        return "-"
    around = mean.interval
    return f"{mean.mean:.2f}" + (f" ({around.low:.2f} to {around.high:.2f})" if around else "")
