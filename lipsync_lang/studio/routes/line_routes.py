"""Routes of the line and the script: text, timings and sound, curves, face and figures."""

from collections.abc import Collection, Mapping
from copy import copy
from dataclasses import asdict, fields, replace
from math import isfinite
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.json_object import Json
from lipsync_lang.performing.gesturing import ALL
from lipsync_lang.performing.label_reader import label_remarks
from lipsync_lang.performing.performer import Performer, performer_of
from lipsync_lang.reports.quality.check_animation import check
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.schedules.schedule import AT_REST
from lipsync_lang.schedules.timing_file import unnamed_encoding
from lipsync_lang.schedules.timing_readers import read_timings
from lipsync_lang.sound.speech.sound import read_audio
from lipsync_lang.studio.array_pack import ArrayPack
from lipsync_lang.studio.face_data import face_data
from lipsync_lang.studio.line_settings import LineSettings
from lipsync_lang.studio.routes.requests import (
    MAX_PATH_DIGITS,
    MAX_TITLE_CHARS,
    PackedResponse,
    StudioRequest,
    listed,
    sent_file,
    tab_of,
    whole_number,
)
from lipsync_lang.studio.take_data import curves_data, figures_data, gesture_data, take_data
from lipsync_lang.studio.workshop import Workshop, without_lines

SOUND_MARGIN_SECONDS = 1.0
"""Seconds of sound to send before and after a line."""

MAX_TYPED_CHARS = 2000
"""Maximum length of a typed line."""

MAX_SOUGHT_CHARS = 200
"""Maximum length of a text to search for in the script."""

SAVED = "saved"
"""Name of the take with the packs on the disk."""


