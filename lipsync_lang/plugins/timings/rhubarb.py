"""Rhubarb Lip Sync: mouth shapes in its TSV, XML and JSON.

Times are seconds. In TSV a line is a start and a shape, and the last line is the end of the
recording with a closed mouth. XML and JSON state the end of every shape. Those of the npm package
`rhubarb-lip-sync-wasm` overlap: a shape lasts until the next one starts.
"""

import re
from collections.abc import Sequence
from itertools import pairwise
from operator import attrgetter

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader
from lipsync_lang.schedules.rows import Start, shapes_of, until_next
from lipsync_lang.schedules.schedule import SNAP_SECONDS

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
        return _shapes(source, cues)
    if source.holds("mouthCues"):
        cues = []
        listed = source.json["mouthCues"]
        for cue in listed if isinstance(listed, list) else [listed]:
            if not isinstance(cue, dict) or not isinstance(cue.get("value"), str):
                raise source.fault(f"a cue has no value; the form is {RHUBARB_FORM}")
            start, end = source.number(cue.get("start")), source.number(cue.get("end"))
            cues.append(LabelRow(cue["value"], start, end))
        return _shapes(source, cues)
    starts: list[Start] = [
        (found[2], source.time(found[1], number), number)
        for number, found in source.matches(RHUBARB_LINE, "a time, a tab and a shape")
    ]
    stop = starts[-1][1] if starts else None
    # The last line only ends the recording; its shape is never shown.
    rows, told = until_next(source, starts[:-1], rest="", end=stop)
    return shapes_of(source, rows, notation=RHUBARB_NOTATION, remarks=told)


def _shapes(source: TimingFile, cues: Sequence[LabelRow]) -> Schedule:
    """Return the schedule of shapes with ends; one that overlaps the next ends at its start."""
    ordered = sorted(cues, key=attrgetter("start"))
    shown = [
        one._replace(end=after.start) if one.end > after.start + SNAP_SECONDS else one
        for one, after in pairwise(ordered)
    ] + ordered[-1:]
    cut = sum(one != before for one, before in zip(shown, ordered, strict=True))
    told = f"{source.path}: shapes that overlap the next one ({cut}) last until it starts"
    shown = [one for one in shown if one.end != one.start]  # under a shape of the same start
    return shapes_of(source, shown, notation=RHUBARB_NOTATION, remarks=[told] * (cut > 0))
