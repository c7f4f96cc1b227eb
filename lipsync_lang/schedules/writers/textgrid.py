"""Praat TextGrid, in the long form."""

from collections.abc import Iterable, Iterator

from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.schedules.tiers import TIME_DIGITS, LabelSpan, tiers_of


def textgrid_text(schedule: Schedule) -> str:
    """Return a schedule as a TextGrid with tiers of words and phones, as long as its sound.

    Silence is an interval without text. Confidences, if any, are a third tier.

    Examples
    --------
    >>> from lipsync_lang.schedules.writers.textgrid import textgrid_text
    >>> text = textgrid_text(ll.Schedule(("M", "_"), [0, 0.1, 0.3]))
    >>> [line.strip() for line in text.splitlines() if "text =" in line]
    ['text = "M"', 'text = ""']
    """
    heard = 0.0 if schedule.audio is None else schedule.audio.seconds
    end = round(float(max(schedule.end, heard)), TIME_DIGITS)
    tiers = tiers_of(schedule)
    lines = [
        'File type = "ooTextFile"', 'Object class = "TextGrid"', "",
        "xmin = 0.0", f"xmax = {end}", "tiers? <exists>", f"size = {len(tiers)}", "item []:",
    ]  # fmt: skip
    for number, (name, spoken) in enumerate(tiers.items(), 1):
        spans = list(_filled(spoken, end))
        lines += [
            f"    item [{number}]:", '        class = "IntervalTier"', f'        name = "{name}"',
            f"        xmin = {spans[0][1]}", f"        xmax = {spans[-1][2]}",
            f"        intervals: size = {len(spans)}",
        ]  # fmt: skip
        for at, (label, begin, stop) in enumerate(spans, 1):
            # Praat doubles a quote, and takes an empty text for silence
            text = "" if label == SILENCE else label.replace('"', '""')
            lines += [
                f"        intervals [{at}]:", f"            xmin = {begin}",
                f"            xmax = {stop}", f'            text = "{text}"',
            ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _filled(spans: Iterable[LabelSpan], end: float) -> Iterator[LabelSpan]:
    """Yield spans with silence in the gaps: Praat needs a tier without gaps."""
    at = 0.0
    for label, begin, stop in spans:
        if begin > at:
            yield SILENCE, at, begin
        yield label, begin, stop
        at = stop
    if at < end:
        yield SILENCE, at, end
