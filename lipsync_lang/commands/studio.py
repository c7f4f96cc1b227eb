"""The command that opens the studio."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.commands.local_server import serve
from lipsync_lang.commands.output import SOUND
from lipsync_lang.commands.registry import handler
from lipsync_lang.commands.shared_options import cleaning

if TYPE_CHECKING:
    from collections.abc import Collection

    from starlette.types import ASGIApp


@handler(
    "studio",
    "open the studio in a browser: play, explain and edit a line",
    "studio -l english -c facefx",
)
def studio(options: Namespace) -> int:
    """Open the studio in a browser, until it is interrupted."""
    from hashlib import sha256

    from platformdirs import user_state_path

    from lipsync_lang.commands.performing import motion_settings
    from lipsync_lang.packs.project import find_project
    from lipsync_lang.performing.gesturing import ALL
    from lipsync_lang.studio.desk import Desk
    from lipsync_lang.studio.project_lines import ProjectLines
    from lipsync_lang.studio.workshop import Workshop

    # Unsaved edits are kept outside the project, in a file of its own.
    name = sha256(str(Path.cwd().resolve()).encode()).hexdigest()[:16]
    journal = user_state_path("lipsync-lang") / "studio" / f"{name}.jsonl"
    desk = Desk(journal)
    workshop = Workshop(
        Path.cwd(), options.path, desk,
        motion=motion_settings(options.settings), engine=options.tts, cleaning=cleaning(options),
        gestures=options.gestures or ALL, script=ProjectLines(find_project(), options.path),
    )  # fmt: skip
    workshop.settings.fps = options.fps
    if options.language and options.character:
        workshop.open_restored(options.language, options.character)

    def open_app(token: str, hosts: "Collection[str]") -> "ASGIApp":
        from lipsync_lang.studio.server import app

        return app(workshop, token, hosts)

    end = "close it with Ctrl-C; unsaved edits are kept"
    kept = journal.with_suffix(".address") if desk.journal else None
    serve(options, "the studio", end, open_app, kept, ws="none")
    return SOUND
