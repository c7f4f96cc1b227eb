"""Rhubarb Lip Sync: mouth shapes in its TSV, XML and JSON.

Times are seconds. In TSV a line is a start and a shape, and the last line is the end of the
recording with a closed mouth. XML and JSON state the end of every shape.
"""

import re

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader
from lipsync_lang.schedules.rows import Start, shapes_of, until_next

RHUBARB_NOTATION = "rhubarb"
RHUBARB_LINE = re.compile(r"(\d+(?:\.\d*)?)\t([A-Z])\s*", re.ASCII)
RHUBARB_FORM = '{"mouthCues": [{"start": 0.0, "end": 0.05, "value": "X"}, ...]}'


def sniff(source: TimingFile) -> bool:
    """Return True if the file has mouth cues, or a line of a time and one capital letter."""
    known = source.has_root("rhubarbResult") or source.holds("mouthCues")
    return known or RHUBARB_LINE.fullmatch(source.first_line) is not None


@reader(RHUBARB_NOTATION, ".tsv", ".xml", ".json", sniff=sniff)
def read_rhubarb(source: TimingFile) -> Schedule:
    """Mouth shapes of Rhubarb Lip Sync, as TSV, XML or JSON."""
    if source.head.lstrip().startswith("<"):
        cues = [
            LabelRow(cue.text or "", source.time(cue.get("start")), source.time(cue.get("end")))
            for cue in source.xml.iter("mouthCue")
        ]
        return shapes_of(source, cues, notation=RHUBARB_NOTATION)
    if source.holds("mouthCues"):
        cues = []
        listed = source.json["mouthCues"]
        for cue in listed if isinstance(listed, list) else [listed]:
            if not isinstance(cue, dict) or not isinstance(cue.get("value"), str):
                raise source.fault(f"a cue has no value; the form is {RHUBARB_FORM}")
            start, end = source.number(cue.get("start")), source.number(cue.get("end"))
            cues.append(LabelRow(cue["value"], start, end))
        return shapes_of(source, cues, notation=RHUBARB_NOTATION)
    starts: list[Start] = [
        (found[2], source.time(found[1], number), number)
        for number, found in source.matches(RHUBARB_LINE, "a time, a tab and a shape")
    ]
    stop = starts[-1][1] if starts else None
    rows, told = until_next(source, starts[:-1], rest="", end=stop)
    return shapes_of(source, rows, notation=RHUBARB_NOTATION, remarks=told)
