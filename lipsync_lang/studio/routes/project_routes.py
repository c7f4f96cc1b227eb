"""Routes of the studio as a whole: its pair, its edits, undo, redo and saving."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from lipsync_lang.errors import LipsyncError
from lipsync_lang.packs.finding import Kind
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.splicing import ABSENT
from lipsync_lang.rigs.container import Json
from lipsync_lang.studio.merging import MergeConflict, SaveConflict, Side
from lipsync_lang.studio.routes.asking import Refused, Routes, Wish, listed
from lipsync_lang.studio.workshop import Workshop

if TYPE_CHECKING:
    from lipsync_lang.packs.yaml.source import Loc

TOUR = "tour.json"
"""File of a tour, beside the pose set that it shows."""

MAX_TOUR_BYTES = 2**16

MAX_TITLE_CHARS = 80
"""Maximum length of the title of an edit."""

MAX_TAB_CHARS = 40
"""Maximum length of the name of a tab."""


def project(workshop: Workshop, _: Wish) -> Json:
    """List the languages and the characters, and name the open pair."""
    library = workshop.library()
    return {
        "folder": workshop.project.name,
        "languages": _names(library, "language"),
        "characters": sorted({*_names(library, "character"), *_names(library, "poseset")}),
        "tours": [name for name in _names(library, "poseset") if _tour(library, name).is_file()],
        "state": workshop.state(),
    }


def tour(workshop: Workshop, wish: Wish) -> Json:
    """Return the tour of a pose set: its language, its line and its steps."""
    library = workshop.library()
    path = _tour(library, wish.name)
    try:
        found: Json = json.loads(path.read_bytes()[:MAX_TOUR_BYTES])
    except (OSError, ValueError):
        raise LipsyncError(f"{wish.name} has no valid {TOUR}") from None
    return found


def _tour(library: Library, poseset: str) -> Path:
    return library.find("poseset", poseset).with_name(TOUR)


def _names(library: Library, kind: Kind) -> list[str]:
    return [found.name for found in library.names(kind) if found.shadowed_by is None]


def open_(workshop: Workshop, asked: Wish) -> Json:
    """Open a pair."""
    workshop.open(asked.text("language"), asked.text("character"))
    return workshop.state()


def state(workshop: Workshop, _: Wish) -> Json:
    """Return the state of the studio."""
    return workshop.state()


def edit(workshop: Workshop, wish: Wish) -> Json:
    """Change values of packs."""
    body = wish.body
    edits = [_edit(workshop, one) for one in listed(body.get("edits"), "edits")]
    seen, merge = body.get("seen"), body.get("merge")
    if not edits:
        raise LipsyncError("the request has no edits")
    workshop.edit(
        wish.text("title")[:MAX_TITLE_CHARS],
        [(path, loc, value) for path, loc, value, _ in edits],
        seen=seen if isinstance(seen, int) else None,
        tab=_tab(wish),
        merge=merge if isinstance(merge, str) else "",
        create={path: text for path, _, _, text in edits if text is not None},
    )
    return workshop.state()


def _edit(workshop: Workshop, one: Any) -> tuple[Path, tuple[str | int, ...], Any, str | None]:
    """Read an edit: file, place, value, and the initial text of a new file."""
    if not isinstance(one, dict):
        raise LipsyncError("an edit must be an object with `file`, `at` and `value`")
    loc = tuple(listed(one.get("at"), "steps"))
    if not loc or not all(isinstance(step, (str, int)) for step in loc):
        raise LipsyncError("`at` must be a list of keys and numbers, the place of the edit")
    value = one.get("value", ABSENT)
    if one.get("file") == "bank":
        path, text = workshop.bank_for(str(loc[1]) if len(loc) > 1 else "")
        return path, loc, value, text
    path, text = workshop.editable(str(one.get("file")))
    return path, loc, value, text


def undo(workshop: Workshop, wish: Wish) -> Json:
    """Undo the last edit."""
    workshop.desk.undo(tab=_tab(wish))
    workshop.homes.clear()
    return workshop.state()


def redo(workshop: Workshop, wish: Wish) -> Json:
    """Redo the edit that was undone last."""
    workshop.desk.redo(tab=_tab(wish))
    workshop.homes.clear()
    return workshop.state()


def warm(workshop: Workshop, _: Wish) -> Json:
    """Read the files of the first edit in advance."""
    if workshop.language:
        for path in workshop.pair().data:
            if workshop.own(path):
                workshop.desk.read(path)
    return {}


def save(workshop: Workshop, wish: Wish) -> Json:
    """Save every edit; for entries that also changed on the disk, `keep` names the side."""
    keep = wish.body.get("keep") or {}
    if not isinstance(keep, dict) or not {*keep.values()}.issubset(get_args(Side)):
        raise LipsyncError("`keep` must be an object with `mine` or `theirs` for each entry")
    known = {workshop.shown(path): path for path in workshop.desk.contents}
    choices: dict[tuple[Path, Loc], Side] = {}
    for text, side in keep.items():
        try:
            file, *loc = json.loads(text)
            choices[known[file], tuple(loc)] = side
        except (ValueError, KeyError, TypeError):
            raise LipsyncError(f"there is no unsaved entry {text}") from None
    try:
        written = workshop.save(choices)
    except SaveConflict as error:
        rows = [_row(workshop, one) for one in error.conflicts]
        raise Refused(str(error), rows) from None
    return {"saved": [workshop.shown(path) for path in written], "state": workshop.state()}


def _row(workshop: Workshop, one: MergeConflict) -> Json:
    """Return a conflict as JSON data; `key` names it in the next request."""
    file, where = workshop.shown(one.path), ": ".join(map(str, one.loc)) or "the whole file"
    return {
        "key": json.dumps([file, *one.loc]),
        "what": f"{file}: {where}",
        "mine": _words(one.mine),
        "theirs": _words(one.theirs),
    }


def _words(value: Any) -> str:
    return "(deleted)" if value is ABSENT else json.dumps(value, ensure_ascii=False, indent=1)


def _tab(wish: Wish) -> str:
    return str(wish.body.get("tab", ""))[:MAX_TAB_CHARS]


ROUTES: Routes = {
    "GET project": project,
    "POST open": open_,
    "GET tour/{name}": tour,
    "GET state": state,
    "POST edit": edit,
    "POST undo": undo,
    "POST redo": redo,
    "POST save": save,
    "POST warm": warm,
}
