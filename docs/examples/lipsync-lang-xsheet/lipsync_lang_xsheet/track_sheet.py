"""A reader: the phonemes that a person has heard on each frame of a track.

The first line is `track` and the frames per second. Each other has a frame, from 1, and the phoneme
that starts there; `-` is silence. The last frame ends the track.
"""

from itertools import pairwise

from lipsync_lang.schedules import SILENCE, Schedule, reader
from lipsync_lang.schedules.timing_file import TimingFile


def sniff(source: TimingFile) -> bool:
    """Tell whether the first line says so."""
    return source.head.startswith("track ")


@reader("track-sheet", ".track", sniff=sniff)
def read_track_sheet(source: TimingFile) -> Schedule:
    """Track sheets of drawn animation: a frame and the phoneme heard on it."""
    (first, head), *rows = source.lines
    fps = source.time(head.removeprefix("track "), first)
    if fps <= 0:
        raise source.fault("has no frames per second; write 24", first)
    marks = []
    for number, line in rows:
        frame, _, label = line.partition("\t")
        marks.append(((source.time(frame, number) - 1) / fps, label.strip() or "-"))
    spans = [(label, start, end) for (start, label), (end, _) in pairwise(marks)]
    labelled = [(SILENCE if label == "-" else label, start, end) for label, start, end in spans]
    return Schedule.from_intervals(labelled, source=str(source.path))
