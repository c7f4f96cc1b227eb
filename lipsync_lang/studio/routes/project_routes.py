"""Routes of the studio as a whole: its pair."""

from lipsync_lang.packs.finding import Kind
from lipsync_lang.packs.library import Library
from lipsync_lang.rigs.container import Json
from lipsync_lang.studio.routes.asking import Routes, Wish
from lipsync_lang.studio.workshop import Workshop


def project(workshop: Workshop, _: Wish) -> Json:
    """List languages and characters, and tell the pair that is open."""
    library = workshop.library()
    return {
        "folder": workshop.project.name,
        "languages": _names(library, "language"),
        "characters": sorted({*_names(library, "character"), *_names(library, "poseset")}),
        "state": workshop.state(),
    }


def _names(library: Library, kind: Kind) -> list[str]:
    return [found.name for found in library.names(kind) if found.shadowed_by is None]


def open_(workshop: Workshop, asked: Wish) -> Json:
    """Open a pair."""
    workshop.open(asked.text("language"), asked.text("character"))
    return workshop.state()


def state(workshop: Workshop, _: Wish) -> Json:
    """Return the state."""
    return workshop.state()


ROUTES: Routes = {
    "GET project": project,
    "POST open": open_,
    "GET state": state,
}
