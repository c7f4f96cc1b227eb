"""Routes of the project's script: its lines, and the opening of a line."""

from lipsync_lang.errors import LipsyncError
from lipsync_lang.rigs.container import Json
from lipsync_lang.studio.routes.asking import Packed, Routes, Wish
from lipsync_lang.studio.routes.line_routes import whole
from lipsync_lang.studio.workshop import Workshop

MAX_SOUGHT_CHARS = 200
"""Maximum length of a text to search for."""

MAX_DIGITS = 9
"""Maximum number of digits of a line's number."""


def lines(workshop: Workshop, asked: Wish) -> Json:
    """List lines of the script; without a query, the script is read first."""
    if not asked.query:
        workshop.script.read()
    first, sought = asked.query.get("first", "0"), asked.query.get("sought", "")
    if not (first.isascii() and first.isdecimal() and len(first) <= MAX_DIGITS):
        raise LipsyncError(f"'{first[:MAX_DIGITS]}' is not the number of a line")
    return workshop.script.listed(
        *workshop.opened_pair(), sought=sought[:MAX_SOUGHT_CHARS], first=int(first)
    )


def open_line(workshop: Workshop, asked: Wish) -> Packed:
    """Open a line of the script in the open language, and return its sound and take."""
    workshop.open_script_line(asked.text("name"))
    return whole(workshop)


ROUTES: Routes = {"GET script": lines, "POST script": open_line}
