"""HTML page of a line: its sound, its face, its curves and their explanations.

Text of packs and schedules is data, never markup: it is in a JSON element with every ``<`` escaped,
and the script shows it as text. The policy of the page allows only its own script and style, by
their hashes, and no requests.
"""

import json
import re
from base64 import b64encode
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache
from hashlib import sha256
from typing import Any

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.json_object import Json
from lipsync_lang.performing.performer import PerformedLine, Performer, performer_of
from lipsync_lang.reports.quality.check_animation import check
from lipsync_lang.reports.quality.figures import Quality
from lipsync_lang.studio.array_pack import ArrayPack
from lipsync_lang.studio.face_data import face_data, packed_face
from lipsync_lang.studio.module_bundle import bundle, static
from lipsync_lang.studio.take_data import curves_data, take_data

PAGE_FORMAT = "lipsync-lang page 1"

POLICY = (
    "default-src 'none'; script-src 'sha256-{}'; style-src 'sha256-{}'; media-src blob:; "
    "img-src data:; base-uri 'none'; form-action 'none'"
)
"""Content policy of the page: a browser runs only the script and the style with these hashes."""

_script = cache(bundle)  # a report has many pages


def line_page(
    animation: Animation,
    *,
    performer: Performer | None = None,
    qualities: Mapping[str, Quality] | None = None,
) -> str:
    """Return an animation as a self-contained page, with the animations in `against` beside it.

    `performer` is that of the face, for an animation from another program. `qualities` are figures
    by the name of the animation in `against`, "" for the first; None to measure them here.

    Examples
    --------
    >>> performer = ll.resolve("english", "facefx")
    >>> page = line_page(performer.perform(ll.Schedule(("M", "AA"), [0, 0.1, 0.3])))
    >>> page.startswith("<!DOCTYPE html>")
    True
    """
    face, pack = packed_face(animation)
    document = _document(animation, performer or performer_of(animation), face, pack, qualities)
    document["arrays"] = pack.layout()
    script, style = _script("line/page"), static("line/page.css")
    hashes = [b64encode(sha256(text.encode()).digest()).decode() for text in (script, style)]
    parts = {
        "POLICY": POLICY.format(*hashes),
        "STYLE": style,
        "SCRIPT": script,
        # No text can end the script element or begin a comment in it.
        "DOCUMENT": json.dumps(document, separators=(",", ":")).replace("<", "\\u003c"),
        "BLOCK": pack.text(),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], static("page.html"))


def _document(
    animation: Animation,
    performer: Performer | None,
    face: Json,
    pack: ArrayPack,
    qualities: Mapping[str, Quality] | None,
) -> Json:
    takes: list[Json] = []
    faces = [face]
    line = PerformedLine.of(animation)
    settings = line.settings if line else {}
    known: dict[Any, int] = {(animation.model, animation.columns): 0}
    for name, one in {"": animation, **animation.export.against}.items():
        own, posed = performer_of(one) or performer, _posed(one)
        quality = None if qualities is None else qualities.get(name)
        if qualities is None and own is not None:
            with suppress(LipsyncError):  # no measure applies
                quality = check(posed, performer=own)
        take = take_data(posed, own, pack, quality)
        key = (one.model, one.columns)
        if key not in known:
            known[key] = len(faces)
            faces.append(face_data(one, pack))
        channels = None if posed is one else curves_data(one, pack)
        takes.append(take | {"name": name, "face": known[key], "channels": channels})
    audio = animation.schedule.audio
    return {
        "format": PAGE_FORMAT,
        "title": animation.title,
        "settings": [f"{name}: {value}" for name, value in settings.items() if value],
        "sound": None if audio is None else {"rate": audio.rate, **pack.add_sound(audio.samples)},
        "takes": takes,
        "faces": faces,
    }


def _posed(animation: Animation) -> Animation:
    """Return the poses from which a rig made an animation, or the animation itself."""
    line = PerformedLine.of(animation)
    if line is None or animation.poses[: len(line.performer.poses)] == line.performer.poses:
        return animation
    posed = line.performer.perform(animation.schedule, animation.fps, **line.settings)
    # Half a frame of tolerance, since a cut animation has the same times but for rounding.
    half = 0.5 / animation.fps
    low, high = animation.times[0] - half, animation.times[-1] + half
    inside = (posed.times > low) & (posed.times < high)
    return replace(posed, times=posed.times[inside], weights=posed.weights[inside])
