"""Routes of edits: their undo and redo, and saving."""

import json
from contextlib import suppress
from typing import TYPE_CHECKING, Any, get_args

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.json_object import Json
from lipsync_lang.packs.splicing import ABSENT
from lipsync_lang.studio.merging import MergeSide, SaveConflict
from lipsync_lang.studio.routes.requests import (
    MAX_TITLE_CHARS,
    StudioRequest,
    UnresolvedConflict,
    listed,
    tab_of,
)
from lipsync_lang.studio.workshop import Workshop

if TYPE_CHECKING:
    from pathlib import Path

    from lipsync_lang.packs.yaml.source import Loc
    from lipsync_lang.studio.desk import PackEdit


def edit(workshop: Workshop, request: StudioRequest) -> Json:
    """Change values of packs."""
    body = request.body
    edits: list[PackEdit] = []
    for one in listed(body.get("edits"), "edits"):
        if not isinstance(one, dict):
            raise LipsyncError("an edit must be an object with `file`, `at` and `value`")
        loc = tuple(listed(one.get("at"), "steps"))
        if not loc or not all(isinstance(step, (str, int)) for step in loc):
            raise LipsyncError("`at` must be a list of keys and numbers, the place of the edit")
        file, _, style = str(one.get("file")).partition(":")
        if file == "bank":
            path, text = workshop.bank_for(str(loc[1]) if len(loc) > 1 else "", style)
        else:
            path, text = workshop.editable(str(one.get("file")))
        if text is not None:
            edits.append((path, (), text))
        edits.append((path, loc, one.get("value", ABSENT)))
    seen, merge = body.get("seen"), body.get("merge")
    if not edits:
        raise LipsyncError("the request has no edits")
    workshop.edit(
        request.text("title")[:MAX_TITLE_CHARS], edits,
        seen=seen if isinstance(seen, int) else None, tab=tab_of(request),
        merge=merge if isinstance(merge, str) else "",
    )  # fmt: skip
    return workshop.state()


def undo(workshop: Workshop, request: StudioRequest) -> Json:
    """Undo the last edit."""
    workshop.desk.undo(tab=tab_of(request))
    workshop.homes.clear()
    return workshop.state()


def redo(workshop: Workshop, request: StudioRequest) -> Json:
    """Redo the edit that was undone last."""
    workshop.desk.redo(tab=tab_of(request))
    workshop.homes.clear()
    return workshop.state()


def warm(workshop: Workshop, _: StudioRequest) -> Json:
    """Read the files of the first edit in advance; the edit itself says why it is impossible."""
    with suppress(LipsyncError):  # such as a model, which is no character yet
        for path in workshop.pair().data if workshop.language else ():
            if workshop.own(path):
                workshop.desk.read(path)
    return {}


def save(workshop: Workshop, request: StudioRequest) -> Json:
    """Save every edit; for entries that also changed on the disk, `keep` names the side."""
    keep = request.body.get("keep") or {}
    sides = get_args(MergeSide)
    if not isinstance(keep, dict) or not all(one in sides for one in keep.values()):
        raise LipsyncError("`keep` must be an object with `mine` or `theirs` for each entry")
    known = {workshop.shown(path): path for path in workshop.desk.contents}
    choices: dict[tuple[Path, Loc], MergeSide] = {}
    for text, side in keep.items():
        try:
            file, *loc = json.loads(text)
            choices[known[file], tuple(loc)] = side
        # the key of an entry is text from outside: no JSON, no list, or no known file
        except (ValueError, KeyError, TypeError):
            raise LipsyncError(f"there is no unsaved entry {text}") from None
    try:
        written = workshop.save(choices)
    except SaveConflict as error:
        rows = [
            {
                "key": json.dumps([file, *one.loc]),  # names the entry in the next request
                "what": f"{file}: {': '.join(map(str, one.loc)) or 'the whole file'}",
                "mine": _words(one.mine),
                "theirs": _words(one.theirs),
            }
            for one in error.conflicts
            for file in [workshop.shown(one.path)]
        ]
        raise UnresolvedConflict(str(error), rows) from None
    return {"saved": [workshop.shown(path) for path in written], "state": workshop.state()}


def _words(value: Any) -> str:
    return "(deleted)" if value is ABSENT else json.dumps(value, ensure_ascii=False, indent=1)
