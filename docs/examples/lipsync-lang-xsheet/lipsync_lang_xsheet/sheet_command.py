"""A command: the phoneme on each frame of a track sheet, or of any other file of timings."""

import sys
from argparse import Namespace

from lipsync_lang.animations.rates import parse_rate
from lipsync_lang.commands.registry import Add, command
from lipsync_lang.schedules import SILENCE, read_schedule


@command("xsheet")
def add_xsheet(add: Add) -> None:
    """Add `xsheet`."""
    made = add(xsheet, "print the phoneme on each frame", "xsheet line.track --fps 24")
    made.add_argument("file", metavar="FILE", help="timed phonemes; - is standard input")
    made.add_argument(
        "--fps", metavar="N", type=parse_rate, default=24.0, help="frames per second [24]"
    )


def xsheet(options: Namespace) -> int:
    """Print a row for each frame."""
    schedule = read_schedule(options.file)
    ends = [round(seconds * options.fps) for seconds in schedule.times]
    for label, start, end in zip(schedule.labels, ends, ends[1:], strict=False):
        for frame in range(start, end):
            sys.stdout.write(f"{1 + frame}\t{'-' if label == SILENCE else label}\n")
    return 0
