"""Remarks on the labels of a schedule: noise, sounds by their features, and doubtful notations."""

from collections import Counter
from collections.abc import Iterator

from lipsync_lang.base.errors import shortlist
from lipsync_lang.performing.label_reader import LabelReader
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.text.phonology.labels import normalise

SURE_SHARE = 0.97
"""Share of the labels that a notation must contain to be used without a remark."""

MAX_UNLISTED = 8
"""Maximum number of labels outside the language with a remark each."""

MAX_SHOWN = 4
"""Maximum number of labels or notations in a remark."""


def label_remarks(reader: LabelReader, schedule: Schedule) -> tuple[str, ...]:
    """Return remarks on doubtful labels and their treatment; empty if there are none."""
    return (
        *_noise(reader, schedule),
        *_by_features(reader, schedule),
        *_notation(reader, schedule),
    )


def _by_features(reader: LabelReader, schedule: Schedule) -> Iterator[str]:
    """Yield a remark on each label that the language lacks, with the phonemes in its place."""
    found = reader.by_features(schedule)
    for label, value in [*found.items()][:MAX_UNLISTED]:
        times, shown = schedule.labels.count(label), " ".join(name for name, _ in value)
        often = f" ({times} times)" if times > 1 else ""
        yield (
            f"{schedule.source}: {label!r}{often} is not a sound of {reader.compiled.language}; it "
            f"is performed as {shown or 'nothing'}, the nearest by phonetic features"
        )
    if len(found) > MAX_UNLISTED:
        more = len(found) - MAX_UNLISTED
        yield (f"{schedule.source}: {more} more labels are performed by their phonetic features")


def _noise(reader: LabelReader, schedule: Schedule) -> Iterator[str]:
    """Yield a remark on labels of noise and of speech that an aligner could not read."""
    noises = {normalise(label).casefold() for label in reader.compiled.noises}
    notation = reader.notation(schedule)
    silence = notation.silence
    counts: Counter[str] = Counter()
    seconds = 0.0
    for label, start, end in zip(schedule.labels, schedule.times, schedule.times[1:], strict=False):
        if normalise(label).casefold() in noises and notation.find(label) == silence:
            counts[label] += 1
            seconds += float(end - start)
    if counts:
        named = (f"{label!r} ({n})" for label, n in counts.items())
        yield (
            f"{schedule.source}: noise or unreadable speech, during which the mouth rests for "
            f"{seconds:.1f} s: {shortlist(named, MAX_SHOWN)}"
        )


def _notation(reader: LabelReader, schedule: Schedule) -> Iterator[str]:
    """Yield a remark on a notation that was recognised by its labels, unless it is certain."""
    if schedule.notation is not None:
        return
    known = reader.own_notations
    chosen = reader.notation(schedule)
    name = next(n for n, one in known.items() if one is chosen)
    labels = {one for one in schedule.labels if one != SILENCE and not chosen.is_silence(one)}
    stated = {one for one in labels if chosen.stated(one) is not None}
    alike = [
        other
        for other, one in known.items()
        if one is not chosen
        and stated
        and all(map(one.spells, stated))
        and any(one.stated(label) != chosen.stated(label) for label in stated)
    ]
    share = len(stated) / len(labels) if labels else 1.0
    if share >= SURE_SHARE and not alike:
        return
    told = f"{schedule.source}: labels are read as {name}, a notation with {share:.0%} of them"
    if alike:
        told += f"; they can also be {shortlist(alike, MAX_SHOWN)} (`notation={alike[0]!r}`)"
    yield told
