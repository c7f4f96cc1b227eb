"""Output formats of timings: schedules as files that the readers read back.

JSON keeps all that a schedule has but its sound. A TextGrid, an ELAN document and a table have
phonemes, words and their confidence; a label track has phonemes alone. Stress and emphasis have no
place there. All but JSON leave out times before zero.
"""

from collections.abc import Callable
from pathlib import Path

from lipsync_lang.errors import OutputError
from lipsync_lang.files import argument_path, atomic
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.writers.audacity import label_track_text
from lipsync_lang.schedules.writers.csv import table_text
from lipsync_lang.schedules.writers.elan import elan_text
from lipsync_lang.schedules.writers.json import json_text
from lipsync_lang.schedules.writers.textgrid import textgrid_text

TIMING_WRITERS: dict[str, Callable[[Schedule], str]] = {
    "json": json_text,
    "TextGrid": textgrid_text,
    "eaf": elan_text,
    "csv": table_text,
    "txt": label_track_text,
}
"""Functions by the suffix of their file, without the dot."""


def save_timings(schedule: Schedule, path: str | Path) -> None:
    """Write a schedule to a file, all at once; see `Schedule.save`."""
    target = argument_path(path)
    write = {f".{suffix.lower()}": one for suffix, one in TIMING_WRITERS.items()}
    found = write.get(target.suffix.lower())
    if found is None:
        raise OutputError(
            f"{target}: timings cannot be written as '{target.suffix}'; use the suffix "
            f"{', '.join(write)}"
        )
    with atomic(target) as stream:
        stream.write(found(schedule).encode("utf-8"))
