"""Label tracks of Audacity."""

from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.tiers import TIME_DIGITS, tiers_of


def label_track_text(schedule: Schedule) -> str:
    """Return the phonemes of a schedule as a label track for Audacity; its words are left out."""
    spans = tiers_of(schedule)["phones"]
    return "".join(
        f"{start:.{TIME_DIGITS}f}\t{end:.{TIME_DIGITS}f}\t{label}\n" for label, start, end in spans
    )
