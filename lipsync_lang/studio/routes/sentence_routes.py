"""Routes of the sentence view: boundaries, phonemes, emphasis, parts of a line, and its timings."""

from collections.abc import Sequence
from functools import partial

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules.schedule import MAX_EMPHASIS, MAX_SCHEDULE_SECONDS, SILENCE
from lipsync_lang.schedules.writers import TIMING_WRITERS
from lipsync_lang.studio.routes.line_routes import changed, whole
from lipsync_lang.studio.routes.requests import PackedResponse, StudioRequest, listed, whole_number
from lipsync_lang.studio.workshop import Workshop


def boundary(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Move a boundary between phonemes, and return the takes."""
    number = _number(request)
    seconds = request.number("seconds", -MAX_SCHEDULE_SECONDS, MAX_SCHEDULE_SECONDS)
    through = request.body.get("through")
    if through is not None and type(through) is not int:
        raise LipsyncError("`through` must be the number of a boundary")
    workshop.spoken.move(number, seconds, workshop.part_seconds, through)
    return changed(workshop, request, "Move a boundary")


def labels(workshop: Workshop, _: StudioRequest) -> Json:
    """Return the labels that the line's phonemes may have, with the common phonemes of each."""
    table = workshop.performer.labels.notation(workshop.spoken.whole).table
    rows = [[label, " ".join(name for name, _ in value)] for label, value in table.items()]
    return {"labels": [[SILENCE, ""], *(row for row in rows if row[0] != SILENCE)]}


def phonemes(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Replace a span of phonemes by others, and return the takes.

    `count` phonemes become `labels`, with the inner boundaries `times` where they are given.
    """
    first, line, length = _number(request), workshop.spoken, workshop.part_seconds
    count, new = request.body.get("count", 1), listed(request.body.get("labels"), "labels")
    if type(count) is not int or not new or not all(isinstance(one, str) for one in new):
        raise LipsyncError("give `count` phonemes, and the `labels` that take their place")
    _refuse_unknown(workshop, first, new)
    inner = listed(request.body.get("times", []), "times")
    if inner and len(inner) != len(new) - 1:
        raise LipsyncError(f"{len(new)} labels have {len(new) - 1} boundaries between them")
    line.relabel((first, first + count), new, length)
    for number, seconds in enumerate(inner, first + 1):
        if type(seconds) not in {int, float} or abs(seconds) > MAX_SCHEDULE_SECONDS:
            raise LipsyncError("`times` must be seconds")
        line.move(number, seconds, length)
    return changed(workshop, request, "Change phonemes")


def align(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Align the words of `count` phonemes with their part of the sound, and return the takes."""
    from lipsync_lang.sound.speech.hearing.alignment import aligned

    first, count = _number(request), request.body.get("count", 1)
    if type(count) is not int or count < 1:
        raise LipsyncError("give the `count` of the phonemes to align")
    workshop.spoken.align(
        (first, first + count), workshop.part_seconds, partial(aligned, workshop.performer.speaker)
    )
    return changed(workshop, request, "Align again")


def _refuse_unknown(workshop: Workshop, first: int, new: Sequence[str]) -> None:
    """Refuse a label that the line's notation does not have, and suggest another."""
    schedule, reader = workshop.spoken.part(workshop.part_seconds), workshop.performer.labels
    notation = reader.notation(workshop.spoken.whole)
    for label in new:
        if notation.find(label) is None and reader.unlisted(notation, label) is None:
            at = f" at {schedule.times[first]:.2f} s" if first < len(schedule) else ""
            raise LipsyncError(
                f"phoneme {first}{at}: '{label[:20]}' is no label of {workshop.language}; "
                f"{notation.suggest(label)}"
            )


def original(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Restore the original phonemes and times, and return the takes."""
    workshop.spoken.restore()
    return changed(workshop, request, "Restore the original times")


def emphasis(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Set the emphasis of a word, and return the takes."""
    level = request.number("level", 0, MAX_EMPHASIS)
    workshop.spoken.emphasise(_number(request), level, workshop.part_seconds)
    return changed(workshop, request, "Emphasis of a word")


def say(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Mark a word that is left out as spoken, and return the takes."""
    workshop.say(_number(request))
    return changed(workshop, request, "Say a word that was left out")


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
