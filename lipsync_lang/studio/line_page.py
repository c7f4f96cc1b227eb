"""HTML page of a line: its sound, its face, its curves and their explanations.

Text of packs and schedules is data, never markup: it is in a JSON element with every ``<`` escaped,
and the script shows it as text. The policy of the page allows only its own script and style, by
their hashes, and no requests.
"""

import json
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256
from typing import TYPE_CHECKING, Any

from lipsync_lang.animations.animation import Animation
from lipsync_lang.errors import LipsyncError
from lipsync_lang.quality.check_animation import check
from lipsync_lang.quality.figures import Quality
from lipsync_lang.rigs.container import Json
from lipsync_lang.studio.array_pack import ArrayPack
from lipsync_lang.studio.face_data import face_data
from lipsync_lang.studio.module_bundle import bundle, static
from lipsync_lang.studio.take_data import curves_data, settings_told, take_data

if TYPE_CHECKING:
    from lipsync_lang.performing.performer import Performer

FORMAT = "lipsync-lang page 1"


def line_page(
    animation: Animation,
    *,
    performer: "Performer | None" = None,
    qualities: Mapping[str, Quality] | None = None,
) -> str:
    """Return an animation as a self-contained page.

    Animations in `against` are shown beside it.

    Parameters
    ----------
    performer : performer of the face, for an animation from another program
    qualities : figures by the name of the animation in `against`, "" for the first; None to
        measure them here

    Examples
    --------
    >>> performer = ll.resolve("english", "facefx")
    >>> page = line_page(performer.perform(ll.Schedule(("M", "AA"), [0, 0.1, 0.3])))
    >>> page.startswith("<!DOCTYPE html>")
    True
    """
    pack = ArrayPack()
    document = _document(animation, performer or animation.performer, pack, qualities)
    document["arrays"] = pack.layout()
    script, style = bundle("page"), static("page.css")
    parts = {
        "POLICY": _policy(script, style),
        "STYLE": style,
        "SCRIPT": script,
        "DOCUMENT": json.dumps(document, separators=(",", ":")).replace("<", "\\u003c"),
        "BLOCK": pack.text(),
    }
    head, *rest = static("page.html").split("{{")
    pieces = [head]
    for part in rest:
        name, _, after = part.partition("}}")
        pieces += [parts[name], after]
    return "".join(pieces)


def _document(
    animation: Animation,
    performer: "Performer | None",
    pack: ArrayPack,
    qualities: Mapping[str, Quality] | None,
) -> Json:
    takes: list[Json] = []
    faces: list[Json] = []
    known: dict[Any, int] = {}
    for name, one in {"": animation, **animation.against}.items():
        own, posed = one.performer or performer, _posed(one)
        quality = _judged(posed, own) if qualities is None else qualities.get(name)
        take = take_data(posed, own, pack, quality)
        key = (one.model, one.columns)
        if key not in known:
            known[key] = len(faces)
            faces.append(face_data(one, pack))
        channels = None if posed is one else curves_data(one, pack)
        takes.append(take | {"name": name, "face": known[key], "channels": channels})
    audio = animation.schedule.audio
    return {
        "format": FORMAT,
        "title": animation.title,
        "settings": settings_told(animation.asked),
        "sound": None
        if audio is None
        else {"rate": audio.rate, "samples": pack.add(audio.samples, "i2")},
        "takes": takes,
        "faces": faces,
    }


def _posed(animation: Animation) -> Animation:
    """Return the poses from which a rig made an animation, or the animation itself."""
    performer: Performer | None = animation.performer
    if performer is None or animation.poses[: len(performer.poses)] == performer.poses:
        return animation
    posed = performer.perform(animation.schedule, animation.fps, **animation.asked)
    half = 0.5 / animation.fps
    low, high = animation.times[0] - half, animation.times[-1] + half
    inside = (posed.times > low) & (posed.times < high)
    return replace(posed, times=posed.times[inside], weights=posed.weights[inside])


def _judged(animation: Animation, performer: "Performer | None") -> Quality | None:
    """Measure an animation; None if no measure applies."""
    if performer is None:
        return None
    try:
        return check(animation, performer=performer)
    except LipsyncError:
        return None


def _policy(script: str, style: str) -> str:
    hashes = [b64encode(sha256(text.encode()).digest()).decode() for text in (script, style)]
    return (
        f"default-src 'none'; script-src 'sha256-{hashes[0]}'; style-src 'sha256-{hashes[1]}'; "
        "media-src blob:; img-src data:; base-uri 'none'; form-action 'none'"
    )
