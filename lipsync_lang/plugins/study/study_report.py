"""Reports of a study: counts of raters and choices, answers set aside, and statistics."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from lipsync_lang import LipsyncError
from lipsync_lang.plugins.study.answer_sorting import (
    SortedAnswers,
    SortingRules,
    reasons,
    sort_answers,
)
from lipsync_lang.plugins.study.bradley_terry import Ranking, ranked
from lipsync_lang.plugins.study.comparisons import CONFIDENCE_LEVEL, Comparison, compared
from lipsync_lang.plugins.study.study_file import (
    REPORT_FORMAT,
    STUDY_NAME,
    Study,
    answer_files,
    read_study,
)

SIGNIFICANCE_LEVEL = 0.05
"""Level of significance in notes."""

ANSWERS_FOLDER = "answers"
"""Folder of a study that may contain answers."""


@dataclass(frozen=True)
class StudyReport:
    """Results of a study."""

    study: Study
    files: tuple[str, ...]
    """Files of answers."""
    rules: SortingRules
    answers: SortedAnswers
    comparisons: tuple[Comparison, ...]
    rankings: tuple[Ranking, ...]
    """Strengths of more than two methods."""
    notes: tuple[str, ...]
    """Sentences that limit the meaning of the figures."""

    def by_pair(self) -> dict[tuple[str, str, str], list[Comparison]]:
        """Return the comparisons of each question and two methods."""
        found: dict[tuple[str, str, str], list[Comparison]] = {}
        for one in self.comparisons:
            found.setdefault((one.question, one.first, one.second), []).append(one)
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return the report as JSON data; `docs/reference/study-report.md` names its keys."""
        answers, rules = self.answers, self.rules.words
        return {
            "format": REPORT_FORMAT,
            "study": self.study.study,
            "title": self.study.title,
            "methods": list(self.study.methods),
            "questions": list(self.study.questions),
            "files": list(self.files),
            "confidence": CONFIDENCE_LEVEL,
            "rules": asdict(self.rules),
            "counted": {
                "raters": answers.raters,
                "unfinished": answers.unfinished,
                "unchecked": answers.unchecked,
                "choices": len(answers.choices),
                "check_answers": answers.checks,
            },
            "read": {"submissions": answers.submissions, "answers": answers.answers},
            "set_aside": [
                {"reason": reason, "submissions": whole, "answers": single, "rule": rules[reason]}
                for reason, (whole, single) in reasons(answers.set_aside).items()
            ],
            "named": [one._asdict() for one in answers.set_aside],
            "suspicious": list(answers.suspicious),
            "comparisons": [_plain(asdict(one)) for one in self.comparisons],
            "rankings": [_plain(asdict(one)) for one in self.rankings],
            "notes": list(self.notes),
        }


def _plain(value: Any) -> Any:
    """Return JSON data with named tuples converted to dictionaries."""
    value = value._asdict() if hasattr(value, "_asdict") else value
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    return [_plain(one) for one in value] if isinstance(value, (list, tuple)) else value


def report_study(
    study: Path, answers: Sequence[Path] = (), rules: SortingRules | None = None
) -> StudyReport:
    """Report a study.

    `study` is the folder of the study, or its `study.json`; `answers` are files of answers, or
    folders of them, and by default those in the study's folder. Raises LipsyncError if the study
    cannot be read, or no answers are found.
    """
    file = study / STUDY_NAME if study.is_dir() else study
    known = read_study(file)
    beside = file.parent
    inside = beside / ANSWERS_FOLDER
    places = list(answers) or [beside]
    if not answers and inside.is_dir():
        try:
            places = [*answer_files([beside]), inside]
        except LipsyncError:  # all answers are in the folder of answers
            places = [inside]
    files = answer_files(places)
    rules = rules or SortingRules()
    told = sort_answers(files, known, rules)
    comparisons = tuple(compared(told.choices, known.methods))
    rankings = tuple(ranked(told.choices, known.methods))
    names, notes = tuple(map(str, files)), tuple(_notes(known, told, comparisons))
    return StudyReport(known, names, rules, told, comparisons, rankings, notes)


def _notes(study: Study, answers: SortedAnswers, comparisons: Sequence[Comparison]) -> list[str]:
    """Return sentences that limit the meaning of the figures."""
    if not comparisons:
        return ["no choice counts, so the report has no figures"]
    notes = [
        "p (raters) allows for similar choices of the same rater; chi-square and binomial do not",
        "p (lines) allows for similar choices about the same line, and for other lines",
    ]
    fewest = min(min(one.raters, one.lines) for one in comparisons)
    # The smallest p of sign flips: all signs alike, in either direction.
    if 2.0 ** (1 - fewest) >= SIGNIFICANCE_LEVEL:
        few = "1 rater or line" if fewest == 1 else f"{fewest} raters or lines"
        least = f"p cannot be below {2.0 ** (1 - fewest):.2g}"
        notes.append(f"with {few}, {least}; take more raters and lines")
    if len(comparisons) > 1:
        notes.append(
            f"{len(comparisons)} comparisons are tested; with Bonferroni's correction, each needs "
            f"p below {SIGNIFICANCE_LEVEL / len(comparisons):.2g}"
        )
    if answers.unfinished:
        notes.append(f"counted raters who stopped early: {answers.unfinished}")
    if answers.unchecked:
        notes.append(f"counted raters without an attention check: {answers.unchecked}")
    if not any(pair.check for pair in study.pairs):
        notes.append("the study has no attention checks")
    return notes
