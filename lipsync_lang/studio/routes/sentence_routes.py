"""Routes of the sentence view: boundaries, emphasis, parts of a long line, and its timings."""

from lipsync_lang.errors import LipsyncError, did_you_mean
from lipsync_lang.rigs.container import Json
from lipsync_lang.schedules.schedule import MAX_EMPHASIS, MAX_SCHEDULE_SECONDS
from lipsync_lang.schedules.timing_writers import TIMING_WRITERS
from lipsync_lang.studio.routes.asking import Packed, Routes, Wish, listed
from lipsync_lang.studio.routes.line_routes import takes, whole
from lipsync_lang.studio.workshop import Workshop

MAX_DIGITS = 6
"""Maximum number of digits of a number in a path."""


def boundary(workshop: Workshop, asked: Wish) -> Packed:
    """Move a boundary between phonemes, and return the takes."""
    number = _number(asked)
    seconds = asked.number("seconds", -MAX_SCHEDULE_SECONDS, MAX_SCHEDULE_SECONDS)
    workshop.spoken.move(number, seconds, workshop.part_seconds)
    return takes(workshop, asked.body.get("against"))


def times(workshop: Workshop, asked: Wish) -> Packed:
    """Set all boundaries of the shown part, and return the takes."""
    given = listed(asked.body.get("times"), "times")
    if not all(isinstance(one, (int, float)) and not isinstance(one, bool) for one in given):
        raise LipsyncError("times must be numbers of seconds")
    workshop.spoken.retime(given, workshop.part_seconds)
    return takes(workshop, asked.body.get("against"))


def original(workshop: Workshop, asked: Wish) -> Packed:
    """Restore the original times, and return the takes."""
    workshop.spoken.restore()
    return takes(workshop, asked.body.get("against"))


def emphasis(workshop: Workshop, asked: Wish) -> Packed:
    """Set the emphasis of a word, and return the takes."""
    level = asked.number("level", 0, MAX_EMPHASIS)
    workshop.spoken.emphasise(_number(asked), level, workshop.part_seconds)
    return takes(workshop, asked.body.get("against"))


def part(workshop: Workshop, asked: Wish) -> Packed:
    """Show another part of a long line, and return its sound and take."""
    workshop.spoken.show(_number(asked), workshop.part_seconds)
    return whole(workshop)


def written(workshop: Workshop, asked: Wish) -> Json:
    """Return the timings of the whole line as a file, named like its line in the script."""
    suffix = asked.name
    if suffix not in TIMING_WRITERS:
        raise LipsyncError(
            f"unknown format of timings '{suffix}'; {did_you_mean(suffix, TIMING_WRITERS)}"
        )
    line = workshop.script_line
    name = "line" if line is None else line.name
    return {"name": f"{name}.{suffix}", "content": TIMING_WRITERS[suffix](workshop.spoken.whole)}


def _number(asked: Wish) -> int:
    """Return the number in the path."""
    if not (asked.name.isascii() and asked.name.isdecimal() and len(asked.name) <= MAX_DIGITS):
        raise LipsyncError(f"'{asked.name[:20]}' is not the number of a boundary, a word or a part")
    return int(asked.name)


ROUTES: Routes = {
    "POST boundary/{name}": boundary,
    "POST times": times,
    "POST original": original,
    "POST emphasis/{name}": emphasis,
    "POST part/{name}": part,
    "GET timings/{name}": written,
}
