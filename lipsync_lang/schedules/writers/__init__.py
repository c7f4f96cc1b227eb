"""Writers of timings, one module per output format.

To add one, write a module here with a function ``(schedule) -> str``, and name it with its suffix
in `TIMING_WRITERS`. `tiers.tiers_of` gives the words and phones from time zero on, with rounded
times. The tests read each format back, so add a reader of it too. A writer in
`animations/writers/performed_timings.py` lets the outputs of a performance use the format.

JSON keeps all that a schedule has but its sound. A TextGrid, an ELAN document and a table have
phonemes, words and their confidence; a label track has phonemes alone. Stress and emphasis have no
place there. All but JSON leave out times before zero.
"""

from collections.abc import Callable

from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.writers.elan import elan_text
from lipsync_lang.schedules.writers.json import json_text
from lipsync_lang.schedules.writers.tables import label_track_text, table_text
from lipsync_lang.schedules.writers.textgrid import textgrid_text

TIMING_WRITERS: dict[str, Callable[[Schedule], str]] = {
    "json": json_text,
    "TextGrid": textgrid_text,
    "eaf": elan_text,
    "csv": table_text,
    "txt": label_track_text,
}
"""Functions by the suffix of their file, without the dot."""
