"""Tiers: parallel rows of labels; one row has the phones.

The phone tier is recognised by its name (`phones`, `MAU`, `Name - phones`, ...). If no name
matches, the tier with many short and brief labels is taken. The words of the same speaker come
with it.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from lipsync_lang.base.errors import OutputError, did_you_mean, shortlist
from lipsync_lang.base.files.quoting import xml_text
from lipsync_lang.schedules.rows import LabelRow, schedule_of
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.schedules.timed_words import are_words, timed_words_of
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import Timings

PHONES = re.compile(r"(ph(on(e(me)?)?s?|onetic|onalign)?|segments?|mau)", re.IGNORECASE)
"""Names of phone tiers in MFA, FAVE, MAUS, SPPAS, EMU, DoReCo, and among users of Praat."""

WORD_TIER_NAME = re.compile(r"(words?|wd|tokens?|ort(-mau)?|tokensalign)", re.IGNORECASE)
"""Names of word tiers in the same programs."""

CONFIDENCE_TIER = "confidence"
"""The tier of the probabilities that words are said, beside the words."""

ALIGNED_TIER_NAME = re.compile(r"(phon|tokens)align", re.IGNORECASE)
"""Names of aligned tiers, beside which SPPAS keeps tiers of the text's phones and words."""

WORD_CLASS = re.compile(r"[A-Z]{1,6}\$?\d?", re.ASCII)
"""Tag of a part of speech, such as NNS or VERB, which tools write into a second line of a label."""

PROBABILITY = re.compile(r"0(\.\d+)?|1(\.0*)?", re.ASCII)

MAX_NAMES = 4
"""Maximum number of names of tiers in a message."""

SPEAKER_TIER_NAME = re.compile(
    r"(?:(?P<before>.*\S)\s+-\s+)?(?P<role>[^@]*|.*)(?:@(?P<after>[^@]+))?", re.DOTALL
)
"""Aligners put the speaker before the tier's name, `Name - phones`; in ELAN it often ends it."""

TIME_DIGITS = 6
"""Decimals of a written time in seconds: microseconds."""

CONFIDENCE_DIGITS = 2

TimeSpan = tuple[float, float]
"""Start and end in the file's unit or in seconds."""

LabelSpan = tuple[str, float, float]
"""Label, start and end in seconds."""


class Tier(NamedTuple):
    """A tier: name, rows, and the line of its name in the file."""

    name: str
    rows: tuple[LabelRow, ...]
    line: int | None = None

    @property
    def speaker(self) -> str:
        """The speaker named before or after the role; may be empty."""
        return self._part("before") or self._part("after")

    @property
    def role(self) -> str:
        """The name without the speaker."""
        return self._part("role")

    @property
    def spoken(self) -> list[LabelRow]:
        """The rows with a label."""
        return [row for row in self.rows if row.label.strip()]

    def looks_like_phones(self) -> bool:
        """Return True if the labels are short, varied and brief."""
        from statistics import median

        labels = [row.label for row in self.spoken]
        short = [label for label in labels if len(label) <= 4]  # noqa: PLR2004 letters and marks
        return (
            len(set(labels)) >= 4  # noqa: PLR2004 fewer is a tier of marks
            and len(short) >= 0.9 * len(labels)
            and not any(re.search(r"\s", label) for label in labels)
            and median(row.end - row.start for row in self.spoken) < 0.25  # noqa: PLR2004 seconds
        )

    def holds_words(self) -> bool:
        """Return True for a tier of words by name, or of labels that cannot be phones."""
        if WORD_TIER_NAME.fullmatch(self.role) or PHONES.fullmatch(self.role) or not self.spoken:
            return bool(WORD_TIER_NAME.fullmatch(self.role))
        return are_words(row.label for row in self.spoken)

    def _part(self, group: str) -> str:
        match = SPEAKER_TIER_NAME.fullmatch(self.name)
        return ((match and match[group]) or "").strip()


def read_speakers(
    source: TimingFile, speakers: Mapping[str, Iterable[LabelRow]], remarks: Iterable[str]
) -> Timings:
    """Read the words of speakers by name; an empty name if the file has none."""
    tiers = [
        Tier(f"{name} - words" if name else "words", tuple(rows)) for name, rows in speakers.items()
    ]
    return read_tiers(source, [tier for tier in tiers if tier.rows], remarks=remarks)


def read_tiers(
    source: TimingFile, tiers: Sequence[Tier], *, guess: bool = False, remarks: Iterable[str] = ()
) -> Timings:
    """Make a schedule of the phone tier, with the words of its speaker; or timed words.

    ``source.tier`` names the tier or a speaker. Without it, only one tier may look like phones.
    A file without phones gives the words of its tier of words. `guess` and `remarks` are as in
    `schedule_of`.
    """
    found = tiers if source.tier is not None else _phones(source, tiers)
    alike = "hold words" if all(tier.holds_words() for tier in found) else "look like phones"
    chosen = only(source, found, f"tiers {alike}")
    if chosen.holds_words():
        rows, tagged = _without_classes(source, chosen.rows)
        return timed_words_of(source, rows, guess=guess, remarks=[*remarks, *tagged])
    own = [tier for tier in tiers if tier.speaker == chosen.speaker]
    words = _sure([tier for tier in own if WORD_TIER_NAME.fullmatch(tier.role)])
    told = [] if chosen.spoken else [f"{source.path}: tier '{chosen.name}' has no labels"]
    spans, tagged = _without_classes(source, words[0].rows if len(words) == 1 else ())
    sure = [tier for tier in own if tier.role == CONFIDENCE_TIER]
    used = (chosen, *(words if spans else ()), *sure)
    # By identity, because two tiers may have equal names and rows.
    others = [tier for tier in tiers if tier.spoken and all(tier is not one for one in used)]
    if others and source.tier is None:
        told.append(f"{source.path}: skipped tiers: {_list(others)}")
    told += [*remarks, *tagged]
    schedule = schedule_of(source, chosen.rows, words=spans, guess=guess, remarks=told)
    if not sure:
        return schedule
    rated = []
    for word in schedule.words:  # a row at the middle of a word states its confidence
        middle = (schedule.times[word.first] + schedule.times[word.stop]) / 2
        label = next((r.label for r in sure[0].spoken if r.start <= middle <= r.end), "").strip()
        stated = float(label) if PROBABILITY.fullmatch(label) else None
        rated.append(replace(word, confidence=stated))
    return replace(schedule, words=tuple(rated))