def speak(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Speak a text, and return its sound and its take."""
    text, most = request.text("text").strip(), MAX_TYPED_CHARS
    if len(text) > most:
        raise LipsyncError(f"the line is longer than {most} characters; speak it in parts")
    workshop.speak(text)
    return whole(workshop)


def timings(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Read timed phonemes of a file, and keep the sound that was opened before."""
    from lipsync_lang.sound.speech.filling import with_phonemes

    with TemporaryDirectory() as folder, unnamed_encoding():
        found = read_timings(sent_file(request, Path(folder)), request.query.get("notation"))
    schedule = with_phonemes(workshop.performer.speaker, found)
    workshop.performer.common_phonemes(schedule)  # refuses labels of no notation
    # the words can be typed anew, unless they are a whole scene
    text = " ".join(word.text for word in schedule.words)
    workshop.take_up(schedule, text if len(text) <= MAX_TYPED_CHARS else "")
    return whole(workshop)


def sound(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Add the sound of the line; align a text with it, or hear it without one."""
    from lipsync_lang.sound.speech.hearing.alignment import aligned
    from lipsync_lang.sound.speech.hearing.recognition import recognised

    with TemporaryDirectory() as folder:
        path, text = sent_file(request, Path(folder)), request.query.get("text", "").strip()
        if text:
            workshop.take_up(aligned(workshop.performer.speaker, path, text), text)
        elif "hear" in request.query:
            workshop.take_up(recognised(workshop.performer.speaker, path), "")
        elif workshop.line is not None:
            workshop.line.hear(read_audio(path))
        else:
            raise LipsyncError(
                "type the text of the recording, hear it without a text, or open its timed "
                "phonemes first"
            )
    return whole(workshop)


def line(workshop: Workshop, _: StudioRequest) -> PackedResponse:
    """Return the sound and the take of the open line."""
    return whole(workshop)


def take(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Perform the line with the requested settings, and return the takes."""
    stated, before = request.body.get("settings"), workshop.settings
    if stated is None:
        return takes(workshop, request.body.get("against"))
    workshop.settings = _settings(stated)
    try:
        name = workshop.settings.line
        if name in workshop.performer.compiled.line_edits and name != workshop.name:
            workshop.name = str(name)
            workshop.follow()
        return changed(workshop, request, "Delivery of the line")
    except LipsyncError:
        workshop.settings = before  # a refused setting must not stay for the next request
        raise


def changed(workshop: Workshop, request: StudioRequest, title: str) -> PackedResponse:
    """Return the takes of a changed line, which is kept unless the change goes on."""
    body = request.body
    answer = takes(workshop, body.get("against"))  # refuses what cannot be performed
    if body.get("passing"):
        return answer
    title = str(body.get("title", title))[:MAX_TITLE_CHARS]
    workshop.keep(title, tab_of(request), str(body.get("merge", "")))
    return PackedResponse(answer.document | {"state": workshop.state()}, answer.arrays)


def _settings(stated: Any) -> LineSettings:
    """Read settings; names of styles and regions are checked when the line is performed."""
    known = {field.name for field in fields(LineSettings)}
    if not isinstance(stated, dict) or not known.issuperset(stated):
        raise LipsyncError(
            f"settings must be an object with fields among {', '.join(sorted(known))}"
        )
    given = LineSettings(**{key: value for key, value in stated.items() if value is not None})
    listed(given.placed, "placed")
    numbers = [given.fps, *([] if given.intensity is None else [given.intensity])]
    for table in (given.styles, given.dials, given.bends):
        if not isinstance(table, dict):
            raise LipsyncError("`styles`, `dials` and `bends` must be objects of names and levels")
        for level in table.values():
            points = level if isinstance(level, list) else [[level]]
            # a level is one number, or points of time and number
            numbers += [number for point in points for number in listed(point, "numbers")]
    if not all(type(number) in {int, float} and isfinite(number) for number in numbers):
        raise LipsyncError("frame rate, intensity and levels must be numbers")
    if given.line is not None and not isinstance(given.line, str):
        raise LipsyncError("`line` must be the name of a line")
    return given


def whole(workshop: Workshop) -> PackedResponse:
    """Return the sound and the take of the line, or of its shown part."""
    packed = takes(workshop, None)
    schedule = workshop.schedule
    sound, remarks, unread = None, [], ""
    if schedule is not None:
        remarks = [*schedule.remarks, *label_remarks(workshop.performer.labels, schedule)]
        unread, audio = " ".join(schedule.unread), schedule.audio
        if audio is not None:
            # a part of a long line is heard with a little of its neighbours
            first = max(0, int((schedule.start - SOUND_MARGIN_SECONDS) * audio.rate))
            stop = max(first, int((schedule.end + SOUND_MARGIN_SECONDS) * audio.rate))
            samples = packed.arrays.add(audio.samples[first:stop], "i2")
            sound = {"rate": audio.rate, "start": first / audio.rate, "samples": samples}
    data = {
        "sound": sound,
        "remarks": remarks,
        "unread": unread,
        "text": workshop.text,
        "settings": asdict(workshop.settings),
        "name": workshop.name,
        "opened": workshop.opened,
        "script": workshop.script.place(workshop.script_line, workshop.opened_pair()[1]),
    }
    return PackedResponse(packed.document | data, packed.arrays)


def takes(workshop: Workshop, against: Any) -> PackedResponse:
    """Return the take, and the take to compare it with."""
    pack = ArrayPack()
    made = [_take(workshop.perform_shown(), workshop.performer, pack, "")]
    if isinstance(against, str) and against:
        from lipsync_lang.reports.quality.baselines import BASELINES

        if against == SAVED:
            other = workshop.perform_shown(workshop.saved)
        elif against in BASELINES:
            schedule = workshop.spoken.part(workshop.part_seconds)
            other = BASELINES[against](workshop.performer, schedule, workshop.settings.fps)
        else:
            known = ", ".join((SAVED, *BASELINES))
            raise LipsyncError(f"'{against}' is not a take; compare with {known}")
        made.append(_take(other, workshop.performer, pack, against))
    line, seconds = workshop.spoken, workshop.part_seconds
    count, length = len(line.cuts(seconds)) - 1, line.whole.end - line.whole.start
    part = {"number": line.number(seconds), "count": count, "seconds": length}
    data = {"revision": workshop.desk.revision, "takes": made, "part": part if count > 1 else None}
    return PackedResponse(data, pack)


def _take(animation: Animation, own: Performer, pack: ArrayPack, name: str) -> Json:
    """Return a take as JSON; for a plain method, the open performer drives the model."""
    performer = performer_of(animation)
    rigged = (performer or own).rigged(animation)
    channels = None if rigged is animation else curves_data(rigged, pack)
    data = take_data(animation, performer, pack)
    data |= {"name": name, "face": 0, "channels": channels, "gestures": gesture_data(animation)}
    return data


def face(workshop: Workshop, _: StudioRequest) -> PackedResponse:
    """Return the model of the character, for `gl_face.js`, and a take of rest."""
    if not workshop.language:
        return PackedResponse({"face": None}, ArrayPack())
    return _faced(workshop.performer, _rest(workshop.performer))


def beside(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Return the take of the line on another character, and its model if `face` asks for it."""
    character = request.text("character")
    performer = other_performer(workshop, character)
    animation = performed_beside(workshop, character) or _rest(performer)
    if request.body.get("face"):
        return _faced(performer, animation)
    pack = ArrayPack()
    return PackedResponse({"take": _take(animation, performer, pack, "")}, pack)


def _rest(performer: Performer) -> Animation:
    """Perform rest, with the columns of gestures."""
    return performer.perform(AT_REST, gestures=ALL)


def _faced(performer: Performer, animation: Animation) -> PackedResponse:
    pack = ArrayPack()
    shown = face_data(performer.rigged(animation), pack)
    return PackedResponse({"face": shown, "take": _take(animation, performer, pack, "")}, pack)


def figures(workshop: Workshop, _: StudioRequest) -> Json:
    """Return the figures of the take with findings; none while a pair without a line is open."""
    if workshop.line is None:
        return {"figures": []}
    return {"figures": figures_data(check(workshop.perform()))}


def script_lines(workshop: Workshop, request: StudioRequest) -> Json:
    """List lines of the script; without a query, the script is read first."""
    # a search must not read the script again at each letter typed
    if not request.query:
        workshop.script.read()
    text, sought = request.query.get("first", "0"), request.query.get("sought", "")
    first = whole_number(text)
    if first is None:
        raise LipsyncError(f"'{text[:MAX_PATH_DIGITS]}' is not the number of a line")
    return workshop.script.listed(
        *workshop.opened_pair(), sought=sought[:MAX_SOUGHT_CHARS], first=first
    )


def open_script_line(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Open a line of the script in the open language, and return its sound and take."""
    workshop.open_script_line(request.text("name"))
    return whole(workshop)


def other_performer(workshop: Workshop, character: str) -> Performer:
    """Return the performer of the open language on another character, with the unsaved edits."""
    now = workshop.language, workshop.desk.revision
    known = workshop.others.get(character)
    # compiled anew after every edit, which changes the number of the revision
    if known is None or known[:2] != now:
        compiled = compile_pair(workshop.library(), workshop.language, character)
        known = (*now, without_lines(workshop.performer_for(compiled)))
        workshop.others = {character: known}
    return known[2]


def performed_beside(workshop: Workshop, character: str) -> Animation | None:
    """Perform the line on another character, with the styles, regions and gestures it shares.

    None if there is no line.
    """
    performer, stated = other_performer(workshop, character), workshop.settings
    if workshop.line is None:
        return None
    # A copy: the settings of the open line must not lose what the other face lacks.
    compiled, aside = performer.compiled, copy(workshop)
    moves = {shape.name for shape in performer.gesture_set.shapes}
    aside.settings = replace(
        stated,
        line=None,
        styles=_among(stated.styles, compiled.style_names),
        dials=_among(stated.dials, compiled.regions),
        bends=_among(stated.bends, compiled.poses),
        placed=[one for one in stated.placed if one["gesture"] in moves],
    )
    return aside.perform_shown(performer)


def _among(levels: Mapping[str, Any], known: Collection[str]) -> dict[str, Any]:
    return {name: level for name, level in levels.items() if name in known}
