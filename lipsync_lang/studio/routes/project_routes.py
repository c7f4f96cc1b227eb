"""Routes of the studio as a whole: its pair, its state and its tours."""

import json
from pathlib import Path

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.json_object import Json
from lipsync_lang.packs.finding import Kind, beside
from lipsync_lang.packs.library import Library
from lipsync_lang.studio.routes.requests import StudioRequest
from lipsync_lang.studio.workshop import Workshop

TOUR = "tour.json"
"""File of a tour, beside the pose set that it shows."""

MAX_TOUR_BYTES = 2**16


def project(workshop: Workshop, _: StudioRequest) -> Json:
    """List the languages and the characters, and name the open pair."""
    library = workshop.library()
    return {
        "folder": workshop.project.name,
        "languages": _names(library, "language"),
        "characters": sorted({*_names(library, "character"), *_names(library, "poseset")}),
        "tours": [name for name in _names(library, "poseset") if _tour(library, name)],
        "first": _first(workshop, library),
        "state": workshop.state(),
    }


def _first(workshop: Workshop, library: Library) -> Json | None:
    """Return a pair and a line to begin with; None without a tour to take them of.

    The open pair comes first, and then the user's own packs. Another language than the tour's says
    the longest of its examples.
    """
    told = next((name for name in _names(library, "poseset") if _tour(library, name)), None)
    if told is None:
        return None
    found = tour(workshop, StudioRequest(told))
    own = {
        kind: next((one.name for one in library.names(kind) if workshop.own(one.path)), None)
        for kind in ("language", "character", "poseset")
    }
    language = workshop.language or own["language"] or found["language"]
    line = found["line"]
    if language != found["language"]:
        examples = [test.text for test in library.language(language).model.tests]
        line = max(examples, key=len, default="")
    face = workshop.character or own["character"] or own["poseset"] or told
    return {"language": language, "character": face, "line": line}


def tour(workshop: Workshop, request: StudioRequest) -> Json:
    """Return the tour of a pose set: its language, its line and its steps."""
    path = _tour(workshop.library(), request.name)
    try:
        # a tour that is cut off here is no JSON any more, and is refused as such
        found: Json = json.loads(path.read_bytes()[:MAX_TOUR_BYTES] if path else b"")
    except (OSError, ValueError):
        raise LipsyncError(f"{request.name} has no valid {TOUR}") from None
    return found


def _tour(library: Library, poseset: str) -> Path | None:
    return beside(library.find("poseset", poseset), TOUR)


def _names(library: Library, kind: Kind) -> list[str]:
    return [found.name for found in library.names(kind) if found.shadowed_by is None]


def open_(workshop: Workshop, request: StudioRequest) -> Json:
    """Open a pair."""
    workshop.open(request.text("language"), request.text("character"))
    return workshop.state()


def state(workshop: Workshop, _: StudioRequest) -> Json:
    """Return the state of the studio."""
    return workshop.state()