def _without_classes(
    source: TimingFile, rows: Sequence[LabelRow]
) -> tuple[Sequence[LabelRow], list[str]]:
    """Return words without the parts of speech below them, and a remark if there are any."""
    lines = [row.label.split("\n") for row in rows]
    several = [one for one in lines if len(one) > 1]
    below = [line.strip() for _, *rest in several for line in rest]
    if not below or not all(map(WORD_CLASS.fullmatch, below)):
        return rows, []
    if all(first.isupper() for first, *_ in several):  # a line of capitals goes on below
        return rows, []
    kept = [row._replace(label=first) for row, (first, *_) in zip(rows, lines, strict=True)]
    what = f"parts of speech below the words, such as {below[0]}, are not spoken"
    return kept, [f"{source.path}: {what}"]


def only(source: TimingFile, tiers: Sequence[Tier], what: str) -> Tier:
    """Return the tier named by ``source.tier``, or else the only one of the `what`."""
    if not tiers:
        raise source.fault("has no phonemes; check that the file is complete")
    found = list(tiers)
    if source.tier is not None:
        found = [tier for tier in tiers if tier.name == source.tier]
        for role in () if found else (PHONES, WORD_TIER_NAME):
            own = (tier for tier in tiers if tier.speaker == source.tier)
            found = found or [tier for tier in own if role.fullmatch(tier.role)]
    if not found:
        names = did_you_mean(str(source.tier), {tier.name for tier in tiers})
        # Without a similar name the hint lists all, which may be hundreds.
        if names.startswith("known") and len(tiers) > MAX_NAMES:
            names = f"there is {_list(tiers)}"
        raise source.fault(f"no tier is named '{source.tier}'; {names}")
    first, *others = found
    same = next((tier for tier in others if tier.name == first.name), None)
    if same:
        also = f" (one in line {first.line})" if first.line else ""
        twice = f"{len(found)} {what}, two of them '{first.name}'{also}"
        raise source.fault(f"{twice}; rename one, or remove it", same.line)
    if others:
        several = f"{len(found)} {what}: {_list(found)}"
        raise source.fault(f'{several}; choose one (`tier="{first.name}"`)')
    return first


def _phones(source: TimingFile, tiers: Sequence[Tier]) -> list[Tier]:
    """Return the tiers that hold phones, or else words; raise an error if none of them does."""
    named = [tier for tier in tiers if PHONES.fullmatch(tier.role)]
    found = _sure([tier for tier in named if tier.spoken]) or named
    found = found or [tier for tier in tiers if tier.looks_like_phones()]
    spoken = [tier for tier in tiers if tier.spoken]
    found = found or [tier for tier in spoken if WORD_TIER_NAME.fullmatch(tier.role)]
    found = found or [tier for tier in spoken if len(spoken) == 1 and tier.holds_words()]
    if tiers and not found:
        what = f"no tier looks like phones; there is {_list(tiers)}"
        raise source.fault(f"{what}. Name the tier (`tier='NAME'`), or align the file first")
    return found


def _sure(tiers: list[Tier]) -> list[Tier]:
    """Return the aligned tiers, or else all."""
    return [tier for tier in tiers if ALIGNED_TIER_NAME.fullmatch(tier.role)] or tiers


def _list(tiers: Sequence[Tier]) -> str:
    return shortlist((f"'{tier.name}'" for tier in tiers), MAX_NAMES)


def tiers_of(schedule: Schedule) -> dict[str, list[LabelSpan]]:
    """Return the tiers of a schedule from time zero on: words, phones and maybe confidences.

    Texts have single spaces and no line breaks. Times have `TIME_DIGITS` decimals. Raises
    OutputError if the schedule ends at time zero, or within the first microsecond.
    """
    times = [round(float(time), TIME_DIGITS) for time in schedule.times]
    if times[-1] <= 0:
        what = f"has no timings to write, as it ends at {schedule.end:g} s"
        raise OutputError(f"{schedule.source}: {what}; check its units per second (--rate)")
    words = [(word, times[word.first], times[word.stop]) for word in schedule.words]
    sure = [
        (f"{word.confidence:.{CONFIDENCE_DIGITS}f}", start, end)
        for word, start, end in words
        if word.confidence is not None
    ]
    tiers = {
        "words": _from_zero((word.text, start, end) for word, start, end in words),
        "phones": _from_zero(zip(schedule.labels, times, times[1:], strict=False)),
        CONFIDENCE_TIER: _from_zero(sure),
    }
    return {name: spans for name, spans in tiers.items() if spans or name != CONFIDENCE_TIER}


def _from_zero(spans: Iterable[LabelSpan]) -> list[LabelSpan]:
    """Return spans from time zero on, with texts of one line, of characters that readers take."""
    return [
        (" ".join(xml_text(label).split()) or SILENCE, max(start, 0.0), end)
        for label, start, end in spans
        if end > 0
    ]
