"""Routes of the export: its formats and lines, and the files of a line."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.animations.animation_writers import WRITERS, Writer
from lipsync_lang.animations.rates import parse_rate
from lipsync_lang.base.errors import LipsyncError, OutputError
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.base.json_object import Json
from lipsync_lang.packs.models import Project
from lipsync_lang.packs.project import find_project, load_project
from lipsync_lang.studio.array_pack import ArrayPack
from lipsync_lang.studio.desk import write_together
from lipsync_lang.studio.routes.requests import PackedResponse, StudioRequest, listed
from lipsync_lang.studio.workshop import Workshop

EXPORT_FOLDER = "exports"
"""Usual folder of a project for exported lines."""


class Exported(NamedTuple):
    """Files of a line by suffix, the formats that failed, and remarks."""

    files: Mapping[str, bytes]
    failed: list[str]
    remarks: list[str]


def format_rows(workshop: Workshop) -> list[dict[str, str]]:
    """Return the formats with their descriptions, and why the line cannot have one."""
    line = None if workshop.line is None else workshop.performer.rigged(workshop.perform())
    return [
        {
            "name": one.name,
            "suffix": one.suffix,
            "title": one.title,
            "refused": "" if line is None else _refusal(one, line),
        }
        for one in (WRITERS[name] for name in WRITERS)
    ]


def _refusal(format_: Writer, animation: Animation) -> str:
    try:
        format_.refuse(animation)
    except LipsyncError as error:
        return str(error)
    return ""


def export(workshop: Workshop, formats: Iterable[str]) -> Exported:
    """Write the whole open line in some formats, as `run` does.

    Files that people watch have gestures; others have those that the project states.
    """
    performer, project = workshop.performer, _project(workshop)
    stated, whole = project and project.gestures, workshop.spoken.whole
    animation = workshop.perform(schedule=whole, gestures=stated or "all")
    rate = parse_rate(project.fps) if project and project.fps is not None else None
    settings = ExportSettings((project and project.offset) or 0.0, frame_rate=rate)
    shown = replace(performer.rigged(animation), export=settings)
    spoken = shown if stated else shown.without_gestures()
    found: dict[str, bytes] = {}
    failed: list[str] = []
    remarks: dict[str, None] = {}
    for name in formats:
        format_, stream = WRITERS.find(name, OutputError), BytesIO()
        try:
            format_.write(shown if format_.shows else spoken, stream)
            remarks |= dict.fromkeys(format_.remarks(spoken))
        except LipsyncError as error:
            failed.append(f"{name}: {error}")
        else:
            found[format_.suffix] = stream.getvalue()
    return Exported(found, failed, list(remarks))


def _project(workshop: Workshop) -> Project | None:
    file = find_project(workshop.project)
    return None if file is None else load_project(file).model


def write_files(workshop: Workshop, files: Mapping[str, bytes], *, over: bool) -> list[str]:
    """Write files into the project, all or none, and return their paths.

    Raises LipsyncError if a path leads out of the project, or a file exists or cannot be written.

    Parameters
    ----------
    files : content by path from the project's folder
    over : replace files that exist
    """
    targets = {name: _inside(workshop.project, name) for name in files}
    there = [name for name, path in targets.items() if path.exists()]
    if there and not over:
        raise OutputError(f"{there[0]}: exists; choose another folder, or replace files")
    write_together({targets[name]: content for name, content in files.items()})
    return list(targets)


def _inside(folder: Path, name: str) -> Path:
    path = folder / name
    # Not beside `lipsync.yaml`, where a file of a format could be taken for a pack or a table.
    if not name.isprintable() or ".." in Path(name).parts or path.parent == folder:
        raise OutputError(f"{name}: name a folder of the project, such as {EXPORT_FOLDER}")
    refuse_outside(path, folder)
    return path


def choices(workshop: Workshop, _: StudioRequest) -> Json:
    """List the formats, and the lines of the open language."""
    return {
        "formats": format_rows(workshop),
        "lines": [{"name": name, "character": one} for name, one in workshop.lines()],
        "folder": EXPORT_FOLDER,
    }


def files(workshop: Workshop, request: StudioRequest) -> PackedResponse:
    """Write a line in some formats: into a folder of the project, or as content to download."""
    body = request.body
    formats = [str(one) for one in listed(body.get("formats"), "formats")]
    if "line" in body:
        workshop = workshop.aside(request.text("line"), request.text("character"))
    made = export(workshop, formats)
    pack = ArrayPack()
    data: Json = {"failed": made.failed, "remarks": made.remarks}
    if "folder" in body:
        stem = f"{request.text('folder').strip(' /') or '.'}/{workshop.name}"
        content = {f"{stem}{suffix}": one for suffix, one in made.files.items()}
        data["written"] = write_files(workshop, content, over=body.get("replace") is True)
    else:
        data["files"] = [
            {
                "name": f"{workshop.name}{suffix}",
                "content": pack.add(np.frombuffer(one, np.uint8), "u1"),
            }
            for suffix, one in made.files.items()
        ]
    return PackedResponse(data, pack)
