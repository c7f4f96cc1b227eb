"""Formats of timings in JSON that differ in their paths and the names of their fields alone.

`record_formats.json` states them as a project states its own. `untimed` is for punctuation, which
may stand among the words without times.
"""

import json
from pathlib import Path

from lipsync_lang.schedules.records import record_format
from lipsync_lang.schedules.timing_readers import TIMING_READERS

for name, fields in json.loads(Path(__file__).with_suffix(".json").read_text("utf-8")).items():
    TIMING_READERS.add(name, record_format(name, fields).reader(), __name__)
