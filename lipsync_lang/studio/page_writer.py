"""Output format `html`: the page of a line."""

from collections.abc import Iterator
from typing import TextIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import writer
from lipsync_lang.animations.writers.glb import unplaced
from lipsync_lang.errors import ModelError


def doubts(animation: Animation) -> Iterator[str]:
    """Yield warnings about the model of a page."""
    try:
        yield from unplaced(animation)
    except ModelError as error:
        yield f"the page draws a simple mouth instead of the model: {error}"


@writer("html", suffix=".html", remarks=doubts, reasons=True)
def write_html(animation: Animation, out: TextIO) -> None:
    """A page to hear and see the line in a browser, with every curve and its explanation."""
    from lipsync_lang.studio.line_page import line_page

    out.write(line_page(animation))
