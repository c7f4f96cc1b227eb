"""Routes of the export: its formats and lines, and the files of a line."""

import numpy as np

from lipsync_lang.base.json_object import Json
from lipsync_lang.studio.array_pack import ArrayPack
from lipsync_lang.studio.exporting import EXPORT_FOLDER, export, format_rows, write_files
from lipsync_lang.studio.routes.requests import PackedResponse, StudioRequest, listed
from lipsync_lang.studio.workshop import Workshop


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
