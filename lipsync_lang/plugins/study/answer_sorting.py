"""Sorting of answers: those that count, and those that are set aside with a reason.

Every submission and every answer is counted exactly once: as counted, as an answer to an
attention check, or as set aside.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from lipsync_lang import LipsyncError
from lipsync_lang.base.errors import shortlist
from lipsync_lang.plugins.study.comparisons import Choice
from lipsync_lang.plugins.study.study_file import (
    MAX_PAIRS,
    PairAnswer,
    Study,
    parse_document,
    texts_of,
)

MIN_COPIED_ANSWERS = 5
"""Minimum number of answers for a copy of another rater's, seconds included."""

MIN_ALIKE_ANSWERS = 10
"""Minimum number of equal answers of two raters, at different speeds, that is suspicious."""

UNKNOWN_CLIP_SECONDS = 1.0
"""Minimum time for a pair of clips of unknown length."""

MAX_NAMED_RATERS = 5
"""Maximum number of raters or pairs in a sentence."""

MAX_RATER_CHARS = 64
"""Maximum length of a rater's number."""


@dataclass(frozen=True)
class SortingRules:
    """Rules for raters and answers to set aside."""

    failed_checks: int = 0
    """Number of attention checks that a rater may fail."""
    keep_unfinished: bool = False
    """True if raters who stopped early count."""
    least_seconds: float | None = None
    """Minimum time for a pair; None for its longer clip's length, or `UNKNOWN_CLIP_SECONDS`."""
    one_side: int = 10
    """Number of pairs from which a rater who always takes one side is set aside; 0 for never."""

    @property
    def words(self) -> dict[str, str]:
        """Rule behind each reason, without a full stop."""
        least = f"the length of the clip ({UNKNOWN_CLIP_SECONDS:g} s if unknown)"
        if self.least_seconds is not None:
            least = f"{self.least_seconds:g} s"
        return {
            "unreadable": "text that is cut off, damaged, or not JSON",
            "no answers": "a file or line of another kind or form",
            "other study": "answers to another study",
            "no consent": "consent is not stated",
            "repeated": "only the first complete submission of a rater counts",
            "unfinished": "the rater stopped early",
            "copied": f"at least {MIN_COPIED_ANSWERS} answers with the choices, strengths and "
            "seconds of an earlier rater",
            "failed checks": f"the rater failed more than {self.failed_checks} attention checks",
            "fast rater": f"more than half of the rater's pairs were answered within {least}",
            "one side": f"one side in every answer to at least {self.one_side} pairs",
            "out of range": "a damaged answer: choice, strength, seconds or plays out of range",
            "nothing left": "the rater has no choice that counts",
            "unknown pair": "a pair or question that the study does not have",
            "answered twice": "the first answer to a question of a pair counts",
            "too fast": f"an answer within {least}",
        }


class SetAsideAnswers(NamedTuple):
    """Submission or answers that do not count."""

    reason: str
    """Key of `SortingRules.words`."""
    place: str
    """File, with the line if it has several."""
    rater: str
    """Number of the rater; empty if unknown."""
    submissions: int
    """1 for a whole submission, 0 for single answers."""
    answers: int
    words: str


@dataclass
class SortedAnswers:
    """Choices that count, and submissions and answers that were set aside."""

    choices: list[Choice] = field(default_factory=list)
    submissions: int = 0
    """Number of submissions, including those set aside, damaged lines and unrelated files."""
    answers: int = 0
    """Number of answers, including those set aside."""
    raters: int = 0
    """Number of raters that count."""
    unfinished: int = 0
    """Number of unfinished raters that count."""
    checks: int = 0
    """Number of answers of these raters to attention checks."""
    unchecked: int = 0
    """Number of raters that count without an attention check, if the study has checks."""
    set_aside: list[SetAsideAnswers] = field(default_factory=list)
    suspicious: list[str] = field(default_factory=list)
    """Sentences on raters that count, but look suspicious."""


@dataclass
class _Rater:
    """A submission of the study, with its valid answers."""

    place: str
    rater: str
    finished: bool
    given: list[Any]
    answers: list[PairAnswer] = field(default_factory=list)
    dropped: list[tuple[str, str]] = field(default_factory=list)
    """Reason and words of each answer that does not count."""


def sort_answers(
    paths: Iterable[Path], study: Study, rules: SortingRules | None = None
) -> SortedAnswers:
    """Read and sort all answers: one submission a file, or JSON lines, in any mix."""
    told = SortedAnswers()
    sorting = _Sorting(study, rules or SortingRules(), told)
    raters: dict[str, list[_Rater]] = defaultdict(list)
    for place, text in texts_of(paths):
        told.submissions += 1
        found = sorting.submission(place, text)
        if found:
            told.answers += len(found.given)
            raters[found.rater].append(found)
    chosen = [one for given in raters.values() if (one := sorting.of_rater(given))]
    chosen = sorting.without_copies(chosen)
    for one in chosen:
        sorting.count(one)
    return told


