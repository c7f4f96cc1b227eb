"""Routes of the sentence view: boundaries, emphasis, parts of a long line, and its timings."""

from lipsync_lang.errors import LipsyncError, did_you_mean
from lipsync_lang.json_object import Json
from lipsync_lang.schedules.schedule import MAX_EMPHASIS, MAX_SCHEDULE_SECONDS
from lipsync_lang.schedules.writers import TIMING_WRITERS
from lipsync_lang.studio.routes.line_routes import changed, whole
from lipsync_lang.studio.routes.requests import PackedResponse, StudioRequest, whole_number
from lipsync_lang.studio.workshop import Workshop


def boundary(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Move a boundary between phonemes, and return the takes."""
    number = _number(request)
    seconds = request.number("seconds", -MAX_SCHEDULE_SECONDS, MAX_SCHEDULE_SECONDS)
    workshop.spoken.move(number, seconds, workshop.part_seconds)
    return changed(workshop, request, "Move a boundary")


def original(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Restore the original times, and return the takes."""
    workshop.spoken.restore()
    return changed(workshop, request, "Restore the original times")


def emphasis(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Set the emphasis of a word, and return the takes."""
    level = request.number("level", 0, MAX_EMPHASIS)
    workshop.spoken.emphasise(_number(request), level, workshop.part_seconds)
    return changed(workshop, request, "Emphasis of a word")


def part(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Show another part of a long line, and return its sound and take."""
    workshop.spoken.show(_number(request), workshop.part_seconds)
    return whole(workshop)


def written(workshop: Workshop, request: StudioRequest) -> Json:
    """Return the timings of the whole line as a file, named like its line in the script."""
    suffix = request.name
    if suffix not in TIMING_WRITERS:
        raise LipsyncError(
            f"unknown format of timings '{suffix}'; {did_you_mean(suffix, TIMING_WRITERS)}"
        )
    line = workshop.script_line
    name = "line" if line is None else line.name
    return {"name": f"{name}.{suffix}", "content": TIMING_WRITERS[suffix](workshop.spoken.whole)}


def _number(request: StudioRequest) -> int:
    """Return the number in the path."""
    number = whole_number(request.name)
    if number is None:
        raise LipsyncError(
            f"'{request.name[:20]}' is not the number of a boundary, a word or a part"
        )
    return number
