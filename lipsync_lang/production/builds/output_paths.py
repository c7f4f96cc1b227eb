"""Paths of outputs and recordings, which a project states with placeholders."""

import posixpath
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from lipsync_lang.animations.animation_writers import WRITERS, find_writer
from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.files.names import BRACES, fill
from lipsync_lang.base.files.reach import is_reached
from lipsync_lang.packs.project import NARRATOR
from lipsync_lang.packs.yaml.source import Loc
from lipsync_lang.production.builds.archives import TAKE_SUFFIX
from lipsync_lang.production.builds.script_faults import ScriptFaults
from lipsync_lang.production.builds.takes import TAKES_SUFFIX

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Project


class OutputPattern(NamedTuple):
    """An output of every line: its writer, its path from the project's folder, and its place."""

    writer: str
    path: str
    loc: Loc


def filled(pattern: str, language: str, character: str = "") -> str:
    """Fill in all but the line's own placeholders."""
    return fill(pattern, {"{line}": "{id}", "{language}": language, "{character}": character})


def for_line(pattern: str, name: str, speaker: str) -> str:
    """Fill in the line's own placeholders."""
    if "{{" in pattern or "}}" in pattern or "{speaker}" in pattern:
        return fill(pattern, {"{speaker}": speaker or NARRATOR, "{id}": name, **BRACES})
    return pattern.replace("{id}", name)  # the usual case, in a quarter of the time


def outputs_of(project: "Project", faults: ScriptFaults) -> list[OutputPattern]:
    """Return the outputs that a project states, each with its writer."""
    if not project.outputs:
        hint = "state files such as `outputs: takes/{language}/{character}/{id}.csv`"
        faults.state((), "P401", "no `outputs`", hint)
    found: list[OutputPattern] = []
    for number, stated in enumerate(project.outputs):
        try:
            name, path = writer_of(as_member(stated))
        except OutputError as error:
            what, hint = str(error), ""
            if stated in WRITERS:
                what = f"'{stated}' is a format, not a file"
                hint = f"state a file, such as takes/{{id}}{WRITERS[stated].suffix}"
            faults.state(("outputs", number), "P404", what, hint)
            continue
        path = posixpath.normpath(path.replace("\\", "/"))
        found.append(OutputPattern(name, path, ("outputs", number)))
    return found


def as_member(stated: str) -> str:
    """Return an output that is an archive of takes as the take of each line in it.

    >>> as_member("takes/{character}.takes")
    'takes/{character}.takes/{language}/{id}.keys'
    """
    if stated.lower().endswith(TAKES_SUFFIX):
        return f"{stated}/{{language}}/{{id}}{TAKE_SUFFIX}"
    if f"{TAKES_SUFFIX}/" in stated.lower() and not stated.lower().endswith(TAKE_SUFFIX):
        raise OutputError(f"'{stated}': an archive of takes holds takes only; end it with .takes")
    return stated


def writer_of(stated: str) -> tuple[str, str]:
    """Return the name of an output's writer, and its path."""
    name, colon, path = stated.partition(":")
    return (name, path) if colon and name in WRITERS else (find_writer(Path(stated)).name, stated)


def check_shared(
    paths: Sequence[tuple[Loc, str]], needed: Mapping[str, str], faults: ScriptFaults
) -> None:
    """Check that no two lines share a file.

    `paths` have their places in the project. `needed` has the placeholders that must stand in
    each, with what there are several of.
    """
    for loc, path in paths:
        for placeholder, several in needed.items():
            if placeholder not in path.replace("{line}", "{id}"):
                what = f"'{path}' would be the same file for {several}"
                faults.state(loc, "P403", what, f"add {placeholder} to it")
    first: dict[str, Loc] = {}
    for loc, path in paths:
        if first.setdefault(path, loc) != loc:
            faults.state(loc, "P402", f"'{path}' is stated twice", "state it once")


def check_links(paths: Iterable[tuple[Loc, str]], folder: Path, faults: ScriptFaults) -> None:
    """Check that paths, with their places in the project, do not lead outside it by a link."""
    for loc, path in paths:
        # What a line fills in is checked when it is written; here only what all lines share.
        head = path.partition("{id}")[0].partition("{speaker}")[0]
        head = head if head == path else posixpath.dirname(head)
        if not is_reached(folder / fill(head, BRACES), folder):
            what = f"{head} leads outside {folder} by a link"
            faults.state(loc, "P106", what, "remove the link, or allow its target: --path FOLDER")