class _Sorting:
    """Steps of sorting; each step sets some answers aside and returns the rest."""

    def __init__(self, study: Study, rules: SortingRules, told: SortedAnswers) -> None:
        self._study, self._rules, self._told = study, rules, told
        self._pairs = {pair.pair: pair for pair in study.pairs}

    def _aside(self, reason: str, one: _Rater, words: str) -> None:
        found = SetAsideAnswers(reason, one.place, one.rater, 1, len(one.given), words)
        self._told.set_aside.append(found)

    def submission(self, place: str, text: bytes | LipsyncError) -> _Rater | None:
        """Return a submission to this study; set aside everything else."""
        reason, words, data = parse_document(text)
        given = data.get("answers") if isinstance(data, dict) else None
        answers = given if isinstance(given, list) else []
        rater = data.get("rater") if isinstance(data, dict) else None
        name = rater if isinstance(rater, str) and len(rater) <= MAX_RATER_CHARS else ""
        if reason:
            pass
        elif not isinstance(data, dict) or data.get("kind") != "answers":
            reason, words = "no answers", "its kind is not 'answers'"
        elif data.get("format") != 1 or "finished" not in data:
            reason, words = "no answers", "its format is not 1, or it has no time of finishing"
        elif data.get("study") != self._study.study:
            reason, words = "other study", f"it belongs to study {_shown(data.get('study'))}"
        elif data.get("consent") is not True:
            reason, words = "no consent", "its consent is not true"
        # Two questions for each pair.
        elif not isinstance(given, list) or len(given) > 2 * MAX_PAIRS:
            reason, words = "no answers", "its answers are not a list, or too many"
        elif not name:
            reason, words = "no answers", "the rater has no number"
        if reason:
            self._told.answers += len(answers)
            aside = SetAsideAnswers(reason, place, name, 1, len(answers), words)
            self._told.set_aside.append(aside)
            return None
        found = _Rater(place, name, bool(data["finished"]), answers)
        self._read_answers(found)
        return found

    def _read_answers(self, one: _Rater) -> None:
        """Check the form of each answer, and compare it with the study."""
        seen: set[tuple[str, str]] = set()
        for number, raw in enumerate(one.given):
            where = f"answers.{number}"
            try:
                # Strict, since pydantic would take "3" and 3.0 for a strength.
                answer = PairAnswer.model_validate(raw, strict=True)
            except ValidationError as error:
                first = error.errors(include_url=False, include_input=False)[0]
                step = ".".join(map(str, first["loc"]))
                one.dropped.append(("out of range", f"{where}.{step}: {first['msg']}"))
                continue
            key = (answer.pair, answer.question)
            if answer.pair not in self._pairs:
                words = f"{where}: the study has no pair {_shown(answer.pair)}"
                one.dropped.append(("unknown pair", words))
            elif answer.question not in self._study.questions:
                words = f"{where}: the study does not ask about {answer.question}"
                one.dropped.append(("unknown pair", words))
            elif key in seen:
                words = f"{where}: {answer.pair} has an earlier answer about {answer.question}"
                one.dropped.append(("answered twice", words))
            else:
                seen.add(key)
                one.answers.append(answer)

    def of_rater(self, given: Sequence[_Rater]) -> _Rater | None:
        """Return the submission that counts for a rater, if there is one."""
        complete = [one for one in given if self._complete(one)]
        chosen = complete[0] if complete else None
        if chosen is None and self._rules.keep_unfinished:
            chosen = max(given, key=lambda one: len(one.answers))
        for one in given:
            if one is chosen:
                continue
            if chosen is None and one is given[0]:
                stopped = "" if one.finished else "no time of finishing; "
                answered = f"{self._answered(one)} of {self._expected()} pairs are answered"
                self._aside("unfinished", one, stopped + answered)
            else:
                first = chosen or given[0]
                self._aside("repeated", one, f"the rater's submission at {first.place} comes first")
        return chosen

    def _expected(self) -> int:
        """Return the minimum number of pairs in a complete submission."""
        return min(self._study.raters_see or len(self._pairs), len(self._pairs))

    def _complete(self, one: _Rater) -> bool:
        return one.finished and self._answered(one) >= self._expected()

    def _answered(self, one: _Rater) -> int:
        """Return the number of pairs with an answer, valid or not."""
        named = {str(raw.get("pair")) for raw in one.given if isinstance(raw, dict)}
        return len(self._pairs.keys() & named)

    def without_copies(self, raters: Sequence[_Rater]) -> list[_Rater]:
        """Return the raters without copied answers, and name suspiciously similar raters."""
        kept: list[_Rater] = []
        exact: dict[tuple[Any, ...], _Rater] = {}
        alike: dict[tuple[Any, ...], list[_Rater]] = defaultdict(list)
        for one in raters:
            timed = _pattern(one, timed=True)
            first = exact.setdefault(timed, one)
            if first is not one and len(timed) >= MIN_COPIED_ANSWERS:
                self._aside("copied", one, f"the answers equal those of rater {first.rater}")
                continue
            kept.append(one)
            untimed = _pattern(one, timed=False)
            if len(untimed) >= MIN_ALIKE_ANSWERS:
                alike[untimed].append(one)
        self._told.suspicious += [
            f"{len(same)} raters gave the same {len(pattern)} choices and strengths at different "
            f"speeds: {shortlist((one.rater for one in same), MAX_NAMED_RATERS)}"
            for pattern, same in alike.items()
            if len(same) > 1
        ]
        return kept

    def count(self, one: _Rater) -> None:
        """Count a rater's answers, or set the rater aside."""
        fault = self._fault(one)
        if fault:
            self._aside(*fault)
            return
        fast = self._fast(one)
        told = self._told
        choices: list[Choice] = []
        checks = 0
        for answer in one.answers:
            pair = self._pairs[answer.pair]
            if answer.pair in fast:
                one.dropped.append(("too fast", f"{answer.pair}: {fast[answer.pair]:g} s"))
            elif pair.check:
                checks += 1
            else:
                left = answer.choice == "left"
                chosen, other = (pair.left, pair.right) if left else (pair.right, pair.left)
                choices.append(
                    Choice(
                        one.rater, pair.pair, pair.line, pair.character, answer.question,
                        chosen, other, answer.strength,
                    )
                )  # fmt: skip
        if not choices:
            first = one.dropped[0][1] if one.dropped else "the rater gave no answers"
            self._aside("nothing left", one, first)
            return
        told.raters += 1
        told.unfinished += not self._complete(one)
        told.checks += checks
        told.unchecked += not checks and any(pair.check for pair in self._study.pairs)
        told.choices += choices
        dropped: dict[str, list[str]] = defaultdict(list)
        for reason, words in one.dropped:
            dropped[reason].append(words)
        for reason, answers in dropped.items():
            more = f", and {len(answers) - 1} more" if len(answers) > 1 else ""
            told.set_aside.append(
                SetAsideAnswers(reason, one.place, one.rater, 0, len(answers), answers[0] + more)
            )

    def _fault(self, one: _Rater) -> tuple[str, _Rater, str] | None:
        """Return the reason to set a rater aside, if there is one."""
        # By pair: both questions of a pair that are answered wrongly are one failed check.
        failed = {a.pair for a in one.answers if self._pairs[a.pair].check not in (None, a.choice)}
        if len(failed) > self._rules.failed_checks:
            return "failed checks", one, f"failed at {shortlist(sorted(failed), MAX_NAMED_RATERS)}"
        pairs, fast = {a.pair for a in one.answers}, self._fast(one)
        if fast and 2 * len(fast) > len(pairs):
            return "fast rater", one, f"{len(fast)} of {len(pairs)} pairs were too fast"
        sides = {a.choice for a in one.answers}
        if len(sides) == 1 and 0 < self._rules.one_side <= len(pairs):
            return "one side", one, f"chose the {sides.pop()} side in all of {len(pairs)} pairs"
        return None

    def _fast(self, one: _Rater) -> dict[str, float]:
        """Return the pairs that were answered faster than their clips play, with the times."""
        spent: dict[str, float] = {}
        for answer in one.answers:  # seconds run from the first sight of the pair
            spent[answer.pair] = max(spent.get(answer.pair, 0.0), answer.seconds)
        stated = self._rules.least_seconds
        clips = {pair: self._pairs[pair].seconds or UNKNOWN_CLIP_SECONDS for pair in spent}
        least = clips if stated is None else dict.fromkeys(spent, stated)
        return {pair: took for pair, took in spent.items() if took < least[pair]}


def _pattern(one: _Rater, *, timed: bool) -> tuple[Any, ...]:
    found = ((a.pair, a.question, a.choice, a.strength, a.seconds * timed) for a in one.answers)
    return tuple(sorted(found))


def _shown(value: Any, most: int = 40) -> str:
    text = str(value)
    return f"'{text}'" if len(text) <= most else f"'{text[:most]}...'"


def reasons(set_aside: Iterable[SetAsideAnswers]) -> dict[str, tuple[int, int]]:
    """Count the submissions and answers that each reason sets aside."""
    found: dict[str, tuple[int, int]] = {}
    for one in set_aside:
        whole, single = found.get(one.reason, (0, 0))
        found[one.reason] = (whole + one.submissions, single + one.answers)
    return found
