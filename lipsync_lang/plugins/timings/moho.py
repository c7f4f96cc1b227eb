"""Switch data of Moho, OpenToonz, Papagayo and Rhubarb Lip Sync (`.dat`).

The first line is `MohoSwitch1`. Each other line has a frame, counted from 1, and the name of the
drawing shown from that frame on. The frames per second are the animation's and are not in the file.
"""

import re

from lipsync_lang.plugins.timings import papagayo, rhubarb
from lipsync_lang.schedules import SILENCE, Schedule, TimingFile, reader
from lipsync_lang.schedules.rows import Start, shapes_of, until_next

MOHO_HEADER = "MohoSwitch1"

MOHO_FPS = 24.0
"""Default of the programs that write the format."""

REST_DRAWING = "rest"
"""Name of the neutral drawing."""

DRAWING_LINE = re.compile(r"\s*(\d{1,9})\s+(\S.*?)\s*", re.ASCII)

LETTER = re.compile(r"[A-HX]")
"""A shape of Rhubarb Lip Sync, under its own name."""


def sniff(source: TimingFile) -> bool:
    """Return True if the file has the header of switch data."""
    return source.head.split("\n", 1)[0].strip() == MOHO_HEADER


@reader("moho", ".dat", sniff=sniff)
def read_moho(source: TimingFile) -> Schedule:
    """Switch data of Moho: the frame from which each drawing is shown, at 24 frames a second."""
    starts: list[Start] = []
    # A file that is read as this format by request may lack its header.
    header = int(sniff(source))
    for number, found in source.matches(DRAWING_LINE, "a frame and a drawing", after=header):
        label = SILENCE if found[2].casefold() == REST_DRAWING else found[2]
        starts.append((label, source.time(found[1], number) - 1, number))
    letters = all(LETTER.fullmatch(label) for label, _, _ in starts if label != SILENCE)
    rows, told = until_next(source, starts, rest=SILENCE, rate=MOHO_FPS)
    if source.rate is None:
        what = f"does not state its frame rate; {MOHO_FPS:g} frames per second are assumed"
        told.append(f"{source.path}: {what}; if that is wrong, state the rate (`rate=30`)")
    notation = rhubarb.RHUBARB_NOTATION if letters else papagayo.PRESTON_BLAIR_NOTATION
    return shapes_of(source, rows, notation=notation, rate=MOHO_FPS, remarks=told)
